"""Physics: scenes against their certified solutions, and a diagnosis of each difference."""

from __future__ import annotations

import dataclasses
import time
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting
from adapters.engine import Coordinates, EngineError
from barchain.conform.checks import FAILED, NOT_RUN, PASSED, UNSUPPORTED, WARNING, Check, CheckState
from barchain.conform.errors_at_settings import judged_declarations
from barchain.conform.noise import agrees_but_forces, needed_noise, noise_fault
from barchain.conform.runs import TIME_LIMITS, collapse, no_time_left, results
from barchain.conform.scenes import STAGES, TOGETHER, candidates, lasts, left_out, rejection, setting_of, solved
from barchain.judge.compare import judge
from barchain.judge.diagnosis.across_scenes import agreed, in_common
from barchain.judge.diagnosis.mistake import looks_single, relative_difference, single_words
from barchain.judge.diagnosis.own_motion import OwnMotion
from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict
from barchain.judge.evidence import Evidence, follow_up_jobs, gathered
from barchain.judge.noise_to_declare import ROUND_OFF, round_off
from barchain.metrics.quantities import differences, sizes
from barchain.runs.asking import ask_about
from barchain.runs.job import Role
from reports.results.outcome import Outcome
from scenarios.channels import UNITS, WORDS
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Trajectory
    from barchain.conform.target import Examined
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.verdict import Verdict
    from barchain.runs.job import Job, RunResult
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

PAGE = "docs/explanation/engine_conventions.md"
LAST_ALONE = "with one effect"
"""Stage before that of effects together"""
ENOUGH = 0.5
"""Share of a scene that must be compared"""
FIRST_PART, GROWTH = 4, 3
"""Scenes of the first part of a stage, and the largest growth from a part to the next"""
MOST_LATE = 6
"""Scenes in which a run may be late before no further part begins: each costs the limit of a run"""
PART_S = 15.0
"""Time that a part of a stage is to take"""
DEPENDENT_PAGE = "docs/howto/conform.md#physics"
DEPENDENT = (
    "the result depends on the runs before it: in a process of its own the scene gives other numbers. Something is "
    "kept from run to run, in the module or in the class"
)
INDEPENDENT = 0.8
"""Least difference of two runs over the larger of their errors if these are random: of a damping by steps it is 1/2"""
SAME = 1e-9
"""Largest relative difference of results that count as the same: a library's sums may depend on where arrays lie"""


def physics(engine: Examined, stages: Mapping[str, tuple[str, ...]] = STAGES) -> Iterator[Check]:
    """Checks of the scenes of some stages, by default of all; no stage follows one with a failure.

    Where no failure of an effect alone has a name, the scenes of effects together are judged too: they may have one.
    """
    failed, named, before = "", False, ""
    made: dict[str, dict[Role, RunResult]] = {}
    for stage, scenes in stages.items():
        if failed and (named or (before, stage) != (LAST_ALONE, TOGETHER)):
            yield Check(stage, NOT_RUN, f"{failed} fails")
            continue
        before = stage
        ahead = stages.get(TOGETHER, ()) if stage == LAST_ALONE else ()  # to start one process instead of two
        if not made.keys() & set(scenes):
            able, later = ([n for n in names if reason_against(engine, n) is None] for names in (scenes, ahead))
            counts = (f"{plural(len(n), 'scene')} {where}" for n, where in ((able, stage), (later, TOGETHER)) if n)
            if able or later:
                engine.note(f"physics: {' and '.join(counts)}, at two settings")
            made |= in_parts(engine, [*able, *later])
        judged = {name: runs for name, runs in made.items() if name not in ahead}  # so far, and in this stage
        for check in stage_checks(engine, scenes, judged):
            failed = failed or (check.name if check.state is FAILED and check.stops else "")
            named |= check.explained
            yield check


