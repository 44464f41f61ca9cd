"""The protocol of studies (options, plan, run that fills tables), and a study from start to tables.

Studies differ in their loops, and share all else: the folder (:class:`barchain.record.study_store.StudyStore`), the
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


@dataclass(frozen=True)
class StudyEnd:
    """Findings of a study beside its tables, where failures alone decide."""

    failures: tuple[str, ...] = ()
    """One line each"""
    idle: dict[str, str] = field(default_factory=dict)
    """Engines that ran nowhere, with the reason"""

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
        """Entries of the record that are known before the first run.

        Versions of further ``packages`` are added to those of the provenance.
        """

    def run(self, plan: PlanT, store: StudyStore, reporter: Reporter) -> ResultT_co:
        """Run the plan, and write tables as results come."""


def run_study(study: Study[Any, PlanT, ResultT_co], plan: PlanT, out: Path, **how: Any) -> ResultT_co:
    """Result of a study; arguments are those of :func:`run_and_render` without `render`."""
    return run_and_render(study, plan, out, ignore, **how)[0]


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
    """Run a planned study, and write its tables and record into ``out/<name>``.

    Parameters
    ----------
    study : Study
    plan : plan of the study
        From ``study.plan(options)``. Its executor, if it has one, keeps answers in the study's folder.
    out : Path
        Result folder; tables of other studies and of comparisons in it stay as they are.
    render : callable
        Renders the tables in `out` before another command may write into the folder.
    command : str
        Command line, for the record.
    reporter : Reporter, optional
        Callbacks for progress; none by default.
    resume : bool
        Take the answers that an earlier study left in `out`, and make what is missing.
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
    start, complete = time.perf_counter(), False
    own = study.record(plan)
    record = provenance(command, own.pop("packages", None)) | own
    with claimed(study.files, out, record.get(PARTS), resume=resume, overwrite=overwrite):
        store = StudyStore(study.files, out, record, resume=resume)
        placed: Any = plan
        if hasattr(plan, "executor"):
            placed = dataclasses.replace(placed, executor=KeptAnswers(store.folder, placed.executor))
        store.write_record()
        try:
            result = study.run(placed, store, reporter or Reporter())
            complete = True
        finally:
            store.end(time.perf_counter() - start, complete=complete)
        rendered = render(out)
        store.finish()
    return result, rendered
