"""Documents of a stored night: page, summary, nightly.json, JUnit XML, and the exit code."""

from __future__ import annotations

import datetime
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import xmlschema
from click.testing import CliRunner
from junitparser import JUnitXml

from barchain.cli.main import cli
from barchain.cli.nightly.documents import publish
from barchain.nightly.figures.figure import Figure, NightPart
from barchain.nightly.history.acceptances import accept, accepted, holding
from barchain.nightly.history.judging import change_named, changes_named, judge
from barchain.nightly.history.news import told_by
from barchain.nightly.history.nights import NightStore, open_store
from reports.render import render
from reports.results.comparison import FILES
from reports.results.nights import STATE
from reports.results.nights.document import AlarmTest, NightlyFile, NightRun, PartResult, PartState, ratio_words
from tests.nightly.history.synthetic import NAMES, PARTS, bits, count, error, night, ratio, verdict
from tests.support.nightly import read_nightly
from tests.support.results import write_results

NOW = datetime.datetime.now(datetime.UTC)
SCHEMA = Path(__file__).with_name("junit-10.xsd")
NEWER = (NightPart("engine:mujoco", "4.0.0", "ee"), *PARTS[1:])
RUN = NightRun(
    "plan", 15.0,
    (
        PartResult("alarm", PartState.DONE, 60.0, 20.0, done=20, command="barchain selftest"),
        PartResult("core", PartState.LEFT, 100.0, 100.0, ("paper/fig13",), "interrupted at its limit of 100 s", 3),
        PartResult("cost", PartState.FAILED, 90.0, 2.0, reason="<b>no & such</b> engine"),
    ),
    AlarmTest(20),
)  # fmt: skip


def report(url: str, out: Path, *more: str) -> tuple[int, NightlyFile]:
    ended = CliRunner().invoke(cli, ["history", "report", "--history", url, "--out", str(out), *more])
    assert ended.exception is None or isinstance(ended.exception, SystemExit), ended.output
    return ended.exit_code, read_nightly(out / "nightly.json")


def add(url: str, *nights: Any, run: NightRun | None = None) -> None:
    store = open_store(url, create=True)
    for each in nights:
        store.add(each, run=run)


def usual(factor: float = 1.0, **more: Any) -> Any:
    return night(error(1e-5 * factor), count(), verdict(), bits("00" if factor == 1.0 else "11"), ratio(), **more)


def test_the_first_night_has_all_documents_and_the_second_one_is_quiet(url: str, tmp_path: Path) -> None:
    for number, state in enumerate(("first night", "quiet")):
        add(url, usual(number=number))
        code, facts = report(url, tmp_path / "out")
        assert (code, facts.state) == (0, state)
        assert facts.sentence.startswith("This is the first night") is (number == 0)
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"nightly.html", "nightly.json", "summary.md", "junit.xml"}


def test_a_verdict_that_is_no_pass_is_named_in_every_document_of_every_night(url: str, tmp_path: Path) -> None:
    for number in (0, 1):
        add(url, night(verdict("inconsistent", reason="reactions off <by> 2 N"), number=number))
        out = tmp_path / str(number)
        shown = CliRunner().invoke(cli, ["history", "report", "--history", url, "--out", str(out)])
        assert shown.exit_code == 0  # nothing changed
        facts = read_nightly(out / "nightly.json")
        (told,) = facts.rejected
        assert (told.verdict, told.reason) == ("inconsistent", "reactions off <by> 2 N")
        assert f"  {told.engine} on {told.scene}: inconsistent: reactions off <by> 2 N\n" in shown.output
        assert told.engine in (out / "summary.md").read_text()
        assert "reactions off &lt;by&gt; 2 N" in (out / "nightly.html").read_text()
        cases = [case for suite in JUnitXml.fromfile(str(out / "junit.xml")) for case in suite]
        assert [case.system_out for case in cases if case.system_out][-1] == told.words
    assert facts.state == "not passed"