def in_parts(engine: Examined, names: list[str]) -> dict[str, dict[Role, RunResult]]:
    """Runs of scenes in parts of :data:`PART_S` each, announced by name; without those for which no time is left.

    A part is a process. The first ones are small, as an engine may be slow in the scenes of an effect alone.
    """
    made: dict[str, dict[Role, RunResult]] = {}
    size, left = FIRST_PART, list(names)
    while left and not engine.late and sum(map(is_late, made.values())) < MOST_LATE:
        part, left, start = left[:size], left[size:], time.monotonic()
        if len(names) > FIRST_PART:
            ends = " to ".join(dict.fromkeys((short(part[0]), short(part[-1]))))
            engine.note(f"physics: {len(made) + len(part)} of {len(names)}, {ends}")
        made |= main_and_finer(engine, part)
        each_s = (time.monotonic() - start) / len(part)
        if not any(is_late(made[name]) for name in part):  # late runs tell nothing of the others
            size = max(1, min(GROWTH * size, int(PART_S / each_s)))
        late = sum(map(is_late, made.values()))
        size = min(size, MOST_LATE - late) if late else size
    return made


def stage_checks(engine: Examined, names: Sequence[str], runs: Mapping[str, dict[Role, RunResult]]) -> Iterator[Check]:
    """Checks of the scenes of a stage, whose runs were made in one process; from the first failure on, at the end."""
    reasons = {name: reason_against(engine, name) for name in names}
    able = [name for name in names if reasons[name] is None]
    found: dict[str, Diagnosis] = {}
    held: list[Check] = []
    dependent = False
    for name in names:
        reason = reasons[name]
        if reason is not None:
            state, words = reason
            check = Check(short(name), state, words, scene=name)
        elif name not in runs:
            late = not engine.late and sum(map(is_late, runs.values()))
            said = f"runs of {late} scenes before it are late" if late else no_time_left(engine)
            check = Check(short(name), NOT_RUN if late else FAILED, said, TIME_LIMITS, scene=name)
        elif dependent:
            check = Check(short(name), NOT_RUN, "the result depends on the runs before it")
        else:
            check = scene_check(engine, name, runs[name], found)
            if is_late(runs[name]) and not any(is_late(runs[c.scene]) for c in held if c.scene in runs):
                hint = collapse(engine, name, runs[name][Role.MAIN])  # told once
                check = dataclasses.replace(check, words=f"{check.words}{hint}")
            if check.state is FAILED and not held and name != able[0]:
                alone = partial(main_run, engine, name, judged_declarations(engine))
                other = dependent_check(check, runs[name][Role.MAIN], alone)
                check, dependent = other or check, other is not None
        if held or check.state is FAILED:
            held.append(check)
        else:
            yield check
    yield from in_agreement(engine, held, found, runs)


def is_late(runs: Mapping[Role, RunResult]) -> bool:
    """Whether a run of a scene was ended at its limit."""
    return any(run.outcome is Outcome.TIMED_OUT for run in runs.values())


def in_agreement(
    engine: Examined, checks: list[Check], found: dict[str, Diagnosis], runs: Mapping[str, dict[Role, RunResult]]
) -> Iterator[Check]:
    """Checks of a stage with diagnoses that no other scene of the stage contradicts."""
    motions = {name: d.own for name, d in found.items() if d.own is not None}
    right = [
        name for name in runs if name not in found and not any(c.scene == name and c.state is FAILED for c in checks)
    ]
    for name in right if found else ():
        run = runs[name][Role.MAIN].trajectory
        if run is not None:
            motions[name] = OwnMotion(solved(engine.scene(name)).scene, run, None)
    agreeing = agreed(found, motions)
    common = in_common([engine.scene(name) for name in found], map(engine.scene, right))
    for check in checks:
        diagnosis = agreeing.get(check.scene)
        if diagnosis is None or check.state is not FAILED or check.words == DEPENDENT:
            yield check
        else:
            others = [d for name, d in agreeing.items() if name != check.scene]
            unnamed = any(not d.explanations for d in others)
            shared = any(names in d.names for d in others for names in diagnosis.names)
            alone = " The name rests on this scene alone." if len(motions) == 1 or (unnamed and not shared) else ""
            yield diagnosed(engine, check.scene, diagnosis, alone if diagnosis.explanations else common)


