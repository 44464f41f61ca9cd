"""Synthetic tables of a round-off study that obeys given laws."""

import numpy as np

from reports.results.roundoff import FILES, TABLES
from tests.support.results import MADE, write_results

U = {"float32": 2.0**-24, "float64": 2.0**-53, "long double": 2.0**-64}
SIZES = [10.0**-k for k in range(2, 13, 2)]
EARTH_M = 6378e3
OBJECTS = {"20 km tether": 20e3, "100 m truss": 100.0, "10 cm CubeSat": 0.1, "5 mm hinge": 5e-3}
LAWS = {  # state, bars, formulation, yardstick: constant over u, exponent of the size
    ("generic", 5, "relative", "reaction"): (3.0, 0.0),
    ("generic", 5, "absolute", "reaction"): (0.5, -1.0),
    ("generic", 500, "relative", "reaction"): (10.0, 0.0),
    ("generic", 500, "absolute", "reaction"): (0.5, -1.0),
    ("80°", 5, "relative", "reaction"): (5.0, 0.0),
    ("80°", 5, "absolute", "reaction"): (0.2, -1.0),
    ("80°", 5, "absolute accelerations", "reaction"): (0.3, -1.0),
    ("80°", 5, "absolute positions", "reaction"): (1e7, -1.0),
    ("80°", 5, "relative positions", "reaction"): (4e7, 0.0),
    ("80°", 500, "relative", "reaction"): (3e4, 0.0),
    ("80°", 500, "absolute", "reaction"): (3e4, 0.0),
    ("unequal masses", 5, "relative", "reaction"): (3e6, 0.0),
    ("unequal masses", 5, "absolute", "reaction"): (3e6, 0.0),
    ("generic", 5, "tree (inertial)", "reaction"): (0.7, -2.0),
    ("generic", 5, "tree (moving frame)", "reaction"): (4.0, 0.0),
    ("horizontal", 5, "relative", "reaction"): (0.5, -2.0),
    ("horizontal", 5, "absolute", "reaction"): (0.05, -3.0),
    ("horizontal", 5, "relative", "m n² l"): (5.0, 0.0),
    ("horizontal", 5, "absolute", "m n² l"): (0.6, -1.0),
}
FEW = {key: law for key, law in LAWS.items() if key[:2] == ("generic", 5)}
"""Laws of one state"""
BEST = {  # coordinates, ratio: steps of the least error, that error
    ("absolute", 1e-3): (2048, 1e-12), ("absolute", 1e-7): (512, 1e-8),
    ("relative", 1e-3): (4096, 3e-14), ("relative", 1e-7): (4096, 4e-14),
}  # fmt: skip


def spread(median):
    return {"q05": 0.5 * median, "median": median, "q95": 2.0 * median, "largest": 3.0 * median, "members": 32}


def fitted(exponent, half=0.01, expected=None):
    wanted = exponent if expected is None else expected
    return {"exponent": exponent, "low": exponent - half, "high": exponent + half, "expected": wanted, "points": 6}


def keys(laws):
    names = ("state", "bars", "formulation", "yardstick", "arithmetic", "source")
    for (state, bars, formulation, yardstick), law in laws.items():
        for arithmetic in U:
            for source in ("formula", "input", "both"):
                yield dict(zip(names, (state, bars, formulation, yardstick, arithmetic, source), strict=True)), law


def evaluation(laws):
    return [
        key | {"ratio": r} | spread(c * U[key["arithmetic"]] * r**e)
        for key, (c, e) in keys(laws) for r in SIZES if key["bars"] * r < 0.1
    ]  # fmt: skip


def law_table(laws):
    return [
        key | fitted(e) | {"constant": c, "first": SIZES[-1], "last": SIZES[0]}
        | {"last_digit_ratio": (0.1 / (c * U[key["arithmetic"]])) ** (1.0 / e) if e else None}
        for key, (c, e) in keys(laws)
    ]  # fmt: skip


def run_head(coordinates, ratio, quantity, arithmetic="float64", method="rk4"):
    words = {"coordinates": coordinates, "arithmetic": arithmetic, "method": method}
    return {"ratio": ratio, "quantity": quantity, "known": True} | words


def trajectories():
    rows = []
    for (c, r), (best, least) in BEST.items():
        for q in ("attitude", "gap"):
            for n in (16, 512, 2048, 4096):
                error = np.inf if n == 16 else least * max(best / n, n / best)
                rows.append(run_head(c, r, q) | {"steps_per_orbit": n} | spread(error))
            rows += [run_head(c, r, q, method="dop853, chosen steps") | {"rtol": t} | spread(10 * least)
                     for t in (1e-6, 1e-9)]  # fmt: skip
    return rows


def tables(laws=LAWS):
    """Rows of every table of a small study."""
    rows = {name: [] for name in TABLES}
    rows["evaluation"], rows["laws"], rows["trajectories"] = evaluation(laws), law_table(laws), trajectories()
    for (c, r), (n, least) in BEST.items():
        for q in ("attitude", "reaction"):
            rows["best"] += [run_head(c, r, q) | {"steps_per_orbit": n, "settled": n < 4096} | spread(least)]
            head = run_head(c, r, q)
            rows["growth"] += [head | {"orbits": t, "known": t > 1} | spread(least * t**1.5) for t in (1, 2, 4)]
    for c, e in (("absolute", -1.0), ("relative", 0.0)):
        head = {"quantity": "attitude", "coordinates": c, "arithmetic": "float64", "method": "rk4"}
        rows["best_laws"].append(head | fitted(e) | {"constant": 8.0})
        rows["growth_laws"].append(head | {"ratio": 1e-3} | fitted(1.5, 0.1))
    for source, p in (("formula", 0.4), ("input", 1e-9)):
        head = {"state": "generic", "ratio": 1e-5, "formulation": "relative", "arithmetic": "float64"}
        head |= {"source": source, "p_value": p}
        rows["longitudes"] += [head | {"sector_deg": 45.0 * k} | spread(1e-16 + 1e-18 * k) for k in range(8)]
    for frame, error in (("inertial", 1e-3), ("moving", 1e-8)):
        for n in (100, 1000):
            head = {"engine": "box", "frame": frame, "ratio": 1e-5, "quantity": "reaction", "outcome": "pass"}
            rows["engines"].append(head | {"steps_per_orbit": n, "known": True} | spread(error * n))
    rows["engines"].append({"engine": "ball", "frame": "inertial", "outcome": "failed", "reason": "<flat> tyre"})
    rows["engine_laws"].append(
        {"engine": "box", "frame": "inertial", "ratio": 1e-5, "quantity": "reaction", "against": "steps_per_orbit"}
        | fitted(2.0)
    )
    times = {"relative_s": 3e-6, "absolute_s": 2e-6, "ratio": 1.5, "low": 1.4, "high": 1.6, "turns": 15}
    rows["times"].append({"code": "reference", "arithmetic": "float64", "bars": 5} | times)
    return rows


RECORD = MADE | {
    "members": 32, "exact_digits": 120, "scene": "paper/fig15", "unit_roundoff": U, "long_doubles": True,
    "objects": [{"name": n, "length_m": m, "ratio": m / EARTH_M} for n, m in OBJECTS.items()],
    "failed": [{"table": "evaluation", "task": "generic, 9 bars", "reason": "ValueError: no"}],
}  # fmt: skip


def write(folder, rows=None, without=(), **record):
    given = tables() if rows is None else rows
    return write_results(
        folder, FILES, {name: own for name, own in given.items() if name not in without}, RECORD | record
    )