def test_a_larger_error_is_told_with_factor_and_suspect_in_each_document_and_ends_with_1(
    url: str, tmp_path: Path
) -> None:
    add(url, usual(number=0), usual(number=1), usual(12390.0, number=2, parts=NEWER))
    code, facts = report(url, tmp_path)
    assert code == 1
    worse = [c for c in facts.changes if c.direction == "worse"]
    assert [(c.quantity, c.factor, [s.name for s in c.suspects]) for c in worse] == [
        ("attitude.max", pytest.approx(12390.0), ["engine:mujoco"])
    ]
    assert "engine:mujoco 4.0.0" in facts.sentence
    assert "×12 400" in facts.sentence
    assert "12 400 times" in worse[0].reason
    for name in ("nightly.html", "summary.md", "junit.xml"):
        text = (tmp_path / name).read_text("utf-8").replace("<wbr>", "")
        assert "×12 400" in text
        assert "3.3.0 → 4.0.0" in text


@pytest.mark.parametrize(("fail_on", "code"), [("worse", 0), ("changed", 1), ("never", 0)])
def test_a_better_figure_fails_only_where_any_change_shall_fail(
    url: str, tmp_path: Path, fail_on: str, code: int
) -> None:
    add(url, usual(number=0), usual(0.5, number=1, parts=NEWER))
    assert report(url, tmp_path / "out", "--fail-on", fail_on)[0] == code


def test_a_void_night_ends_with_3_and_is_an_error_of_its_plan(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1, void="1 of 20 planted faults missed: mu"), run=RUN)
    code, facts = report(url, tmp_path / "out")
    assert (code, facts.night.state, facts.changes) == (3, "void", ())
    plan = {suite.name: suite for suite in JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml"))}["plan"]
    assert plan.errors == 3  # the night, the part that was left, the part that failed


def test_an_incomplete_night_ends_with_3_unless_something_is_worse(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(number=1, complete=False))
    assert report(url, tmp_path / "out")[0] == 3
    assert plan_errors(tmp_path / "out") == 1
    add(url, usual(2.0, number=2, complete=False))
    assert report(url, tmp_path / "out")[0] == 1


def plan_errors(out: Path) -> int:
    """Errors of the suite of the plan."""
    return next(suite.errors for suite in JUnitXml.fromfile(str(out / "junit.xml")) if suite.name == "plan")


def test_a_baseline_without_a_common_figure_ends_with_3_and_is_an_error(url: str, tmp_path: Path) -> None:
    add(url, night(error(quantity="place"), number=0, plan="other"), night(error(), number=1))
    store = open_store(url)
    first = store.nights()[0].name
    assert report(url, tmp_path / "out", "--baseline", first)[0] == 3
    assert plan_errors(tmp_path / "out") == 1


@pytest.mark.parametrize("later", [0, 2])
def test_a_change_for_the_worse_no_longer_fails_or_is_red_in_the_calendar_once_it_is_accepted(
    url: str, tmp_path: Path, later: int
) -> None:
    for number in range(later + 2):
        add(url, usual(2.0 if number else 1.0, number=number, parts=NEWER if number else PARTS))
        report(url, tmp_path / "out")
    store = open_store(url)
    assert worse_on_each_night(store) == [0, *[1] * (later + 1)][-len(told_by(store)) :]
    accept(store, [change_named(judge(store), error().identity.name)], "Ada", "fewer steps on purpose")
    assert set(worse_on_each_night(store)) == {0}
    code, facts = report(url, tmp_path / "out")
    assert (code, facts.standing) == (0, ())
    assert (facts.counts.accepted, [c.quantity for c in facts.held]) == ((0, ["attitude.max"]) if later else (1, []))
    assert "fewer steps on purpose" in (tmp_path / "out" / "nightly.html").read_text("utf-8")
    assert "accepted by Ada on" in (tmp_path / "out" / "summary.md").read_text("utf-8")
    assert sum(suite.failures for suite in JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml"))) == 0


def worse_on_each_night(store: NightStore) -> list[int]:
    """Numbers of figures that were worse than what is accepted now."""
    return [facts.worse(holding(accepted(store), NOW)) for facts in told_by(store).values()]


def test_an_earlier_change_for_the_worse_stands_until_it_is_mended(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1), usual(2.0, number=2))
    code, facts = report(url, tmp_path / "out")
    assert code == 1
    assert facts.sentence == ("One figure is worse than accepted by ×2 since 2 January. Nothing is new tonight.")
    assert [c.quantity for c in facts.standing] == ["attitude.max"]
    assert "attitude.max" in (tmp_path / "out" / "summary.md").read_text("utf-8")
    assert sum(suite.failures for suite in JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml"))) == 1
    add(url, usual(number=3, parts=NEWER))
    code, facts = report(url, tmp_path / "out")
    assert code == 0
    assert facts.standing == ()


def test_junit_agrees_with_the_schema_of_jenkins(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1, parts=NEWER), run=RUN)
    add(url, night(error(3e-5), verdict("unsupported", reason="no <gravity> & such"), number=2), run=RUN)
    report(url, tmp_path / "out", "--junit", str(tmp_path / "own.xml"))
    xmlschema.validate(str(tmp_path / "own.xml"), str(SCHEMA))
    suites = {suite.name: suite for suite in JUnitXml.fromfile(str(tmp_path / "own.xml"))}
    assert suites["mujoco"].failures >= 1
    assert {case.name for case in suites["plan"]} == {"night", "alarm", "core", "cost"}


def test_nightly_json_agrees_with_its_own_schema(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1, parts=NEWER), run=RUN)
    report(url, tmp_path / "out")
    printed = CliRunner().invoke(cli, ["schema", "nightly"]).output
    jsonschema.validate(json.loads((tmp_path / "out" / "nightly.json").read_text("utf-8")), json.loads(printed))


