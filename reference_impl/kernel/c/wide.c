/* The functions of kernel.c in the wide type, for solutions that judge double precision: wide_NAME for each NAME. */
#define WIDE
#define INSTANCE(name) wide_##name
#include "instance.h"
#include "kernel.c"
