"""REBOUND: the orbit of the centre of mass, as one particle about a point mass.

Formulation: one test particle. A chain's centre of mass moves like a particle up to O((L/r)²) of gravity. The judge
predicts that model difference from the judging solution and removes it from the engine's error.
Coordinates: absolute, relative to the central body.
Integrators: IAS15 with error control; WHFast at coarse settings of a pure Kepler orbit.
Accuracy parameter: `rtol`.

Supported: point gravity, oblateness, third bodies, thrusts and impulses along fixed directions. Gravity models of bars,
joint springs and prescribed rotations move the centre of mass by the model difference only, and are accepted.
Observables: the centre of mass only.
Not supported: drag, solar pressure, thrusts and impulses in a bar's axes, because the force depends on a bar's
attitude; orbits whose lowest point is above the surface by less than the chain's length.

Traps: stops of IAS15 at samples would cost accuracy, so that separate short runs give the samples. ctypes drops an
exception of a callback. REBOUND is GPL-3: only this package imports it, when a scene is built.
"""
