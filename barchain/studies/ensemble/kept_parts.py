"""Results of an ensemble's runs, reduced as they come, and their checkpoints in its folder for `--resume`."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import signal
import threading
import time
import zipfile
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.record.sources import our_digest
from barchain.studies.ensemble.rows import RunColumns, RunTally, header_text, rows_text, run_columns, table
from barchain.studies.ensemble.samples import CountedSamples, HeldSamples
from reports.tables.reading import TABLES, DamagedResultsError, recorded_content

if TYPE_CHECKING:
    from collections.abc import Iterator

    import pandas as pd

    from barchain.record.study_store import StudyStore
    from barchain.studies.ensemble.plan import EnsemblePlan
    from barchain.studies.ensemble.samples import Samples
    from barchain.studies.ensemble.task_results import EnsembleTaskResult
    from barchain.studies.ensemble.tasks import EnsembleTask

KEY = "key"
"""Entry of the record: digest of the plan and of the sources that made the parts"""
FOLDER, ENDING = "parts", ".npz"
WHOLE = f"{FOLDER}/whole{ENDING}"
"""File of a checkpoint with the number of runs, and everything that is not in a file of some runs"""
WRITE_S = 30.0  # between checkpoints: a kill costs at most this time, and a quick ensemble writes none
MOST_TEXT = 4_000_000  # B of rows between checkpoints, some 100 000 runs
WORDS, ROWS = "words", "rows"
UNREADABLE = (OSError, DamagedResultsError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile)


def plan_key(plan: EnsemblePlan) -> str:
    """Digest of everything that decides the numbers of a part."""
    decides = (plan.scene.digest, [v.text for v in plan.variations], plan.runs, plan.seed, plan.rtol, our_digest())
    return hashlib.sha256(repr(decides).encode()).hexdigest()


class KeptParts:
    """Results of the first runs, in memory alone."""

    def __init__(self, plan: EnsemblePlan) -> None:
        """Begin without runs."""
        self.plan, self.runs = plan, 0
        self.samples: Samples = HeldSamples(plan.scene, plan.runs) if plan.exact else CountedSamples(plan.scene)
        self.tally, self.rows = RunTally(), list[RunColumns]()
        self.settled = True
        """False while a part is taken"""

    def add(self, task: EnsembleTask, result: EnsembleTaskResult) -> None:
        """Take the next part; an interrupt waits until it is taken whole."""
        with uninterrupted():
            self.settled = False
            rows = run_columns(task, result, self.plan.variations)
            self.samples.add(task.first, result.seen)
            self.tally.add(rows)
            self.take_rows(rows)
            self.runs += task.part.runs
            self.settled = True

    def take_rows(self, rows: RunColumns) -> None:
        """Take rows of the table of runs."""
        self.rows.append(rows)

    def run_table(self) -> pd.DataFrame:
        """One row for each run."""
        return table(self.rows)

    @contextlib.contextmanager
    def written(self) -> Iterator[None]:
        """Keep the parts, whatever ends the runs."""
        yield


class StoredParts(KeptParts):
    """Results of the first runs; rows are text, which is written into the study's folder from time to time.

    A checkpoint is a file of the runs since the last one (rows; samples too if all are held), and the file `WHOLE`.
    """

    def __init__(self, plan: EnsemblePlan, store: StudyStore) -> None:
        """Take the parts of an interrupted study that had the same plan and code; others are deleted."""
        super().__init__(plan)
        self.store, self.since = store, time.monotonic()
        self.firsts = list[int]()
        """First run of each file"""
        self.stored = 0
        """Runs in files"""
        self.header, self.text = b"", list[bytes]()
        try:
            self.recall()
        except UNREADABLE:  # damaged: all runs are made again
            super().__init__(plan)
            self.firsts, self.stored, self.header = [], 0, b""
        self.remove({WHOLE, *map(file_name, self.firsts)} if self.stored else set())

    def recall(self) -> None:
        """Take the checkpoint of an interrupted study, if it has one of this plan and code."""
        earlier = self.store.earlier
        if not earlier or earlier.get(KEY) != self.store.record[KEY] or WHOLE not in (earlier.get(TABLES) or {}):
            return
        with self.file(WHOLE) as whole:
            words = json.loads(whole[WORDS].tobytes().decode("ascii"))
            firsts, runs = words["firsts"], words["runs"]
            self.samples.restore_whole(whole)
        for first, last in zip(firsts, [*firsts[1:], runs], strict=True):
            with self.file(file_name(first)) as part:
                self.samples.restore_part(first, last, part)
        self.tally = RunTally(Counter(words["outcomes"]), words["evaluations"], words["first_failure"])
        self.header = words["header"].encode("utf-8")
        self.firsts, self.stored, self.runs = firsts, runs, runs

    def file(self, name: str) -> Any:
        """File of a checkpoint, whose digest is the recorded one."""
        record = self.store.earlier if name in (self.store.earlier.get(TABLES) or {}) else self.store.record
        content = recorded_content(self.store.folder, name, record)
        if content is None:
            raise KeyError(name)
        return np.load(io.BytesIO(content), allow_pickle=False)

    def add(self, task: EnsembleTask, result: EnsembleTaskResult) -> None:
        """Take the next part."""
        super().add(task, result)
        if time.monotonic() - self.since > WRITE_S or sum(map(len, self.text)) > MOST_TEXT:
            self.write()

    def take_rows(self, rows: RunColumns) -> None:
        """Take rows as text."""
        self.header = self.header or header_text(rows)
        self.text.append(rows_text(rows))

    @contextlib.contextmanager
    def written(self) -> Iterator[None]:
        """Write a checkpoint if the runs are interrupted; of complete runs the tables are written."""
        try:
            yield
        except BaseException:
            if self.settled:
                self.write()
            raise

    def write(self) -> None:
        """Write a checkpoint. A kill between its two files leaves the one before."""
        if self.runs > self.stored:
            name, text = file_name(self.stored), np.frombuffer(b"".join(self.text), np.uint8)
            self.save(name, {ROWS: text} | self.samples.part(self.stored, self.runs))
            self.save(WHOLE, {WORDS: self.words([*self.firsts, self.stored])} | self.samples.whole())
            self.firsts, self.stored, self.text = [*self.firsts, self.stored], self.runs, []
        self.since = time.monotonic()

    def words(self, firsts: list[int]) -> Any:
        """Numbers and words of a checkpoint, as bytes of JSON."""
        known = {
            "runs": self.runs, "firsts": firsts, "header": self.header.decode("utf-8"),
            "outcomes": self.tally.outcomes, "evaluations": self.tally.evaluations,
            "first_failure": self.tally.first_failure,
        }  # fmt: skip
        return np.frombuffer(json.dumps(known).encode("ascii"), np.uint8)

    def save(self, name: str, arrays: dict[str, Any]) -> None:
        """Write a file of a checkpoint."""
        with self.store.writer.replacing(name) as file:
            np.savez(file, **arrays)

    def run_text(self) -> Iterator[bytes]:
        """Text of the table of runs, part by part."""
        yield self.header
        for first in self.firsts:
            with self.file(file_name(first)) as part:
                yield part[ROWS].tobytes()
        yield from self.text

    def remove(self, but: set[str] | frozenset[str] = frozenset()) -> None:
        """Delete all files of parts but some."""
        folder = self.store.folder / FOLDER
        names = {f"{FOLDER}/{path.name}" for path in folder.glob(f"*{ENDING}")}
        for name in sorted((names | {n for n in self.store.writer.tables if n.startswith(f"{FOLDER}/")}) - but):
            self.store.writer.remove(name)
        with contextlib.suppress(OSError):  # another's files are there, or none ever were
            folder.rmdir()


def file_name(first: int) -> str:
    """File of the runs from run `first` on."""
    return f"{FOLDER}/{first:010}{ENDING}"


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Let an interrupt wait until the end of the context."""
    if threading.current_thread() is not threading.main_thread():  # which alone is interrupted
        yield
        return
    waiting: list[tuple[Any, ...]] = []
    before = signal.signal(signal.SIGINT, lambda *given: waiting.append(given))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if waiting and callable(before):
            before(*waiting[0])