def reason_against(engine: Examined, name: str) -> tuple[CheckState, str] | None:
    """CheckState and reason if an engine is not run on a scene."""
    try:
        reason = rejection(engine.declarations, engine.scene(name))
    except EngineError as error:
        return FAILED, str(error)
    return None if reason is None else (UNSUPPORTED, reason)


def unsupported_check(engine: Examined, name: str, scenes: Sequence[str]) -> Check:
    """Check of a group whose scenes are all unsupported, with the first reason; failed if a reason can't be had."""
    reasons = [reason for scene in scenes if (reason := reason_against(engine, scene)) is not None]
    state, words = min(reasons, key=lambda reason: reason[0] is not FAILED)
    said = words if state is FAILED else f"supports no scene of this check: {words}"
    return Check(name, state, said)


def ask_about_scenes(engine: Examined) -> None:
    """Ask an engine about all scenes at once: a process for each of them would take half of the examination."""
    declared = engine.declarations
    with suppress(EngineError):  # told with the scene that causes it
        ask_about(declared, (s for names in STAGES.values() for name in names for s in candidates(declared, name)))


def main_run(engine: Examined, name: str, loaded: Declarations) -> RunResult:
    """Run of one scene at the setting that declarations lead to, alone: an engine that hangs costs one time limit."""
    scene = engine.scene(name)
    job = engine.job(scene, setting_of(loaded, scene), Role.MAIN)
    return by_role(engine, [job])[name][Role.MAIN]


def main_and_finer(engine: Examined, names: list[str]) -> dict[str, dict[Role, RunResult]]:
    """Runs of scenes at the setting of each, and at the next finer one."""
    loaded, jobs, parting = judged_declarations(engine), [], []
    for name in names:
        scene = engine.scene(name)
        setting = setting_of(loaded, scene)
        parting += [] if lasts(loaded, setting, scene) else [short(name)]
        jobs.append(engine.job(scene, setting, Role.MAIN))
        jobs.append(engine.job(scene, finer_setting(scene, loaded.sweep, setting), Role.FINER))
    if parting:
        engine.note(f"physics: at no setting tried do right runs agree up to nine tenths of {', '.join(parting)}")
    return by_role(engine, jobs)


def dense_runs(engine: Examined, name: str, scene: Scene, twice: Scene) -> tuple[Trajectory | None, Trajectory | None]:
    """Runs of a scene with dense samples, and with twice as many at the next finer setting."""
    loaded = judged_declarations(engine)
    setting = setting_of(loaded, engine.scene(name))
    finer = finer_setting(scene, loaded.sweep, setting)
    jobs = [engine.job(scene, setting, Role.MAIN), engine.job(twice, finer, Role.FINER)]
    main, second = results(engine, jobs, [job.scene.times_s for job in jobs], engine.run_s)
    return main.trajectory, second.trajectory


def by_role(engine: Examined, jobs: list[Job]) -> dict[str, dict[Role, RunResult]]:
    """Results of runs, by scene and role."""
    found: dict[str, dict[Role, RunResult]] = {}
    times = [solved(engine.scene(job.scene.name)).trajectory.t_s for job in jobs]
    for job, result in zip(jobs, results(engine, jobs, times, engine.run_s), strict=True):
        found.setdefault(job.scene.name, {})[job.role] = result
    return found


