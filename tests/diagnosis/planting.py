"""A scene on which every mistake shows, and results with known mistakes in them."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.judge.compare import judge
from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.reading import Reading, Timing
from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict, verdict_tolerance
from barchain.judge.evidence import Evidence
from barchain.metrics.quantities import arrays
from barchain.runs.job import RunResult
from barchain.solutions.judging import solution_engine
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.solutions import run, solution_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Engine
    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.diagnosis.mistake import Mistake
    from barchain.judge.verdict import Verdict
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    DenseRuns = Callable[[Scene, Scene], tuple[Trajectory, Trajectory]]

RTOL = 1e-9
"""Accuracy of the planted results; the judging solution has 1e-13"""


def unequal_chain(samples: int = 101, duration_s: float = 2000.0) -> Scene:
    """Three unequal bars at longitude 30 degrees, no inertia slender, on an eccentric orbit."""
    base, mass_kg, length_m = load_scene("paper/fig05"), (80.0, 50.0, 30.0), (60.0, 100.0, 40.0)
    shapes = zip(mass_kg, length_m, (1.3, 1.1, 1.5), strict=True)
    chain = dataclasses.replace(
        base.chain,
        mass_kg=mass_kg,
        length_m=length_m,
        inertia_kg_m2=tuple(f * m * size**2 / 12.0 for m, size, f in shapes),
        angle_rad=tuple(np.radians([20.0, -35.0, 50.0]).tolist()),
        rate_factor=(1.0, 0.6, 1.7),
    )
    orbit = dataclasses.replace(base.orbit, longitude_rad=float(np.radians(30.0)), speed_factor=1.05)
    run = dataclasses.replace(base.run, duration_s=duration_s, samples=samples)
    return dataclasses.replace(base, chain=chain, orbit=orbit, run=run)


def planted(scene: Scene, mistake: Mistake, rtol: float, motion: Trajectory | None = None) -> Trajectory | None:
    """Result with a mistake of reading, of a right or a given motion; None if it changes nothing in the scene."""
    if isinstance(mistake, Reading):
        right = motion or run(scene, rtol)
        read = mistake.read(scene, right)
        return None if read is right else with_known_samples(read, right)
    assert isinstance(mistake, Timing)
    return late(scene, mistake, rtol)


def dense_runs(change: Callable[[Scene], Scene]) -> DenseRuns:
    """Runs of an engine that takes another scene for the given one."""
    return lambda scene, twice: (run(change(scene), RTOL), run(change(twice), 0.1 * RTOL))


def diagnosis_of_runs(scene: Scene, main: Trajectory, finer: Trajectory, dense: DenseRuns | None = None) -> Diagnosis:
    """Diagnosis of two runs of an engine."""
    solved = solution_of(scene)
    return diagnose(scene, main, solved, verdict_tolerance(verdict_on(main, finer, solved)), dense)


def diagnosis_of_scene(scene: Scene, change: Callable[[Scene], Scene]) -> Diagnosis:
    """Diagnosis of an engine that takes another scene for the given one."""
    solved, (main, finer) = solution_of(scene), dense_runs(change)(scene, scene)
    impulse = scene.effects.impulse
    main, finer = (t.replace(impulse_N_s=np.zeros_like(t.reaction_N)) if impulse and t.impulse_N_s is None else t
                   for t in (main, finer))  # fmt: skip
    return diagnosis_of_verdict(verdict_on(main, finer, solved), main, solved, dense_runs(change))


def late(scene: Scene, mistake: Timing, rtol: float) -> Trajectory:
    """Result with delayed samples; the sample outside the run is the right one."""
    right = run(scene, rtol)
    halves = dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=2 * scene.run.samples - 1))
    read = mistake.read(right, run(halves, rtol))
    assert read is not None
    return with_known_samples(read, right)


def with_known_samples(read: Trajectory, right: Trajectory) -> Trajectory:
    """Altered reading with right values at the samples of which it says nothing."""
    known = {name: (values, getattr(right, name)) for name, values in arrays(read).items()}
    return read.replace(**{name: np.where(np.isnan(a), b, a) for name, (a, b) in known.items()})


def verdict_on(
    main: Trajectory, finer: Trajectory, solved: ReferenceSolution, engine: str = "", **at: Setting
) -> Verdict:
    """Verdict on two runs of an engine; of the reference at `RTOL` by default."""
    loaded: type[Engine] = ENGINES[engine or solution_engine()].load()
    evidence = Evidence(RunResult(Outcome.PASS, trajectory=main), RunResult(Outcome.PASS, trajectory=finer))
    setting = at.get("setting", Setting(AccuracyParameter.RTOL, RTOL) if not engine else loaded.sweep.setting())
    return judge("engine", loaded, setting, evidence, solved)


def runs_of(engine: str, scene: Scene, setting: Setting | None = None) -> tuple[Trajectory, Trajectory]:
    """Main and finer run of an engine at its default setting."""
    loaded = ENGINES[engine].load()
    main = setting or loaded.sweep.setting()
    return loaded().run(scene, main), loaded().run(scene, finer_setting(scene, loaded.sweep, main))
