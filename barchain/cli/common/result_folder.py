"""Folders that hold results: never overwritten in silence."""

from __future__ import annotations

import contextlib
import os
import shutil
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from collections.abc import Iterable
    from contextlib import AbstractContextManager
    from pathlib import Path

COMPARISON = ("record.json", "metrics.csv", "trajectories", "differences")
"""What a comparison writes into its folder; a study writes into a folder of its own there"""


def claim_comparison(out: Path, *, resume: bool, overwrite: bool) -> None:
    """Make sure that a comparison may write into `out`, as :func:`claim`."""
    with alone(out):
        claim([out / name for name in COMPARISON], f"{out} holds a comparison", resume=resume, overwrite=overwrite)


def claim_study(out: Path, folder: str, *, resume: bool | None = None, overwrite: bool) -> None:
    """Make sure that a study may write into its `folder` of `out`, as :func:`claim`."""
    inside = out / folder
    with alone(out):
        claim([inside] if has_entries(inside) else [], f"{inside} holds results", resume=resume, overwrite=overwrite)


def alone(out: Path) -> AbstractContextManager[None]:
    """Lock of a result folder that exists: what another process is writing is neither judged nor deleted."""
    from barchain.record.folder_lock import locked  # noqa: PLC0415

    return locked(out) if out.is_dir() else contextlib.nullcontext()


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
    UsageError
        If something is there, and neither of both is asked for; or if both are.
    """
    if resume and overwrite:
        raise click.UsageError("--resume and --overwrite exclude each other")
    there = [place for place in places if os.path.lexists(place)]
    if not there or resume:
        return
    if not overwrite:
        goes_on = "" if resume is None else "--resume goes on from there, "
        raise click.UsageError(f"{holds}; {goes_on}--overwrite replaces what is there")
    for place in there:
        delete(place)


def has_entries(folder: Path) -> bool:
    """Whether a folder is there and not empty."""
    return folder.is_dir() and any(folder.iterdir())


def delete(place: Path) -> None:
    """Delete a file, a symbolic link, or a folder with all it holds."""
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    else:
        place.unlink()
