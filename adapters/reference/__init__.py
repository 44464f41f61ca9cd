"""barchain's own engines: the relative formulation in NumPy and compiled, and NumPy in absolute coordinates.

Formulation: equations of motion in the bars' angles, reactions from a tridiagonal system for the joints; see
`reference_impl`. Coordinates: centre of mass and angles (`reference`, `reference-fast`), or places and velocities of
all bars from the centre of the Earth (`reference-absolute`), which shows what those lose to round-off. Integrator:
Dormand and Prince, order 8, with error control; Radau where springs or dampers are stiff. Accuracy parameter: `rtol`.
Supports every effect of a scene. Needs numba for `reference-fast` alone.
"""
