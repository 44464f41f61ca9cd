"""Support of a scene by engines with independent physics: effects they lack, instants they reject, certified solutions.

Engines of equal steps reject instants at which no step ends. Such a rejection is no lack of an effect: another run of
the same scene may have every instant at a step's end, see :mod:`barchain.crossval.suggested_run`.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from adapters.common.step_alignment import misalignment, off_step_events_s
from adapters.registry import engines
from barchain.crossval.suggested_run import aligned, fitting_run, run_advice, with_run
from barchain.runs.declared import AdapterLoadError, engine_class, engine_fault
from barchain.solutions.certified import committed_tables
from barchain.solutions.certified_table import physics_digest, read_head
from barchain.solutions.judging import WORDS
from barchain.solutions.reference import SolutionSource
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import pandas as pd

    from adapters.engine import Engine
    from adapters.registry import Registration
    from scenarios import Scene


def external_coverage(scene: Scene, requested: Mapping[str, Registration]) -> dict[str, Any]:
    """Entry of record.json: requested engines with independent physics that can't run the scene, and others that can.

    Returns
    -------
    dict
        ``lack``: effects that each engine lacks; ``instants``: see :func:`unaligned_instants`; ``not_requested``:
        engines with independent physics that support the scene; ``not_installed``: such engines whose library is not
        installed; ``not_loaded``: message of each installed engine whose
        adapter does not load; ``solution``: precision of its certified solution, or empty.
    """
    others = {name: r for name, r in engines().items() if name not in requested and r.in_default_set}
    failures: dict[str, str] = {}
    independent = loaded({name: r for name, r in requested.items() if not r.missing}, scene, failures)
    supporting = [name for name, e in loaded(others, scene, failures).items() if e.unsupported(scene) is None]
    installed = {name for name, r in (others | dict(requested)).items() if not r.missing}
    return {
        "lack": {name: lacking for name, e in independent.items() if (lacking := lacking_effects(scene, e))},
        "instants": unaligned_instants(scene, independent),
        "not_requested": [name for name in supporting if name in installed],
        "not_installed": [name for name in supporting if name not in installed],
        "not_loaded": {name: said for name, said in failures.items() if name in installed},
        "solution": committed_precision(scene),
    }


def loaded(
    registrations: Mapping[str, Registration], scene: Scene, failures: dict[str, str]
) -> dict[str, type[Engine]]:
    """Classes of the engines with independent physics; messages of broken adapters go to `failures`."""
    found: dict[str, type[Engine]] = {}
    for name, registration in registrations.items():
        if not registration.external:
            continue
        try:
            engine: type[Engine] = engine_class(registration)
            engine.unsupported(scene)
        except Exception as error:
            failures[name] = error.reason if isinstance(error, AdapterLoadError) else engine_fault(error)
        else:
            found[name] = engine
    return found


def lacking_effects(scene: Scene, engine: type[Engine]) -> list[str]:
    """Effects of a scene that an engine lacks, by name."""
    return sorted(scene.effects.names - engine.effects)


def rejects(engine: type[Engine], scene: Scene) -> bool:
    """Whether an engine gives a reason against a scene; one that fails to answer gives none."""
    try:
        return engine.unsupported(scene) is not None
    except Exception:
        return False


def unaligned_instants(scene: Scene, independent: Mapping[str, type[Engine]]) -> dict[str, Any]:
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
    advice = run_advice(scene)
    rejecting = external_coverage(scene, requested)["instants"].get("engines") if advice else None
    return f"instants alone stop {', '.join(rejecting)}: {advice}" if rejecting else ""


def committed_precision(scene: Scene) -> str:
    """Precision of the certified solution committed for a scene of these physics; empty if there is none."""
    path = committed_tables().get(physics_digest(scene))
    return "" if path is None else read_head(path)["precision"]


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
