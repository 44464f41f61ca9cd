"""Many chains in step, one in each lane of the processor's vector registers; see docs/studies/ensemble.md.

A row of W numbers holds one quantity of W chains. Each operation is applied to all W lanes, and no operation combines
lanes. A chain's numbers therefore depend neither on its lane nor on its neighbours. Lanes serve free chains with
gravity alone: prescribed rotations, effects and ill-conditioned chains stay with :mod:`reference_impl.fast.batch`.
"""
