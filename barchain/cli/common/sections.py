"""A click group whose help shows its commands in titled sections."""

from __future__ import annotations

import copy
import functools
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence


WHOLE = 1000  # characters: enough never to cut a sentence off


class EndedEarlyError(RuntimeError):
    """Raised for a command that something inside it ended: its exit code says nothing of the command."""


def to_its_end(body: Callable[..., Any]) -> Callable[..., Any]:
    """Body of a command that can't be left with exit code 0 but at its end."""

    @functools.wraps(body)
    def guarded(*args: Any, **options: Any) -> Any:
        try:
            return body(*args, **options)
        except click.exceptions.Exit as ended:
            if ended.exit_code == ExitCode.OK:
                raise EndedEarlyError("something inside asked the command to end with 0") from ended
            raise

    return guarded


def guarded_command(command: click.Command) -> click.Command:
    """Command whose body is :func:`to_its_end`."""
    made = copy.copy(command)
    if command.callback is not None:
        made.callback = to_its_end(command.callback)
    return made


class SectionedGroup(click.Group):
    """Group of commands that its help lists section by section, in the given order."""

    def __init__(self, *args: Any, sections: Mapping[str, Sequence[click.Command]], **kwargs: Any) -> None:
        """Take the commands of all sections."""
        super().__init__(*args, **kwargs)
        self.sections = sections
        for command in (c for commands in sections.values() for c in commands):
            self.add_command(command)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Command of a command line; `--help` ends a command before its body begins, and may end with 0."""
        name, found, rest = super().resolve_command(ctx, args)
        return name, found and guarded_command(found), rest

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  # click's own signature
        """Names of the commands in the order of the sections."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write each section with its commands and their short help, without blank lines: the help fits a screen."""
        formatter.write_paragraph()
        width = max(map(len, self.commands))
        for title, commands in self.sections.items():
            formatter.write_heading(title)
            for command in commands:
                formatter.write(f"  {command.name:<{width}}  {command.get_short_help_str(WHOLE)}\n")
