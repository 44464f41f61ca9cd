"""barchain's own engines: relative coordinates in NumPy and compiled, and absolute coordinates in NumPy.

Formulation: equations of motion in the bars' angles, with reactions from a tridiagonal system for the joints; see
`reference_impl`.
Coordinates: centre of mass and angles (`reference`, `reference-fast`), or positions and velocities of all bars relative
to the centre of the central body (`reference-absolute`), which shows the round-off of absolute coordinates.
Integrator: Dormand and Prince's method of order 8 with error control, restarted at events; Radau's method where springs
or dampers are stiff.
Accuracy parameter: `rtol`. It is relative to the radius for the centre of mass: after two circular orbits in low Earth
orbit the track is off by 4 mm at the default 1e-10, and by 0.04 mm at 1e-12.

Supported: every effect of a scene. The engines locate the instant at which a bar reaches the surface.
Requirement: the kernel in C, for `reference-fast` alone, which the installation compiles: docs/explanation/kernel.md.

Trap: these engines share their equations with the reference solution, and so are no independent check of the physics.
"""

WIDE_UNTIL = "wide_until_s"
"""Key in `info` of the last instant of extended precision, s"""
CLOSE_START_RAD = 1e-16
"""Shift of the start below double precision: a thousand roundings of an angle of the wide type"""
