/* The functions of kernel.c in the wide type for chains with unequal levers: wide_levers_NAME for each NAME. */
#define WIDE
#define LEVERS
#define INSTANCE(name) wide_levers_##name
#include "instance.h"
#include "kernel.c"