def test_the_page_loads_nothing_and_shows_no_markup_of_the_data(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1), run=RUN)
    report(url, tmp_path / "out")
    page = (tmp_path / "out" / "nightly.html").read_text("utf-8")
    assert "default-src 'none'" in page
    assert "<b>no" not in page
    assert "&lt;b&gt;no &amp; such" in page
    assert not re.search(r"<script|https?://", page)


def test_a_baseline_is_a_night_or_a_copy_of_its_folder_that_the_user_keeps(url: str, tmp_path: Path) -> None:
    first = usual(number=0)
    add(url, first, usual(2.0, number=1, parts=NEWER), usual(2.0, number=2, parts=NEWER))
    assert report(url, tmp_path / "out")[1].changes == ()
    code, facts = report(url, tmp_path / "out", "--baseline", first.name)
    assert (code, facts.against.baseline) == (1, first.name)
    shutil.copytree(Path(url) / first.name, tmp_path / "kept" / "release")
    assert report(url, tmp_path / "out", "--baseline", str(tmp_path / "kept" / "release"))[0] == 1


@pytest.mark.parametrize("content", ["", '{"format": 1}'])
def test_a_folder_that_is_no_baseline_is_told_in_one_line(url: str, tmp_path: Path, content: str) -> None:
    add(url, usual(number=0))
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "record.json").write_text(content, "utf-8")
    words = ["history", "report", "--history", url, "--out", str(tmp_path), "--baseline", str(tmp_path / "base")]
    ended = CliRunner().invoke(cli, words)
    assert type(ended.exception).__name__ == "HistoryError"
    assert "\n" not in str(ended.exception)


def test_a_case_of_several_changes_has_one_failure_which_a_worse_verdict_names(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), run=RUN)
    add(url, night(error(3e-5), verdict("inconsistent"), number=1, parts=NEWER), run=RUN)
    report(url, tmp_path / "out")
    found = JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml"))
    suites = {suite.name: suite for suite in found}
    assert suites["mujoco"].failures == len(list(suites["mujoco"])) == 1
    (case,) = suites["mujoco"]
    assert "verdict" in case.result[0].message
    assert "attitude.max" in case.result[0].text
    _, facts = report(url, tmp_path / "out")
    assert [c.kind for c in facts.changes][:2] == ["verdict", "error"]  # the gravest one first


