"""Support of a scene by engines with independent physics: effects they lack, instants they reject, certified solutions.

Engines of equal steps reject instants at which no step ends. Such a rejection is no lack of an effect: another run of
the same scene may have every instant at a step's end, see :mod:`barchain.studies.comparison.external_coverage`.
"""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from adapters.common.step_alignment import half_interval_s, inner_events_s, misalignment, off_step_events_s
from adapters.registry import ENGINES
from barchain.runs.asking import AdapterLoadError, declarations_of, engine_fault
from barchain.solutions.certified_file import head_of, physics_digest, shipped_files
from barchain.solutions.judging import WORDS
from barchain.solutions.reference import SolutionSource
from reports.results.outcome import Outcome
from scenarios.scene import Run

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import pandas as pd

    from adapters.engine import Declarations
    from adapters.registry import Registration
    from scenarios import Scene

MAX_SUGGESTED_SAMPLES = 20_001
"""Largest number of samples of a suggested run"""


def external_coverage(scene: Scene, requested: Mapping[str, Registration]) -> dict[str, Any]:
    """Entry of the record: requested engines with independent physics that can't run the scene, and others that may.

    Engines that were not requested are asked nothing: what they declare tells which effects they have.

    Returns
    -------
    dict
        ``lack``: effects that each engine lacks; ``instants``: see :func:`unaligned_instants`; ``not_requested``:
        engines of barchain with independent physics that have the scene's effects; ``not_installed``: such
        engines whose library is not installed; ``not_loaded``: message of each installed engine whose adapter does not
        load; ``solution``: precision of its certified solution, or empty.
    """
    others = {name: r for name, r in ENGINES.items() if name not in requested and r.in_default_set}
    failures: dict[str, str] = {}
    independent = loaded({name: r for name, r in requested.items() if not r.missing}, failures)
    supporting = [name for name, e in loaded(others, failures).items() if scene.needs.issubset(e.effects)]
    installed = {name for name, r in (others | dict(requested)).items() if not r.missing}
    committed = shipped_files().get(physics_digest(scene))
    return {
        "lack": {
            name: sorted(lacking)
            for name, engine in independent.items()
            if (lacking := scene.needs.difference(engine.effects))
        },
        "instants": unaligned_instants(scene, independent),
        "not_requested": [name for name in supporting if name in installed],
        "not_installed": [name for name in supporting if name not in installed],
        "not_loaded": {name: said for name, said in failures.items() if name in installed},
        "solution": "" if committed is None else head_of(committed)["precision"],
    }


def loaded(registrations: Mapping[str, Registration], failures: dict[str, str]) -> dict[str, Declarations]:
    """Declarations of the engines with independent physics; messages of broken adapters go to `failures`."""
    found: dict[str, Declarations] = {}
    for name, registration in registrations.items():
        if not registration.external:
            continue
        try:
            found[name] = declarations_of(registration)
        except Exception as error:
            failures[name] = error.reason if isinstance(error, AdapterLoadError) else engine_fault(error)
    return found


def rejects(engine: Declarations, scene: Scene) -> bool:
    """Whether an engine gives a reason against a scene; one that fails to answer gives none."""
    try:
        return engine.unsupported(scene) is not None
    except Exception:
        return False


def unaligned_instants(scene: Scene, independent: Mapping[str, Declarations]) -> dict[str, Any]:
    """Engines that reject a scene for its instants alone, those instants (s), and a run that they would support.

    The cause is tested with the same scene and every instant at a sample.
    """
    if misalignment(scene) is None:
        return {}
    run = fitting_run(scene)
    trial = aligned(scene) if run is None else with_run(scene, run)
    rejecting = [name for name, e in independent.items() if rejects(e, scene) and not rejects(e, trial)]
    if not rejecting:
        return {}
    off = off_step_events_s(scene)
    return {"engines": rejecting, "at_s": off, "run": None if run is None else dataclasses.asdict(run)}


