"""`barchain engines`: the engines, and how to get those that are missing."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.options import json_option
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.registry import Registration

HEADINGS = ("engine", "version", "default set", "setting", "what")


@click.command(short_help="List the engines, and how to install missing ones.")
@click.option("--installed/--missing", default=None, help="List only engines that are installed, or only missing ones.")
@json_option
def engines(installed: bool | None, as_json: bool) -> None:
    """List the engines with version and default setting, and how to get missing ones."""
    from adapters import registry  # noqa: PLC0415

    wanted = {n: r for n, r in registry.engines().items() if installed is None or installed is (not r.missing)}
    if as_json:
        say(json.dumps(list(facts(wanted)), indent=2))
    else:
        show_engines(wanted)


def facts(registered: Mapping[str, Registration]) -> Iterable[dict[str, Any]]:
    """Facts of each engine; "fault" says why its adapter does not load."""
    for name, r in registered.items():
        known = {
            "name": name, "installed": not r.missing, "version": None if r.missing else r.version,
            "default": r.by_default, "independent_physics": r.external, "missing": r.missing,
            "install": r.remedy or None,
        }  # fmt: skip
        yield known | ({} if r.missing else of_class(r))


def of_class(registration: Registration) -> dict[str, Any]:
    """Declarations of an engine's class."""
    from barchain.runs.declared import engine_class, engine_fault  # noqa: PLC0415

    try:
        loaded = engine_class(registration)
    except Exception as error:  # an adapter of a third party may raise anything
        return {"fault": engine_fault(error)}
    return {
        "title": loaded.title,
        "setting": str(loaded.sweep.setting()),
        "coordinates": str(loaded.coordinates),
        "effects": sorted(map(str, loaded.effects)),
    }


def show_engines(registered: Mapping[str, Registration]) -> None:
    """Print name, version, default, setting and title of each engine, or how to get it."""
    from barchain.cli.common.terminal import show_rows  # noqa: PLC0415

    show_rows(HEADINGS, [row(known) for known in facts(registered)])


def row(known: Mapping[str, Any]) -> tuple[str, ...]:
    """Cells of an engine."""
    from reports.text.numerals import unpadded  # noqa: PLC0415

    default = "yes" if known["default"] else ""
    words = known["missing"] or known.get("fault") or known["title"]
    return known["name"], known["version"] or "missing", default, unpadded(known.get("setting", "")), words
