"""`barchain doctor`: what an installation has, and what it lacks."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.options import json_option
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


@click.command(short_help="Check the installation.")
@json_option
def doctor(as_json: bool) -> None:
    """Check the installation: versions, engines, compiled kernel, cores, memory and tables.

    Prints the command that gets each missing engine. Exits with 1 if an installed engine does not load, or if a table
    of a certified solution is damaged or out of date.
    """
    from barchain.cli.maintain.diagnosis import diagnosis, faults  # noqa: PLC0415

    found = diagnosis()
    wrong = faults(found)
    if as_json:
        say(json.dumps(found | {"faults": wrong}, indent=2))
    else:
        show(found, wrong)
    if wrong:
        raise findings()


def show(found: Mapping[str, Any], wrong: Iterable[str]) -> None:
    """Print a diagnosis."""
    for line in machine_lines(found):
        say(line)
    show_engines(found["engines"])
    for fault in wrong:
        say(f"fault: {fault}")
    say(f"missing engines: {missing_words(found['engines'])}")


def machine_lines(found: Mapping[str, Any]) -> list[str]:
    """One line each for versions, machine, compiled kernel and certified solutions."""
    machine, kernel, tables = found["machine"], found["kernel"], found["certified_solutions"]
    compiled = kernel["missing"] or f"for {kernel['level']}, {kernel['library']}"
    whole = f"{tables['tables']} tables, {len(tables['faults'])} faulty, for {tables['scenes']} scenes,"
    return [
        f"barchain        {found['barchain']}",
        f"Python          {found['python']} ({found['executable']})",
        f"platform        {machine['platform']}",
        f"processor       {machine['cpu']}, {machine['cores']} cores",
        f"memory          {memory_words(machine)}",
        f"kernel          {compiled}",
        f"solutions       {whole} in {tables['folder']}; computed ones are kept in {tables['cache']}",
    ]


def memory_words(machine: Mapping[str, Any]) -> str:
    """Memory of the machine, as far as the system tells."""
    total, free = machine["memory_GB"], machine["available_GB"]
    return "not known" if total is None else f"{total:.1f} GB, {free:.1f} GB available"


def show_engines(engines: Iterable[Mapping[str, Any]]) -> None:
    """Print name, version and state of each engine."""
    from barchain.cli.common.terminal import show_rows  # noqa: PLC0415

    rows = [(e["name"], e["version"] or "missing", state(e)) for e in engines]
    show_rows(("engine", "version", "state"), rows)


def state(engine: Mapping[str, Any]) -> str:
    """Whether an engine can be used, or what to type to get it."""
    return f"get it: {engine['install']}" if not engine["installed"] else engine.get("fault", "ready")


def missing_words(engines: Iterable[Mapping[str, Any]]) -> str:
    """Commands that bring the missing engines, each with the engines that it brings."""
    by: dict[str, list[str]] = {}
    for engine in engines:
        if not engine["installed"]:
            by.setdefault(engine["install"], []).append(engine["name"])
    return "; ".join(f"{', '.join(names)}: {command}" for command, names in by.items()) or "none"