def test_another_plan_is_told_with_the_figures_that_come_and_go(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(number=1), night(error(1e-5), error(2e-5, "place"), number=2, plan="other"))
    _, facts = report(url, tmp_path / "out")
    assert "The plan is another one than on the night before: one figure is new, four figures are not measured" in (
        facts.sentence
    )
    assert facts.counts.judged == 1


def test_figures_that_are_new_or_gone_are_counted(url: str, tmp_path: Path) -> None:
    more = [*usual().figures, error(1e-5, "reaction.max")]
    add(url, usual(number=0), night(*more, number=1))
    assert report(url, tmp_path)[1].sentence == "Nothing changed tonight among 5 figures. One figure is new."
    add(url, night(*more, number=2), night(error(1e-5), number=3))
    _, facts = report(url, tmp_path)
    assert [1 + change.also for change in facts.changes] == [5]  # one run, one line
    assert facts.counts.judged == 6
    assert facts.sentence.startswith("Five figures of 6 changed tonight")


def test_a_night_is_reported_in_its_folder_and_the_latest_one_beside_all(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(2.0, number=1, parts=NEWER))
    store = open_store(url)
    first, last = (each.name for each in store.nights())
    for name in (first, last):
        CliRunner().invoke(cli, ["history", "report", name, "--history", url])
    assert read_nightly(Path(url) / first / "nightly.json").night.name == first
    assert read_nightly(Path(url) / "nightly.json").night.name == last
    own, beside = ((Path(url) / place / "nightly.html").read_text("utf-8") for place in (last, ""))
    assert f'href="../{first}/nightly.html"' in own
    assert f'href="{first}/nightly.html"' in beside


def test_an_engine_that_never_passed_fails_where_every_verdict_has_to_pass(url: str, tmp_path: Path) -> None:
    for number in (0, 1):
        add(url, night(verdict("inconsistent", reason="wrong sign"), number=number))
    assert report(url, tmp_path / "out")[0] == 0
    assert report(url, tmp_path / "out", "--fail-on", "not-pass")[0] == 1
    found = JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml"))
    assert sum(suite.failures for suite in found) == 1
    assert "inconsistent: wrong sign" in next(iter(next(s for s in found if s.name == "mujoco"))).result[0].message


