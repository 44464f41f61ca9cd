"""`barchain explain` gives the meaning of what barchain prints and reads, from the tables of the documentation."""

from __future__ import annotations

import pytest

from barchain.cli.common.meanings import MISTAKES, explain, kinds
from barchain.cli.main import run
from reports.results.outcome import Outcome


@pytest.mark.parametrize(
    ("word", "kind", "said"),
    [
        ("inconsistent", "outcomes", Outcome.INCONSISTENT.advice),
        ("Exceeds bound", "outcomes", Outcome.EXCEEDS_BOUND.advice),
        ("predictability limit", "terms", "agree to"),
        ("drag.width_m", "keys", "width of each bar"),
        ("effects.drag", "keys", "density_kg_m3"),
        ("reaction-sign", "mistakes", "opposite sign"),
        ("joint_angle", "channels", "Angle of bar j+1 minus that of bar j"),
        ("com_residual", "channels", "com_residual_m"),
        ("130", "exit codes", "interrupted"),
    ],
)
def test_a_word_is_explained(word: str, kind: str, said: str) -> None:
    assert [m.kind for m in explain(word) if said in m.text] == [kind]


def test_a_word_may_have_several_meanings() -> None:
    assert {m.word for m in explain("width_m")} == {"effects.drag.width_m", "effects.solar_pressure.width_m"}
    assert "reaction-sign" in {m.word for m in explain("Your reactions have the opposite sign")}


def test_every_outcome_and_mistake_has_one_meaning() -> None:
    found = kinds()
    assert [m.word for m in found["outcomes"]] == list(Outcome)
    assert {m.word for m in found["mistakes"]} == {m.name for m in MISTAKES}
    assert all(m.text and m.page for every in found.values() for m in every)


@pytest.mark.parametrize(("given", "meant"), [("inconsistant", "inconsistent"), ("altitude_km", "altitude_m")])
def test_a_misspelt_word_leads_to_the_nearest(given: str, meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", given]) == 2
    assert f"did you mean {meant}?" in capsys.readouterr().err


def test_without_a_word_the_kinds_are_listed_and_a_kind_lists_its_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain"]) == 0
    listed = capsys.readouterr().out
    assert all(kind in listed for kind in kinds())
    assert run(["explain", "outcomes"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(Outcome)
