"""Basilisk: MuJoCo bodies in its multibody scene, with its gravity and its integrator, in a Python of its own.

Formulation: a tree of MuJoCo bodies in an `MJScene`: bar 1 has a free joint, each further bar a hinge. `NBodyGravity`
pulls each bar at its centre of mass; MuJoCo's own gravity and contacts are off.
Coordinates: the place of bar 1's centre of mass and its attitude, and the angle at each joint.
Frame: inertial axes from the centre of the central body, which is a central source without an ephemeris message. The
orbit lies in the plane of x and y; angles count from x. The start is a place and a velocity, no elements of any kind.
Integrator: Basilisk's `svIntegratorRK4` with equal steps; order 4.
Accuracy parameter: steps per orbit.
Time: Basilisk counts whole nanoseconds. The step is rounded to them, and the unit of time is longer or shorter than
the second in the same ratio (2e-10 of it or less in steps of 2.5 s): each sample is the end of a step, and the
parameter of gravity, velocities and rates are in that unit.

Supported: no gravity, gravity of a point on each bar, and centres of mass not midway. Observables are the centre of
mass, attitudes and rates.
Not supported: reactions, as the message of `MJJointReactionForces` has forces along the joints' own coordinates, and
none across a hinge; the torque of the gravity gradient, as `NBodyGravity` gives each body a force, and Basilisk's
`GravityGradientEffector` acts on its rigid spacecraft; other effects, which the program does not set up; and the
instant at the surface.

Traps: MuJoCo takes moments about a point in places from the centre of the central body. Half a unit in the last place
of that distance is an arm for gravity, and turns a short bar: one of 1 m by 0.04 rad in `basics/kepler_elliptic`. A
scene in which more than 2e-6 rad are expected is left out. Basilisk's effectors of hinged bodies
(`NHingedRigidBodyStateEffector`, `SpinningBodyNDOFStateEffector`) take gravity at the whole spacecraft's centre of mass
for each body (docs/engines/measurements.md): a chain of them is exact without gravity alone.
"""
