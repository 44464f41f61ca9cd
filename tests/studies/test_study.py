"""What all studies share: the folder, the record's beginning and end, and going on from an interrupted study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import pytest

from barchain.record.study_store import StudyStore
from barchain.runs.call import Call
from barchain.runs.cases import Task, run_tasks
from barchain.studies.study import Reporter, StudyEnd, run_study
from reports.results.files import StudyFiles
from reports.results.schema import KEY, SCHEMA_VERSION
from reports.results.table import Table
from tests.support.here import HERE
from tests.support.results import read_record

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.executors import Executor

FILES = StudyFiles(
    "squares",
    {"squares": Table(("number",), "square", {"square": ".value", "word": ".text"}, sizes=("number",))},
)


@dataclass(frozen=True)
class SquaresStudy:
    """A study of a few lines: numbers to be squared."""

    numbers: tuple[int, ...]
    repeats: int = 1
    executor: Executor = HERE
    files: ClassVar[StudyFiles] = FILES

    def record(self) -> dict[str, Any]:
        """Limits, and a package more."""
        return {"packages": {"abacus": "1.0"}, "limits": {"repeats": self.repeats}}

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Append a row for each number; an answer that is there is not asked for."""
        for number in self.numbers:
            task = Task(Call(square, (number,), 1.0), lambda answer: int(answer.content))
            (found,) = run_tasks([task], self.executor)
            store.append("squares", [{"number": number, "square": found}])
            reporter.step(str(number), "squared", "pass")
        return StudyEnd()


def square(number: int) -> bytes:
    """Square of a number, which is noted."""
    SQUARED.append(number)
    return str(number**2).encode()


SQUARED: list[int] = []


def test_a_study_leaves_its_tables_and_a_finished_record(tmp_path: Path) -> None:
    told: list[tuple[str, str, str]] = []
    assert run_study(
        SquaresStudy((3, 1)), tmp_path, command="typed", reporter=Reporter(lambda *a: told.append(a))
    ).passed
    table = FILES.contents(tmp_path).squares
    assert table.columns.tolist() == ["number", "square", "word"]
    assert table.square.tolist() == [9, 1]
    assert table.word.tolist() == ["", ""]  # an empty cell of text is no NaN
    assert [subject for subject, *_ in told] == ["3", "1"]
    record = read_record(tmp_path, "squares")
    assert record["finished"]
    assert record["command"] == "typed"
    assert record["seconds"] > 0.0
    assert record["limits"] == {"repeats": 1}
    assert record["packages"]["abacus"] == "1.0"
    assert "numpy" in record["packages"]


def test_an_interrupted_study_leaves_its_rows_and_goes_on_from_them(tmp_path: Path) -> None:
    def cut(number: str, *_: str) -> None:
        if number == "2":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(SquaresStudy((1, 2, 3)), tmp_path, reporter=Reporter(cut))
    assert not read_record(tmp_path, "squares")["finished"]
    assert FILES.contents(tmp_path).squares.number.tolist() == [1, 2]
    SQUARED.clear()
    noted: list[str] = []
    run_study(SquaresStudy((1, 2, 3)), tmp_path, resume=True, reporter=Reporter(note=noted.append))
    assert SQUARED == [3]
    assert noted == ["kept 2 of 3 answers"]
    assert FILES.contents(tmp_path).squares.square.tolist() == [1, 4, 9]
    assert read_record(tmp_path, "squares")["finished"]


def test_the_earlier_record_is_read_before_it_is_written_anew(tmp_path: Path) -> None:
    first = StudyStore(FILES, tmp_path, {KEY: SCHEMA_VERSION, "runs": [1, 2]})
    first.write_record()
    second = StudyStore(FILES, tmp_path, {"runs": []}, resume=True)
    second.write_record()
    assert second.earlier["runs"] == [1, 2]
    assert StudyStore(FILES, tmp_path, {}).earlier == {}
