"""heyoka: Taylor integration in double, extended and quadruple precision.

Formulation: equations derived independently of the reference's, by recursion from the last bar to the first and back;
reactions from the bars' accelerations. In quadruple precision heyoka computes the certified solutions; see
docs/explanation/certified_solutions.md.
Coordinates: centre of mass and inertial angles, so that joints have no gap.
Integrator: Taylor series of adaptive order and step, with events for bars that turn their other face to the wind or the
Sun, for the shadow's edge and for the surface.
Accuracy parameter: `rtol`, relative to the largest unknown in units near 1.

Supported: every effect of a scene.
Cost: 1 to 3 s of compilation for each structure of a scene of five bars, minutes for hundreds of bars; scenes that
differ in numbers alone share the code.

Traps: constants must be made in the precision of the run; `expr / 5.0` is rounded to double. heyoka detects an event
again just after a restart unless its cooldowns apply.
"""

CLOSE_START = "close_start"
"""Name of the option of a perturbed start below double precision"""
CLOSE_START_RAD = "1e-18"
"""Perturbation of angles, rad, and of rates relative to the orbit's or the bars' own, as a decimal number"""