def scene_check(
    engine: Examined, name: str, runs: dict[Role, RunResult], diagnoses: dict[str, Diagnosis] | None = None
) -> Check:
    """Check of one scene, with a diagnosis where the engine is wrong, which is added to those of other scenes."""
    loaded, scene = judged_declarations(engine), engine.scene(name)
    setting, solution = setting_of(loaded, scene), solved(scene)
    noise = noise_fault(loaded, setting, solution)
    if noise:
        return Check(short(name), FAILED, noise, f"{PAGE}#declarations", scene=name)
    verdict, evidence = verdict_of(engine, scene, runs)
    state, said = state_without_failure(verdict, scene, loaded.coordinates)
    run = evidence.main.trajectory
    if state is UNSUPPORTED and run is not None:  # every declared effect must be judged
        alright = agrees_but_forces(loaded, setting, evidence, solution)
        return Check(short(name), WARNING if alright else FAILED, said, f"{PAGE}#declarations", scene=name)
    if state in (PASSED, WARNING):
        state, said = needed_noise(verdict, loaded, setting, evidence, solution) or (state, said)
        if state is FAILED:
            return Check(short(name), FAILED, said, f"{PAGE}#declarations", scene=name)
    where = f"{left_out(loaded, name)}{at_setting(loaded, setting)}"
    if state is not FAILED:
        return Check(short(name), state, f"{said}{where}", scene=name)
    found = None
    if run is not None and verdict.series is not None and not engine.late:
        hangs = evidence.finest is not None and evidence.finest.outcome is Outcome.TIMED_OUT
        if not hangs:
            engine.note(f"physics: {short(name)} differs, and is run again with dense samples for its diagnosis")
        found = diagnosis_of_verdict(verdict, run, solution, None if hangs else partial(dense_runs, engine, name))
    words = round_off_words(verdict, loaded.coordinates, evidence, solution)
    if words and (found is None or not found.explanations) and verdict.outcome is not Outcome.MALFORMED:
        check = Check(short(name), FAILED, f"{words}{where}", f"{PAGE}#declarations", scene=name, stops=False)
    elif found is None or found.inside_tolerances or verdict.outcome is Outcome.MALFORMED:
        check = Check(short(name), FAILED, f"{said}{where}", TIME_LIMITS if is_late(runs) else PAGE, scene=name)
    else:
        check = diagnosed(engine, name, found)
        if diagnoses is not None:
            diagnoses[name] = found
    return check


def round_off_words(verdict: Verdict, coordinates: Coordinates, evidence: Evidence, solution: ReferenceSolution) -> str:
    """Words on errors that are round-off, with the noise to declare; empty if they are not."""
    main, finer = evidence.main.trajectory, evidence.finer.trajectory
    noise = {} if main is None or finer is None else round_off(verdict, coordinates, main, finer, solution)
    said = ", ".join(f"{q} = {size:.1e} ({UNITS[q]} of the {WORDS[q]})" for q, size in noise.items())
    return f"{ROUND_OFF}; declare `noise` of {said}" if noise else ""


def diagnosed(engine: Examined, name: str, found: Diagnosis, common: str = "") -> Check:
    """Failed check of a scene, with its diagnosis and words on what such scenes have in common."""
    relative = relative_difference(found.wrong)
    random = found.own is None or (bool(found.own.departure) and found.own.scatters)  # seen between samples, too
    single = looks_single(relative) and not found.explanations and not systematic(found) and random
    hint = f" {single_words(relative)}" if single else ""
    sizes = "; ".join(f"{WORDS[w.quantity]} {w.words}" for w in found.wrong)
    page = found.explanations[0].mistakes[0].anchor if found.explanations else PAGE
    loaded = judged_declarations(engine)
    where = f"{left_out(loaded, name)}{at_setting(loaded, setting_of(loaded, engine.scene(name)))}"
    off = "" if found.of_one_sample and not found.explanations else f" Off: {sizes}"  # the diagnosis has told them
    said = f"{found}{hint}{common}{off}{where}"
    return Check(short(name), FAILED, said, page, bool(found.explanations), name)


def systematic(found: Diagnosis) -> bool:
    """Whether the engine's runs at two settings share the largest difference, or a part of it: rounding does not."""
    worst = max(found.wrong, key=lambda w: w.difference / w.size if w.size else 0.0)
    return found.own is not None and found.own.apart(worst.quantity) < INDEPENDENT * worst.difference


def at_setting(engine: Declarations, setting: Setting) -> str:
    """Words on the setting of a scene, if it is not the default."""
    return "" if setting == engine.sweep.setting() else f", at {setting}"