def instants_advice(scene: Scene, requested: Mapping[str, Registration]) -> str:
    """Advice for a scene that some engines reject for its instants alone; empty where another run helps none."""
    rejecting = None if misalignment(scene) is None else external_coverage(scene, requested)["instants"].get("engines")
    if not rejecting:
        return ""
    run, half_s = fitting_run(scene), half_interval_s(scene)
    said = f"instants alone stop {', '.join(rejecting)}: engines of equal steps support instants at samples or midway "
    said += f"between two, multiples of {half_s:g} s here"
    if run is None:
        return f"{said}; no run of up to {MAX_SUGGESTED_SAMPLES} samples has each instant at one: move the instants"
    return f"{said}; with duration_s = {run.duration_s:.12g} and samples = {run.samples} in [run] each instant is one"


def unchecked_attitudes(
    metrics: pd.DataFrame,
    outcomes: Mapping[tuple[str, str], Outcome],
    independent: Collection[str],
    record: Mapping[str, Any],
) -> dict[str, list[str]]:
    """Scenes judged by the reference in which only engines on its equations pass with an attitude, and these engines.

    Parameters
    ----------
    metrics : DataFrame
        Rows of a comparison.
    outcomes : mapping of tuple of str to Outcome
        By scene and engine.
    independent : collection of str
        Engines with independent physics.
    record : mapping
        Record of the comparison.
    """
    compared = metrics.query("quantity == 'attitude' and metric == 'normalised_error'")
    found: dict[str, list[str]] = {}
    for scene, engine in zip(compared.scene, compared.engine, strict=True):
        by_reference = record["scenes"][scene].get("solution_source") == WORDS[SolutionSource.REFERENCE]
        if by_reference and outcomes.get((scene, engine)) is Outcome.PASS:
            found.setdefault(scene, []).append(engine)
    return {scene: names for scene, names in found.items() if not set(names) & set(independent)}


def with_run(scene: Scene, run: Run) -> Scene:
    """`scene` over another run; what lasts to the old end lasts to the new one."""
    end_s = scene.run.duration_s
    effects = scene.effects.at_instants(lambda t: run.duration_s if t == end_s else t)
    return dataclasses.replace(scene, run=run, effects=effects)


def fitting_run(scene: Scene) -> Run | None:
    """Run of as many samples as the scene's, or a few more, in which every instant is a sample or midway between two.

    The scene's own duration is kept if possible, else extended to the next multiple of the instants' common divisor.
    None where the run would need more than :data:`MAX_SUGGESTED_SAMPLES`.
    """
    instants = [Fraction(repr(t)) for t in inner_events_s(scene)]
    scale = common_denominator(instants)
    shared = Fraction(math.gcd(*(int(t * scale) for t in instants)), scale)
    own = Fraction(repr(scene.run.duration_s))
    for duration in (own, math.ceil(own / shared) * shared):
        halves = common_denominator([t / duration for t in instants])  # duration/halves goes into every instant
        unit = halves // 2 if halves % 2 == 0 else halves
        run = Run(float(duration), math.ceil(Fraction(scene.run.samples - 1, unit)) * unit + 1)
        if run.samples <= max(MAX_SUGGESTED_SAMPLES, scene.run.samples):
            return run
    return None


def common_denominator(values: list[Fraction]) -> int:
    """Smallest positive integer whose product with each value is an integer."""
    return math.lcm(*(v.denominator for v in values))


def aligned(scene: Scene) -> Scene:
    """`scene` with its tables in time, impulses and manoeuvres at the nearest samples."""
    every = scene.run.duration_s / (scene.run.samples - 1)

    def near(t_s: float) -> float:
        return every * round(t_s / every)

    effects = scene.effects.at_instants(near)
    laws = (law.with_turns(lambda t: dataclasses.replace(t, duration_s=t.duration_s or every))
            for law in effects.prescribed_rotation)  # fmt: skip
    return dataclasses.replace(scene, effects=dataclasses.replace(effects, prescribed_rotation=tuple(laws)))
