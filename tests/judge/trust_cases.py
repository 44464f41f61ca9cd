"""Runs, verdicts and disturbed results for the tests of a pass."""

import dataclasses

import numpy as np

from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from scenarios import load_scene

SETTING = Setting(AccuracyParameter.RTOL, 1e-8)


def lasting(name, orbits, samples):
    scene = load_scene(name)
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=orbits * scene.period_s, samples=samples)
    )


def with_a_heavier_bar(scene):
    mass_kg = (*scene.chain.mass_kg[:-1], 1.1 * scene.chain.mass_kg[-1])
    return dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, mass_kg=mass_kg))


def judged(solution, main, finer, engine=Reference, setting=SETTING, **more):
    evidence = Evidence(RunResult(Outcome.PASS, trajectory=main), RunResult(Outcome.PASS, trajectory=finer), **more)
    return judge("x", engine, setting, evidence, solution)


def value(verdict, quantity, metric):
    return next(r["value"] for r in verdict.rows if (r["quantity"], r["metric"]) == (quantity, metric))


def garbage(seen, share, *, growing, seed):
    """Nonsense in all channels, rates and velocities too, from a share on: 1400 km, radians, several newtons."""
    rng = np.random.default_rng(seed)
    reached = np.clip((seen.t_s / seen.t_s[-1] - share) / (1.0 - share), 0.0, 1.0)
    weight = 1e-9 * np.expm1(reached * np.log(1e9)) if growing else (reached > 0.0).astype(float)

    def disturbed(values, size):
        pushed = size * rng.uniform(0.5, 1.5, values.shape) * rng.choice([-1.0, 1.0], values.shape)
        return values + weight.reshape(-1, *[1] * (values.ndim - 1)) * pushed

    return seen.replace(
        com_m=disturbed(seen.com_m, 1.4e6),
        com_velocity_m_s=disturbed(seen.com_velocity_m_s, 1e3),
        angle_rad=disturbed(seen.angle_rad, 1.0),
        rate_rad_s=disturbed(seen.rate_rad_s, 1e-3),
        reaction_N=disturbed(seen.reaction_N, 5.0),
    )


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
