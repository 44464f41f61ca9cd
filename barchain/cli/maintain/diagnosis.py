"""State of an installation: versions, engines, machine, compiled kernel, tables of certified solutions."""

from __future__ import annotations

import os
import platform
import sys
from typing import TYPE_CHECKING, Any

from adapters.registry import engines
from barchain.cli.run.engines import facts
from barchain.record.environment import environment, package_version, packages
from barchain.solutions import certified_table
from barchain.solutions.certified import cache_folder
from barchain.solutions.certified_table import DamagedTableError, physics_digest, read_table
from reference_impl.kernel import build
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

GIGA = 1e9


def diagnosis() -> dict[str, Any]:
    """Everything that `barchain doctor` tells, as JSON can hold it."""
    return {
        "barchain": package_version("barchain"),
        "python": platform.python_version(),
        "executable": sys.executable,
        "machine": environment() | memory(),
        "packages": packages(),
        "engines": list(facts(engines())),
        "kernel": kernel(),
        "certified_solutions": solution_tables(),
    }


def memory() -> dict[str, float | None]:
    """Memory of the machine and its available part, GB; None where the system does not tell."""
    try:
        page = os.sysconf("SC_PAGE_SIZE")
        total, free = (page * os.sysconf(name) / GIGA for name in ("SC_PHYS_PAGES", "SC_AVPHYS_PAGES"))
    except (AttributeError, ValueError, OSError):  # Windows has no sysconf, macOS not all names
        return {"memory_GB": None, "available_GB": None}
    return {"memory_GB": total, "available_GB": free}


def kernel() -> dict[str, Any]:
    """Library of the compiled reference, the level of this processor, and the C compiler; or why there is none."""
    reason, command = build.why_missing(), build.compiler()
    return {
        "missing": reason or None,
        "library": None if reason else str(build.library_file()),
        "level": build.best_level(),
        "compiler": " ".join(command) if command else None,
    }


def solution_tables() -> dict[str, Any]:
    """Folders of certified solutions, how many scenes have one, and the fault of each table that has one."""
    folder, names = certified_table.CERTIFIED_SOLUTIONS, scene_names()
    tables = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.csv"))}
    found = {name: table_fault(name, path) for name, path in tables.items() if name in names}
    return {
        "folder": str(folder),
        "cache": str(cache_folder()),
        "scenes": len(names),
        "tables": len(found),
        "faults": {name: fault for name, fault in found.items() if fault},
    }


def table_fault(name: str, path: Path) -> str:
    """Why the table of a scene can't be used; empty if it can."""
    try:
        kept = read_table(path)
    except DamagedTableError as error:
        return str(error)
    return "" if kept.physics == physics_digest(load_scene(name)) else "made for other values of the scene"


def faults(found: Mapping[str, Any]) -> list[str]:
    """Faults of an installation, one line each; an engine that is not installed is no fault."""
    loaded = [f"{e['name']}: {e['fault']}" for e in found["engines"] if "fault" in e]
    return loaded + [f"table of {name}: {fault}" for name, fault in found["certified_solutions"]["faults"].items()]