def test_a_lost_history_ends_with_3_where_one_is_required(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0))
    assert report(url, tmp_path / "out")[0] == 0
    night_case = next(iter(next(s for s in JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml")) if s.name == "plan")))
    assert night_case.system_out.startswith("This is the first night: there is no earlier one to compare it with")
    assert report(url, tmp_path / "out", "--require-history")[0] == 3
    assert plan_errors(tmp_path / "out") == 1
    add(url, usual(number=1))
    assert report(url, tmp_path / "out", "--require-history")[0] == 0


def test_a_scene_of_another_name_and_equal_content_is_the_same_scene_and_no_suspect(url: str, tmp_path: Path) -> None:
    def of(scene: str, number: int, engine: str = "3.2.7", value: float = 1e-5) -> Any:
        parts = (
            NightPart(f"scene:{scene}", "", "aa"),
            NightPart(f"solution:{scene}", "0.6.0"),
            NightPart("engine:mujoco", engine, ""),
        )
        own = (replace(f, depends=tuple(part.name for part in parts)) for f in (error(value), verdict()))
        named = (replace(f, identity=replace(f.identity, scene=scene)) for f in own)
        return night(*named, number=number, parts=parts)

    add(url, of("old", 0), of("old", 1), of("new", 2, "4.0.0", 2e-5))
    _, facts = report(url, tmp_path / "out")
    (found,) = facts.changes
    assert [suspect.name for suspect in found.suspects] == ["engine:mujoco"]
    assert [part.name for part in facts.night.exchanged] == ["engine:mujoco"]
    assert (facts.counts.judged, facts.counts.new) == (2, 0)
    assert "The scene old became new: figures are compared by their role." in facts.sentence


def test_a_copy_of_a_scene_continues_no_other_setting_of_the_scene(url: str, tmp_path: Path) -> None:
    def of(number: int, *own: tuple[str, int, float]) -> Any:
        made = [
            replace(error(value), identity=replace(error().identity, scene=scene, setting=f"steps_per_orbit={steps}"))
            for scene, steps, value in own
        ]
        parts = (*PARTS, *(NightPart(f"scene:{s}", "", "aa") for s in ("a", "copy")))
        return night(*made, number=number, parts=parts, plan=own[1][0])

    add(url, *(of(k, ("a", 1000, 1e-5), ("a", 2000, 1e-7)) for k in range(2)))
    add(url, of(2, ("a", 1000, 1e-5), ("copy", 1000, 1e-5)))
    assert report(url, tmp_path / "out")[1].changes == ()


def test_an_engine_that_fails_is_one_event_and_one_acceptance(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(number=1))
    gone = [Figure(f.identity, reason="the run failed", depends=f.depends) for f in (error(), count())]
    add(url, night(*gone, verdict("failed"), bits("00"), ratio(), number=2))
    _, facts = report(url, tmp_path / "out")
    (event,) = facts.changes
    assert (event.quantity, event.also) == ("verdict", 2)
    assert facts.sentence.startswith("Three figures of 5 changed tonight, all for the worse")
    words = ["history", "accept", event.id, "--reason", "known", "--history", url]
    assert CliRunner().invoke(cli, words).exit_code == 0
    assert report(url, tmp_path / "out")[0] == 0


def test_a_run_without_a_result_is_told_though_its_part_ended_before_the_verdict(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(number=1))
    late = Figure(bits().identity, reason="no result within 14 s, ended in simulate")
    add(url, night(late, number=2, complete=False), run=RUN)
    _, facts = report(url, tmp_path / "out")
    (told,) = facts.rejected
    assert told.words == "mujoco on paper/fig05: missing: no result within 14 s, ended in simulate"


def test_what_is_worse_and_was_not_measured_tonight_says_so(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(number=1), usual(5.0, number=2, parts=NEWER))
    report(url, tmp_path / "before")
    add(url, night(count(), number=3, complete=False))
    _, facts = report(url, tmp_path / "out")
    assert "not measured tonight" in facts.sentence
    assert "Nothing is new among" in facts.sentence
    assert facts.standing
    assert all(change.measured.startswith("2026-01-03") for change in facts.standing)
    assert "not measured since" in (tmp_path / "out" / "junit.xml").read_text("utf-8")


def test_a_program_that_is_gone_is_the_one_suspect_of_its_loss_and_of_its_return(url: str, tmp_path: Path) -> None:
    program = NightPart("program:mine", "mine 1.7", "aa")
    adapter = NightPart("adapter:command", "0.7.0", "bb")
    depends = (program.name, adapter.name, *NAMES)
    here = [replace(f, depends=depends) for f in (error(), verdict(), count())]
    gone = [replace(f, value=None, word="", reason="engine is not there", depends=depends[2:]) for f in here]
    whole = (program, adapter, *PARTS)
    nights = [night(*here, number=k, parts=whole) for k in range(2)]
    add(url, *nights, night(*gone, number=2))
    _, lost = report(url, tmp_path / "lost")
    add(url, night(*here, number=3, parts=whole))
    _, back = report(url, tmp_path / "back")
    for facts in (lost, back):
        (change,) = [one for one in facts.changes if one.kind != "count"]
        assert [one.name for one in change.suspects] == ["program:mine"]
        assert change.also >= 1


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1.2345678, "×1.235"), (12390.0, "×12 400"), (9999.9, "×10 000"), (3e-5, "÷33 300"), (1e-4, "÷10 000"),
        (0.25, "×0.25"), (4e-4, "÷2500"), (1e12, "×1e12"), (1.0 + 2e-9, "×(1 + 2e-09)"), (0.0, "×0"),
    ],
)  # fmt: skip
def test_a_factor_is_told_in_plain_digits(factor: float, words: str) -> None:
    assert ratio_words(factor) == words


