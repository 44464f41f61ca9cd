"""Changes that real runs can attribute, reasons why others can't be, and cells that are of the sort of their night."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from barchain.nightly.attribution.attribute import as_on_the_night, attribute, reasons_against, worth_attributing
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import Figure, FigureKind, NightPart
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import open_store
from tests.nightly.history.synthetic import NAMES, PARTS, bits, error, identity, night, verdict

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.history.levels import JudgedNight

NEWER = (NightPart("engine:mujoco", "4.0.0", "ee"), *PARTS[1:])
SAME_VERSION = (dataclasses.replace(PARTS[0], digest="edited"), *PARTS[1:])


def of_scene(figure: Figure, scene: str) -> Figure:
    return dataclasses.replace(figure, identity=dataclasses.replace(figure.identity, scene=scene))


def judged(folder: Path, parts: tuple[NightPart, ...], *scenes: str) -> JudgedNight:
    """Night on which the error doubled in some scenes, with other parts than on the two nights before."""
    store = open_store(str(folder / "history"), create=True)
    for number, factor in enumerate((1.0, 1.0, 2.0)):
        figures = (of_scene(error(1e-5 * factor), scene) for scene in scenes)
        store.add(night(*figures, number=number, parts=parts if factor > 1.0 else PARTS))
    return judge(store, "latest")


def test_a_scene_of_a_file_is_left_out_and_costs_no_other_change(tmp_path: Path) -> None:
    found = judged(tmp_path, NEWER, "mine", "paper/fig05")
    assert [change.identity.scene for change in worth_attributing(found, 10)] == ["paper/fig05"]
    assert any("scene of a file" in reason for reason in reasons_against(found))


def test_other_files_of_one_version_are_the_reason_against_a_change(tmp_path: Path) -> None:
    found = judged(tmp_path, SAME_VERSION, "paper/fig05")
    assert worth_attributing(found, 10) == []
    assert reasons_against(found) == [
        "engine:mujoco: has the same version on both nights; other files of one version can't be installed again"
    ]


def test_a_change_whose_earlier_night_has_been_removed_says_so(tmp_path: Path) -> None:
    found = dataclasses.replace(judged(tmp_path, NEWER, "paper/fig05"), compared_with=())
    assert worth_attributing(found, 10) == []
    (reason,) = reasons_against(found)
    assert reason.endswith("the night with the earlier value has been removed")


def test_a_figure_of_a_program_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    store, program = (
        open_store(str(tmp_path / "history"), create=True),
        NightPart("program:mine (its entry)", "1", "aa"),
    )
    newer = dataclasses.replace(PARTS[3], digest="edited")
    for number, (factor, judge_part) in enumerate(((1.0, PARTS[3]), (1.0, PARTS[3]), (2.0, newer))):
        parts = (*PARTS[:3], judge_part, program)
        figure = error(1e-5 * factor, depends=("judge", program.name))
        store.add(night(figure, number=number, parts=parts))
    found = judge(store, "latest")
    assert worth_attributing(found, 10) == []
    (reason,) = reasons_against(found)
    assert "is of the program mine" in reason
    noted: list[str] = []
    with pytest.raises(HistoryError, match="is of the program mine"):
        attribute(store, found, found.tonight, note=noted.append)
    assert noted == []


MISSING = Figure(identity("verdict", FigureKind.VERDICT), reason="does not import", depends=NAMES)


@pytest.mark.parametrize(
    ("found", "night", "alike"),
    [
        (verdict("pass"), verdict("pass"), True),
        (verdict("pass"), verdict("failed"), False),
        (MISSING, verdict("pass"), False),
        (verdict("pass"), MISSING, False),
        (MISSING, MISSING, True),
        (error(1e-9), error(2e-9), True),
        (bits("00"), bits("11"), True),
    ],
)
def test_another_verdict_or_a_missing_result_is_another_end(found: Figure, night: Figure, alike: bool) -> None:
    assert as_on_the_night(found, night) is alike
