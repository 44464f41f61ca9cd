"""The protocol of studies (options, plan, run that fills tables), and a study from start to tables.

Studies differ in their loops, and share all else: the folder (:class:`barchain.record.study_store.StudyStore`), the
record's beginning (:func:`barchain.record.environment.provenance`), the reporter, and :func:`run_study`.
"""

from __future__ import annotations

import contextlib
import dataclasses
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from barchain.record.claim import claimed
from barchain.record.environment import provenance
from barchain.record.study_store import PARTS, StudyStore
from barchain.runs.executors import KeptAnswers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from reports.tables.files import StudyFiles

PlanT = TypeVar("PlanT")
OptionsT_contra = TypeVar("OptionsT_contra", contravariant=True)


class StudyResult(Protocol):
    """End of a study. A result that did not pass ends the study's command with exit code 1."""

    @property
    def passed(self) -> bool:
        """Whether everything asked for ran or is declared unsupported, and no check failed."""


ResultT_co = TypeVar("ResultT_co", bound=StudyResult, covariant=True)
RenderedT = TypeVar("RenderedT")


def ignore(*_: object) -> None:
    """Report nothing."""


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


class Study(Protocol[OptionsT_contra, PlanT, ResultT_co]):
    """One study: its name is that of its folder of tables, its page and its command."""

    @property
    def files(self) -> StudyFiles:
        """Tables and record, with the study's name."""

    def plan(self, options: OptionsT_contra) -> PlanT:
        """Scenes, engines and limits to be run.

        Raises
        ------
        ValueError
            If the options can't be met; nothing has been run then.
        """

    def record(self, plan: PlanT) -> dict[str, Any]:
        """Entries of the record that are known before the first run."""

    def run(self, plan: PlanT, store: StudyStore, reporter: Reporter) -> ResultT_co:
        """Run the plan, and write tables as results come."""


class Limited(Protocol):
    """A plan whose measurements are repeated within a budget."""

    @property
    def repeats(self) -> int:
        """Times that each point is measured."""

    @property
    def minutes(self) -> float:
        """Budget of the study."""

    @property
    def time_limit_s(self) -> float:
        """Longest run."""


def limits_of(plan: Limited) -> dict[str, float]:
    """Entry ``limits`` of the record."""
    return {"repeats": plan.repeats, "minutes": plan.minutes, "time_limit_s": plan.time_limit_s}


def run_study(
    study: Study[Any, PlanT, ResultT_co],
    plan: PlanT,
    out: Path,
    *,
    command: str = "",
    reporter: Reporter | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> ResultT_co:
    """Run a planned study, and write its tables and record into ``out/<name>``.

    Parameters
    ----------
    study : Study
    plan : plan of the study
        From ``study.plan(options)``.
    out : Path
        Result folder; tables of other studies and of comparisons in it stay as they are.
    command : str
        Command line, for the record.
    reporter : Reporter, optional
        Callbacks for progress; none by default.
    resume : bool
        Continue from the tables that an interrupted study left in `out`.
    overwrite : bool
        Delete the study's earlier results in `out` first.

    Returns
    -------
    result of the study

    Raises
    ------
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.
    """
    return run_and_render(
        study, plan, out, nothing, command=command, reporter=reporter, resume=resume, overwrite=overwrite
    )[0]


def nothing(_: Path) -> None:
    """Render nothing."""


def run_and_render(
    study: Study[Any, PlanT, ResultT_co],
    plan: PlanT,
    out: Path,
    render: Callable[[Path], RenderedT],
    *,
    command: str = "",
    reporter: Reporter | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> tuple[ResultT_co, RenderedT]:
    """Run a planned study, and render its tables before another command may write into the folder.

    Arguments and errors are those of :func:`run_study`; `render` is called with `out`.

    Returns
    -------
    tuple
        The results of the study and of `render`.

    Notes
    -----
    The record is written before the first run and after the last, also when the run is interrupted. ``complete`` is
    true only if the run came to its end, ``finished`` only if `render` did too.
    """
    start = time.perf_counter()
    reporter = reporter or Reporter()
    complete = False
    record = new_record(study, plan, command)
    with claimed(study.files, out, record.get(PARTS), resume=resume, overwrite=overwrite):
        store = StudyStore(study.files, out, record, resume=resume)
        plan = keeping_answers(plan, store)
        store.write_record()
        try:
            result = study.run(plan, store, reporter)
            complete = True
        finally:
            store.end(time.perf_counter() - start, complete=complete)
        rendered = render(out)
        store.finish()
    return result, rendered


def keeping_answers(plan: PlanT, store: StudyStore) -> PlanT:
    """Plan whose executor, if it has one, keeps answers in the study's folder."""
    placed: Any = plan
    if not store.files.keeps_answers or not hasattr(plan, "executor"):
        return plan
    return dataclasses.replace(placed, executor=KeptAnswers(store.folder, placed.executor))  # type: ignore[no-any-return]


def new_record(study: Study[Any, PlanT, Any], plan: PlanT, command: str) -> dict[str, Any]:
    """Record of a study before its first run: provenance, then the study's own entries.

    Versions of further ``packages`` in the study's entries are added to those of the provenance.
    """
    own = study.record(plan)
    packages = own.pop("packages", None)
    return provenance(command, packages) | own
