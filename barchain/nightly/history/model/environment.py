"""Environment of a night: of this process, or of a result folder's record."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.nightly.history.model.figures import Environment
from barchain.record.environment import environment, machine

if TYPE_CHECKING:
    from collections.abc import Mapping

LIBC = "-with-"
"""Stands before the C library in the platform's name"""


def capture() -> Environment:
    """Environment of this process."""
    return environment_from(environment(), machine())


def recorded_environment(record: Mapping[str, Any]) -> Environment:
    """Environment of a record; earlier records know the kernel and the C library by the platform's name only."""
    own = record.get("environment") or {}
    platform = str(own.get("platform") or "")
    kernel, _, libc = platform.partition(LIBC)
    earlier = {"kernel": kernel, "libc": libc.replace("glibc", "glibc ")}
    return environment_from(own, earlier | dict(record.get("machine") or {}))


def environment_from(own: Mapping[str, Any], below: Mapping[str, Any]) -> Environment:
    """Environment from the entries of a record."""
    text = {name: str(below.get(name) or "") for name in ("cpu_flags", "architecture", "kernel", "libc", "blas")}
    return Environment(
        cpu=str(own.get("cpu") or ""), cores=int(own.get("cores") or 0), python=str(own.get("python") or ""), **text
    )
