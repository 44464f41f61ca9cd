"""Time of an ensemble at equal error: chains in lanes, one chain at a time, and heyoka's batch and ensemble modes.

    python benchmarks/ensemble_lanes.py [--members N] [--turns N]

Copies of fig05 run over one orbit with 101 samples. Each contender runs at several tolerances, all contenders in turn,
on one core and on two; the least time counts. The error of a contender is the median over its copies of the largest
error of an angle at any sample, relative to heyoka at its finest tolerance. Times at 1e-8 and 1e-10 rad lie straight
between the points of a contender's tolerances in both logarithms.

heyoka has every advantage: it computes no reactions, watches no surface, and is compiled without compact mode. On one
core it runs in batch mode, on two in ensemble mode of batches.
"""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from adapters.heyoka.compiled import DOUBLE, symbols
from adapters.heyoka.structure import parameters_of, start_of, structure_of, units_of
from barchain.record.environment import processor
from barchain.studies.ensemble.population import batch, populate
from barchain.studies.ensemble.study import shortened
from barchain.studies.ensemble.variation import parse
from reference_impl.kernel.batch import run_batch, run_lanes
from reports.text.numerals import span_text
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from barchain.studies.ensemble.population import Population

SCENE, SPREAD, SAMPLES = "paper/fig05", "angle_deg=normal(0, 0.1)", 101
TARGETS_RAD = (1e-8, 1e-10)
CORES = (1, 2)
PART = 250  # copies of a task
CHECKED = 64  # copies whose error is measured
FINEST = 1e-16
TOLERANCES = tuple(10.0**-k for k in range(8, 15))
WIDTHS = (4, 8)


@dataclass
class Contender:
    """A way to run all copies at one tolerance."""

    name: str
    tolerance: float
    run: Callable[[int], Any]
    """Run all copies on a number of cores"""
    angle_rad: Callable[[], Array]
    """(copies, n, N) of the first copies"""
    seconds: dict[int, float] = field(default_factory=dict)
    error_rad: float = np.nan


def ours(name: str, run: Callable[[Any], Any], population: Population, rtol: float) -> Contender:
    """The compiled reference."""
    parts = [population.part(k, min(k + PART, population.runs)) for k in range(0, population.runs, PART)]
    batches = [batch(part, rtol) for part in parts]
    return Contender(
        name, rtol, lambda cores: on_threads(run, batches, cores), lambda: run(batches[0]).angle_rad[:CHECKED]
    )


def on_threads(run: Callable[[Any], Any], given: list[Any], cores: int) -> list[Any]:
    """Run each of the given on threads."""
    if cores == 1:
        return [run(one) for one in given]
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(run, given))


