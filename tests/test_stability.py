"""The stability study: an engine planted for each outcome reaches it, and short hard scenes leave ours stable."""

from __future__ import annotations

import dataclasses
import functools
import json
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pytest

from adapters.engine import Coordinates, EngineError, Knob, Ladder, Setting
from adapters.reference_adapter import Reference
from adapters.registry import ENGINES, Registration
from barchain.cli import run as command
from barchain.job import TRUTH_ROLES, Job, Role, RunResult, failure
from barchain.model_difference import com_displacement, track_response
from barchain.stability import expected
from barchain.stability.evidence import evidence
from barchain.stability.expected import SLOW
from barchain.stability.growth import BLOWN_UP, linear_rate
from barchain.stability.law import law
from barchain.stability.plan import HUGE, Plan, chosen_engines, coarser, default_engines, hard_scenes, settings
from barchain.stability.rules import Finding, finding
from barchain.stability.seen import Seen
from barchain.stability.study import stability
from barchain.truth import FINE_RTOL, establish, finely, twin
from barchain.worker import run_job
from reports.outcome import Outcome
from reports.stability_page import render_stability
from reports.stability_tables import EVIDENCE, OUTCOMES, Stability, read_stability
from reports.stability_view import view_stability
from scenarios import load_scene
from tests import faulty_engines
from tests.faulty_engines import Faulty

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from adapters.engine import Array, Trajectory
    from barchain.model_difference import Displacement
    from scenarios import Scene

FREE, FALLS = "basics/two_bars_free", "hard/straight_horizontal"
OPENED = 1e-6  # of a bar: far beyond a joint's band in relative coordinates, far below what is taken for no joint


class Drifts(Faulty):
    """Joints that open, ever faster."""

    def spoil(self, seen: Trajectory) -> Trajectory:
        opened = OPENED * (seen.t_s / seen.t_s[-1])[:, None] ** 1.5
        return seen.replace(gap_m=seen.gap_m + opened)


class BlowsUp(Faulty):
    """Rates that grow exponentially to many times what they are."""

    def spoil(self, seen: Trajectory) -> Trajectory:
        rate = 3.0 * BLOWN_UP * np.abs(seen.rate_rad_s).max()
        grown = np.exp(20.0 * (seen.t_s / seen.t_s[-1] - 1.0))[:, None]
        angle = seen.angle_rad + rate * seen.t_s[-1] / 20.0 * (grown - grown[0])
        return seen.replace(angle_rad=angle, rate_rad_s=seen.rate_rad_s + rate * grown)


class KnowsItsRequest(Faulty):
    """No fault; for those that hang on what is asked for."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, setting)
        self.rtol = setting.value


class WorseWithFiner(KnowsItsRequest):
    """An error that grows as what is asked for shrinks."""

    def spoil(self, seen: Trajectory) -> Trajectory:
        return seen.replace(angle_rad=seen.angle_rad + 1e-15 / self.rtol * (seen.t_s / seen.t_s[-1])[:, None])


class Loose(KnowsItsRequest):
    """Errors as its own two settings say, far beyond what it was asked for."""

    def spoil(self, seen: Trajectory) -> Trajectory:
        return seen.replace(angle_rad=seen.angle_rad + 1e6 * self.rtol * (seen.t_s / seen.t_s[-1])[:, None])


class EndsAtOnce(Faulty):
    """A method of equal steps that loses the chain to the ground before its second sample."""

    ladder: ClassVar = Ladder(Knob.STEPS_PER_ORBIT, (1000.0, 4000.0), default=4000.0)
    order: ClassVar = 2
    coordinates: ClassVar = Coordinates.ABSOLUTE

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, Reference.ladder.setting())

    def spoil(self, seen: Trajectory) -> Trajectory:
        first = {k: v[:1] for k, v in vars(seen).items() if isinstance(v, np.ndarray)}
        return dataclasses.replace(seen, **first, ended="a bar reached the surface")


class RunsAway(Faulty):
    """A departure that grows at twice the linear rate of a pendulum in the tide."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, setting)
        self.rate = 2.0 * np.sqrt(3.0) * scene.mean_motion_rad_s

    def spoil(self, seen: Trajectory) -> Trajectory:
        return seen.replace(angle_rad=seen.angle_rad + 1e-3 * np.exp(self.rate * (seen.t_s - seen.t_s[-1]))[:, None])


