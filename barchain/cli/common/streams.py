"""Standard streams of a command: a stream that is closed or full costs the output, not the runs."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import TextIO

from barchain.runs.environment import fill_standard_streams


class LossyFile(io.FileIO):
    """File whose text is dropped where the system does not take it; a reader that has ended is told as ever."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self.lost = ""
        """Reason of the first loss; empty without one"""

    def write(self, content: bytes) -> int:  # type: ignore[override]
        """Write bytes; the number of those that are written or dropped."""
        try:
            return super().write(content) or 0
        except BrokenPipeError:
            raise
        except OSError as error:
            self.lost = self.lost or error.strerror or str(error)
            return len(content)


def guard_streams() -> LossyFile | None:
    """Make the standard streams of this process safe to write to.

    Returns
    -------
    LossyFile or None
        File of standard output, which knows of losses; None where the system's own file of a terminal is kept.
    """
    fill_standard_streams()
    sys.stdin = sys.stdin or open(os.devnull, encoding="utf-8")  # noqa: PTH123, SIM115  # for the life of the process
    sys.stdout, found = guarded(sys.stdout, 1)
    sys.stderr, _ = guarded(sys.stderr, 2)
    return found


def guarded(stream: TextIO | None, descriptor: int) -> tuple[TextIO, LossyFile | None]:
    """Stream over a file that drops what is not taken, and that file."""
    file = LossyFile(descriptor)
    if stream is None:
        return io.TextIOWrapper(io.BufferedWriter(file)), file  # type: ignore[type-var]
    buffer = getattr(stream, "buffer", None)
    if not isinstance(getattr(buffer, "raw", buffer), io.FileIO):  # a console of Windows, or another's stream
        return stream, None
    # `python -u` has no buffer
    inner = file if isinstance(buffer, io.FileIO) else io.BufferedWriter(file)  # type: ignore[type-var]
    form = {name: getattr(stream, name) for name in ("encoding", "errors", "line_buffering", "write_through")}
    return io.TextIOWrapper(inner, **form), file


def lost_output(file: LossyFile | None) -> str:
    """Why standard output was lost; empty if all was written."""
    if file is None:
        return ""
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
    return file.lost
