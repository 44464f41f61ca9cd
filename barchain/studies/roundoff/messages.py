"""Rows and high-precision solutions as messages between processes: read without running code."""

from __future__ import annotations

import dataclasses
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.message import MessageError, message_bytes, plain_text, read_message
from barchain.studies.roundoff.parts.trajectories import HighPrecisionSolution, solution_of
from reference_impl.precision.coordinates import ChainObservables

if TYPE_CHECKING:
    from barchain.studies.roundoff.parts.trajectories import ScaledScene

Rows = list[dict[str, Any]]
OBSERVABLES = tuple(f.name for f in dataclasses.fields(ChainObservables))
PLAIN = (str, int, float, type(None))


def task_bytes(function: str, arguments: tuple[Any, ...]) -> bytes:
    """Message with a task's rows; the function, ``module:function``, is called here."""
    module, _, name = function.partition(":")
    return message_bytes({"rows": getattr(import_module(module), name)(*arguments)}, {})


def rows_from(content: bytes) -> Rows:
    """Rows of a message.

    Raises
    ------
    MessageError
        If they are no rows of text and numbers.
    """
    rows = read_message(content)[0].get("rows")
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise MessageError("its answer holds no rows")
    for row in rows:
        wrong = next((name for name, value in row.items() if not isinstance(value, PLAIN)), None)
        if wrong is not None:
            raise MessageError(f"{plain_text(wrong)} is a {type(row[wrong]).__name__}, expected text or a number")
    return rows


def solution_bytes(family: ScaledScene) -> bytes:
    """Message with a high-precision solution, made here; arrays of long doubles."""
    found = solution_of(family)
    seen = {f"{k} {name}": getattr(one, name) for k, one in enumerate(found.seen) for name in OBSERVABLES}
    return message_bytes({}, seen | {f"error {k}": v.astype(np.longdouble) for k, v in found.error.items()})


def solution_from(family: ScaledScene, content: bytes) -> HighPrecisionSolution:
    """High-precision solution of a message.

    Raises
    ------
    MessageError, KeyError
        If a part is missing, or of another type.
    """
    _, arrays = read_message(content, np.longdouble)
    count = sum(name.endswith(OBSERVABLES[0]) for name in arrays)
    seen = tuple(ChainObservables(*(arrays[f"{k} {name}"] for name in OBSERVABLES)) for k in range(count))
    error = {k.removeprefix("error "): v.astype(float) for k, v in arrays.items() if k.startswith("error ")}
    return HighPrecisionSolution(family, seen, error)
