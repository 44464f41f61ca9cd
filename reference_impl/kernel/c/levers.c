/* The functions of kernel.c for chains with unequal levers: levers_NAME for each NAME. */
#define LEVERS
#define INSTANCE(name) levers_##name
#include "instance.h"
#include "kernel.c"
