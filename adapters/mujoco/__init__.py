"""MuJoCo: joint coordinates in a freely falling frame.

Formulation: a tree of hinges on two slides, composite rigid body algorithm. MuJoCo has no orbital mechanics: gravity
less that at the frame's origin acts on each bar's centre through the control callback, at every stage.
Coordinates: one end of bar 1 in a frame on the orbit of a freely falling particle, and the angle at each joint.
Integrator: MuJoCo's fourth-order Runge-Kutta method with equal steps; order 4.
Accuracy parameter: steps per orbit.
Reactions: `cfrc_int`, the force of a body's parent on the body; impulsive reactions from the same joint system.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses at the end of a step.
Not supported: prescribed rotations, the shadow's edge, events within a step, and bars that turn their other face to the
wind or the Sun within a step.

MuJoCo's implicit integrators are of order 1 on the chain (docs/engines/measurements.md), so that there is no option.

Traps: callbacks belong to the whole process. `qfrc_passive` would leave the loads out of the reactions; `xfrc_applied`
does not. MuJoCo resets a state that is not finite without an error, so the reset is disabled and warnings become
errors.
"""
