"""`barchain history`: what each command prints, and one line for each fault."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.nightly.figures.storage import VARIABLE, default_url
from barchain.nightly.history.nights import open_store
from tests.nightly.history.synthetic import error, night, ratio, verdict

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """History of three nights, which the environment variable names."""
    place = tmp_path / "history"
    store = open_store(str(place), create=True)
    for k in range(3):
        store.add(night(error(1e-5 * (k + 1)), verdict(), ratio(2.0, low=1.9), number=k))
    monkeypatch.setenv(VARIABLE, str(place))
    return place


def printed(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert run(["history", *words]) == code
    shown = capsys.readouterr()
    assert "Traceback" not in shown.err
    if code:
        assert shown.err.startswith("barchain: ")
        assert shown.err.count("\n") == 1
        return shown.err
    return shown.out


def test_nights_are_listed_shown_and_followed(filled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [n["name"] for n in json.loads(printed(capsys, "list", "--json"))]
    assert names == sorted(names)
    assert all(name in printed(capsys, "list") for name in names)
    text = printed(capsys, "show", "latest")
    assert "engine:mujoco" in text
    assert "3e-05" in text
    whole = json.loads(printed(capsys, "show", names[0], "--json"))
    assert len(whole["figures"]) == 3
    found = json.loads(printed(capsys, "series", "paper/fig05:mujoco:*:attitude.max", "--json"))
    assert [f["value"] for f in found[0]["figures"]] == [1e-5, 2e-5, 3.0000000000000004e-05]
    assert "1e-05" in printed(capsys, "series", error().identity.name)


def test_a_series_has_a_row_with_the_reason_for_nights_without_the_figure(
    filled: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = open_store(str(filled))
    for k in (3, 4):
        store.add(night(verdict(), number=k, complete=False))
    store.add(night(error(), number=5))
    damaged = filled / store.nights()[1].name / "figures.parquet"
    damaged.write_bytes(b"x" * damaged.stat().st_size)
    text = " ".join(printed(capsys, "series", error().identity.name).split())
    assert f"{damaged.parent.name} missing rad left out: it is damaged" in text
    assert f"2 from {store.nights()[3].name} missing rad not measured; the night is incomplete" in text
    (found,) = json.loads(printed(capsys, "series", error().identity.name, "--json"))
    assert [one["value"] is None for one in found["figures"]] == [False, True, False, True, True, False]


def test_export_and_prune_say_how_much(filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "all.parquet"
    assert printed(capsys, "export", "--parquet", str(path)) == f"{path}: 9 figures\n"
    store = open_store(str(filled))
    for k in range(3, 6):
        store.add(night(error(3e-5), verdict(), ratio(2.0, low=1.9), number=k))
    assert "0 nights removed" in printed(capsys, "prune", "--keep-nights", "6")
    assert "2 nights removed" in printed(capsys, "prune", "--keep-nights", "1")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("show 2026-01-01T02-00-01", "no such night (did you mean 2026-01-0"),
        ("show 2026", "3 nights begin so"),
        ("series attitude", "no such figure"),
        ("prune", "give --keep-nights N, --older-than DAYS"),
        ("prune --older-than nan", "nan given"),
        ("list --history nowhere/nights", "no history there; `barchain nightly` and `barchain history add DIR`"),
        (
            "list --history postgresql://me:secret@127.0.0.1:1/x",
            "//***@127.0.0.1:1/x: Protocol not known: postgresql; allowed: a folder, or an address that fsspec knows",
        ),
        ("export --parquet nowhere/all.parquet", "there is no folder nowhere"),
        ("add .", "no results there"),
        ("add", "DIR"),
    ],
)
def test_a_fault_is_one_line_and_exit_code_2(
    filled: Path, words: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    text = printed(capsys, *words.split(), code=2)
    assert said in " ".join(text.split())
    assert "secret" not in text


def test_a_file_of_something_else_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "notes.txt"
    place.write_text("nothing like a history\n" * 100)
    assert "is no folder; a history is a folder of nights" in printed(capsys, "list", "--history", str(place), code=2)
    assert place.read_text().startswith("nothing like")


def test_a_missing_package_is_one_line_with_its_remedy(
    filled: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "fsspec", None)
    said = "barchain: the history needs fsspec, which is not installed; try: pip install '.[nightly]'\n"
    assert printed(capsys, "list", code=2) == said


def test_without_option_and_variable_the_history_is_the_folder_of_nights(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert default_url() == "nights"
    monkeypatch.setenv(VARIABLE, "elsewhere")
    assert default_url() == "elsewhere"
