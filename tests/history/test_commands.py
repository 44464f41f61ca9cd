"""`barchain history` keeps the figures of result folders, and says what it can't do in one line."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pandas as pd
import pytest

from barchain.cli.main import run
from barchain.crossval.run import run_comparison
from barchain.history.figures import FigureKind
from barchain.history.folders import night_of
from barchain.run.selection import chosen_engines

if TYPE_CHECKING:
    from pathlib import Path

SCENE = "basics/kepler_circular"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Result folder of a small comparison."""
    out = tmp_path_factory.mktemp("results")
    run_comparison([SCENE], out=out, registered=chosen_engines(["reference", "rebound", "pymunk"]))
    record = out / "record.json"  # as the command writes it after the report
    record.write_text(json.dumps(json.loads(record.read_text()) | {"finished": True}))
    return out


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Store of each test."""
    file = tmp_path / "history.sqlite"
    monkeypatch.setenv("BARCHAIN_HISTORY", f"sqlite:///{file}")
    return file


def test_a_folder_gives_verdicts_errors_counts_and_digests_with_what_they_depend_on(folder: Path) -> None:
    night = night_of(folder)
    assert night.complete
    kinds = {figure.series.kind for figure in night.figures if figure.series.engine == "reference"}
    assert kinds == {FigureKind.VERDICT, FigureKind.ERROR, FigureKind.COUNT, FigureKind.BITS}
    verdicts = {f.series.engine: f.word for f in night.figures if f.series.kind is FigureKind.VERDICT}
    assert verdicts == {"reference": "pass", "rebound": "pass", "pymunk": "pass"}
    depends = {f.series.engine: f.parts for f in night.figures}
    assert depends["rebound"] == ("barchain", "engine rebound")
    assert depends["reference"] == ("barchain",)
    assert {"barchain", "engine rebound", "package numpy"} <= {part.name for part in night.parts}


def test_errors_are_those_of_the_metrics(folder: Path) -> None:
    metrics = pd.read_csv(folder / "metrics.csv").query("metric == 'max' and quantity == 'com'").set_index("engine")
    found = {
        f.series.engine: f.value
        for f in night_of(folder).figures
        if (f.series.quantity, f.series.metric) == ("com", "max")
    }
    assert found == metrics["value"].to_dict()


def test_a_folder_is_added_once_and_listed_shown_exported_and_pruned(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    night, out = night_of(folder), tmp_path / "all.parquet"
    assert run(["history", "add", str(folder)]) == 0
    assert f"added as {night.id}" in capsys.readouterr().out
    assert run(["history", "add", str(folder)]) == 0
    assert f"is there already: {night.id}" in capsys.readouterr().out
    assert run(["history", "list"]) == 0
    assert night.id in capsys.readouterr().out
    assert run(["history", "show", "latest"]) == 0
    assert f"{SCENE}" in capsys.readouterr().out
    assert run(["history", "export", "--parquet", str(out)]) == 0
    assert len(pd.read_parquet(out)) == len(night.figures)
    assert run(["history", "prune", "--keep-nights", "1"]) == 0
    assert "deleted 0 nights" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("history add NOWHERE", "no metrics.csv there"),
        ("history show abc", "the history is empty"),
        ("history prune --keep-nights 0", "0 is not in the range"),
        ("history list --history mysql://there/db", "allowed: sqlite:///FILE"),
        ("history export --parquet NOWHERE/all.parquet", "there is no folder"),
    ],
)
def test_bad_input_ends_in_one_line_and_exit_code_2(
    line: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.replace("NOWHERE", str(tmp_path / "nowhere")).split()) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_one_damaged_folder_adds_none(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(folder, damaged)
    (damaged / "metrics.csv").write_text("scene\n")
    assert run(["history", "add", str(folder), str(damaged)]) == 2
    assert "metrics.csv" in capsys.readouterr().err
    assert run(["history", "show", "latest"]) == 2


def test_without_its_libraries_the_command_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['sqlalchemy'] = None\n"
        "from barchain.cli.main import run; sys.exit(run(['history', 'list']))"
    )
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert made.returncode == 2
    assert "pip install 'barchain[nightly]'" in made.stderr
    assert made.stderr.count("\n") == 1
