"""How errors grow over many orbits of a regular swing: the energy's drift, and the place along the orbit.

    python benchmarks/growth.py [--orbits 1000] [--starts 16]

The bar of `hard/long_1000` is started at several angles and longitudes, and each engine's errors are taken as the root
mean square of all: a single run's exponent tells of one random walk. Energy needs no judge; places are compared with
heyoka's in long double, whose roundings are two thousand times smaller. Exponents are fitted as everywhere else
(`barchain.studies.stability.rules`): the running maximum over the last decade of time. Needs the `certified` extra.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import click
import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import find_engine
from barchain.metrics.quantities import differences, drifts
from barchain.studies.stability.rules import law
from scenarios import load_scene

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.studies.stability.rules import GrowthLaw
    from scenarios import Scene

SCENE = "hard/long_1000"
SAMPLES = 1001
JUDGE = "heyoka-long", 1e-19
RUNS = (("reference-fast", 1e-13), ("reference-fast", 1e-14), ("reference-fast", 1e-15), ("heyoka", 1e-16))
SPREAD_DEG = 5.0


def starts(orbits: float, count: int) -> list[Scene]:
    """The scene, started at `count` angles and longitudes; the same ones each time."""
    base, random = load_scene(SCENE), np.random.default_rng(1)
    run = replace(base.run, duration_s=orbits * base.period_s, samples=SAMPLES)
    found = []
    for _ in range(count):
        angle = base.chain.angle_rad[0] + np.radians(random.uniform(-SPREAD_DEG, SPREAD_DEG))
        orbit = replace(base.orbit, longitude_rad=float(random.uniform(-np.pi, np.pi)))
        found.append(replace(base, chain=replace(base.chain, angle_rad=(float(angle),)), orbit=orbit, run=run))
    return found


def seen(engine: str, rtol: float, scenes: list[Scene]) -> list[Trajectory]:
    """Runs of all starts."""
    return [find_engine(engine).engine().run(scene, Setting(AccuracyParameter.RTOL, rtol)) for scene in scenes]


def root_mean_square(errors: list[Array]) -> Array:
    """Over the starts, (n,)."""
    found: Array = np.sqrt(np.mean(np.square(errors), axis=0))
    return found


def words(found: GrowthLaw | None) -> str:
    """An error at the end, and its exponent with its interval."""
    if found is None:
        return "none"
    return f"{found.at_end:.1e}, t^{found.exponent:.2f} ({found.low:.2f} to {found.high:.2f})"


@click.command()
@click.option("--orbits", default=1000.0, show_default=True)
@click.option("--starts", "count", default=16, show_default=True)
def main(orbits: float, count: int) -> None:
    """Run all and print a line for each setting."""
    scenes = starts(orbits, count)
    solution = seen(*JUDGE, scenes)
    for engine, rtol in RUNS:
        runs = seen(engine, rtol, scenes)
        energy = [drifts(scene, run)["energy"] for scene, run in zip(scenes, runs, strict=True)]
        place = [differences(a, b)["com"] / scenes[0].radius0_m for a, b in zip(runs, solution, strict=True)]
        t = solution[0].t_s
        grown = (law(t, root_mean_square(each)) for each in (energy, place))
        click.echo("{} rtol={:g}: energy {}; place/r {}".format(engine, rtol, *map(words, grown)))


if __name__ == "__main__":
    main()
