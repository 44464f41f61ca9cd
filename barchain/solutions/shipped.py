"""Certified solutions that come with barchain: one Parquet file a scene with all that a verdict needs.

A file has a row for each dense sample (:func:`barchain.solutions.reference.densely_sampled`). Its columns are those of
a trajectory (`adapters.trajectory`), in double precision. At the scene's own samples it also has, in single precision,
``amplification``, and ``error_q`` and ``response_q`` for each quantity q. Error bars are rounded up, so that they stay
bounds. Attributes give the scene and the runs; a checksum over attributes and columns detects a damaged file.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
from functools import cache as remembered
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.trajectory import ENDED, Trajectory, from_frame, to_frame
from barchain.solutions.certified_table import CERTIFIED_SOLUTIONS, DamagedTableError
from barchain.solutions.reference import ReferenceSolution, SolutionSource
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array
    from scenarios import Scene

ERROR, RESPONSE, AMPLIFICATION = "error_", "response_", "amplification"
CHECKSUM = "checksum"
Head = dict[str, Any]


def shipped_solution(scene: Scene) -> ReferenceSolution | None:
    """Certified solution that comes with barchain for these physics and samples; None if there is none.

    Raises
    ------
    DamagedTableError
        If the file differs from its checksum.
    """
    path = shipped_files().get(scene.digest)
    return None if path is None else dataclasses.replace(read_solution(path, scene), source=SolutionSource.SHIPPED)


@remembered
def shipped_files() -> dict[str, Path]:
    """Files by digest of their scenes, samples included."""
    return {head_of(path)["digest"]: path for path in sorted(CERTIFIED_SOLUTIONS.rglob("*.parquet"))}


def shipped_path(name: str, folder: Path = CERTIFIED_SOLUTIONS) -> Path:
    """File of a scene's solution in a folder."""
    return folder / f"{name}.parquet"


def write_solution(path: Path, solution: ReferenceSolution) -> None:
    """Write a solution and make its folder; an interruption leaves no partial file."""
    frame = to_frame(solution.fine)
    fine, own = len(frame), len(solution.amplification)
    every = stride(solution)
    for name, values in judged_columns(solution).items():
        column = np.full(fine, np.nan, np.float32)
        column[: own * every : every] = values
        frame[name] = column
    head: Head = {
        "scene": solution.scene.name,
        "digest": solution.scene.digest,
        "setting": solution.setting,
        "samples": own,
        "every": every,
        "limit_s": solution.limit_s,
        "ended": solution.fine.ended,
        ENDED: solution.fine.info.get(ENDED),
    }
    frame.attrs.update(head | {CHECKSUM: checksum(head, frame)})
    path.parent.mkdir(parents=True, exist_ok=True)
    sink = io.BytesIO()
    frame.to_parquet(
        sink, index=False, compression="zstd", compression_level=19, use_dictionary=False, use_byte_stream_split=True,
        write_statistics=False,
    )  # fmt: skip
    write_atomically(path, sink.getvalue())
    shipped_files.cache_clear()  # the folder may be that of the shipped solutions


def stride(solution: ReferenceSolution) -> int:
    """Dense samples from one own sample to the next."""
    own = solution.trajectory.t_s
    return int(np.searchsorted(solution.fine.t_s, own[1])) if len(own) > 1 else 1


def judged_columns(solution: ReferenceSolution) -> dict[str, Array]:
    """Columns at the scene's own samples, (n,) each, rounded up to single precision."""
    found = {AMPLIFICATION: solution.amplification}
    found |= {ERROR + name: values for name, values in solution.error.items()}
    found |= {RESPONSE + name: values for name, values in solution.response.items()}
    n = len(solution.amplification)
    return {name: rounded_up(values[:n]) for name, values in found.items()}


def rounded_up(values: Array) -> Any:
    """Values in single precision, none smaller than before; zero stays zero."""
    near = values.astype(np.float32)
    return np.where(near < values, np.nextafter(near, np.float32(np.inf)), near)


def checksum(head: Head, frame: pd.DataFrame) -> str:
    """Hash of attributes, and of every column's name and numbers."""
    found = hashlib.sha256(json.dumps(head, sort_keys=True).encode())
    for name in frame.columns:
        found.update(str(name).encode())
        found.update(np.ascontiguousarray(frame[name].to_numpy()).tobytes())
    return found.hexdigest()[:16]


def head_of(path: Path) -> Head:
    """Attributes of a file, without its columns.

    Raises
    ------
    DamagedTableError
        If it has none.
    """
    import pyarrow.parquet as pq  # noqa: PLC0415  # takes long to import

    try:
        found: Head = json.loads(pq.read_schema(path).metadata[b"PANDAS_ATTRS"])
        found["digest"], found[CHECKSUM]
    except Exception as error:  # Arrow's errors have several bases
        raise DamagedTableError(f"{path}: not a certified solution") from error
    return found


def read_solution(path: Path, scene: Scene) -> ReferenceSolution:
    """Read the solution of a scene.

    Raises
    ------
    DamagedTableError
        If the file is no such solution, or differs from its checksum.
    """
    try:
        frame = pd.read_parquet(path)
    except Exception as error:  # Arrow's errors have several bases
        raise DamagedTableError(f"{path}: not a certified solution") from error
    head: Head = {str(key): value for key, value in frame.attrs.items()}
    said = head.pop(CHECKSUM, None)
    if said != checksum(head, frame):
        raise DamagedTableError(f"{path}: its numbers differ from their checksum")
    fine = fine_of(frame, head)
    own = slice(0, head["samples"] * head["every"], head["every"])
    values = {str(name): frame[name].to_numpy(float)[own] for name in frame.columns}

    def group(prefix: str) -> dict[str, Array]:
        return {name.removeprefix(prefix): v for name, v in values.items() if name.startswith(prefix)}

    return ReferenceSolution(
        scene,
        fine.samples(slice(None, None, head["every"])),
        fine,
        group(ERROR),
        values[AMPLIFICATION],
        group(RESPONSE),
        head["limit_s"],
        setting=head["setting"],
    )


def fine_of(frame: pd.DataFrame, head: Head) -> Trajectory:
    """Dense samples of a file."""
    seen = dataclasses.replace(from_frame(frame, ended=head["ended"]), gap_m=None)
    if head[ENDED] is not None:
        seen.info[ENDED] = head[ENDED]
    return seen