class WillNot(Faulty):
    """Says so before its first step."""

    def build(self, scene: Scene, setting: Setting) -> None:
        raise EngineError("bars of this mass are too light for me")


class CanNotFactor(Faulty):
    """Arithmetic that fails while it builds: no refusal."""

    def build(self, scene: Scene, setting: Setting) -> None:
        raise np.linalg.LinAlgError("not positive definite")


class Lands(Faulty):
    """Ends where the truth does not."""

    def spoil(self, seen: Trajectory) -> Trajectory:
        early = faulty_engines.StopsEarly.spoil(self, seen)
        return dataclasses.replace(early, ended="a bar reached the surface")


class CanNot(Faulty):
    """Carries nothing."""

    effects: ClassVar = frozenset()


@functools.cache
def scene(name: str) -> Scene:
    """Scene, the unstable one for an orbit, the free one for as long as its faults take to show."""
    found = load_scene(name)
    share, samples = (1.0 / 3.0, 101) if name == FALLS else (0.25, 31)
    run = dataclasses.replace(found.run, duration_s=share * found.run.duration_s, samples=samples)
    return dataclasses.replace(found, run=run)


@functools.cache
def truth(name: str):  # type: ignore[no-untyped-def]
    """Truth of a scene, run in this process."""
    of = scene(name)

    def seen(each: Scene, rtol: float) -> Trajectory:
        return Reference().run(each, Setting(Knob.RTOL, rtol))

    return establish(of, seen(of, 1e-13), seen(of, 1e-12), seen(twin(of), 1e-13), seen(finely(of), FINE_RTOL))


def registration(engine: type[Faulty]) -> Registration:
    """How a planted engine is registered."""
    return Registration(f"{engine.__module__}:{engine.__name__}", ours=True)


def seen_of(engine: type[Faulty], name: str, tmp_path: Path) -> Seen:
    """Runs of a planted engine, made as a worker makes them."""
    own = settings(scene(name), engine)
    jobs = {role: Job(scene(name), "planted", registration(engine), s, role) for role, s in own.items()}
    runs = {role: run_job(job, tmp_path / f"{role}.log") for role, job in jobs.items()}
    return Seen(scene(name), "planted", engine, own, runs, truth(name))


CASES = [
    (faulty_engines.Sound, FREE, Stability.STABLE, ""),
    (faulty_engines.Sound, FALLS, Stability.STABLE, ""),
    (Drifts, FREE, Stability.DRIFTING, "gap: "),
    (faulty_engines.SwapsSign, FREE, Stability.INACCURATE, "reaction: "),
    (faulty_engines.IgnoresJointsInSilence, FREE, Stability.INACCURATE, "attitude"),
    (faulty_engines.IgnoresJoints, FREE, Stability.INACCURATE, "joint 1 is open"),
    (Loose, FREE, Stability.INACCURATE, "times the band at t = "),
    (BlowsUp, FREE, Stability.UNSTABLE, "kinetic energy"),
    (WorseWithFiner, FREE, Stability.UNSTABLE, "a finer setting makes the attitude's error 10"),
    (RunsAway, FALLS, Stability.UNSTABLE, "grew"),
    (faulty_engines.GivesUp, FREE, Stability.FAILED, "step size became zero"),
    (faulty_engines.Raises, FREE, Stability.FAILED, "ZeroDivisionError"),
    (faulty_engines.ReturnsNan, FREE, Stability.FAILED, "not finite"),
    (faulty_engines.StopsEarly, FREE, Stability.FAILED, "gave no reason"),
    (Lands, FREE, Stability.FAILED, "apart from the truth"),
    (EndsAtOnce, FREE, Stability.FAILED, "apart from the truth"),
    (CanNotFactor, FREE, Stability.FAILED, "not positive definite"),
    (WillNot, FREE, Stability.REFUSED, "too light"),
]


