"""pymunk: a game physics engine with impulses and iterative joints, made second order.

Formulation: bodies and pivot joints; sequential impulses, whose number of iterations is worked out from the masses.
Coordinates: a freely falling frame, or absolute inertial ones (`pymunk-absolute`).
Integrator: the engine's semi-implicit Euler with velocities half a step ahead of places, which makes it a leapfrog.
Accuracy parameter: steps per orbit. Order: 2.
Reactions: momentum balance along the chain over the step that is centred on a sample.
Not supported: prescribed rotations, the shadow's edge, jumps within a step, chains of more than about 57 bars.
Traps: exceptions in callbacks are swallowed; joints burst without a word if there are too few iterations.
"""
