"""diffrax: Runge-Kutta methods in JAX, compiled by XLA, on barchain's equations written again in JAX.

Formulation and coordinates: barchain's relative formulation, centre of mass and angles, transcribed to JAX arrays;
Encke's form of gravity, and a block elimination for the joint reactions. The engine is an integrator on barchain's
equations and no check of the physics.
Integrator: Dopri8, order 8 with step control (diffrax's `PIDController` at its defaults), double precision; samples by
diffrax's interpolation of order 8.
Accuracy parameter: `rtol`; the absolute tolerance is a thousandth of `rtol`, in SI units, as a typical user gives it.

Compiling: XLA compiles the whole run once for each number of bars, gravity model and number of samples. The engine
compiles while it builds, so that the timed run holds none of it.
Supported: gravity as point masses, with the paper's gradient torque, or none. The run stops at the surface.
Not supported: all other effects; their equations are not written in JAX.

Traps: JAX computes in single precision unless it is told otherwise, for the whole process. An event ends a run only
after the step in which the chain reaches the surface; a root search on the interpolation finds the instant. Samples
after an event are infinite. A state that is not finite is rejected and tried again without end: a number of steps ends
such runs.
"""
