"""Result folders as nights, read by the readers that reports use."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import pandas as pd
import pytest

from barchain.cli.main import run
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.dependencies import installation_here
from barchain.nightly.figures.figure import FigureKind
from barchain.nightly.figures.results import night_here, read_night
from barchain.nightly.history.standing import every_change
from reports.results.rows import frame_digest
from tests.nightly.history.histories import judged_last, summaries
from tests.nightly.history.synthetic import FIRST
from tests.storage.small_plans import SMALL
from tests.support.results import change_record, read_record, series_folder
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.figures.figure import Figure, Night

KINDS = {
    "comparison": {FigureKind.BITS, FigureKind.COUNT, FigureKind.ERROR, FigureKind.VALUE, FigureKind.VERDICT},
    "stability": {FigureKind.BITS, FigureKind.COUNT, FigureKind.VERDICT},
    "cost": {FigureKind.COUNT, FigureKind.VERDICT, FigureKind.VALUE},
    "scaling": {FigureKind.MEMORY, FigureKind.VERDICT},
    "roundoff": {FigureKind.RATIO},
    "effects": {FigureKind.RATIO, FigureKind.VALUE, FigureKind.VERDICT},
    "selftest": {FigureKind.VERDICT},
    "ensemble": {FigureKind.COUNT, FigureKind.VALUE},
}


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compared") / "out"
    words = "compare basics/two_bars_free --engine reference --engine rebound --workers 1"
    assert run(["-q", *words.split(), "--out", str(folder)]) == 0
    return folder


def named(night: Night, quantity: str, engine: str = "reference") -> Figure:
    found = [f for f in night.figures if f.identity.quantity == quantity and f.identity.engine == engine]
    assert len(found) == 1
    return found[0]


def test_a_comparison_gives_errors_with_their_rounding_verdicts_counts_and_bits(compared: Path) -> None:
    night = read_night(compared)
    assert night.complete
    assert night.void is None
    assert {f.identity.kind for f in night.figures} == KINDS["comparison"]
    assert named(night, "verdict").word == "pass"
    assert named(night, "evaluations").value > 100
    worst = named(night, "attitude.max")
    assert worst.value > 0.0
    assert 0.0 < worst.tolerance < 1e-7  # rad
    assert worst.trajectory == named(night, "trajectory").word
    drift = named(night, "energy.drift")
    assert 0.0 < drift.tolerance < 1e-9
    assert {"reference", "adapter:reference", "judge", "scene:basics/two_bars_free"} <= set(worst.depends)
    assert "engine:rebound" not in worst.depends
    assert "engine:rebound" in named(night, "verdict", "rebound").depends


def test_the_record_gives_environment_versions_and_scenes(compared: Path) -> None:
    night, record = read_night(compared), read_record(compared)
    assert night.environment.cpu == record["environment"]["cpu"]
    assert night.environment.libc == record["machine"]["libc"]
    assert night.environment.cpu_flags
    assert night.part_named["engine:rebound"].version == record["packages"]["rebound"]
    assert night.part_named["scene:basics/two_bars_free"].digest
    assert night.part_named["machine"].digest == night.environment.machine_class


def test_the_same_folder_is_the_same_night_and_an_interrupted_one_is_incomplete(compared: Path, tmp_path: Path) -> None:
    assert read_night(compared) == read_night(compared)
    copied = tmp_path / "copied"
    copied.symlink_to(compared)
    assert read_night(copied).name == read_night(compared).name
    half = shutil.copytree(compared, tmp_path / "half")
    change_record(half, complete=False)
    assert not read_night(half).complete


def test_a_night_of_this_installation_knows_the_digests_of_its_parts(compared: Path) -> None:
    own = installation_here(["reference", "rebound"], ["basics/two_bars_free"])
    made = night_here([compared, compared], own, started=FIRST, duration_s=60.0, plan="plan")
    assert {f.identity for f in made.figures} == {f.identity for f in read_night(compared).figures}
    assert all(part.digest for part in made.parts)
    assert made.complete
    judged = judged_last(summaries(made, made))
    assert judged.judged == len(made.figures)
    assert every_change(judged) == []


def test_the_digest_of_a_trajectory_does_not_depend_on_its_file(compared: Path) -> None:
    path = series_folder(compared) / "trajectories/basics/two_bars_free/rebound.parquet"
    frame = pd.read_parquet(path)
    assert frame_digest(frame) == named(read_night(compared), "trajectory", "rebound").word
    assert frame_digest(frame[frame.columns[::-1]]) == frame_digest(frame)
    column = frame.columns[1]
    last_bit = frame.assign(**{column: frame[column].to_numpy() * (1.0 + 2.0**-52)})
    assert frame_digest(last_bit) != frame_digest(frame)


def test_a_folder_without_results_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(HistoryError, match="no results there; give a folder with results of: comparison, cost"):
        read_night(tmp_path)
    with pytest.raises(HistoryError, match="no such folder"):
        read_night(tmp_path / "none")


@pytest.mark.slow
@pytest.mark.parametrize("study", exhaustive_but((n for n in KINDS if n != "comparison"), ["stability"]))
def test_every_study_gives_figures(study: str, tmp_path: Path) -> None:
    run(["-q", *SMALL[study].command.split(), "--out", str(tmp_path / "out")])
    night = read_night(tmp_path / "out")
    assert night.figures
    assert {f.identity.kind for f in night.figures} <= KINDS[study]
    assert not all(f.missing for f in night.figures)
    assert night.plan.startswith(study)
