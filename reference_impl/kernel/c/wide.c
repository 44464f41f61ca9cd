/* The functions of kernel.c in the wide type, for solutions that judge double precision: wide_NAME for each NAME. */
#define WIDE
#define source_digest wide_source_digest
#define layout_name wide_layout_name
#define layout_value wide_layout_value
#define effect_name wide_effect_name
#define evaluate_state wide_evaluate_state
#define evaluate_repeatedly wide_evaluate_repeatedly
#define observe wide_observe
#define advance_to wide_advance_to
#define take_partial_step wide_take_partial_step
#define make_interpolant wide_make_interpolant
#define interpolate_step wide_interpolate_step
#define take_samples wide_take_samples
#define begin_next_step wide_begin_next_step
#define integrate_batch wide_integrate_batch
#include "kernel.c"
