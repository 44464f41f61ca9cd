"""MuJoCo: joint coordinates in a freely falling frame.

Formulation: a tree of hinges on two slides, composite rigid body algorithm. Gravity less that at the frame's origin is
applied to each bar's centre in the control callback, at every stage.
Integrator: the engine's own fourth-order Runge-Kutta, equal steps. Accuracy parameter: steps per orbit. Order: 4.
Reactions: `cfrc_int`, the forces that a body's parent exerts on it.
Not supported: prescribed rotations, blows, the shadow's edge, faces that turn between two steps.
Traps: callbacks belong to the whole process; a state that is not a number is reset in silence.
"""
