"""pymunk: a game physics engine with impulses and iterative joints, made second order.

Formulation: bodies and pivot joints; sequential impulses. The number of iterations per step is computed from the
masses.
Coordinates: a freely falling frame, or absolute inertial ones (`pymunk-absolute`).
Integrator: pymunk's semi-implicit Euler method with velocities half a step ahead of positions, which makes it a
leapfrog method; order 2.
Accuracy parameter: steps per orbit.
Reactions: momentum balance along the chain over the step that is centred on a sample.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses at the end of a step.
Not supported: prescribed rotations, the shadow's edge, events within a step, and chains of more than about 57 equal
bars.

Traps: pymunk swallows exceptions in callbacks. With too few iterations the joints separate without an error.
"""
