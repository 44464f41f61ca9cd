"""Pinocchio: articulated-body algorithm in joint coordinates, in a freely falling frame.

Formulation: a planar joint and revolute joints; accelerations by `aba`, reactions by `rnea`.
Integrator: Pinocchio has none; SciPy's DOP853 steps its accelerations. Accuracy parameter: `rtol`.
Not supported: prescribed rotations and the shadow's edge.
Trap: a list of external forces that is too short is read out of its bounds in silence.
"""
