"""DART: articulated-body algorithm in joint coordinates, in a freely falling frame.

Formulation: a planar joint at one end of bar 1 and a revolute joint between bars; accelerations by
`computeForwardDynamics`, reactions by `getBodyForce`.
Coordinates: the frame's origin, one end of bar 1 in the frame, and the angle at each joint.
Integrator: DART's own step is a semi-implicit Euler step; SciPy's DOP853 steps its accelerations, with error control.
Accuracy parameter: `rtol`.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses.
Not supported: prescribed rotations, because DART prescribes angles between bars, and the shadow's edge, whose instant
depends on the motion.

Traps: `addExtForce` turns a force in world axes into the body's by the pose at that moment. A force added before
the new positions are set acts in an old direction, and accelerations are wrong by 30 to 60 %. The forces are therefore
given in the bars' own axes. `setExtTorque` overwrites the moment of `setExtForce`. A thin rod's inertia of 0 is a
warning on the standard error.
"""