@pytest.mark.parametrize(("engine", "name", "outcome", "words"), CASES)
def test_each_outcome_is_reached_by_an_engine_planted_for_it(
    engine: type[Faulty], name: str, outcome: Stability, words: str, tmp_path: Path
) -> None:
    seen = seen_of(engine, name, tmp_path)
    found = finding(seen)
    assert found.stability is outcome, found
    assert words in found.reason
    assert not found.slow
    rows = evidence(seen)
    assert [r["level"] for r in rows] == ["coarse", "default", "finer"]
    assert set().union(*rows) <= set(EVIDENCE)


def test_a_drift_says_how_it_grows(tmp_path: Path) -> None:
    found = finding(seen_of(Drifts, FREE, tmp_path))
    assert found.quantity == "gap"
    assert found.law is not None
    assert found.law.exponent == pytest.approx(1.5, abs=0.01)
    assert found.law.at_end == pytest.approx(OPENED, rel=1e-3)


def test_a_time_out_is_a_failure_that_hangs_on_the_machine(tmp_path: Path) -> None:
    seen = seen_of(faulty_engines.Sound, FREE, tmp_path)
    late = seen.runs | {Role.FINER: failure(Outcome.TIMED_OUT, "no result within 60 s")}
    found = finding(dataclasses.replace(seen, runs=late))
    assert (found.stability, found.slow) == (Stability.FAILED, True)
    assert found.reason == "no result within 60 s (at its finer setting)"


def test_without_a_truth_nothing_is_stable(tmp_path: Path) -> None:
    seen = seen_of(faulty_engines.Sound, FREE, tmp_path)
    assert finding(dataclasses.replace(seen, truth=None)).stability is Stability.FAILED


def test_a_refusal_is_said_while_building_and_nowhere_else(tmp_path: Path) -> None:
    def made(engine: type[Faulty]) -> RunResult:
        job = Job(scene(FREE), "planted", registration(engine), engine.ladder.setting(), Role.MAIN)
        return run_job(job, tmp_path / "log")

    assert made(WillNot).refused
    assert not made(CanNotFactor).refused
    assert not made(faulty_engines.GivesUp).refused  # an EngineError, but of its steps


def test_a_small_departure_grows_at_the_linear_rate_of_a_pendulum_in_the_tide() -> None:
    found = linear_rate(truth(FALLS))
    assert found is not None
    n = scene(FALLS).mean_motion_rad_s
    # the twin is aside in angle and rate, and its decaying part e^-√3nt is below 1 % from growth 10 on
    assert found[0] == pytest.approx(np.sqrt(3.0) * n, rel=0.01)


def test_a_track_seen_less_than_once_a_radian_is_bounded_and_not_interpolated() -> None:
    long = load_scene("hard/long_1000")

    def displaced(samples: int) -> tuple[Displacement, Array]:
        run = dataclasses.replace(long.run, duration_s=3.0 * long.period_s, samples=samples)
        of = dataclasses.replace(long, run=run)
        seen = Reference().run(of, Setting(Knob.RTOL, 1e-10))
        aside = Reference().run(twin(of), Setting(Knob.RTOL, 1e-10))
        return com_displacement(of, seen), track_response(of, seen, aside)["com"]

    (close, moved), (far, most) = displaced(301), displaced(4)
    assert not far.vector_m.any()
    assert (np.linalg.norm(close.vector_m[::100], axis=1) <= far.uncertainty_m).all()
    assert (moved[::100] <= most).all()


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_a_law_is_found_from_what_follows_it(exponent: float) -> None:
    t = np.linspace(0.0, 1e6, 2001)
    wobble = 1.0 + 0.05 * np.sin(40.0 * np.log1p(t))
    found = law(t, 1e-9 * wobble * (t / t[-1]) ** exponent)
    assert found is not None
    assert found.low - 0.03 <= exponent <= found.high + 0.03
    assert found.exponent == pytest.approx(exponent, abs=0.05)


