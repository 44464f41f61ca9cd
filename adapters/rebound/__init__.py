"""REBOUND: the track of the centre of mass, as one particle about a point mass.

Formulation: one test particle. A chain's centre of mass is a particle up to O((L/r)²) of gravity; that model difference
is predicted from the reference solution and taken out before the engine is judged.
Integrators: IAS15 with error control; WHFast at coarse settings of a pure Kepler orbit.
Accuracy parameter: `rtol`. Shows the centre of mass only.
Not supported: what pushes bars by their attitude (drag, light, thrust in a bar's axes).
REBOUND is GPL-3: it is imported in this package only, when a scene is built.
"""
