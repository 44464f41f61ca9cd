"""The relative formulation compiled: the reference's equations and stepper, some hundred times faster."""
