"""Measure the ratios that the project claims, in one run.

    python benchmarks/speed.py [--history FILE]

One evaluation of the compiled reference against the number of bars; times to reach an attitude error on a scene's first
orbit, engines taken in turn on one core, the least of the repeats, straight between the points of their sweeps in both
logarithms, compiling apart; an ensemble of ten thousand orbits.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
import pandas as pd

from barchain.record.environment import now, processor
from barchain.studies.cost.findings import curve_of
from barchain.studies.cost.study import cost_study
from barchain.studies.defaults import BARS, DIVIDED_SCENE, FAST
from barchain.studies.ensemble.study import ensemble
from barchain.studies.scaling.study import FAST_BARS, exponent
from barchain.studies.study import Reporter, run_study
from barchain.studies.timing.bench import pin, quietest_core
from barchain.studies.timing.evaluation import divided, evaluation_times, loop_of
from barchain.studies.timing.statistics import cost_at, locate
from reports.results.cost import FILES
from reports.text.numerals import span_text
from scenarios import load_scene

ORBIT = "paper/fig05"
TARGETS_RAD = (1e-4, 1e-8, 1e-10, 1e-11)
EXUDYN = "exudyn"  # its configurations share this first word; the fastest of them counts
RIVALS = ("heyoka", EXUDYN, "mujoco", "scipy-dop853")
ENGINES = (FAST, "heyoka", "exudyn", "exudyn-index3", "exudyn-absolute", "exudyn-tree", "mujoco", "scipy-dop853")
SHOWN_BARS = (5, 500, 100_000)
TURNS = 15
RUNS, RTOL, SPREAD = 10_000, 1e-8, "angle_deg=normal(0, 0.1)"
ENSEMBLES = 3  # of which the least time counts

Found = dict[str, float | str]


def evaluations() -> Found:
    """Time of an evaluation at :data:`SHOWN_BARS`, and its exponent."""
    first, last = FAST_BARS
    bars = sorted({*SHOWN_BARS, *(n for n in BARS if first <= n <= last)})
    scene, found = load_scene(DIVIDED_SCENE), {}
    for n in bars:
        found[n] = float(evaluation_times([loop_of(FAST, divided(scene, n))], TURNS).min())
    fitted = [n for n in bars if n >= first]
    power = exponent(np.array(fitted, float), np.array([found[n] for n in fitted]))
    assert power is not None
    for n in SHOWN_BARS:
        click.echo(f"one evaluation, N = {n:<8d}{span_text(found[n]):>10s}{1e9 * found[n] / n:10.2f} ns a bar")
    click.echo(f"exponent, N = {first} ... {last}: {power.value:.3f} ({power.low:.3f} to {power.high:.3f})\n")
    return {f"evaluation_{n}_s": found[n] for n in SHOWN_BARS} | {"exponent": power.value}


def orbits(minutes: float) -> Found:
    """Times to reach :data:`TARGETS_RAD`, and what others take over the compiled reference."""
    with tempfile.TemporaryDirectory() as folder:
        study = cost_study([ORBIT], ENGINES, minutes=minutes)
        run_study(study, Path(folder), reporter=Reporter(lambda *_: click.echo(".", nl=False, err=True)))
        tables = FILES.contents(Path(folder), "points", "times")
        points, least = tables.points, tables.times.groupby(["engine", "setting"]).seconds.min()
    click.echo(err=True)
    points = points.drop(columns="seconds").join(least, on=["engine", "setting"])
    compiled = points.groupby("engine").compile_s.max()
    found: Found = {}
    for target in TARGETS_RAD:
        found |= row(points, target)
    for engine in (FAST, "heyoka"):
        click.echo(f"{engine}: compiling and importing {span_text(float(compiled[engine]))}")
        found[f"compile_{engine}_s"] = float(compiled[engine])
    return found


def row(points: pd.DataFrame, target: float) -> Found:
    """Times at one error, printed."""
    times = {engine: seconds(points, engine, target) for engine in ENGINES}
    mine = times[FAST]
    click.echo(f"{ORBIT} to {target:g} rad: {FAST} {span_text(mine) if np.isfinite(mine) else 'does not reach it'}")
    found: Found = {f"{FAST}_{target:g}_s": mine}
    for rival in RIVALS:
        name = min(
            (e for e in ENGINES if e == rival or (rival == EXUDYN and e.startswith(EXUDYN))), key=times.__getitem__
        )
        ratio = times[name] / mine
        said = f"{span_text(times[name])}, x {ratio:.3g}" if np.isfinite(ratio) else "not reached"
        said += ", at most: its coarsest run is better" if better_at_once(points, name, target) else ""
        click.echo(f"    {name:16s}{said}")
        found |= {f"{rival}_{target:g}_ratio": ratio}
    return found


def seconds(points: pd.DataFrame, engine: str, target: float) -> float:
    """Time of an engine at an error; infinite where it does not reach it."""
    curve = curve_of(points[points.engine == engine], "attitude", "seconds", {})
    place = locate(curve, target)
    return np.inf if place is None else cost_at(curve, place)


def better_at_once(points: pd.DataFrame, engine: str, target: float) -> bool:
    """Whether even an engine's coarsest run is better than an error, so that its time there is only a bound."""
    place = locate(curve_of(points[points.engine == engine], "attitude", "seconds", {}), target)
    return place is not None and place.at_most


def many() -> Found:
    """Time of an ensemble, on all cores."""
    ensemble(ORBIT, [SPREAD], runs=100, rtol=RTOL, orbits=1.0)  # compiles
    runs = [ensemble(ORBIT, [SPREAD], runs=RUNS, rtol=RTOL, orbits=1.0) for _ in range(ENSEMBLES)]
    run = min(r.seconds["run"] for r in runs)
    whole = min(sum(r.seconds.values()) for r in runs)
    click.echo(
        f"\nensemble of {RUNS} orbits at {RTOL:g}: {span_text(run)}, with drawing and quantiles {span_text(whole)}"
    )
    return {"ensemble_run_s": run, "ensemble_s": whole}


@click.command()
@click.option("--minutes", default=4.0, show_default=True, help="For the times at equal error.")
@click.option("--history", type=click.Path(path_type=Path, dir_okay=False), help="CSV to append a line to.")
def main(minutes: float, history: Path | None) -> None:
    """Measure the ratios that the project claims, in one run."""
    click.echo(f"{processor()}\n")
    found = many()  # first: it uses all cores, the others are pinned to one
    click.echo()
    found |= orbits(minutes)
    click.echo()
    pin(quietest_core())
    found |= evaluations()
    if history:
        line = pd.DataFrame([{"when": now(), "cpu": processor()} | found])
        line.to_csv(history, mode="a", header=not history.exists(), index=False)


if __name__ == "__main__":  # engines run in worker processes, which import this script
    main()
