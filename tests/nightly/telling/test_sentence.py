"""The sentence that opens the page of a night."""

from __future__ import annotations

import datetime
from types import SimpleNamespace
from typing import Any

import pytest

from barchain.nightly.figures.changes import Change, Direction, results_words
from barchain.nightly.figures.figure import Figure
from barchain.nightly.telling.sentence import opening
from reports.results.nights.document import (
    CUT,
    AcceptanceEntry,
    ChangeEntry,
    NightRun,
    PartResult,
    PartState,
    RejectedEntry,
    SuspectEntry,
)
from tests.nightly.history.synthetic import error

MUJOCO = SuspectEntry(name="engine:mujoco", before="3.2.7", after="4.0.0")
NUMPY = SuspectEntry(name="library:numpy", before="1.26.4", after="2.4.6")
ACCEPTED = AcceptanceEntry(who="Ada", when="2026-01-02T03:04:05Z", reason="a better method")  # type: ignore[arg-type]


def change(direction: str = "worse", suspects: tuple[SuspectEntry, ...] = (MUJOCO,), **more: Any) -> ChangeEntry:
    options: dict[str, Any] = {
        "id": "0123456789", "figure": "paper/fig05:mujoco::attitude.max", "scene": "paper/fig05", "engine": "mujoco",
        "setting": "", "quantity": "attitude.max", "kind": "error", "unit": "rad", "was": "1e-9 rad",
        "became": "2e-9 rad", "direction": direction, "last": "a", "since": "b", "reason": "", "irreproducible": False,
        "suspects": suspects,
    }  # fmt: skip
    return ChangeEntry(**(options | more))


def said(*changes: ChangeEntry, **more: Any) -> str:
    judged: Any = SimpleNamespace(
        night=SimpleNamespace(
            name=more.get("night", "tonight"), figures=more.get("figures", 900),
            void=None, complete=more.get("complete", True),
            started=datetime.datetime(2026, 11, 29, tzinfo=datetime.UTC),
        ),
        judged=more.get("judged", 900), renamed=(),
        compared_with=(*[SimpleNamespace(run=None)] * 5, *more.get("before", ())),
        replanned=False, is_first=False, new=0, left_out=0,
    )  # fmt: skip
    standing = more.get("standing", ())
    facts: Any = SimpleNamespace(
        changes=changes, standing=standing, held=(change(),) * more.get("held", 0),
        against=SimpleNamespace(baseline=more.get("baseline", "")), rejected=more.get("rejected", ()),
        run=more.get("run"),
        other_news=[one for one in changes if one.figure not in {each.figure for each in standing}],
    )  # fmt: skip
    return opening(judged, facts)


def since(day: str, count: int = 1, factor: float = 5.0, suspect: SuspectEntry = MUJOCO) -> list[ChangeEntry]:
    """Figures that are worse than accepted since a day."""
    return [change(since=f"{day}T02-00-00-abcdef01", factor=factor, suspects=(suspect,))] * count


def run(*parts: PartResult) -> NightRun:
    return NightRun("mine 0123", 15.0, parts)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ((), "Nothing changed tonight among 900 figures."),
        ((change(),), "One figure of 900 changed tonight, for the worse; since engine:mujoco 4.0.0."),
        (
            (change(), change("better", (NUMPY,))),
            "Two figures of 900 changed tonight, one for the worse and one for the better; one since "
            "engine:mujoco 4.0.0 and one since library:numpy 2.4.6.",
        ),
        (
            (change(suspects=(MUJOCO, NUMPY)),) * 2,
            "Two figures of 900 changed tonight, all for the worse; both with the suspects engine:mujoco and "
            "library:numpy.",
        ),
        (
            (*(change(confirmed="confirmed: engine:mujoco 3.2.7 → 4.0.0"),) * 2, change()),
            "Three figures of 900 changed tonight, all for the worse; all three since engine:mujoco 4.0.0, two of them "
            "confirmed.",
        ),
        (
            (change(accepted=ACCEPTED),),
            "One figure of 900 changed tonight; the change is accepted. Nothing else changed.",
        ),
        ((change(suspects=()),), "One figure of 900 changed tonight, for the worse; without a change of any part."),
    ],
)  # fmt: skip
def test_a_night_is_told_in_one_sentence(changes: tuple[ChangeEntry, ...], words: str) -> None:
    assert said(*changes) == words


def test_runs_that_are_not_reproducible_are_told_first() -> None:
    text = said(change(), change(irreproducible=True, suspects=()))
    assert text.startswith("One run is not reproducible")
    assert "One figure of 900 changed" in text


def test_what_is_worse_than_accepted_comes_first_with_its_size_its_nights_and_its_causes() -> None:
    assert said(standing=since("2025-11-03")).startswith(
        "One figure is worse than accepted by ×5 since 3 November 2025 (engine:mujoco 4.0.0)."
    )
    both = [*since("2026-11-03", 2), *since("2026-11-09", suspect=NUMPY)]
    assert said(change(), standing=both).startswith(
        "Three figures are worse than accepted by up to ×5: two since 3 November (engine:mujoco 4.0.0) and one since "
        "9 November (library:numpy 2.4.6). One figure of 900 changed tonight, for the worse; "
    )