@pytest.mark.parametrize(("judging", "offered"), [("0.7.0", True), ("", False)])
def test_the_page_offers_no_runs_of_a_program_whose_earlier_state_is_not_kept(
    judging: str, offered: bool, url: str, tmp_path: Path
) -> None:
    """Only what differs beside the program, here another judge and not its loss, can be tried."""
    for number, (version, judge_version) in enumerate((("1.6", "0.6.0"), ("1.6", "0.6.0"), ("1.7", judging))):
        parts = [NightPart("program:mine", version, version)]
        parts += [NightPart("judge", judge_version, judge_version)] if judge_version else []
        own = error(1e-5 if number < 2 else 1e-3, depends=("program:mine", "judge"))
        add(url, night(own, number=number, parts=tuple(parts)))
    report(url, tmp_path)
    page = (tmp_path / "nightly.html").read_text("utf-8")
    assert ("other than of programs, whose earlier states are not kept" in page) is offered


def test_an_engine_that_crashes_from_its_first_night_on_is_red_until_that_is_accepted(url: str, tmp_path: Path) -> None:
    for number in range(2):
        add(url, night(verdict("failed", reason="ended with code 139"), number=number))
        code, facts = report(url, tmp_path / "out")
        assert (code, facts.state) == (1, "worse")
        (one,) = facts.standing
        assert one.words.endswith(":verdict: failed from the first night on (no earlier pass)")
        assert one.reason == "failed from the first night on: ended with code 139"
        assert one.suspect_words == ""
        for name in ("nightly.html", "summary.md", "junit.xml"):
            text = (tmp_path / "out" / name).read_text("utf-8")
            assert "failed from the first night on" in text
            assert "all parts that the figure depends on" not in text
            assert "suspects: " not in text
    store = open_store(url)
    assert worse_on_each_night(store) == [1, 1]
    accept(store, changes_named(judge(store), "*:mujoco:*"), "Ada", "no wheel of it yet", pattern="*:mujoco:*")
    assert report(url, tmp_path / "out")[0] == 0
    assert worse_on_each_night(store) == [0, 0]


def test_an_engine_that_crashes_as_on_the_baseline_is_no_worse_than_it(url: str, tmp_path: Path) -> None:
    for number in range(2):
        add(url, night(verdict("failed", reason="ended with code 139"), number=number))
    first, _ = open_store(url).nights()
    assert report(url, tmp_path / "out", "--baseline", first.name)[0] == 0


def test_the_part_behind_the_latest_step_is_told_on_quiet_nights_too(url: str, tmp_path: Path) -> None:
    newer_still = (NightPart("engine:mujoco", "5.0.0", "ff"), *NEWER[1:])
    states = ((1.0, PARTS), (5.0, NEWER), (6.0, newer_still), (6.0, newer_still))
    add(url, *(night(error(1e-5 * f), number=k, parts=parts) for k, (f, parts) in enumerate(states)))
    _, facts = report(url, tmp_path / "out")
    assert "(first engine:mujoco 4.0.0; two steps, the latest with engine:mujoco 5.0.0)" in facts.sentence
    both = "engine:mujoco 3.3.0 → 4.0.0; latest step: engine:mujoco 4.0.0 → 5.0.0"
    for name in ("nightly.html", "summary.md", "junit.xml"):
        assert both in (tmp_path / "out" / name).read_text("utf-8").replace("<wbr>", "")


def test_no_line_for_a_chat_is_longer_than_a_chat_shows(url: str) -> None:
    long = [error(1e-5, f"{'quantity' * 8}.{k}") for k in range(8)]
    add(url, night(*long, number=0))
    for number in (1, 2):
        worse = [error(3e-5 * number, f"{'quantity' * 8}.{k}") for k in range(8)]
        add(url, night(*worse, verdict("inconsistent", reason="why " * 100), number=number, parts=NEWER))
    lines = CliRunner().invoke(cli, ["history", "tell", "--history", url]).output.splitlines()
    assert max(map(len, lines)) <= 200
    assert lines[0].startswith(
        "Eight figures are worse than accepted by up to ×6 since 2 January (first engine:mujoco 4.0.0; two steps, "
    )