def state_without_failure(verdict: Verdict, scene: Scene, coordinates: Coordinates) -> tuple[CheckState, str]:
    """State of a scene and its reason; failed if the verdict is no other one.

    Round-off limits runs in absolute coordinates alone: in smaller ones a run that scatters has another cause.
    """
    reasons = reasons_of(verdict)
    if verdict.outcome is Outcome.PASS:
        return PASSED, agreement(verdict)
    if verdict.outcome is Outcome.UNSUPPORTED:
        return UNSUPPORTED, reasons
    if verdict.outcome is Outcome.ROUNDOFF_LIMITED and coordinates.absolute:
        return WARNING, f"round-off limits the run: {reasons}"
    if verdict.outcome is Outcome.ROUNDOFF_LIMITED:
        return FAILED, f"runs scatter far more than numbers in {coordinates} coordinates round: {reasons}"
    if verdict.outcome in (Outcome.TOO_COARSE, Outcome.NOTHING_COMPARED) and compared_share(verdict, scene) >= ENOUGH:
        return WARNING, f"{agreement(verdict)}; {reasons}"
    return FAILED, reasons


def verdict_of(engine: Examined, scene: Scene, runs: dict[Role, RunResult]) -> tuple[Verdict, Evidence]:
    """Verdict on a scene, and its runs, with the further runs that it asks for."""
    loaded, solution, evidence = judged_declarations(engine), solved(scene), gathered(runs)
    setting = setting_of(loaded, scene)
    verdict = judge(engine.name, loaded, setting, evidence, solution)
    if not verdict.further_runs:
        return verdict, evidence
    jobs = follow_up_jobs(scene, engine.name, engine.registration, loaded, setting, verdict.further_runs)
    evidence = gathered(runs | by_role(engine, jobs)[scene.name])
    return judge(engine.name, loaded, setting, evidence, solution), evidence


def compared_share(verdict: Verdict, scene: Scene) -> float:
    """Share of a scene before the predictability limit of the quantities that were compared."""
    limits = [row["limit_s"] for row in verdict.rows if row["metric"] == "max"]
    return min(limits, default=0.0) / float(scene.run.duration_s)


def agreement(verdict: Verdict) -> str:
    """Largest differences from the certified solution, in the order of the quantities."""
    found = {row["quantity"]: row["value"] for row in verdict.rows if row["metric"] == "max"}
    said = [f"{WORDS[q]} {found[q]:.1e} {UNITS[q]}" for q in WORDS if q in found]
    return f"differs by {', '.join(said)}"


def reasons_of(verdict: Verdict) -> str:
    """Reasons of the rows that are no pass; of values with too few digits, that reason alone."""
    rows = [row for row in verdict.rows if row["reason"] and Outcome(row["outcome"]) is not Outcome.PASS]
    rows = [row for row in rows if Outcome(row["outcome"]) is Outcome.MALFORMED] or rows
    return "; ".join(dict.fromkeys(f"{row['quantity']}: {row['reason']}" if row["quantity"] != "run" else row["reason"]
                                   for row in rows)) or str(verdict.outcome)  # fmt: skip


def short(name: str) -> str:
    """Name of a scene in words: ``two bars free``."""
    return name.partition("/")[2].replace("_", " ")


def dependent_check(failed: Check, after_others: RunResult, alone: Callable[[], RunResult]) -> Check | None:
    """Failed check with another reason, if a scene gives other numbers alone than after other scenes; None if not.

    An engine that starts at random gives other numbers each time: two runs alone then differ, too.

    Parameters
    ----------
    failed : Check
        Of the scene.
    after_others : RunResult
        Run after those of other scenes, in one process.
    alone : callable
        Makes the same run in a process of its own.
    """
    first = alone().trajectory
    if first is None or after_others.trajectory is None or same_numbers(first, after_others.trajectory):
        return None
    second = alone().trajectory
    if second is None or not same_numbers(first, second):
        return None
    return dataclasses.replace(failed, words=DEPENDENT, page=DEPENDENT_PAGE, explained=True)


def same_numbers(one: Trajectory, other: Trajectory) -> bool:
    """Whether two results are the same."""
    if len(one.t_s) != len(other.t_s) or one.observables != other.observables:
        return False
    apart = differences(one, other)
    return all(
        float(apart[quantity].max(initial=0.0)) <= SAME * float(size.max(initial=0.0))
        for quantity, size in sizes(one).items()
        if quantity in apart
    )