def test_nothing_is_fitted_to_nothing() -> None:
    t = np.linspace(0.0, 1.0, 101)
    assert law(t, np.zeros(101)) is None
    assert law(t[:3], t[:3]) is None
    held = law(t, np.ones(101))
    assert held is not None
    assert held.exponent == 0.0


def test_coarser_settings_are_coarser_or_none() -> None:
    free = scene(FREE)
    for name, each in default_engines().items():
        loaded = each.load()
        main = loaded.ladder.setting()
        found = coarser(free, main)
        if found is not None:
            rises = found.value / main.value
            assert rises == (100.0 if main.knob is Knob.RTOL else 0.25), name
    close = dataclasses.replace(free, run=dataclasses.replace(free.run, samples=100_001))
    assert coarser(close, Setting(Knob.STEPS_PER_ORBIT, 1000.0)) is None


def test_scipy_runs_at_its_own_default_tolerances_too() -> None:
    roles = {name: settings(scene(FREE), r.load()) for name, r in default_engines().items()}
    plain = {name for name, by in roles.items() if Role.PLAIN in by}
    assert plain == {"scipy-rk45", "scipy-dop853", "scipy-radau", "scipy-lsoda"}


def found_as(word: str) -> Finding:
    """Finding as it would be recorded by a word."""
    return Finding(expected.stability_of(word), slow=word == SLOW)


@pytest.mark.parametrize(
    ("before", "now", "direction"),
    [
        ("stable", "stable", None),
        ("stable", "unstable", "worse"),
        ("failed", "drifting", "better"),
        ("inaccurate", "refused", "better"),
        ("stable", SLOW, "worse"),
        ("failed", SLOW, None),
        (SLOW, "stable", None),
        (SLOW, "failed", None),
        (None, "failed", None),
    ],
)
def test_a_change_either_way_is_told_and_time_outs_alone_are_none(
    before: str | None, now: str, direction: str | None
) -> None:
    found = expected.change("hard/x", "exudyn", before, found_as(now))
    assert (found.direction if found else None) == direction
    if found:
        assert found.words == f"hard/x  exudyn: {before} before, {now} now ({direction})"


def test_what_is_accepted_is_what_is_expected(tmp_path: Path) -> None:
    path = tmp_path / "expected.toml"
    expected.accept({("hard/a", "exudyn"): found_as("drifting"), ("hard/b", "pymunk"): found_as(SLOW)}, path)
    expected.accept({("hard/a", "exudyn"): found_as("stable")}, path)
    assert expected.recorded(path) == {("hard/a", "exudyn"): "stable", ("hard/b", "pymunk"): SLOW}


def test_what_is_recorded_is_of_scenes_and_engines_that_are_there() -> None:
    scenes = set(hard_scenes())
    for (name, engine), word in expected.recorded().items():
        assert name in scenes or HUGE in load_scene(name).tags
        assert engine in ENGINES
        assert expected.stability_of(word) in Stability


def test_engines_that_can_not_are_left_out_and_no_engine_is_run_without_hope(tmp_path: Path) -> None:
    planted: dict[str, type[Faulty]] = {"can-not": CanNot, "hangs": faulty_engines.Hangs}
    plan = Plan((scene(FREE),), {n: registration(e) for n, e in planted.items()}, time_limit_s=1.0, workers=1)
    result = stability(plan, tmp_path, command="test")
    assert result.findings[FREE, "can-not"].stability is Stability.UNSUPPORTED
    late = result.findings[FREE, "hangs"]
    assert (late.stability, late.slow) == (Stability.FAILED, True)
    assert late.reason.startswith("not run: the coarse setting already took longer than 1 s")
    assert result.passed
    runs = json.loads((tmp_path / "stability" / "run.json").read_text())["runs"]
    assert [r["role"] for r in runs if r["engine"] == "hangs"] == ["coarse", "main", "finer"]


