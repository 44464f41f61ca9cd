"""Message for a chat, and JUnit, of nights without figures, damaged nights, new verdicts, and accepted steps."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner
from junitparser import JUnitXml

from barchain.cli.main import cli, run
from barchain.nightly.figures.dependencies import Installation
from barchain.nightly.figures.figure import NIGHT_FORMAT
from barchain.nightly.history.acceptances import accept
from barchain.nightly.history.judging import change_named, judge
from barchain.nightly.history.nights import open_store
from barchain.nightly.running.state import NightState, write_state
from barchain.record.claim import locked
from reports.results.nights.document import NightRun, PartResult, PartState
from tests.nightly.history.synthetic import ENVIRONMENT, PARTS, NightPart, count, error, identity, night, verdict
from tests.support.nightly import read_nightly

if TYPE_CHECKING:
    from junitparser import TestCase

    from barchain.nightly.history.nights import NightStore

NEWER = (NightPart("engine:mujoco", "4.0.0", "ee"), *PARTS[1:])


def told(url: str, *words: str) -> list[str]:
    """Lines of the message for a chat."""
    ended = CliRunner().invoke(cli, ["history", "tell", *words, "--history", url])
    assert ended.exit_code == 0, ended.output
    return ended.output.splitlines()


def report(url: str, out: Path) -> dict[str, TestCase]:
    """Write the documents of the latest night, and give the cases of its JUnit XML by name."""
    CliRunner().invoke(cli, ["history", "report", "--history", url, "--out", str(out)])
    return {case.name: case for suite in JUnitXml.fromfile(str(out / "junit.xml")) for case in suite}


def cut_short(reason: str) -> NightRun:
    return NightRun("plan", 15.0, (PartResult("core", PartState.LEFT, 10.0, reason=reason),))


def test_an_earlier_night_is_told_after_the_reason_why_the_latest_one_has_no_figures(
    store: NightStore, url: str
) -> None:
    store.add(night(error(), number=0))
    store.add(night(error(), number=1))
    store.add(night(number=2, complete=False), run=cut_short("the night was interrupted"))
    earlier, empty = (each.name for each in store.nights()[1:])
    assert told(url) == [
        "The night of 3 January is incomplete: core, the night was interrupted. The last night with figures:",
        "Nothing changed tonight among 1 figure.",
        earlier,
    ]
    assert told(url, earlier) == told(url)[1:]
    assert told(url, empty)[-1] == empty
    store.add(night(error(), number=3))
    assert told(url)[0] == "Nothing changed tonight among 1 figure. The night of 3 January did not end."


def test_the_reason_of_a_night_without_figures_is_no_longer_than_a_chat_shows(store: NightStore, url: str) -> None:
    store.add(night(error(), number=0))
    store.add(night(number=1, complete=False), run=cut_short("triple.toml: chain.bars: not a number " * 20))
    assert max(map(len, told(url))) <= 200


def test_damaged_nights_are_named_in_the_message_and_in_junit(store: NightStore, url: str, tmp_path: Path) -> None:
    for number in range(4):
        store.add(night(error(), number=number))
    names = [each.name for each in store.nights()][:2]
    assert not any(name in line for line in told(url) for name in names)
    for name in names:
        path = Path(url) / name / "figures.parquet"
        content = path.read_bytes()
        path.write_bytes(content[:40] + bytes([content[40] ^ 1]) + content[41:])
    first, line, last = told(url)
    assert (first, last) == ("Nothing changed tonight among 1 figure.", open_store(url).nights()[-1].name)
    said = report(url, tmp_path)["night"].system_out
    for name in names:
        assert name in line
        assert name in said


def test_a_new_wrong_verdict_is_told_before_figures_that_are_worse_since_earlier(store: NightStore, url: str) -> None:
    names = [f"rate.{k}" for k in range(5)]
    for number, factor in enumerate((1.0, 2.0, 2.0)):
        word = "inconsistent" if number == 2 else "pass"
        store.add(night(*(error(factor * 1e-5, name) for name in names), verdict(word), number=number, parts=NEWER))
    lines = told(url, "--link", "https://example.org/nightly.html")
    assert lines[-1] == "https://example.org/nightly.html"
    assert "(one verdict: inconsistent)" in " ".join(lines)
    found = [line for line in lines if line.startswith("worse ")]
    assert found[0].startswith("worse tonight: paper/fig05:mujoco:steps_per_orbit=1000:verdict: pass → inconsistent")
    assert found[1].startswith("worse since 2026-01-02: ")


def test_a_large_new_step_is_told_before_a_small_one_of_an_earlier_night(store: NightStore, url: str) -> None:
    names = [f"rate.{k}" for k in range(5)]
    for number, (factor, new) in enumerate(((1.0, 1.0), (2.0, 1.0), (2.0, 4.0))):
        store.add(night(*(error(factor * 1e-5, name) for name in names), error(new * 1e-5), number=number))
    found = [line for line in told(url) if line.startswith("worse ")]
    assert found[0].startswith("worse tonight: ")
    assert "(×4)" in found[0]
    assert found[1].startswith("worse since 2026-01-02: ")


def test_of_the_verdicts_an_explained_one_that_became_wrong_is_told_first(
    store: NightStore, url: str, tmp_path: Path
) -> None:
    def cell(scene: str, reason: str) -> object:
        own = identity("verdict", verdict().identity.kind, scene=scene)
        return type(verdict())(own, word="inconsistent" if reason else "pass", reason=reason)

    old, unknown, known = "old", "no known mistake explains it", "off by 2 N; explained by: the torque is doubled"
    store.add(night(cell("a", old), cell("b", ""), cell("c", ""), number=0))
    store.add(night(cell("a", old), cell("b", unknown), cell("c", known), number=1))
    report(url, tmp_path)
    assert [each.reason for each in read_nightly(tmp_path / "nightly.json").rejected] == [known, unknown, old]
    assert f"mujoco on c: inconsistent: {known}" in told(url)


def test_an_open_step_beside_an_accepted_one_is_compared_with_what_it_may_be(
    store: NightStore, url: str, tmp_path: Path
) -> None:
    for number, value in enumerate((1e-5, 5e-5, 6e-5)):
        store.add(night(error(value), error(value, "rate.max"), number=number))
    for quantity in ("attitude.max", "rate.max"):
        accept(store, [change_named(judge(store), change.id) for change in judge(store).news
                       if change.identity.quantity == quantity], "Ada", "a fifth on purpose")  # fmt: skip
    found = report(url, tmp_path)["paper/fig05"].result[0]
    assert "may be 1.2e-05 rad, is 6e-05 rad (×5) and 1 more figure since 2026-01-02" in found.message
    assert "was 2e-05" not in found.text
    assert "attitude.max: may be 1.2e-05 rad, is 6e-05 rad (×5)" in "\n".join(told(url))
    (one, _) = read_nightly(tmp_path / "nightly.json").standing
    assert one.reason.startswith("5 times what it may be with the accepted step of 2026-01-03")
    assert "what it may be with the accepted step" in (tmp_path / "nightly.html").read_text("utf-8")


def begun(folder: Path, number: int, *, finished: bool = False) -> None:
    """Folder of a night as it is after its first part."""
    started = night(number=number).started
    folder /= f"{started.strftime(NIGHT_FORMAT)}-abcdef01"
    folder.mkdir(parents=True)
    here = Installation("0.8.0", ENVIRONMENT)
    write_state(folder, NightState("plan 0123", 15.0, 0, started, "code", ("core",), here, (), finished=finished))


def test_a_night_that_was_killed_is_listed_and_told(store: NightStore, url: str) -> None:
    store.add(night(error(), number=0))
    begun(Path(url), 1, finished=True)
    assert told(url)[0].startswith("This is the first night")
    begun(Path(url), 2)
    listed = CliRunner().invoke(cli, ["history", "list", "--history", url])
    (line,) = listed.stderr.splitlines()
    assert line.startswith("2026-01-03T02-00-00-abcdef01: was begun and did not end")
    assert told(url)[0] == "The night of 2026-01-03 was begun and did not end. The last night with figures:"
    store.add(night(error(), number=3))
    assert told(url)[0] == "Nothing changed tonight among 1 figure."


def test_a_night_that_runs_now_is_no_night_that_did_not_end(store: NightStore, url: str) -> None:
    store.add(night(error(), number=0))
    begun(Path(url), 2)
    (folder,) = Path(url).glob("*-abcdef01")
    with locked(folder):
        ended = subprocess.run(
            [sys.executable, "-P", "-m", "barchain", "history", "list", "--history", url],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
    assert ended.stderr == ""


def test_an_acceptance_counts_what_is_worse_and_better_apart(
    store: NightStore, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, factor in enumerate((1.0, 5.0)):
        store.add(night(error(1e-5 * factor), error(1e-2 / factor**3, "rate.max"), count(100 * factor), number=number))
    assert run(["history", "accept", "*:mujoco:*", "--reason", "a trade", "--history", url]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("3 figures accepted: 1 worse, 1 better, 1 changed; covers ×5 in one step since ")


def test_an_acceptance_of_a_night_on_which_a_figure_got_better_is_no_accepted_step_of_it(
    store: NightStore, url: str, tmp_path: Path
) -> None:
    for number, value in enumerate((1e-5, 9e-5, 5e-5)):
        store.add(night(error(value), number=number))
    accept(store, judge(store).news, "Ada", "a trade")
    report(url, tmp_path)
    (still,) = read_nightly(tmp_path / "nightly.json").standing
    assert still.factor == pytest.approx(5.0)
    assert "accepted step" not in still.reason


def test_an_accepted_step_of_a_drift_is_called_accepted(store: NightStore, url: str, tmp_path: Path) -> None:
    for number, value in enumerate((1e-5, 5e-5, 6e-5)):
        store.add(night(error(value), number=number))
    accept(store, judge(store).news, "Ada", "a fifth on purpose")
    report(url, tmp_path)
    facts = read_nightly(tmp_path / "nightly.json")
    assert [one.accepted.who for one in facts.changes if one.accepted] == ["Ada"]
    (still,) = facts.standing
    assert "with the accepted step of 2026-01-03 (Ada: a fifth on purpose)" in still.reason
    for name in ("nightly.html", "summary.md"):
        text = (tmp_path / name).read_text("utf-8")
        assert f"accepted by Ada on {facts.changes[0].accepted.when.date()}: a fifth on purpose" in text
        assert "with the accepted step of 2026-01-03 (Ada: a fifth on purpose)" in text
