"""Command `doctor`: what an installation has, and what it lacks."""

from __future__ import annotations

import json
import platform
import sys
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.options import json_option
from barchain.cli.common.terminal import say, show_rows
from barchain.cli.engines import facts

if TYPE_CHECKING:
    from collections.abc import Mapping

GIGA = 1e9


@click.command(short_help="Check the installation.")
@json_option
def doctor(as_json: bool) -> None:
    """Check the installation: versions, engines, compiled kernel, cores, memory and tables.

    Prints the command that gets each missing engine. Exits with 1 if an installed engine does not load, or if a table
    of a certified solution is damaged or out of date.
    """
    found = diagnosis()
    wrong = faults(found)
    if as_json:
        say(json.dumps(found | {"faults": wrong}, indent=2))
    else:
        show(found, wrong)
    if wrong:
        raise findings()


def diagnosis() -> dict[str, Any]:
    """Everything that the command tells, as JSON can hold it."""
    import psutil

    from adapters.registry import engines
    from barchain.record.environment import environment, package_version, packages

    memory = psutil.virtual_memory()
    return {
        "barchain": package_version("barchain"),
        "python": platform.python_version(),
        "executable": sys.executable,
        "machine": environment() | {"memory_GB": memory.total / GIGA, "available_GB": memory.available / GIGA},
        "packages": packages(),
        "engines": list(facts(engines())),
        "kernel": kernel(),
        "certified_solutions": solution_tables(),
    }


def kernel() -> dict[str, Any]:
    """Library of the compiled reference, the level of this processor, and the C compiler; or why there is none."""
    from reference_impl.kernel import build

    reason, command = build.why_missing(), build.compiler()
    return {
        "missing": reason or None,
        "library": None if reason else str(build.library_file()),
        "level": build.best_level(),
        "compiler": " ".join(command) if command else None,
    }


def solution_tables() -> dict[str, Any]:
    """Folders of certified solutions, how many scenes have one, and the fault of each table that has one."""
    from barchain.solutions import certified_file
    from barchain.solutions.certified import cache_folder
    from scenarios import load_scene, scene_names

    def fault(name: str) -> str:
        try:
            head, _ = certified_file.read_file(tables[name])
        except certified_file.DamagedTableError as error:
            return str(error)
        same = head["physics"] == certified_file.physics_digest(load_scene(name))
        return "" if same else "made for other values of the scene"

    folder, names = certified_file.CERTIFIED_SOLUTIONS, scene_names()
    every = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.parquet"))}
    tables = {name: path for name, path in every.items() if name in names}
    return {
        "folder": str(folder),
        "cache": str(cache_folder()),
        "scenes": len(names),
        "tables": len(tables),
        "faults": {name: said for name in tables if (said := fault(name))},
    }


def faults(found: Mapping[str, Any]) -> list[str]:
    """Faults of an installation, one line each; an engine that is not installed is no fault."""
    loaded = [f"{e['name']}: {e['fault']}" for e in found["engines"] if "fault" in e]
    return loaded + [f"table of {name}: {fault}" for name, fault in found["certified_solutions"]["faults"].items()]


def show(found: Mapping[str, Any], wrong: list[str]) -> None:
    """Print versions, machine, compiled kernel, certified solutions, engines, and what is wrong or missing."""
    machine, compiled, tables = found["machine"], found["kernel"], found["certified_solutions"]
    library = compiled["missing"] or f"for {compiled['level']}, {compiled['library']}"
    whole = f"{tables['tables']} tables, {len(tables['faults'])} faulty, for {tables['scenes']} scenes,"
    say(f"barchain        {found['barchain']}")
    say(f"Python          {found['python']} ({found['executable']})")
    say(f"platform        {machine['platform']}")
    say(f"processor       {machine['cpu']}, {machine['cores']} cores")
    say(f"memory          {machine['memory_GB']:.1f} GB, {machine['available_GB']:.1f} GB available")
    say(f"kernel          {library}")
    say(f"solutions       {whole} in {tables['folder']}; computed ones are kept in {tables['cache']}")
    missing: dict[str, list[str]] = {}
    rows = []
    for engine in found["engines"]:
        state = engine.get("fault", "ready") if engine["installed"] else f"get it: {engine['install']}"
        rows.append((engine["name"], engine["version"] or "missing", state))
        if not engine["installed"]:
            missing.setdefault(engine["install"], []).append(engine["name"])
    show_rows(("engine", "version", "state"), rows)
    for fault in wrong:
        say(f"fault: {fault}")
    said = "; ".join(f"{', '.join(names)}: {command}" for command, names in missing.items())
    say(f"missing engines: {said or 'none'}")
