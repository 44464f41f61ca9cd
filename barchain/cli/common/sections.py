"""A click group whose help shows its commands in titled sections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


WHOLE = 1000  # characters: enough never to cut a sentence off


class SectionedGroup(click.Group):
    """Group of commands that its help lists section by section, in the given order."""

    def __init__(self, *args: Any, sections: Mapping[str, Sequence[click.Command]], **kwargs: Any) -> None:
        """Take the commands of all sections."""
        super().__init__(*args, **kwargs)
        self.sections = sections
        for command in (c for commands in sections.values() for c in commands):
            self.add_command(command)

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  # click's own signature
        """Names of the commands in the order of the sections."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write each section with its commands and the first sentence of their help."""
        for title, commands in self.sections.items():
            with formatter.section(title):
                formatter.write_dl([(str(c.name), c.get_short_help_str(WHOLE)) for c in commands])
