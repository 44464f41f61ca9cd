"""heyoka: Taylor integration in double, extended and quadruple precision.

Formulation: equations derived apart from the reference's, from Lagrange's function of the joined chain; reactions from
the bars' accelerations. In quadruple precision it makes the certified solutions; see docs/certified_solutions.md.
Coordinates: centre of mass and inertial angles: no joint can open.
Integrator: Taylor series of adaptive order and step, with events for faces, shadow and surface.
Accuracy parameter: `rtol`. Supports every effect. Compiles each scene anew, 20 to 40 s.
Trap: constants must be made in the precision of the run; `expr / 5.0` is rounded to double.
"""
