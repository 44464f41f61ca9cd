"""Exudyn: redundant coordinates with Lagrange multipliers, or a kinematic tree.

Formulation: `ObjectRigidBody2D` and `ObjectJointRevolute2D`; the joints' multipliers are the reactions. `exudyn-tree`
is an `ObjectKinematicTree` without constraints; the balance of momentum along the chain gives its reactions.
Coordinates: a frame on the Kepler orbit, in which forces are of the size of those on a bar (`exudyn`, `exudyn-index3`,
`exudyn-tree`), or absolute inertial coordinates (`exudyn-absolute`, `exudyn-absolute-index3`), in which multipliers
lose digits.
Integrators: trapezoidal rule at index 2 (order 2), generalized-alpha at index 3 (order 2), RK67 for the tree (order 6);
equal steps.
Accuracy parameter: steps per orbit.

Loads: one connector for each bar, whose force is a symbolic user function: an expression that Exudyn evaluates in C++.
On a circular orbit no Python runs in a step. On other orbits, and under loads that depend on time, Python sets the
expressions' numbers once before each step (3 to 5 % of a run). Exudyn has no faster exact form: its own gravity
connector acts on points, without the gradient's torque. The cost study measures the loads' share of a run.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts; prescribed rotations except by the tree, and except by a motor in a joint at index 3 in absolute coordinates.
Not supported: impulses, the shadow's edge, bars that turn their other face to the wind or the Sun, tables in time with
corners inside a step, and forces or torques that jump during a run with prescribed rotations.

In `effects/slews` the comparison of `exudyn`, `exudyn-index3` and `exudyn-absolute` ends as `too_coarse`: beyond
the predictability limit, 620 to 635 s, their rates are too uncertain to predict 21 of 22 segments. With 20 000
steps per orbit (`--set steps_per_orbit=20000`) `exudyn` and `exudyn-index3` pass there, and `exudyn-absolute` is
`roundoff_limited`.

Traps: Newton's tolerances must be absolute and in the scene's units. Index 2 differences (C_q q')_q, whose increment
must be scaled. A run that stops early reports success. In absolute coordinates Newton accepts torques whose error turns
small bars. Initial accelerations are wrong where a prescribed offset follows the motion.
"""
