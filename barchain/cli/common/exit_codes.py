"""Exit codes of every command, and the errors that end a command with each."""

from __future__ import annotations

import json
from enum import IntEnum

import click


class ExitCode(IntEnum):
    """End of a command. Of its members `MEANINGS` makes the table of docs/reference/command_line.md."""

    OK = 0
    FINDINGS = 1
    BAD_INPUT = 2
    MISSING_ENGINE = 3
    NOT_BELIEVED = 3  # another name of the member above, whose meaning has both
    INTERNAL_ERROR = 70
    INTERRUPTED = 130
    UNREAD = 141


MEANINGS = {
    ExitCode.OK: "The command did its work, and every check passed.",
    ExitCode.FINDINGS: "A run, a comparison or a check failed.",
    ExitCode.BAD_INPUT: "An option, a scene, a file, a folder or a disk is not usable, or there is not enough memory; "
    "runs are made only before a disk or the memory fails.",
    ExitCode.MISSING_ENGINE: "An engine that was named, or that the command needs, is not installed; nothing was "
    "run. Of `nightly` and `history report`: the night is void or incomplete, and nothing is known to be worse.",
    ExitCode.INTERNAL_ERROR: "barchain itself failed; a traceback was printed.",
    ExitCode.INTERRUPTED: "The command was interrupted, e.g. by Ctrl-C; results that were written are kept.",
    ExitCode.UNREAD: "The reader of the command's output ended first, e.g. `head`; results so far are kept.",
}


REFUSED = ("can't start new thread", "failed to map segment")
"""Words of Python's errors on a thread, or a library, for which there is no memory"""


class MissingEngineError(click.ClickException):
    """An engine that was named, or that the command needs, is not installed."""

    exit_code = ExitCode.MISSING_ENGINE


def findings() -> click.exceptions.Exit:
    """Exception that ends a command whose checks did not all pass."""
    return click.exceptions.Exit(ExitCode.FINDINGS)


def failure(error: Exception) -> tuple[str, ExitCode] | None:
    """Message and exit code of an error that a user can act on; None of a fault of barchain's own."""
    if isinstance(error, click.ClickException):
        missing = isinstance(error, MissingEngineError)
        return error.format_message(), ExitCode.MISSING_ENGINE if missing else ExitCode.BAD_INPUT
    if isinstance(error, MemoryError) or any(words in str(error) for words in REFUSED):
        return f"there is not enough memory{f': {error}' if str(error) else ''}", ExitCode.BAD_INPUT
    if isinstance(error, json.JSONDecodeError):
        return f"a file of these results is damaged: {error}", ExitCode.BAD_INPUT
    if isinstance(error, OSError):  # a file or folder that is not there, not a folder, or not writable
        said = f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error)
        return said, ExitCode.BAD_INPUT
    from adapters.command.entries import EntryError
    from adapters.engine import EngineError, SettingError
    from adapters.registry import UnknownEngineError
    from barchain.nightly.errors import HistoryError
    from barchain.record.claim import FolderInUseError, ResultsInPlaceError
    from barchain.result_files.table import TableError
    from barchain.runs.cluster.connection import ClusterError, ClusterLostError
    from barchain.solutions.certified_file import DamagedTableError
    from barchain.solutions.judging import SolutionFailedError
    from reports.results.reading import DamagedResultsError
    from reports.results.schema import SchemaVersionError
    from scenarios import SceneError

    bad_tables = TableError, DamagedTableError, DamagedResultsError, SchemaVersionError
    bad_folder = FolderInUseError, ResultsInPlaceError
    bad_input = SceneError, UnknownEngineError, EntryError, SettingError, HistoryError, *bad_tables, *bad_folder
    if isinstance(error, bad_input) or (isinstance(error, ClusterError) and not isinstance(error, ClusterLostError)):
        return str(error), ExitCode.BAD_INPUT
    found = ClusterLostError, EngineError, SolutionFailedError
    return (str(error), ExitCode.FINDINGS) if isinstance(error, found) else None
