"""Lock and claim of result folders and files: one writer at a time, and never overwritten unasked."""

from __future__ import annotations

import contextlib
import os
import shutil
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from reports.results.files import ANSWERS, SERIES

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from reports.results.files import StudyFiles


LOCK = ".barchain.lock"
"""Empty file in a result folder; the operating system's lock on it counts, and its presence does not"""


class ResultsInPlaceError(ValueError):
    """Raised for results that would be overwritten unasked; the message is one line."""


class FolderInUseError(ValueError):
    """Raised for a result folder that another process, or another thread, writes into; the message is one line."""


def locked_if_there(folder: Path) -> AbstractContextManager[None]:
    """Lock of a result folder that exists; nothing of one that does not."""
    return locked(folder) if folder.is_dir() else contextlib.nullcontext()


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a result folder, which is made if need be; the same thread may hold it several times.

    Raises
    ------
    FolderInUseError
        If somebody else holds it.
    OSError
        If the folder can't be made or written into.
    """
    folder.mkdir(parents=True, exist_ok=True)
    place = folder.resolve() / LOCK
    lock = FileLock(place, timeout=0, is_singleton=True, thread_local=True)
    try:
        lock.acquire()
    except Timeout:
        said = "another barchain writes into this folder; wait for its end, or give another --out"
        raise FolderInUseError(f"{folder}: {said}") from None
    try:
        yield
    finally:
        lock.release()


@contextlib.contextmanager
def claimed(
    files: StudyFiles, out: Path, parts: Collection[str] | None = None, *, resume: bool | None, overwrite: bool
) -> Iterator[None]:
    """Hold the lock of the result folder `out`, in which a study, or a comparison, may write.

    Arguments and errors are those of :func:`claim_results` and :func:`locked`.
    """
    need_one_mode(resume=bool(resume), overwrite=overwrite)
    with locked(out):
        claim_results(files, out, parts, resume=resume, overwrite=overwrite)
        yield


def claim_results(
    files: StudyFiles,
    out: Path,
    parts: Collection[str] | None = None,
    *,
    resume: bool | None = False,
    overwrite: bool = False,
) -> None:
    """Make sure that a study, or a comparison, may write into the result folder `out`, as :func:`claim`.

    Parameters
    ----------
    files : StudyFiles
    out : Path
        A folder whose lock is held: no other process is writing into it.
    parts : collection of str, optional
        Parts of the study that are run; tables of the others stay.
    resume : bool, optional
        None of a command that can't go on from what is there.
    overwrite : bool

    Raises
    ------
    ResultsInPlaceError
        If results are there, and neither `resume` nor `overwrite` is given, or both are; if the results are those of
        another study; or if a folder of theirs is a link.
    DamagedResultsError, SchemaVersionError
        If tables of other parts shall stay beside a record that can't be read.
    """
    answers = out / ANSWERS / files.study
    # the record first, so that no record is left without its rows
    places = [files.record_path(out), out / files.rows_name, out / SERIES / files.study, answers]
    need_no_links(out, places)
    if parts is not None and not set(files.parts) <= set(parts) and files.has_record(out):
        before = set(files.read_record(out).get("parts") or ())
        if before - set(parts):  # rows of other parts stay, beside those that are made anew
            places = [answers] if before & set(parts) else []
    rendered = [out / name for name in files.pages] if overwrite else []
    what = f"results of {files.study}" if not files.parts else f"results of these parts of {files.study}"
    claim(places, f"{out} holds {what}", resume=resume, overwrite=overwrite)
    for page in (p for p in rendered if os.path.lexists(p)):
        delete(page)


def claim(places: Iterable[Path], holds: str, *, resume: bool | None = None, overwrite: bool) -> None:
    """Make sure that files and folders may be written; with `overwrite` those that are there are deleted.

    Parameters
    ----------
    places : iterable of Path
    holds : str
        What is said of them where they are there.
    resume : bool, optional
        Leave them for the command to go on from; None of a command that can't.
    overwrite : bool

    Raises
    ------
    ResultsInPlaceError
        If something is there, and neither of both is asked for; or if both are.
    """
    need_one_mode(resume=bool(resume), overwrite=overwrite)
    there = [place for place in places if os.path.lexists(place)]
    if not there or resume:
        return
    if not overwrite:
        goes_on = "" if resume is None else "--resume goes on from there, "
        raise ResultsInPlaceError(f"{holds}; {goes_on}--overwrite replaces what is there")
    for place in there:
        delete(place)


def need_no_links(out: Path, places: Iterable[Path]) -> None:
    """Check that files and folders inside a result folder lie there: what is deleted or written is the study's own.

    A link to a file is replaced, and the file stays.

    Raises
    ------
    ResultsInPlaceError
        If one of them, or a folder on the way to it, is a link to a folder.
    """
    for place in places:
        for part in (place, *(folder for folder in place.parents if out in folder.parents)):
            if part.is_symlink() and not part.is_file():
                raise ResultsInPlaceError(f"{part} is a link, allowed: a folder that lies in the result folder")


def need_one_mode(*, resume: bool, overwrite: bool) -> None:
    """Check that earlier results are not to be both kept and replaced."""
    if resume and overwrite:
        raise ResultsInPlaceError("--resume and --overwrite exclude each other")


def delete(place: Path) -> None:
    """Delete a file, a symbolic link, or a folder with all it holds."""
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    else:
        place.unlink()
