"""One orbit of a chain of ten thousand bars: its time, its steps and the peak of its memory.

    python benchmarks/ten_thousand_bars.py [--orbits 1.0] [--bars 10000] [--rtol 1e-6]

The fastest mode of a chain at an angle is about 2.1 N times the orbit's rate: steps grow as N, an evaluation as N, time
as N². Memory grows as N; the project promises a gibibyte for ten thousand bars, and the command exits with 1 beyond it.
"""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import replace

import click

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.run.timing.divided_chain import divided
from scenarios import load_scene

SCENE = "hard/bars_10000"
SAMPLES = 21
GIBIBYTE_KIB = 2**20


@click.command()
@click.option("--orbits", default=1.0, show_default=True)
@click.option("--bars", default=10_000, show_default=True)
@click.option("--rtol", default=1e-6, show_default=True)
def main(orbits: float, bars: int, rtol: float) -> None:
    """Run it once and print what it took."""
    scene = load_scene(SCENE)
    scene = scene if bars == scene.bars else divided(scene, bars)
    scene = replace(scene, run=replace(scene.run, duration_s=orbits * scene.period_s, samples=SAMPLES))
    engine = ReferenceFast()
    engine.build(scene, Setting(AccuracyParameter.RTOL, rtol))
    start = time.perf_counter()
    engine.simulate()
    seconds = time.perf_counter() - start
    seen = engine.read()
    peak_KiB = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    click.echo(f"{bars} bars, {orbits:g} orbits at rtol {rtol:g}: {seen.info['steps']} steps, {seconds:.0f} s")
    click.echo(
        f"peak {peak_KiB / 1024:.0f} MiB, largest gap {seen.gap_m.max():.1e} m" if seen.gap_m is not None else ""
    )
    sys.exit(peak_KiB > GIBIBYTE_KIB)


if __name__ == "__main__":
    main()
