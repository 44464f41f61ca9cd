"""Environment of a run: versions, processor, date."""

from __future__ import annotations

import datetime
import os
import platform
import shlex
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.registry import Registration

PACKAGES = (
    "numpy", "scipy", "pandas", "pyarrow", "exudyn", "rebound", "pymunk", "heyoka", "mujoco", "pin",
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
    """Model name of the processor, or its architecture."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def machine() -> dict[str, str]:
    """Kernel, libraries and instruction sets, for the history of nights; a text is empty where it is unknown."""
    return {
        "architecture": platform.machine(),
        "kernel": f"{platform.system()} {platform.release()}".strip(),
        "libc": " ".join(platform.libc_ver()).strip(),
        "cpu_flags": cpu_flags(),
        "blas": blas(),
    }


def cpu_flags() -> str:
    """Instruction sets of the processor, in order."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    found = [line.partition(":")[2].split() for line in lines if line.startswith(("flags", "Features"))]
    return " ".join(sorted(set(found[0]))) if found else ""


def blas() -> str:
    """Libraries of linear algebra behind NumPy and SciPy; each with its version and its code for this processor.

    A library that a wheel brings along has the wheel's name in brackets. Empty without threadpoolctl, of the extra
    `nightly`.
    """
    try:
        from threadpoolctl import threadpool_info  # noqa: PLC0415
    except ImportError:
        return ""
    import numpy as np  # noqa: F401, PLC0415
    import scipy.linalg  # noqa: F401, PLC0415  # loads its own

    found = [of for of in threadpool_info() if of.get("user_api") == "blas"]
    own = [of for of in found if wheel_of(of)]  # engines bring along others, in a process that has loaded them
    return ", ".join(sorted({library_words(of) for of in own or found}))


def wheel_of(library: Mapping[str, Any]) -> str:
    """Wheel of NumPy or SciPy that a library of linear algebra lies in; empty for any other place."""
    folders = Path(str(library.get("filepath") or "")).parts
    return next((name for name in ("numpy", "scipy") if {name, f"{name}.libs"} & set(folders)), "")


def library_words(library: Mapping[str, Any]) -> str:
    """Name, version, code for this processor, and the wheel that a library of linear algebra lies in."""
    words = [str(library.get(key) or "") for key in ("internal_api", "version", "architecture")]
    wheel = wheel_of(library)
    return " ".join(word for word in (*words, f"({wheel})" if wheel else "") if word)


def packages() -> dict[str, str]:
    """Versions of the packages that results depend on."""
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


def typed() -> str:
    """Command line of this process, for records."""
    return shlex.join(["barchain", *sys.argv[1:]])


def provenance(command: str, extra: dict[str, str] | None = None) -> dict[str, Any]:
    """Beginning of every record, before the first run: schema version, command, date, environment and packages.

    Parameters
    ----------
    command : str
        Command line that started the study; empty from Python.
    extra : dict of str, optional
        Versions of further packages by name.
    """
    from reports.results.schema import KEY, SCHEMA_VERSION  # noqa: PLC0415  # worker processes ask for versions alone

    return {
        KEY: SCHEMA_VERSION,
        "barchain": package_version("barchain"),
        "created": now(),
        "complete": False,
        "finished": False,
        "command": command,
        "seconds": 0.0,
        "environment": environment(),
        "machine": machine(),
        "packages": packages() | (extra or {}),
    }


def external_versions(engines: Mapping[str, Registration]) -> dict[str, str]:
    """Versions of the distributions that the engines require."""
    return {name: r.version for r in engines.values() if (name := r.requires or r.distribution)}
