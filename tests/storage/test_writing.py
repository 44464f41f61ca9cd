"""Writing: whole or not at all, one writer at a time; and no way out but the end is 0."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.record import study_store
from barchain.record.claim import FolderInUseError, locked
from barchain.record.study_store import StudyStore
from barchain.runs.call import Answer, Call
from barchain.runs.kept_answers import AnswerStore
from reports.results.files import StudyFiles
from reports.results.schema import KEY, SCHEMA_VERSION
from reports.results.table import Table
from reports.results.writing import write_atomically
from tests.support.results import rows_file

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

SQUARES = Table(("number",), "square", {"square": ".value"}, sizes=("number",))
FILES = StudyFiles("squares", {"squares": SQUARES})
HOLDER = "import sys, time; from pathlib import Path; from barchain.record.claim import locked\n\
with locked(Path(sys.argv[1])): print('held', flush=True); time.sleep(60)"


def record() -> dict[str, object]:
    return {KEY: SCHEMA_VERSION}


def test_a_pipe_or_a_device_is_never_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="not an ordinary file"):
        write_atomically(pipe, "x")
    assert run(["simulate", "basics/libration", "--out", str(pipe)]) == 2
    assert "not an ordinary file" in capsys.readouterr().err
    assert pipe.is_fifo()


def test_a_second_writer_is_refused_and_the_lock_of_a_killed_one_does_not_block(tmp_path: Path) -> None:
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE)
    assert holder.stdout is not None
    assert holder.stdout.readline() == b"held\n"
    with pytest.raises(FolderInUseError, match="another barchain writes into this folder"), locked(tmp_path):
        pass
    holder.kill()
    holder.wait()
    holder.stdout.close()
    with locked(tmp_path), locked(tmp_path):  # and the same thread may hold it twice
        pass


def test_a_full_disk_leaves_the_earlier_file_and_no_partial_one(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    write_atomically(path, "earlier")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match="too large") as failed:
            write_atomically(path, bytes(5000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert failed.value.filename == str(path)
    assert path.read_text() == "earlier"
    assert [p.name for p in tmp_path.iterdir()] == ["x.csv"]


def squares(numbers: Iterable[int]) -> list[dict[str, int]]:
    return [{"number": number, "square": number**2} for number in numbers]


def stored(out: Path) -> list[float]:
    """Numbers whose squares the rows in place have; those rows are the ones that the record describes."""
    found: list[float] = FILES.contents(out).squares.number.tolist()
    return found


def test_rows_in_place_are_known_to_the_record_at_every_instant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_store, "REST", 0.0)
    store = StudyStore(FILES, tmp_path, record())
    store.write("squares", squares([1]))

    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    announce = StudyStore.announce
    with monkeypatch.context() as patch:  # between the record and the rows
        patch.setattr(StudyStore, "announce", lambda *a: (announce(*a), killed()))
        with pytest.raises(KeyboardInterrupt):
            store.write("squares", squares([2]))
        assert stored(tmp_path) == [1]
    store.append("squares", squares([3]))
    assert stored(tmp_path) == [2, 3]


def test_rows_are_written_now_and_then_and_at_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_store, "REST", 1e9)
    store = StudyStore(FILES, tmp_path, record())
    for number in (1, 2, 3):
        store.append("squares", squares([number]))
    assert stored(tmp_path) == [1]
    store.end(1.0, complete=True)
    assert stored(tmp_path) == [1, 2, 3]


def test_a_study_that_goes_on_leaves_no_rows_of_the_earlier_one(tmp_path: Path) -> None:
    """All rows follow from the answers in the folder, and are made anew."""
    first = StudyStore(FILES, tmp_path, record())
    first.write("squares", squares([1]))
    call = Call(print, ("asked",), 1.0)
    AnswerStore(first.answers).keep(call, Answer(b"an answer"))
    again = StudyStore(FILES, tmp_path, record(), resume=True)
    assert again.read("squares").empty
    assert not rows_file(tmp_path, "squares").exists()
    assert AnswerStore(again.answers).find(call) == Answer(b"an answer")


def test_a_table_that_the_study_does_not_declare_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'cubes' is not in list"):
        StudyStore(FILES, tmp_path, record()).write("cubes", squares([1]))
