"""Exudyn: redundant coordinates with Lagrange multipliers, or a kinematic tree.

Formulation: `ObjectRigidBody2D` and `ObjectJointRevolute2D`; the joints' multipliers are the reactions. `exudyn-tree`
is an `ObjectKinematicTree` without constraints, its reactions are found from momentum. Coordinates: a frame on the
Kepler orbit, so that forces are of the size of a bar; or absolute inertial ones (`exudyn-absolute*`), which show what
multipliers lose there. Integrators: trapezoidal rule with index 2, generalized-alpha with index 3, RK67 for the tree;
equal steps. Accuracy parameter: steps per orbit. Order: 2; 6 for the tree. Not supported: blows, the edge of the
Earth's shadow, faces that turn to wind or light between two steps, and thrusts that start or end beside a prescribed
rotation. The tree takes no prescribed rotation. Traps: Newton's tolerances have to be absolute and in the scene's
units; index 2 differences (C_q q')_q, which has to be scaled; a run that stops early reports success; in absolute
coordinates Newton accepts torques that turn small bars.
"""
