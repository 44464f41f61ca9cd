"""Other engines' runs of the study's scene, in the inertial frame and in one that moves with the chain.

Each member starts at another longitude, which no reaction and no attitude knows of, and is judged as the study's own
runs are. A short part of an orbit is enough: what is looked for is noise, and it is there from the first steps on.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.equal_steps import steps_between_samples
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.registry import find_engine
from adapters.trajectory import Observable
from barchain.runs.asking import declarations_of
from barchain.runs.phases import exception_words
from barchain.runs.trajectory_checks import fault
from barchain.studies.roundoff.evaluation import SHARES, quantiles
from barchain.studies.roundoff.formulations import EQUATOR_M
from barchain.studies.roundoff.trajectories import MARGIN, judged
from reference_impl.precision.coordinates import ChainObservables
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.registry import Registration
    from adapters.trajectory import Array, Trajectory
    from barchain.studies.roundoff.trajectories import HighPrecisionSolution, ScaledScene
    from scenarios import Scene

INERTIAL, MOVING = "inertial", "moving"
APART = "-absolute"  # in the name of an engine's counterpart in the inertial frame
SETTLED = 0.5  # of a run, after which errors are judged: index 3 starts its multipliers with an error of first order in
# the step and damps it in some 50 steps, which is neither truncation of the method's order nor round-off
QUANTITIES = {"attitude": Observable.ATTITUDE, "reaction": Observable.REACTION, "gap": Observable.GAP}


@dataclass(frozen=True)
class RunFault:
    """Why a run gives no errors."""

    outcome: Outcome
    reason: str


def engine_rows(solution: HighPrecisionSolution, name: str, size: int, value: float) -> list[dict[str, Any]]:
    """Rows of the table `engines` for one engine at one size and setting, one for each quantity that it shows.

    Parameters
    ----------
    solution : HighPrecisionSolution
    name : str
        Registered name; an engine with a counterpart in the other frame goes by the same name as that in the table.
    size : int
        Place of the size ratio in the high-precision solution's family.
    value : float
        Steps in an orbit (those of the scene's own period, as in the table `trajectories`), or what is asked of a step.

    Returns
    -------
    list of dict
        Errors are NaN where no member has any; where some have not, theirs are infinite and the reason counts them.

    Raises
    ------
    UnknownEngineError
        If there is no such engine.
    """
    registration, family = find_engine(name), solution.family
    engine, ratio = declarations_of(registration), family.ratios[size]
    longitudes = np.random.default_rng(family.members).uniform(0.0, 2.0 * np.pi, family.members)
    scenes = [scene_at(family, ratio, longitude) for longitude in longitudes.tolist()]
    setting = setting_of(engine, scenes[0], value)
    head = {"engine": name.replace(APART, ""), "frame": frame_of(engine), "ratio": ratio, **columns(scenes[0], setting)}
    shown = [q for q, observable in QUANTITIES.items() if observable in engine.observables]
    rejection = RunFault(Outcome.MISSING, registration.missing) if registration.missing else rejected(engine, scenes[0])
    if rejection:
        return [head | empty(q, rejection) for q in shown]
    runs = [attempt(registration, engine, scene, setting) for scene in scenes]
    return [head | row for row in judged_rows(solution, size, longitudes, runs, shown)]


def judged_rows(
    solution: HighPrecisionSolution, size: int, longitudes: Array, runs: list[Trajectory | RunFault], shown: list[str]
) -> list[dict[str, Any]]:
    """Quantiles of each quantity, and the outcomes of the runs."""
    faults = [run for run in runs if isinstance(run, RunFault)]
    whole = [not isinstance(run, RunFault) for run in runs]
    if not any(whole):
        return [empty(q, faults[0]) for q in shown]
    seen = instants([run for run in runs if not isinstance(run, RunFault)])
    found = judged(solution, seen, longitudes[whole], np.full(len(seen[0].gap_m), size))
    rows = []
    for quantity in shown:
        errors = np.full(len(runs), np.inf)
        errors[whole] = settled(found[quantity])
        spread = quantiles(errors)
        known = quantity == "gap" or spread["median"] >= MARGIN * solution.error[quantity][size]
        rows.append({"quantity": quantity, **spread, "known": bool(known), **ending(faults, len(runs))})
    return rows


def settled(errors: Array) -> Array:
    """Largest of errors (samples, B) in the later part of each run, (B,)."""
    largest: Array = errors[int(SETTLED * len(errors)) :].max(axis=0)
    return largest


def ending(faults: list[RunFault], members: int) -> dict[str, Any]:
    """Outcome and reason of an ensemble that has errors to show."""
    if not faults:
        return {"outcome": str(Outcome.REPORTED), "reason": ""}
    return {"outcome": str(faults[0].outcome), "reason": f"{len(faults)} of {members} runs: {faults[0].reason}"}


def empty(quantity: str, fault: RunFault) -> dict[str, Any]:
    """Row without errors."""
    none = dict.fromkeys(SHARES, np.nan)
    said = {"outcome": str(fault.outcome), "reason": fault.reason}
    return {"quantity": quantity, **none, "members": 0, "known": False, **said}


def attempt(registration: Registration, engine: Declarations, scene: Scene, setting: Setting) -> Trajectory | RunFault:
    """Run one member; whatever goes wrong is its own."""
    try:
        found = registration.engine().run(scene, setting)
    except EngineError as error:
        return RunFault(Outcome.FAILED, str(error))
    except Exception as error:
        return RunFault(Outcome.FAILED, exception_words(error))
    if found.ended:
        return RunFault(Outcome.INCOMPLETE, found.ended)
    wrong = fault(scene, engine, found)
    return RunFault(*wrong) if wrong else found


def rejected(engine: Declarations, scene: Scene) -> RunFault | None:
    """Why an engine can't do the scene."""
    reason = engine.unsupported(scene)
    return RunFault(Outcome.UNSUPPORTED, reason) if reason else None


def instants(runs: list[Trajectory]) -> list[ChainObservables]:
    """Runs side by side at each sample after the start."""
    return [instant(runs, k) for k in range(1, len(runs[0].t_s))]


def instant(runs: list[Trajectory], k: int) -> ChainObservables:
    """Sample `k` of all runs; gaps are NaN where an engine shows none."""
    angle = np.array([run.angle_rad[k] for run in runs if run.angle_rad is not None]).T
    reaction = np.array([run.reaction_N[k].T for run in runs if run.reaction_N is not None])
    gap = np.array([np.nan if run.gap_m is None else run.gap_m[k].max() for run in runs])
    return ChainObservables(angle, np.moveaxis(reaction, 0, -1), gap, np.array([run.com_m[k] for run in runs]).T)


def frame_of(engine: Declarations) -> str:
    """Inertial, or moving with the chain in any way."""
    return INERTIAL if engine.coordinates.absolute else MOVING


def setting_of(engine: Declarations, scene: Scene, value: float) -> Setting:
    """Setting of an engine's accuracy parameter, whose unit of steps may be another orbit than the scene's own."""
    parameter = engine.sweep.parameter
    return Setting(
        parameter,
        value * scene.step_period_s / scene.period_s if parameter is AccuracyParameter.STEPS_PER_ORBIT else value,
    )


def columns(scene: Scene, setting: Setting) -> dict[str, float]:
    """Steps really taken in an orbit, or the tolerance."""
    if setting.parameter is AccuracyParameter.RTOL:
        return {"rtol": setting.value}
    steps = steps_between_samples(scene, setting.value) * (scene.run.samples - 1)
    return {"steps_per_orbit": steps * scene.period_s / scene.run.duration_s}


def scene_at(family: ScaledScene, ratio: float, longitude_rad: float) -> Scene:
    """Scene of a family's run: its chain scaled, its orbit turned."""
    scene, chain = family.scene, family.scene.chain
    scale = ratio * EQUATOR_M / max(chain.length_m)
    return dataclasses.replace(
        scene,
        orbit=dataclasses.replace(scene.orbit, longitude_rad=longitude_rad),
        chain=dataclasses.replace(
            chain,
            length_m=tuple(scale * length for length in chain.length_m),
            inertia_kg_m2=tuple(scale * scale * inertia for inertia in chain.inertia_kg_m2),
        ),
        run=dataclasses.replace(scene.run, duration_s=family.orbits * scene.period_s, samples=family.samples + 1),
    )