class HeyokaBatch:
    """heyoka's batch mode of a width: the copies' starts, and one integrator for each tolerance."""

    def __init__(self, population: Population, width: int) -> None:
        """Derive the equations; the surface is not watched."""
        first = population.copy(0)
        self.width, self.units, self.structure = width, units_of(first), structure_of(first)
        number = DOUBLE.number
        self.starts = np.array([start_of(population.copy(k), self.units, number) for k in range(population.runs)])
        self.parameters = parameters_of(first, self.units, number)
        self.grid = np.repeat((population.scene.times_s / self.units.time_s)[:, None], width, axis=1)

    def contender(self, tolerance: float, *, compact: bool) -> Contender:
        """Contender at a tolerance; compiles."""
        import heyoka as hy  # noqa: PLC0415

        found = symbols(self.structure)
        integrator = hy.taylor_adaptive_batch(
            list(zip(found.variables, found.rates, strict=True)),
            np.zeros((len(found.variables), self.width)),
            tol=tolerance,
            pars=np.repeat(self.parameters[:, None], self.width, axis=1),
            compact_mode=compact,
        )
        groups = self.starts.reshape(-1, self.width, self.starts.shape[1]).transpose(0, 2, 1)

        def run(cores: int) -> Any:
            if cores == 1:
                return [self.one(integrator, group) for group in groups]
            return hy.ensemble_propagate_grid_batch(
                integrator, self.grid[:, 0], len(groups), lambda own, k: self.started(own, groups[k]), max_workers=cores
            )

        def angle_rad() -> Array:
            rows = [self.one(integrator, group) for group in groups[: CHECKED // self.width]]
            n = self.structure.bars
            return np.concatenate([r.transpose(2, 0, 1)[:, :, 4 : 4 + n] for r in rows])

        return Contender(f"heyoka batch {self.width}", tolerance, run, angle_rad)

    def started(self, integrator: Any, group: Array) -> Any:
        """Integrator at the start of a group of copies."""
        integrator.set_time(0.0)
        integrator.state[:] = group
        return integrator

    def one(self, integrator: Any, group: Array) -> Array:
        """States (n, size, width) of a group of copies."""
        found = self.started(integrator, group).propagate_grid(self.grid)
        states: Array = found[-1] if isinstance(found, tuple) else found
        return states


def measure(contenders: list[Contender], turns: int, *, core_seconds: bool) -> None:
    """Time all contenders in turn on each number of cores."""
    clock = time.process_time if core_seconds else time.perf_counter
    for cores in CORES:
        if cores == 1:
            one_core = {max(os.sched_getaffinity(0))}
            before = os.sched_getaffinity(0)
            os.sched_setaffinity(0, one_core)
        for _ in range(turns):
            for contender in contenders:
                begun = clock()
                contender.run(cores)
                spent = clock() - begun
                contender.seconds[cores] = min(spent, contender.seconds.get(cores, np.inf))
        if cores == 1:
            os.sched_setaffinity(0, before)


def seconds_at(contenders: list[Contender], name: str, cores: int, target: float) -> float:
    """Time of a contender at an error; infinite where it does not reach it."""
    own = sorted((c for c in contenders if c.name == name), key=lambda c: c.error_rad)
    errors, spent = np.log([c.error_rad for c in own]), np.log([c.seconds[cores] for c in own])
    if not errors[0] <= np.log(target) <= errors[-1]:
        return np.inf
    return float(np.exp(np.interp(np.log(target), errors, spent)))


@click.command()
@click.option("--members", default=1000, show_default=True, help="Run this number of copies, a multiple of 8.")
@click.option("--turns", default=5, show_default=True, help="Take the least time of this number of turns.")
@click.option("--width", "widths", multiple=True, type=int, default=WIDTHS, show_default=True, help="Widths of heyoka.")
@click.option("--tolerance", "tolerances", multiple=True, type=float, default=TOLERANCES, help="Tolerances of all.")
@click.option("--compact", is_flag=True, help="Compile heyoka in compact mode, in a tenth of the time.")
@click.option("--lanes-only", is_flag=True, help="Leave out one chain at a time.")
@click.option("--core-seconds", is_flag=True, help="Measure seconds of cores, for a machine with other work.")
def main(
    members: int, turns: int, widths: tuple[int, ...], tolerances: tuple[float, ...], compact: bool, lanes_only: bool,
    core_seconds: bool,
) -> None:  # fmt: skip
    """Measure the time of an ensemble at equal error."""
    scene = shortened(load_scene(SCENE), 1.0, SAMPLES)
    population = populate(scene, (parse(SPREAD, scene.bars),), members, seed=1)
    segment = np.array([[scene.times_s[0], scene.times_s[-1]]])
    ways = {
        "lanes": lambda one: run_lanes(one, scene.times_s),
        "one chain at a time": lambda one: run_batch(one, scene.times_s, segment),
    }
    used = list(ways)[:1] if lanes_only else list(ways)
    contenders = [ours(name, ways[name], population, rtol) for name in used for rtol in tolerances]
    rivals = [HeyokaBatch(population, width) for width in widths]
    contenders += [rival.contender(tolerance, compact=compact) for rival in rivals for tolerance in tolerances]
    exact = rivals[0].contender(FINEST, compact=True).angle_rad()
    for contender in contenders:
        difference = np.abs(contender.angle_rad() - exact).max(axis=(1, 2))
        contender.error_rad = float(np.median(difference))
    measure(contenders, turns, core_seconds=core_seconds)
    report(contenders, members, "core seconds" if core_seconds else "seconds")


def report(contenders: list[Contender], members: int, unit: str) -> None:
    """Print the times of all points, and ratios at equal error."""
    click.echo(f"{processor()}; {members} copies of {SCENE}, one orbit, {SAMPLES} samples; {unit} of a copy\n")
    for contender in contenders:
        spent = "".join(f"{span_text(contender.seconds[cores] / members):>12s}" for cores in CORES)
        click.echo(f"{contender.name:22s}{contender.tolerance:9.0e}{contender.error_rad:12.1e} rad{spent}")
    names = list(dict.fromkeys(c.name for c in contenders))
    for target in TARGETS_RAD:
        click.echo(f"\nto {target:g} rad on {' and '.join(map(str, CORES))} cores; relative to lanes")
        base = [seconds_at(contenders, "lanes", cores, target) for cores in CORES]
        for name in names:
            spent = [seconds_at(contenders, name, cores, target) for cores in CORES]
            text = "".join(f"{span_text(s / members):>12s} x{s / b:5.2f}" for s, b in zip(spent, base, strict=True))
            click.echo(f"{name:22s}{text}")


if __name__ == "__main__":
    main()
