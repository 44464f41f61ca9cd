"""The kill matrix: every fault is detected, the unmodified engine is not rejected, the self-test checks itself."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from adapters.exudyn.adapter import Exudyn
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import ENDED
from barchain.cli.main import run as command
from barchain.judge.verdict import JUDGED_METRICS
from barchain.solutions.reference_run import NUMPY
from barchain.studies.selftest.faults import (
    declarations,
    equations,
    events,
    forces,
    output,
    paper_misprints,
    samples,
)
from barchain.studies.selftest.faults.catalogue import CATALOGUE, CONTROLS, FIXED_SCENES, UNMODIFIED, find
from barchain.studies.selftest.faults.fault import FaultGroup, Size
from barchain.studies.selftest.matrix import (
    CHECKS,
    OCTAVES,
    Matrix,
    cell,
    detection_edge,
    moved_beyond_rounding,
    reading,
    selftest_study,
)
from barchain.studies.selftest.matrix import tried as tried_on
from barchain.studies.selftest.scenes import FALL, STAGES, find_scene
from barchain.studies.selftest.trial import SceneRuns, Trial, judged
from barchain.studies.study import run_study
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.model import relative
from reports.chapters.selftest import CHECKS as SIGNS
from reports.chapters.selftest import view_selftest
from reports.render import render_study
from reports.results.outcome import Outcome
from reports.results.rows import spread
from reports.results.selftest import CAUGHT, FILES, KILLED, FaultOutcome
from scenarios import load_scene
from tests.support.here import result_of
from tests.support.slow import one_in, slow_but

if TYPE_CHECKING:
    import contextlib
    from collections.abc import Iterator
    from pathlib import Path

    from adapters.trajectory import Trajectory
    from barchain.runs.cases import Case
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.matrix import FaultCell
    from scenarios import Scene

CHEAP = ("basics/libration", "basics/two_bars_free", "paper/fig15", "effects/impulse", FALL, "paper/fig17")
HOMES = {
    "effects/drag": ("drag", "still-air"),
    "effects/joint_springs": ("springs", "dampers"),
    "effects/oblateness": ("j2",),
    "effects/slender": ("slender-force",),
    "effects/solar_shadow": ("light", "black", "shadow-missing", "switch-late"),
    "effects/third_body": ("third-body",),
    "paper/fig17": ("slew-counter-torque",),
    "effects/thrust": ("thrust", "thrust-axes", "thrust-end", "thrust-late"),
}
"""Scenes of single effects, and the faults that only these show"""
SHARE = 0.15  # of each that is run
DUSK_DEG = 155.0  # 20 degrees before the shadow of effects/solar_shadow
HOST = "reference"


def brief(name: str) -> Scene:
    """A stage, or a share of another scene."""
    if name in STAGES:
        return find_scene(name)
    scene = load_scene(name)
    run = dataclasses.replace(scene.run, duration_s=SHARE * scene.run.duration_s, samples=31)
    if name == "effects/solar_shadow":
        orbit = dataclasses.replace(scene.orbit, longitude_rad=math.radians(DUSK_DEG))
        return dataclasses.replace(scene, run=run, orbit=orbit)
    return dataclasses.replace(scene, run=run)


@functools.cache
def stage(name: str) -> SceneRuns:
    """A scene, whose runs are made once, in this process."""
    return SceneRuns(brief(name), NUMPY)


def cell_on(where: SceneRuns, fault: str, size: float | None = None) -> FaultCell:
    """Outcome of a fault; by default at its natural size."""
    found: FaultCell = result_of(tried_on(where, Trial(where.scene, HOST, fault, size)))
    return found


def solution_of(where: SceneRuns) -> ReferenceSolution:
    """Reference solution of a scene."""

    def needed() -> Case[ReferenceSolution]:
        (solution,) = yield [where.solution]
        return solution

    found: ReferenceSolution = result_of(needed())
    return found


def nothing(where: SceneRuns, fault: str) -> str:
    """Why a fault changes nothing in a scene."""
    return Trial(where.scene, HOST, fault).left_out(solution_of(where))


def homes(fault: str) -> Iterator[SceneRuns]:
    """Scenes in which a fault may show, cheap ones first."""
    own = [scene for scene, faults in HOMES.items() if fault in faults]
    return map(stage, own or CHEAP)


@pytest.mark.parametrize("name", slow_but(FIXED_SCENES, list(FIXED_SCENES)[::40]))
def test_every_fault_is_caught_in_some_scene_or_proven_invisible(name: str) -> None:
    fault, survived = FIXED_SCENES[name], []
    for where in homes(name):
        if nothing(where, name):
            continue
        found = cell_on(where, fault.name)
        assert found.fate is not FaultOutcome.BROKEN, found.reason
        if found.fate is (FaultOutcome.INVISIBLE if fault.invisible else FaultOutcome.KILLED):
            return
        survived.append((where.scene.name, found.reason))
    pytest.fail(f"{name} survives: {survived}" if survived else f"{name} has nothing to change anywhere")


@pytest.mark.parametrize("name", one_in(4, dict.fromkeys([*CHEAP, *HOMES])))
def test_the_sound_engine_is_refused_by_nothing(name: str) -> None:
    where = stage(name)
    for control in CONTROLS:
        if not nothing(where, control):
            found = cell_on(where, control)
            assert found.fate is FaultOutcome.CLEAN, (control, found.worst)


def test_a_check_that_rejects_a_control_is_a_false_alarm_and_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    where = stage("basics/two_bars_free")
    wrong = dataclasses.replace(FIXED_SCENES["sign-reaction"], group=FaultGroup.CONTROL)
    monkeypatch.setitem(CATALOGUE, wrong.name, wrong)
    found = cell_on(where, wrong.name)
    assert found.fate is FaultOutcome.FALSE_ALARM
    assert not Matrix((found,)).passed


def test_a_fault_that_nothing_kills_fails() -> None:
    found = cell_on(stage("basics/two_bars_free"), "scale-reaction", 1e-15)
    assert found.fate is FaultOutcome.SURVIVES
    assert "of what is allowed" in found.reason
    assert Matrix((found,)).unkilled == ("scale-reaction",)
    assert not Matrix((found,)).passed
    assert Matrix((found, cell_on(stage("paper/fig15"), "scale-reaction"))).passed


def test_an_engine_that_fails_by_mistake_is_no_kill(monkeypatch: pytest.MonkeyPatch) -> None:
    def stumble(size: float) -> contextlib.AbstractContextManager[object]:
        raise TypeError("not as it is meant")

    broken = dataclasses.replace(FIXED_SCENES["inertia"], name="broken", code=stumble)
    monkeypatch.setitem(CATALOGUE, broken.name, broken)
    found = cell_on(stage("basics/two_bars_free"), broken.name)
    assert found.fate is FaultOutcome.BROKEN
    assert "not as it is meant" in found.reason
    assert not Matrix((found,)).passed


def test_a_claim_to_be_invisible_is_measured() -> None:
    where = stage("paper/fig15")
    solution, beta, other = solution_of(where), "misprint-beta-denominator", "misprint-w-third-row"
    assert "measured" in cell_on(where, beta).reason
    assert moved_beyond_rounding(solution, FIXED_SCENES[beta], 1.0) <= 1.0
    assert moved_beyond_rounding(solution, FIXED_SCENES[other], 1.0) > 1e3


def test_the_references_code_is_right_again_after_each_fault() -> None:
    parts = [vars(relative), vars(relative.ReactionSolution), vars(SlenderBarEffect), vars(Reference)]
    before = [dict(p) for p in parts]
    for fault in FIXED_SCENES.values():
        if fault.code:
            with fault.within(fault.natural):
                pass
            assert [dict(p) for p in parts] == before, fault.name


def test_an_engine_that_runs_past_the_truths_end_is_judged() -> None:
    """Its samples beyond have nothing to be compared with."""
    found = cell_on(stage(FALL), "surface-missed")
    assert found.fate is FaultOutcome.KILLED
    assert "ended" in found.worst["reason"]


def test_the_instant_of_landing_is_judged_by_the_errors_of_track_and_attitude() -> None:
    """At 900 m/s a track good to a millimetre or so is met to some microseconds; samples are 2.5 s apart."""
    where, late = stage(FALL), "landing-late"
    for size, fate in ((1.0, FaultOutcome.KILLED), (1e-3, FaultOutcome.KILLED), (1e-8, FaultOutcome.SURVIVES)):
        assert cell_on(where, late, size).fate is fate, size
    runs = result_of(where.runs_of(Trial(where.scene, HOST, late), solution_of(where)))
    rows = result_of(judged(runs)).rows
    assert {r["reason"].split()[0] for r in rows if not Outcome(r["outcome"]).ok} == {"ended"}
    unlocated = {role: dataclasses.replace(run, trajectory=forgetful(run)) for role, run in runs.results.items()}
    forgotten = dataclasses.replace(runs, results=unlocated)
    assert cell(forgotten, result_of(judged(forgotten))).fate is FaultOutcome.SURVIVES


def forgetful(run: RunResult) -> Trajectory:
    """Trajectory of an engine that does not locate the instant of its end."""
    assert run.trajectory is not None
    info = {k: v for k, v in run.trajectory.info.items() if k != ENDED}
    return dataclasses.replace(run.trajectory, info=info)


def test_the_initial_rate_of_a_bar_that_follows_a_law_is_no_place_for_a_fault() -> None:
    where, fault = stage("paper/fig17"), FIXED_SCENES["start-rate"]
    assert fault.staged(where.scene, 1e-6).chain.rate_factor == (1.0, 1.0, 1.0, 1.0 + 1e-6, 1.0)
    assert cell_on(where, fault.name).fate is FaultOutcome.KILLED


def test_names_are_unique_and_words_are_there() -> None:
    modules = (declarations, equations, events, forces, output, paper_misprints, samples)
    assert len(CATALOGUE) == sum(len(module.FAULTS) for module in modules) + len(samples.GARBAGE)
    assert not set(FIXED_SCENES) & set(CONTROLS)
    for fault in CATALOGUE.values():
        assert fault.words
        assert fault.stands_for
        assert np.isfinite(fault.natural)
        assert not (fault.expected_failure and fault.invisible)
    assert all(stage.scene().run.samples <= 61 for stage in STAGES.values())


def test_faults_are_listed_and_the_nearest_name_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["selftest", "--list"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in FIXED_SCENES)
    assert command(["selftest", "--fault", "maas"]) == 2
    assert "did you mean mass" in capsys.readouterr().err


def edge_of(least: float, most: float | None = None) -> tuple[Any, list[float]]:
    """Edge of a fault with a natural size of 1 that is detected from a least size on, and the sizes that are tried."""
    check, tries = {"quantity": "reaction"}, list[float]()

    def killer(size: float) -> Case[dict[str, str] | None]:
        yield []
        tries.append(size)
        return check if size >= least else None

    natural = check if least <= 1.0 else None
    return result_of(detection_edge(Size(1.0, most=most), natural, killer)), tries


@pytest.mark.parametrize("edge", [-OCTAVES, -7, 0])
def test_bisection_finds_the_edge(edge: int) -> None:
    (caught, by, missed), tries = edge_of(2.0**edge)
    assert (caught, by) == (2.0**edge, "reaction")
    assert missed in (None, 2.0 ** (edge - 1))
    assert len(tries) <= 7


def test_a_natural_size_that_is_missed_is_tried_larger_where_that_makes_sense() -> None:
    assert edge_of(100.0) == ((None, "", 1.0), [])
    assert edge_of(100.0, most=16.0) == ((None, "", 16.0), [16.0])
    assert edge_of(4.0, most=16.0) == ((4.0, "reaction", 2.0), [16.0, 4.0, 2.0])


def test_the_smallest_size_that_is_caught_lies_just_above_one_that_is_not() -> None:
    where = stage("basics/two_bars_free")

    def killer(at: float) -> Case[dict[str, Any] | None]:
        found = yield from tried_on(where, Trial(where.scene, HOST, "scale-reaction", at))
        return found.killer

    natural = cell_on(where, "scale-reaction").killer
    caught, _, missed = result_of(detection_edge(find("scale-reaction").size, natural, killer))
    assert missed == caught / 2.0
    assert 1e-12 < caught < 1e-7  # what is explained is some ten requests of 1e-10 and their response
    assert cell_on(where, "scale-reaction", caught).fate is FaultOutcome.KILLED
    assert cell_on(where, "scale-reaction", missed).fate is FaultOutcome.SURVIVES


def test_faults_of_the_scene_and_of_what_is_read_serve_any_engine() -> None:
    exudyn = Exudyn.declarations()
    assert FIXED_SCENES["inertia"].foreign_to(exudyn) == "inserted into the reference's code"
    assert not any(FIXED_SCENES[name].foreign_to(exudyn) for name in ("j2", "mass", "mu", "sign-reaction"))
    assert not FIXED_SCENES["inertia"].foreign_to(Reference.declarations())


@pytest.mark.slow
def test_the_command_writes_tables_and_a_page(tmp_path: Path) -> None:
    named = ("nan-com", "mass", "gravity-torque-sign", "scale-rate")
    asked = [word for name in named for word in ("--fault", name)]
    line = ["selftest", "basics/libration", *asked, "--smallest", "--workers", "1", "--out", str(tmp_path)]
    assert command(line) == 0
    tables = FILES.contents(tmp_path)
    assert tables.record["finished"]
    assert tables.record["passed"]
    fates = tables.fates.groupby("fault").fate.first().to_dict()
    assert fates[UNMODIFIED] == "clean"
    assert fates["mass"] == "not applicable"
    assert {fates[n] for n in ("nan-com", "gravity-torque-sign", "scale-rate")} == {"killed"}
    sizes = spread(FILES.rows(tmp_path))
    assert set(sizes.fault[sizes.metric == CAUGHT]) == {"scale-rate"}
    rate = tables.readings.query("fault == 'scale-rate' and killed == 'killed'")
    assert set(rate.quantity) == {"rate", "angular_momentum_about_com"}
    headline = view_selftest(tmp_path).headline
    assert headline == "3 of 3 faults are detected."
    assert headline in render_study("selftest", tmp_path).page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_fault_killed_by_nothing_ends_with_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    small = dataclasses.replace(FIXED_SCENES["scale-rate"], size=Size(1e-15))
    for known in (CATALOGUE, FIXED_SCENES):
        monkeypatch.setitem(known, "scale-rate", small)
    assert command(["selftest", "basics/libration", "--fault", "scale-rate", "--workers", "1"]) == 1
    said = capsys.readouterr().out
    assert "undetected: scale-rate" in said


@pytest.mark.exhaustive
def test_the_full_matrix_has_no_survivor(tmp_path: Path) -> None:
    whole = run_study(selftest_study(), tmp_path)
    assert whole.passed, (whole.unkilled, whole.wrong)
    tried_somewhere = {c.fault.name for c in whole.cells if c.fate is not FaultOutcome.NOTHING}
    assert tried_somewhere == set(FIXED_SCENES) | set(CONTROLS)


def test_every_metric_that_can_reject_a_run_is_a_check_with_a_sign_and_words() -> None:
    """A metric left out would call a fault that it alone detects a survivor."""
    rejecting = JUDGED_METRICS | {"restart_ratio", "own_state_ratio", "judged_share"}
    assert set(CHECKS) == rejecting
    checks = set(CHECKS.values()) | {o for o in Outcome if not o.ok or o is Outcome.TOO_COARSE}
    assert set(SIGNS) == checks


@pytest.mark.parametrize(
    ("quantity", "metric", "value", "tolerance", "outcome", "check"),
    [
        ("attitude", "extrapolation_ratio", 3.0, 1.0, Outcome.INCONSISTENT, "extrapolated"),
        ("run", "judged_share", 0.02, 0.1, Outcome.NOTHING_COMPARED, "judged_share"),
    ],
)
def test_what_only_one_reading_rejects_is_a_detected_fault(
    quantity: str, metric: str, value: float, tolerance: float, outcome: Outcome, check: str
) -> None:
    row = {"quantity": quantity, "metric": metric, "value": value, "tolerance": tolerance, "reason": "why"}
    rejected = reading(row | {"outcome": str(outcome)})
    assert rejected is not None
    assert (rejected["check"], rejected["killed"]) == (check, KILLED)
    accepted = reading(row | {"outcome": str(Outcome.PASS)})
    assert not (accepted and accepted["killed"])
