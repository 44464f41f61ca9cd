"""`barchain schema`: the JSON Schema of a scene file."""

from __future__ import annotations

import json

import click

from barchain.cli.common.terminal import say


@click.command()
def schema() -> None:
    """Print the JSON Schema of a scene file, for editors."""
    from scenarios import SceneFile  # noqa: PLC0415

    say(json.dumps(SceneFile.model_json_schema(), indent=2))