def test_a_figure_that_is_worse_since_earlier_and_moves_tonight_is_one_line(url: str, tmp_path: Path) -> None:
    add(url, usual(number=0), usual(5.0, number=1), usual(6.0, number=2))
    words = ["history", "report", "--history", url, "--out", str(tmp_path / "out")]
    shown = CliRunner().invoke(cli, words).output
    (line,) = [line for line in shown.splitlines() if "attitude.max" in line]
    assert line.startswith("  worse since 2026-01-02: ")
    assert line.endswith("(×6 in 2 steps, ×1.2 tonight)")
    told = CliRunner().invoke(cli, ["history", "tell", "--history", url]).output
    assert told.count("attitude.max") == 1
    (case,) = [case for suite in JUnitXml.fromfile(str(tmp_path / "out" / "junit.xml")) for case in suite if case.result
               and suite.name != "plan"]  # fmt: skip
    assert "(×6 in 2 steps, ×1.2 tonight)" in case.result[0].message


def test_the_page_of_a_night_links_the_pages_of_its_parts_and_of_other_nights(url: str, tmp_path: Path) -> None:
    """Also where the history lies beside the folder of the results."""
    add(url, usual(number=0), usual(number=1), run=RUN)
    store = open_store(url)
    first, last = (each.name for each in store.nights())
    results = tmp_path / "nights" / last
    (results / "core").mkdir(parents=True)
    (results / "core" / "index.html").touch()
    report(url, tmp_path / "nights" / first, first)
    report(url, results)
    page = (results / "nightly.html").read_text("utf-8")
    assert f'href="../{last}/core/index.html"' in page
    assert f'href="../{first}/nightly.html"' in page
    (tmp_path / "nights" / first / "nightly.html").rename(Path(url) / first / "nightly.html")
    report(url, results)
    assert f'href="../../history/{first}/nightly.html"' in (results / "nightly.html").read_text("utf-8")


def test_the_page_of_a_part_leads_back_to_the_page_of_its_night(tmp_path: Path) -> None:
    rows = [{"scene": "basics/a", "engine": "exudyn", "metric": "verdict", "outcome": "failed", "quantity": "run"}]
    record = {"complete": True, "scenes": {"basics/a": {}}, "engines": {"exudyn": {}}}
    folder = write_results(tmp_path / "night" / "core", FILES, {"metrics": rows}, record)
    assert "nightly.html" not in render(folder)[0].read_text("utf-8")
    (tmp_path / "night" / STATE).touch()
    assert 'href="../nightly.html"' in render(folder)[0].read_text("utf-8")


def test_a_night_that_ends_after_a_newer_one_leaves_the_newest_in_front(url: str, tmp_path: Path) -> None:
    out = tmp_path / "nights"
    for number in (0, 2, 1):
        one = usual(number=number)
        add(url, one)
        report(url, out / one.name, one.name)
        assert publish(open_store(url), one.name, out / one.name) == (out / one.name if number == 1 else out)
    assert read_nightly(out / "nightly.json").night.started.day == 3


def test_a_part_that_gave_no_times_says_so_where_their_steps_would_stand(url: str, tmp_path: Path) -> None:
    reason = "interrupted at its limit of 8 s"
    part = PartResult("times", PartState.LEFT, 8.0, 8.0, ("paper/fig05",), reason, command="barchain cost paper/fig05")
    add(url, usual(number=0), usual(number=1), run=NightRun("plan", 1.0, (part,)))
    report(url, tmp_path / "out")
    page = (tmp_path / "out" / "nightly.html").read_text("utf-8")
    new = page[page.index('id="changes"') : page.index('id="plan"')]
    assert f"No times, or not all, of times: {reason}" in new
