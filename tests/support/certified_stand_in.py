"""A stand-in for a certified solution: a tight run of the reference with given error bars."""

from types import SimpleNamespace

import numpy as np

from barchain.metrics.quantities import differences
from tests.support import solutions


def certified_stand_in(scene, error=1e-12):
    seen = solutions.run(scene, 1e-13)
    n = len(seen.t_s)
    bound = {name: np.full(n, error) for name in differences(seen, seen)}
    return SimpleNamespace(scene=scene, trajectory=seen, error=bound, precision="double", source="stand-in")
