"""What a run happened on: versions, processor, date."""

from __future__ import annotations

import datetime
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = (
    "numpy", "scipy", "pandas", "pyarrow", "numba", "exudyn", "rebound", "pymunk", "heyoka", "mujoco", "pin",
    "scikit-sundae",
)  # fmt: skip


def environment() -> dict[str, object]:
    """Python, platform, processor and its cores."""
    return {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
    }


def processor() -> str:
    """Model name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def packages() -> dict[str, str]:
    """Versions of the packages that decide the numbers."""
    return {name: package_version(name) for name in PACKAGES}


def package_version(name: str) -> str:
    """Installed version of a distribution."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def now() -> str:
    """Date and time, to the second, with the offset from UTC."""
    return datetime.datetime.now().astimezone().isoformat(timespec="seconds")
