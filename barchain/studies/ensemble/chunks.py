"""Chunks of an ensemble: drawn as they are asked for, run on threads or on a cluster, their results kept in files.

A chunk is one call with the runs of many copies. Its answer holds all samples, item by item: a quantile over all runs
reads one stretch of each file, and nothing that is held grows with the number of runs.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.runs.call import Answer, Call, CallFailedError
from barchain.runs.executors import KeptAnswers, LocalProcesses
from barchain.runs.kept_answers import HEAD_B, KeptSession, answer_key
from barchain.runs.pool import Session
from barchain.studies.ensemble.population import batch, populations
from reference_impl.integrate.stepper import smooth_segments
from reference_impl.kernel.batch import run_members
from reference_impl.kernel.layout import ARRIVED

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.runs.executors import Executor
    from barchain.studies.ensemble.population import Ensemble, Population
    from barchain.studies.ensemble.variation import Variation
    from reference_impl.kernel.batch import BatchResult
    from scenarios import Scene

LEAST_RUNS = 250  # of a chunk: some ten milliseconds
MOST_CHUNKS = 64  # of few runs: progress is smooth, a kill costs little, and all threads have work to the end
MOST_RUNS, MOST_NUMBERS = 10_000, 2**20  # of a chunk; 8 MB of samples
LIMIT_S = 3600.0  # of 250 runs, which take some hundredths of a second, of a long scene minutes
AHEAD, MOST_WAITING = 8, 2**26  # chunks of each thread under way, and B of their results; two for each may be more
SAMPLES = np.dtype("<f8")


@dataclass(frozen=True)
class Chunk:
    """A part of the population to be run."""

    part: Population
    rtol: float
    first: int = 0
    """Number of its first run, counted from 0"""

    @property
    def bytes(self) -> int:
        """Size of its samples."""
        return SAMPLES.itemsize * columns(self.part.scene) * self.part.runs

    @property
    def call(self) -> Call:
        """Call that runs it."""
        return Call(chunk_bytes, (self,), LIMIT_S * max(1.0, self.part.runs / LEAST_RUNS))


@dataclass(frozen=True)
class RunEnds:
    """Ends of the runs of a chunk."""

    ended: list[str]
    """Of each run: why it ended early; empty if it did not"""
    failed: list[str]
    """Of each run: why it failed; empty if it did not"""
    steps: list[int]
    evaluations: list[int]


def columns(scene: Scene) -> int:
    """Angles and reactions of a run at all samples: first all angles, instant by instant."""
    return scene.run.samples * (2 * scene.bars - 1)


def chunks(ensemble: Ensemble) -> Iterator[Chunk]:
    """Chunks in order, drawn as they are asked for; the same however many workers there are."""
    size = max(LEAST_RUNS, min(ensemble.runs // MOST_CHUNKS, MOST_NUMBERS // columns(ensemble.scene), MOST_RUNS))
    for k, part in enumerate(populations(ensemble.scene, ensemble.variations, ensemble.runs, ensemble.seed, size)):
        yield Chunk(part, ensemble.rtol, k * size)


class Threads(Session):
    """Calls on threads of this process: compiled code holds no interpreter lock."""

    def __init__(self, threads: int) -> None:
        super().__init__()
        self.threads, self.pool = threads, ThreadPoolExecutor(threads)

    def start(self, key: Hashable, call: Call) -> None:
        """Queue a call."""
        self.pool.submit(self.answer, key, call)

    def answer(self, key: Hashable, call: Call) -> None:
        """Answer a call, in a thread."""
        try:
            self.done.put((key, Answer(call.function(*call.given))))
        except Exception as error:  # a fault of barchain's own ends the command with its traceback
            self.done.put(error)

    def side_by_side(self) -> int:
        """Threads."""
        return self.threads

    def close(self) -> None:
        """Begin no further call; an interrupt waits for those at work only."""
        self.pool.shutdown(wait=False, cancel_futures=True)


def session_of(executor: Executor) -> Session:
    """Session of an executor; on this machine of threads."""
    if isinstance(executor, KeptAnswers):
        return KeptSession(session_of(executor.inside), executor.folder)
    if isinstance(executor, LocalProcesses):
        return Threads(executor.workers or os.cpu_count() or 1)
    return executor.session()


def run_chunks(ensemble: Ensemble, done: Callable[[int], None]) -> ChunkFiles:
    """Make all chunks whose answers are not kept; `done` is called with the number of runs of each.

    Raises
    ------
    CallFailedError
        If a chunk gives no result, or a damaged one.
    ClusterLostError
        If the executor is a cluster, and fails; results so far are kept.
    """
    assert isinstance(ensemble.executor, KeptAnswers)
    files: list[tuple[Path, int]] = []
    under_way: dict[int, tuple[Chunk, Path]] = {}

    def take(*, wait: bool = True) -> Iterator[None]:
        for first, answer in session.answers(wait=wait):
            chunk, file = under_way.pop(first)
            need_sound(chunk, answer.needed(), file)
            done(chunk.part.runs)
            yield

    with session_of(ensemble.executor) as session:
        for chunk in chunks(ensemble):
            call = chunk.call
            file = ensemble.executor.folder / answer_key(call)
            under_way[chunk.first] = chunk, file
            files.append((file, chunk.part.runs))
            session.submit(chunk.first, call)
            at_once = session.side_by_side()
            most = max(2 * at_once, min(AHEAD * at_once, MOST_WAITING // chunk.bytes))
            for _ in take(wait=session.left >= most):
                if session.left < most:
                    break
        for _ in take():
            pass
    return ChunkFiles(ensemble, tuple(files))


def chunk_bytes(chunk: Chunk) -> bytes:
    """Run a chunk: its samples (columns, runs), then the ends of its runs as JSON."""
    seen, ends = run_chunk(chunk)
    runs = chunk.part.runs
    samples = np.concatenate([seen.angle_rad.reshape(runs, -1).T, seen.reaction_N.reshape(runs, -1).T])
    return np.ascontiguousarray(samples, dtype=SAMPLES).tobytes() + json.dumps(vars(ends)).encode("ascii")


def need_sound(chunk: Chunk, content: bytes, file: Path) -> None:
    """Check the answer to a chunk.

    Raises
    ------
    CallFailedError
        If it has another form; it is then not kept in its file.
    """
    try:
        ends = RunEnds(**json.loads(content[chunk.bytes :].decode("ascii")))
        whole = {len(values) for values in vars(ends).values()} == {chunk.part.runs}
        plain = all(isinstance(word, str) for word in (*ends.ended, *ends.failed))
        sound = whole and plain and all(type(count) is int for count in (*ends.steps, *ends.evaluations))
    except (ValueError, TypeError):
        sound = False
    if not sound:
        file.unlink(missing_ok=True)
        raise CallFailedError("a part of the ensemble came back damaged")


def run_chunk(chunk: Chunk) -> tuple[BatchResult, RunEnds]:
    """Run copies; one that the compiled loop gives back is run by itself, event and error words included."""
    scene = chunk.part.scene
    breaks_s = tuple(t for p in scene.effects.prescribed_rotation for t in p.breaks_s)
    smooth = np.array(smooth_segments(scene.times_s, breaks_s))
    seen = run_members(batch(chunk.part, chunk.rtol), scene.times_s, smooth)
    ended, failed = [""] * chunk.part.runs, [""] * chunk.part.runs
    for run in np.nonzero(seen.code != ARRIVED)[0]:
        ended[run], failed[run] = run_alone(chunk, int(run), seen)
    return seen, RunEnds(ended, failed, seen.steps.astype(int).tolist(), seen.evaluations.astype(int).tolist())


def run_alone(chunk: Chunk, run: int, seen: BatchResult) -> tuple[str, str]:
    """Run one copy in the engine, write its samples into `seen`, and return how it ended and why it failed."""
    try:
        found = ReferenceFast().run(chunk.part.copy(run), Setting(ReferenceFast.sweep.parameter, chunk.rtol))
    except EngineError as error:
        seen.angle_rad[run], seen.reaction_N[run] = np.nan, np.nan
        return "", str(error)
    assert found.angle_rad is not None
    assert found.reaction_N is not None
    n = len(found.t_s)
    seen.angle_rad[run, :n], seen.angle_rad[run, n:] = found.angle_rad, np.nan
    seen.reaction_N[run, :n], seen.reaction_N[run, n:] = np.linalg.norm(found.reaction_N, axis=2), np.nan
    seen.steps[run], seen.evaluations[run] = found.info["steps"], found.info["evaluations"]
    return found.ended, ""


@dataclass(frozen=True)
class ChunkFiles:
    """Results of all chunks, in files."""

    ensemble: Ensemble
    files: tuple[tuple[Path, int], ...]
    """Each with its number of runs, in the order of the chunks"""

    def samples(self, first: int = 0, last: int | None = None) -> Array:
        """Columns `first` to `last`, the last left out, of all runs, shape (columns, runs)."""
        every = columns(self.ensemble.scene)
        parts = [
            np.memmap(file, SAMPLES, mode="r", offset=HEAD_B, shape=(every, runs))[first:last]
            for file, runs in self.files
        ]
        return np.concatenate(parts, axis=1)

    def ends(self) -> Iterator[tuple[Chunk, RunEnds]]:
        """Chunks, drawn again, with the ends of their runs."""
        for chunk, (file, _) in zip(chunks(self.ensemble), self.files, strict=True):
            with file.open("rb") as content:
                content.seek(HEAD_B + chunk.bytes)
                yield chunk, RunEnds(**json.loads(content.read()))


FAILED, ENDED, FINISHED = "failed", "ended", "finished"
MOST_SORTED = 2**22
"""Numbers that are sorted together, 32 MB; of more runs, one column at a time"""
RunColumns = dict[str, "Sequence[Any] | np.ndarray"]
"""Columns of the rows of some runs"""


@dataclass
class RunTally:
    """Counts over all runs so far."""

    outcomes: Counter[str] = field(default_factory=Counter)
    evaluations: int = 0
    first_failure: str = ""
    """Number of the first failed run and its reason; empty if none failed"""

    def add(self, rows: RunColumns) -> None:
        """Count rows."""
        self.outcomes.update(rows["outcome"])
        self.evaluations += int(np.sum(rows["evaluations"]))
        if not self.first_failure and FAILED in rows["outcome"]:
            k = list(rows["outcome"]).index(FAILED)
            self.first_failure = f"run {rows['run'][k]}: {rows['reason'][k]}"

    @property
    def failures(self) -> tuple[str, ...]:
        """Number of failed runs with the first reason, in one line; empty if none failed."""
        count, runs = self.outcomes[FAILED], self.outcomes.total()
        return (f"{count} of {runs} runs failed, the first of them {self.first_failure}",) if count else ()


def run_rows(made: ChunkFiles, tally: RunTally) -> Iterator[RunColumns]:
    """Rows of all runs, chunk by chunk; the tally counts them as they are given."""
    for chunk, ends in made.ends():
        rows = run_columns(chunk, ends, made.ensemble.variations)
        tally.add(rows)
        yield rows


def run_columns(chunk: Chunk, ends: RunEnds, variations: Iterable[Variation]) -> RunColumns:
    """Rows of the runs of a chunk."""
    found: RunColumns = {"run": np.arange(chunk.first + 1, chunk.first + chunk.part.runs + 1)}
    for v in variations:
        found |= drawn_columns(chunk.part, v)
    pairs = list(zip(ends.ended, ends.failed, strict=True))
    found["outcome"] = [FAILED if failed else ENDED if ended else FINISHED for ended, failed in pairs]
    found["reason"] = [failed or ended for ended, failed in pairs]
    found["steps"], found["evaluations"] = np.array(ends.steps), np.array(ends.evaluations)
    return found


def drawn_columns(population: Population, v: Variation) -> dict[str, Array]:
    """Columns of the values that one variation drew, in the units it was given in."""
    name = v.key.replace("_deg", "_rad")
    values = np.degrees(getattr(population, name)) if v.key.endswith("_deg") else getattr(population, name)
    if values.ndim == 1:
        return {v.key: values}
    if v.bar is None:
        return {v.key: values[:, 0]}
    bars = range(1, values.shape[1] + 1) if v.bar == 0 else [v.bar]
    return {f"{v.key}[{bar}]": values[:, bar - 1] for bar in bars}


def run_table(parts: Iterable[RunColumns]) -> pd.DataFrame:
    """Rows of several chunks as one table."""
    given = list(parts)
    return pd.DataFrame({name: np.concatenate([np.asarray(part[name]) for part in given]) for name in given[0]})


def quantile_table(made: ChunkFiles) -> pd.DataFrame:
    """Quantiles of the angles and of the sizes of the reactions, as a tidy table."""
    ensemble = made.ensemble
    value, reached = exact_quantiles(made)
    angles = ensemble.scene.run.samples * ensemble.scene.bars
    attitude = tidy(ensemble, "attitude", "rad", value[:, :angles], reached[:angles])
    if ensemble.scene.bars == 1:
        return attitude
    return pd.concat(
        [attitude, tidy(ensemble, "reaction", "N", value[:, angles:], reached[angles:])], ignore_index=True
    )


def exact_quantiles(made: ChunkFiles) -> tuple[Array, np.ndarray]:
    """Quantiles over the runs of each column, by NumPy's linear definition, and the number of runs that reached it.

    Returns
    -------
    ndarray, shape (quantiles, columns)
        NaN in a column that no run reached.
    ndarray, shape (columns,)
    """
    wanted, count, runs = made.ensemble.quantiles, columns(made.ensemble.scene), made.ensemble.runs
    found, reached = np.full((len(wanted), count), np.nan), np.empty(count, np.int64)
    together = max(1, MOST_SORTED // runs)
    for first in range(0, count, together):
        block = made.samples(first, first + together)
        here = runs - np.isnan(block).sum(axis=1)
        whole = here == runs
        reached[first : first + together] = here
        found[:, first + np.nonzero(whole)[0]] = np.quantile(block[whole], wanted, axis=1)
        for k in np.nonzero(~whole & (here > 0))[0]:
            found[:, first + k] = np.nanquantile(block[k], wanted)
    return found, reached


def tidy(ensemble: Ensemble, quantity: str, unit: str, value: Array, reached: np.ndarray) -> pd.DataFrame:
    """Quantiles of one quantity as a tidy table; columns go item by item of each instant."""
    n = ensemble.scene.run.samples
    shape = (len(ensemble.quantiles), n, value.shape[1] // n)
    return pd.DataFrame(
        {
            "t_s": np.broadcast_to(ensemble.scene.times_s[:, None], shape).ravel(),
            "quantity": quantity,
            "item": np.broadcast_to(np.arange(1, shape[2] + 1), shape).ravel(),
            "quantile": np.broadcast_to(np.asarray(ensemble.quantiles)[:, None, None], shape).ravel(),
            "value": value.ravel(),
            "unit": unit,
            "runs": np.broadcast_to(reached, value.shape).ravel(),
        }
    )
