"""The protocol of studies, and a study from its start to its page.

A study is made with everything chosen: a function takes options, raises what is wrong with them, and returns it.
Studies differ in their cases, and share all else: the folder (:class:`barchain.record.study_store.StudyStore`), the
record's beginning (:func:`barchain.record.environment.provenance`), the reporter, and :func:`run_study`.
"""

from __future__ import annotations

import contextlib
import dataclasses
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from barchain.record.claim import claimed
from barchain.record.environment import provenance
from barchain.record.study_store import PARTS, StudyStore
from barchain.runs.executors import KeptAnswers
from barchain.runs.kept_answers import ASKED, KEPT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from reports.results.files import StudyFiles


class StudyResult(Protocol):
    """End of a study. A result that did not pass ends the study's command with exit code 1."""

    @property
    def passed(self) -> bool:
        """Whether everything asked for ran or is declared unsupported, and no check failed."""


ResultT_co = TypeVar("ResultT_co", bound=StudyResult, covariant=True)
RenderedT = TypeVar("RenderedT")


@dataclass(frozen=True)
class StudyEnd:
    """Findings of a study beside its tables, where failures alone decide."""

    failures: tuple[str, ...] = ()
    """One line each"""
    idle: dict[str, str] = field(default_factory=dict)
    """Engines that ran nowhere, with the reason"""
    ends: tuple[str, ...] = ()
    """Word for the end of each point"""

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return not self.failures


def ignore(*_: object) -> None:
    """Report nothing, and render nothing."""


@contextlib.contextmanager
def uncounted(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Count nothing."""
    del what, total
    yield ignore


@dataclass(frozen=True)
class Reporter:
    """Callbacks for the progress of a study; by default they do nothing."""

    step: Callable[[str, str, str], None] = ignore
    """Called with subject, run and outcome after each step"""
    note: Callable[[str], None] = ignore
    """Called with a sentence on what goes on between steps"""
    counted: Callable[[str, int], AbstractContextManager[Callable[[int], None]]] = uncounted
    """Given a task and its size, a context whose value is called with each number of items done"""


class Study(Protocol[ResultT_co]):
    """One study with all that was chosen, a frozen dataclass.

    Its ``executor``, if it has one, is the place of its runs. Where a study has parts that can be run by themselves,
    ``parts`` names those that are.
    """

    @property
    def files(self) -> StudyFiles:
        """Tables and record, with the study's name."""

    def record(self) -> dict[str, Any]:
        """Entries of the record that are known before the first run.

        Versions of further ``packages`` are added to those of the provenance.
        """

    def run(self, store: StudyStore, reporter: Reporter) -> ResultT_co:
        """Make the runs, and write tables as results come."""


def run_study(study: Study[ResultT_co], out: Path, **how: Any) -> ResultT_co:
    """Result of a study; arguments are those of :func:`run_and_render` without `render`."""
    return run_and_render(study, out, ignore, **how)[0]


def run_and_render(
    study: Study[ResultT_co],
    out: Path,
    render: Callable[[Path], RenderedT],
    *,
    command: str = "",
    reporter: Reporter | None = None,
    resume: bool | None = False,
    overwrite: bool = False,
) -> tuple[ResultT_co, RenderedT]:
    """Run a study, and write its tables and record into ``out/<name>``.

    Parameters
    ----------
    study : Study
        It runs with an executor that keeps answers in the study's folder.
    out : Path
        Result folder; tables of other studies and of comparisons in it stay as they are.
    render : callable
        Renders the tables in `out` before another command may write into the folder.
    command : str
        Command line, for the record.
    reporter : Reporter, optional
        Callbacks for progress; none by default.
    resume : bool, optional
        Take the answers that an earlier study left in `out`, and make what is missing; None of a study that can't.
    overwrite : bool
        Delete the study's earlier results in `out` first.

    Returns
    -------
    tuple
        The results of the study and of `render`.

    Raises
    ------
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.

    Notes
    -----
    The record is written before the first run and after the last, also when the run is interrupted. ``complete`` is
    true only if the run came to its end, ``finished`` only if `render` did too.
    """
    start, complete, told = time.perf_counter(), False, reporter or Reporter()
    with claimed(study.files, out, getattr(study, PARTS, None), resume=resume, overwrite=overwrite):
        own = study.record()
        store = StudyStore(study.files, out, provenance(command, own.pop("packages", None)) | own, resume=bool(resume))
        placed: Any = study
        if hasattr(study, "executor"):
            placed = dataclasses.replace(placed, executor=KeptAnswers(store.answers, placed.executor))
        store.write_record()
        try:
            result = placed.run(store, told)
            complete = True
        finally:
            store.end(time.perf_counter() - start, complete=complete)
        if resume and placed is not study:
            told.note(f"kept {placed.executor.tally[KEPT]} of {placed.executor.tally[ASKED]} answers")
        rendered = render(out)
        store.finish()
    return result, rendered
