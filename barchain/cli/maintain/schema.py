"""`barchain schema`: the JSON Schemas of barchain's files."""

from __future__ import annotations

import json

import click

from barchain.cli.common.terminal import say

FILES = ("scene", "request", "result", "engines", "plan", "nightly")


@click.command(short_help="Print the JSON Schema of a kind of file.")
@click.argument("file", type=click.Choice(FILES), default=FILES[0])
def schema(file: str) -> None:
    """Print the JSON Schema of a kind of file; default: a scene file.

    A program in any language reads a request and writes a result; engines.toml names such programs.
    """
    say(json.dumps(schema_of(file), indent=2))


def schema_of(file: str) -> dict[str, object]:
    """JSON Schema of a kind of file."""
    # ruff: noqa: PLC0415  # each kind has its own imports
    if file == "plan":
        from barchain.nightly.plan.tables import PlanFile

        return PlanFile.model_json_schema()
    if file == "nightly":
        from reports.tables.nights.facts import NightlyFile

        return NightlyFile.model_json_schema()
    if file == "request":
        from adapters.request import request_schema

        return request_schema()
    if file == "result":
        from adapters.request import result_schema

        return result_schema()
    if file == "engines":
        from adapters.command.entries import EngineFile

        return EngineFile.model_json_schema()
    from scenarios import SceneFile

    return SceneFile.model_json_schema()
