"""Pinocchio: articulated-body algorithm in joint coordinates, in a freely falling frame.

Formulation: two massless slides and a revolute joint for each bar; accelerations by `aba`, reactions by `rnea`.
Coordinates: the frame's origin, one end of bar 1 in the frame, and the angle at each joint.
Integrator: Pinocchio has none; SciPy's DOP853 steps its accelerations, with error control.
Accuracy parameter: `rtol`.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses.
Not supported: prescribed rotations, because forward dynamics takes torques, and the shadow's edge, whose instant
depends on the motion.

Trap: Pinocchio reads a list of external forces without a check of its length; the list must have one entry per joint.
"""
