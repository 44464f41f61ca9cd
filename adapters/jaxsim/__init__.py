"""JaxSim: articulated-body algorithm in joint coordinates, in a freely falling frame, in a Python of its own.

Formulation: a tree of links with a free base, bar 1, and a revolute joint about one axis to each further bar, built
from SDF. Accelerations by `jaxsim.rbda.aba`, with the loads as forces of links and joints; reactions by
Newton's law for all bars up to a joint, relative to the frame.
Coordinates: one end of bar 1 in the frame, bar 1's angle, and the angle at each joint. The base's quaternion is made of
the angle for each evaluation and never integrated: attitudes keep their turns, and the motion its plane.
Frame: axes of fixed direction on the Kepler orbit of the centre of mass, in closed form. Gravity is the field at a bar
less that at the origin; other fields act whole.
Integrator: the classical Runge-Kutta method with equal steps, compiled by JAX together with accelerations and loads;
order 4. JaxSim's own step holds the forces of links over a step, so that gravity would be of order 1 in it.
Accuracy parameter: steps per orbit.

Supported: gravity of points, with its gradient and its second moments, oblateness, third bodies, springs, dampers and
motors in joints, thrusts, and centres of mass not midway.
Not supported: prescribed rotations, as forward dynamics takes torques; gravity of slender bars, drag, light and
impulses, which the program does not set up; and the instant at the surface.

Traps: gravity is 9.8 m/s² by default. Links without mass are left out with their joints, so that a planar base of two
massless slides is none. Damping and limits of joints act in JaxSim's own step, and not in forward dynamics. Velocities,
accelerations and moments of `rbda.aba` are those of the body's point at the world's origin; those of `js.model` count
in the representation of the data, in the mixed one at a link's origin. The base's matrix is singular for a rod without
inertia about its own axis. JaxSim turns on float64, unless the variable JAX_ENABLE_X64 is 0. Each number of bars and of
samples, and each scene, is built and compiled anew (docs/engines/measurements.md).
"""
