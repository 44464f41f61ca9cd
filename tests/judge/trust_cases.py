"""Runs, verdicts and disturbed results for the tests of a pass."""

import dataclasses
import functools
from types import SimpleNamespace

import numpy as np

from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.reference.numpy_engines import Reference
from barchain.faults.readings import garbage as planted_garbage
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.runs.job import RunResult
from barchain.solutions.reference import establish, with_perturbed_start
from reports.tables.outcome import Outcome
from scenarios import load_scene

SETTING = Setting(AccuracyParameter.RTOL, 1e-8)


def run(scene, rtol):
    return Reference().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def lasting(name, orbits, samples):
    scene = load_scene(name)
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=orbits * scene.period_s, samples=samples)
    )


@functools.cache
def solution_of(scene):
    return establish(scene, run(scene, 1e-13), run(scene, 1e-12), run(with_perturbed_start(scene), 1e-13))


def judged(solution, main, finer, engine=Reference, setting=SETTING, **more):
    evidence = Evidence(RunResult(Outcome.PASS, trajectory=main), RunResult(Outcome.PASS, trajectory=finer), **more)
    return judge("x", engine, setting, evidence, solution)


def value(verdict, quantity, metric):
    return next(r["value"] for r in verdict.rows if (r["quantity"], r["metric"]) == (quantity, metric))


def garbage(seen, share, *, growing, seed):
    """Garbage of the catalogue, from a share of the run on: 1400 km, radians, several newtons."""
    scene = SimpleNamespace(run=SimpleNamespace(duration_s=seen.t_s[-1]))
    return planted_garbage(share, growing=growing)(seen, scene, 1.0, np.random.default_rng(seed))


def three_settings(engine, scene):
    main = engine.sweep.setting()
    finer = finer_setting(scene, engine.sweep, main)
    finest = finer_setting(scene, engine.sweep, finer)
    return main, [engine().run(scene, s) for s in (main, finer, finest)]


def cut(seen, samples, ended="a bar reached the surface"):
    rows = {name: v[:samples] for name, v in vars(seen).items() if isinstance(v, np.ndarray)}
    return dataclasses.replace(seen, **rows, ended=ended)


class NoisyReference(Reference.__mro__[1]):  # the abstract base of the NumPy forms
    """Says that it is as noisy as its results are large."""

    title, coordinates, coordinate_set = "noisy", Coordinates.RELATIVE, "minimal"

    @classmethod
    def noise(cls, scene, setting, t_s):
        return {"reaction": 1e9, "attitude": 1e9, "rate": 1e9, "com": 1e12, "com_velocity": 1e9}


class JustBelieved(NoisyReference):
    """Declares rates just less noisy than is believed: with that in the start, no restart could predict anything."""

    @classmethod
    def noise(cls, scene, setting, t_s):
        return {"rate": 0.0099 * scene.fastest_rate_rad_s}
