"""Results of a part of an ensemble, and their form between processes: arrays, and words as JSON."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference_impl.kernel.batch import BatchResult

WORDS = "words"


@dataclass(frozen=True)
class EnsembleTaskResult:
    """Result of a task."""

    seen: BatchResult
    ended: tuple[str, ...]
    """Of each run: why it ended early; empty if it did not"""
    failed: tuple[str, ...]
    """Of each run: why it failed; empty if it did not"""

    def fits(self, runs: int, samples: int, bars: int) -> bool:
        """Whether all parts have the shapes of so many runs."""
        shapes = [(runs, samples, bars), (runs, samples, bars - 1), (runs,), (runs,), (runs,)]
        words = (*self.ended, *self.failed)
        return (
            [x.shape for x in self.seen] == shapes
            and all(x.dtype == np.float64 for x in self.seen)
            and len(self.ended) == len(self.failed) == runs
            and all(isinstance(word, str) for word in words)
        )


def packed(result: EnsembleTaskResult) -> bytes:
    """Result as the contents of a file of arrays."""
    words = json.dumps([result.ended, result.failed]).encode("ascii")
    arrays: dict[str, Any] = result.seen._asdict() | {WORDS: np.frombuffer(words, np.uint8)}
    sink = io.BytesIO()
    np.savez(sink, **arrays)
    return sink.getvalue()


def unpacked(content: bytes) -> EnsembleTaskResult | None:
    """Result from another process; None if it can't be read."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            ended, failed = json.loads(file[WORDS].tobytes().decode("ascii"))
            return EnsembleTaskResult(
                BatchResult(*(file[name] for name in BatchResult._fields)), tuple(ended), tuple(failed)
            )
    except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile):
        return None