def test_all_that_is_worse_is_counted_in_the_first_sentence_with_what_is_new_of_it() -> None:
    new = [change(figure=f"place.{k}") for k in range(7)]
    text = said(*new, change("better", figure="other"), standing=since("2026-11-03", 9, 6.0))
    assert text.startswith(
        "16 figures are worse than accepted, seven of them new tonight; the other nine by up to ×6 since 3 November "
        "(engine:mujoco 4.0.0). Eight figures of 900 changed tonight, seven for the worse"
    )
    accepted = [change(figure="accepted", accepted=ACCEPTED), change(figure="wild", irreproducible=True)]
    assert said(*accepted, standing=since("2026-11-03")).startswith("One figure is worse than accepted by ×5 since")


def test_a_night_without_a_figure_to_judge_does_not_say_that_nothing_changed() -> None:
    assert said(judged=0, complete=False) == (
        "The night is incomplete. Nothing was judged: no figure of this night has an earlier one."
    )
    assert said(judged=0, figures=0, complete=False) == (
        "The night is incomplete. Nothing was judged: this night has no figures."
    )


def test_the_nights_just_before_that_did_not_end_are_told_after_what_is_worse_and_new() -> None:
    def before(day: int, reason: str) -> SimpleNamespace:
        parts = PartResult("alarm", PartState.DONE, 9.0), PartResult("core", PartState.LEFT, 9.0, reason=reason)
        return SimpleNamespace(started=datetime.datetime(2026, 11, day, tzinfo=datetime.UTC), run=run(*parts))

    late, cut = before(26, "interrupted at its limit of 9 s"), [before(day, CUT) for day in (25, 27, 28)]
    assert said(before=(cut[0], late)) == "Nothing changed tonight among 900 figures."
    assert said(before=(cut[0], late, cut[1])) == (
        "Nothing changed tonight among 900 figures. The night of 27 November did not end."
    )
    assert said(change(), standing=since("2026-11-03"), before=(late, *cut[1:])).endswith(
        "for the worse; since engine:mujoco 4.0.0. The night of 28 November did not end, nor did the one before it."
    )
    assert said(before=tuple(cut)).endswith("The night of 28 November did not end, nor did the two before it.")
    assert "did not end" not in said(before=tuple(cut), baseline="release.json")


def test_what_was_not_measured_is_told_with_its_reason_before_nothing_changed() -> None:
    parts = (
        PartResult("core", PartState.DONE, 10.0, missing="my.toml: gravity_m_s2: no such key", bad_input=True),
        PartResult("cost", PartState.LEFT, 10.0, reason="interrupted at its limit of 100 s"),
        PartResult("alarm", PartState.DONE, 10.0),
    )
    text = said(complete=False, run=run(*parts))
    assert text.startswith(
        "The night is incomplete: core, my.toml: gravity_m_s2: no such key; cost, interrupted at its limit of 100 s. "
    )
    assert text.endswith("Nothing changed tonight among 900 figures.")


def test_a_part_of_which_nothing_ran_is_not_done() -> None:
    part = PartResult("core", PartState.DONE, 10.0, missing="my.toml: can't be read")
    assert part.shown_state == "not run"
    assert PartResult("core", PartState.DONE, 10.0, done=3, missing="no engine exudyn").shown_state == "in part"
    assert PartResult("core", PartState.DONE, 10.0, done=3).shown_state == "done"


def test_an_engine_that_never_worked_is_told_before_nothing_changed() -> None:
    failed = RejectedEntry(scene="a", engine="mine", setting="", verdict="failed", reason="no such file: ./mine.")
    text = said(rejected=(failed, failed), held=23)
    assert text.startswith("Two verdicts are no pass: the first mine on a: failed: no such file: ./mine. ")
    assert text.endswith("Nothing changed tonight among 900 figures. 23 figures are worse, and accepted.")


def test_a_change_is_shown_with_the_digits_that_tell_its_results_apart() -> None:
    was, now = (Figure(error().identity, value, reason="") for value in (1.28886e-07, 1.28886000001e-07))
    told = Change(error().identity, was, now, "a", "b", Direction.WORSE, "", now.value / was.value)
    assert results_words(told) == ("1.28886e-07 rad", "1.28886000001e-07 rad")
    words = change(was="1.28886e-07 rad", became="1.28886000001e-07 rad", factor=1.0 + 7.8e-12).words
    assert words.endswith("(×(1 + 7.8e-12))")
    assert change(kind="bits", was=64 * "0", became=64 * "1", factor=None).words.count("0") < 20


def test_a_figure_that_fails_tonight_from_its_first_night_on_is_new() -> None:
    verdict = {"kind": "verdict", "quantity": "verdict", "was": "pass", "became": "failed", "suspects": ()}
    tonight = "2026-11-29T02-00-00-abcdef01"
    first = change(figure="first", since=tonight, last=tonight, **verdict)
    assert said(standing=[first], night=tonight).startswith(
        "One figure is worse than accepted since 29 November (from the first night on)."
    )
    assert said(standing=[first, *since("2026-11-03")], night=tonight).startswith(
        "Two figures are worse than accepted, one of them new tonight; the other one by ×5 since 3 November"
    )
    assert said(change(), standing=[first], night=tonight).startswith(
        "Two figures are worse than accepted, all of them new tonight. One figure of 900 changed tonight"
    )
