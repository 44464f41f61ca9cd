"""Effects beyond the paper's model, one module each; imported only for a model with that effect.

Prescribed rotations are part of the equations (`model/chain.py`, `model/relative.py`). `timed` and `second_moment` are
shared by several effects; impulses are no loads: `integrate/discrete_modes.py` applies them.
"""
