"""Parts of an ensemble in its folder, so that an interrupted ensemble goes on from them."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import time
import zipfile
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.record.sources import our_digest
from barchain.studies.ensemble.tasks import EnsembleTaskResult
from reference_impl.fast.batch import BatchResult
from reports.tables.reading import TABLES, DamagedResultsError, recorded_content

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.record.study_store import StudyStore
    from barchain.studies.ensemble.plan import EnsemblePlan

KEY = "key"
"""Entry of the record: digest of the plan and of the sources that made the parts"""
FOLDER, ENDING = "parts", ".npz"
WRITE_S = 30.0  # between files: a kill costs at most this time, and a quick ensemble writes none
WORDS = "words"


def plan_key(plan: EnsemblePlan) -> str:
    """Digest of everything that decides the numbers of a part."""
    decides = (plan.scene.digest, [v.text for v in plan.variations], plan.runs, plan.seed, plan.rtol, our_digest())
    return hashlib.sha256(repr(decides).encode()).hexdigest()


class KeptParts:
    """Results by part, in memory alone."""

    def __init__(self, parts: dict[int, EnsembleTaskResult] | None = None) -> None:
        self.parts = parts or {}

    def add(self, k: int, result: EnsembleTaskResult) -> None:
        """Keep the result of a part."""
        self.parts[k] = result

    @contextlib.contextmanager
    def written(self) -> Iterator[None]:
        """Write every part at the end, whatever ends the runs."""
        yield


class StoredParts(KeptParts):
    """Results by part, written into a study's folder from time to time and at the end of the runs."""

    def __init__(self, store: StudyStore) -> None:
        """Take the parts of an interrupted study that had the same plan and code; others are deleted."""
        self.store, self.unwritten, self.since = store, list[int](), time.monotonic()
        super().__init__(recalled(store))
        if not self.parts:
            self.remove()

    def add(self, k: int, result: EnsembleTaskResult) -> None:
        """Keep the result of a part."""
        super().add(k, result)
        self.unwritten.append(k)
        if time.monotonic() - self.since > WRITE_S:
            self.write()

    @contextlib.contextmanager
    def written(self) -> Iterator[None]:
        """Write every part if the runs are interrupted; of complete runs the tables are written."""
        try:
            yield
        except BaseException:
            self.write()
            raise

    def write(self) -> None:
        """Write the parts that no file holds, as one file."""
        if self.unwritten:
            content = packed({k: self.parts[k] for k in self.unwritten})
            self.store.writer.write(f"{FOLDER}/{self.unwritten[0]:06}{ENDING}", content)
        self.unwritten, self.since = [], time.monotonic()

    def remove(self) -> None:
        """Delete all files of parts."""
        folder = self.store.folder / FOLDER
        names = {f"{FOLDER}/{path.name}" for path in folder.glob(f"*{ENDING}")} if not folder.is_symlink() else set()
        for name in sorted(names | {n for n in self.store.writer.tables if is_part(n)}):
            self.store.writer.remove(name)
        with contextlib.suppress(OSError):  # another's files are there, or none ever were
            folder.rmdir()


def is_part(name: str) -> bool:
    """Whether a recorded table holds parts."""
    return name.startswith(f"{FOLDER}/")


def recalled(store: StudyStore) -> dict[int, EnsembleTaskResult]:
    """Parts that an interrupted study recorded; none of another plan or code. Damaged files are left out."""
    found: dict[int, EnsembleTaskResult] = {}
    if not store.earlier or store.earlier.get(KEY) != store.record[KEY]:
        return found
    for name in filter(is_part, store.earlier.get(TABLES) or {}):
        with contextlib.suppress(OSError, DamagedResultsError):
            content = recorded_content(store.folder, name, store.earlier)
            found |= unpacked(content) if content is not None else {}
    return found


def packed(parts: dict[int, EnsembleTaskResult]) -> bytes:
    """Contents of a file of parts: arrays, and words as JSON."""
    words = {k: [list(p.ended), list(p.failed)] for k, p in parts.items()}
    arrays: dict[str, Any] = {
        f"{k} {name}": getattr(p.seen, name) for k, p in parts.items() for name in BatchResult._fields
    }
    arrays[WORDS] = np.frombuffer(json.dumps(words).encode("ascii"), np.uint8)
    sink = io.BytesIO()
    np.savez(sink, **arrays)
    return sink.getvalue()


def unpacked(content: bytes) -> dict[int, EnsembleTaskResult]:
    """Parts of a file whose digest is the recorded one; none if it can't be read."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            words = json.loads(file[WORDS].tobytes().decode("ascii"))
            return {
                int(k): EnsembleTaskResult(
                    BatchResult(*(file[f"{k} {name}"] for name in BatchResult._fields)), tuple(ended), tuple(failed)
                )
                for k, (ended, failed) in words.items()
            }
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return {}