def ours() -> Iterable[str]:
    """Both forms of the reference, where they are there."""
    return [name for name in ("reference", "reference-fast") if ENGINES[name].missing is None]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a small study, run as a user would."""
    out = tmp_path_factory.mktemp("stability")
    named = [word for name in (*ours(), "scipy-rk45") for word in ("--engine", name)]
    few = ["--workers", "1", "--out", str(out)]  # the runs are short: starting processes takes longer
    assert command(["stability", "hard/vertical_fall", "hard/slews_overlapping", *named, *few]) == 0
    return out


def test_ours_are_stable_in_short_hard_scenes(folder: Path) -> None:
    tables = read_stability(folder)
    assert list(tables.outcomes.columns) == list(OUTCOMES)
    assert list(tables.evidence.columns) == list(EVIDENCE)
    own = tables.outcomes[tables.outcomes.engine.isin(list(ours()))]
    assert len(own) == 2 * len(list(ours()))
    assert set(own.stability) == {"stable"}
    assert tables.record["finished"]


def test_scipy_at_its_defaults_reports_success_and_is_told_on(folder: Path) -> None:
    plain = read_stability(folder).plain.set_index("scene")
    assert set(plain.run) == {"pass"}
    assert plain.attitude_rad["hard/slews_overlapping"] > 0.01  # it asks for 1e-3 a step
    view = view_stability(folder)
    assert view is not None
    assert "success reported in 2 of 2 runs; in 1 of these attitude is off by more than 0.01 rad" in view.plain_sentence


def test_the_page_is_rendered_from_the_tables_alone(folder: Path) -> None:
    text = render_stability(folder).read_text(encoding="utf-8")
    view = view_stability(folder)
    assert view is not None
    assert view.headline in text
    assert "stable in all 2 hard scenes" in view.headline
    for word in ("Condition of the joint system", "a bar reached the surface", "SciPy at its defaults"):
        assert word in text, word
    assert r"| hard/vertical\_fall |" in (folder / "stability" / "stability.md").read_text(encoding="utf-8")


def test_a_study_goes_on_from_what_an_earlier_one_left(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(jobs: list[Job], **_: object) -> list[tuple[Job, RunResult]]:
        assert not jobs
        return []

    before = read_stability(folder).outcomes
    monkeypatch.setattr("barchain.stability.study.run_jobs", nothing)
    named = [word for name in (*ours(), "scipy-rk45") for word in ("--engine", name)]
    assert command(["stability", *before.scene.unique(), *named, "--out", str(folder), "--resume"]) == 0
    assert read_stability(folder).outcomes.equals(before)


def test_forms_of_the_reference_get_ten_times_as_long_as_other_engines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    allowed_s: dict[str, float] = {}

    def noted(jobs: list[Job], *, time_limit_s: float, **_: object) -> list[tuple[Job, RunResult]]:
        allowed_s.update({job.engine: time_limit_s for job in jobs if job.role not in TRUTH_ROLES})
        return []

    monkeypatch.setattr("barchain.stability.study.run_jobs", noted)
    plan = Plan((load_scene("hard/vertical_fall"),), chosen_engines(["reference", "exudyn"]), time_limit_s=7.0)
    stability(plan, tmp_path, command="test")
    assert allowed_s == {"reference": 70.0, "exudyn": 7.0}


@pytest.mark.slow
@pytest.mark.timeout(0)  # an hour on two cores
def test_ours_are_stable_in_all_hard_scenes_and_nothing_changed(tmp_path: Path) -> None:
    scenes = tuple(load_scene(name) for name in hard_scenes())
    result = stability(Plan(scenes, default_engines()), tmp_path, command="test")
    assert not result.ours
    assert not result.changes
