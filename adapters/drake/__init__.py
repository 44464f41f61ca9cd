"""Drake: articulated-body algorithm in joint coordinates, in a freely falling frame, by Drake's own integrator.

Formulation: a planar joint at one end of bar 1 and a revolute joint between bars, in a continuous `MultibodyPlant`;
loads are applied spatial forces, reactions those of `get_reaction_forces_output_port`.
Coordinates: the frame's origin, one end of bar 1 in the frame, and the angle at each joint.
Integrator: Drake's RK5 (fifth order, error control) in a `Simulator`; at requests of 1e-8 and below its
errors are within a factor of four of those of SciPy's DOP853 on the same accelerations, and users of Drake expect it.
Accuracy parameter: `rtol`, Drake's accuracy, in units of the radius, the longest bar, the radian and the fastest rate.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses.
Not supported: prescribed rotations, and the shadow's edge, whose instant depends on the motion.

Traps: with caching RK5 repeats a rejected step with a stale derivative. On a double pendulum its error is then 108 to
2800 times as large at accuracies from 1e-7 to 1e-4 (docs/engines/measurements.md), and a run with long steps does not
end. A context without caching is right, but an evaluation of a plant in it takes 4 times (5 bars) to 58 times (200
bars) as long; the plant therefore has a context of its own. Error control counts every component in units of 1.
Generalized forces are missing in the reactions, spatial forces are not.
"""
