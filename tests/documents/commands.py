"""Command lines in the documents, parsed by click's own objects; nothing runs."""

from __future__ import annotations

import itertools
import re
import shlex

import click

from barchain.cli.main import cli

OPTION = re.compile(r"(?<![\w-])--?[a-z][a-z-]*")


def fault(words: str, *, whole: bool) -> str:
    """Reason why a command line can't be typed; empty if it can be.

    Parameters
    ----------
    words
        What follows ``barchain``.
    whole
        Whether all arguments are there. Otherwise only the command's and the options' names are checked.
    """
    tokens = after_flags(words.split())
    command, context = descend(tokens)
    if tokens and command is cli and not tokens[0].startswith("-"):
        return f"there is no command {tokens[0]}"
    known = {name for each in command.get_params(context) for name in (*each.opts, *each.secondary_opts)}
    unknown = [name for name in OPTION.findall(" ".join(tokens)) if name not in known]
    if unknown:
        return f"no option {', '.join(unknown)}; there are: {', '.join(sorted(known))}"
    return complaint(words) if whole else ""


def options(command: click.Command = cli) -> set[str]:
    """Long options of a command and of all commands below it."""
    context = click.Context(command)
    found = {name for each in command.get_params(context) for name in (*each.opts, *each.secondary_opts)}
    if isinstance(command, click.Group):
        below = (command.get_command(context, name) for name in command.list_commands(context))
        found = found.union(*(options(each) for each in below if each is not None))
    return {name for name in found if name.startswith("--")}


def descend(tokens: list[str]) -> tuple[click.Command, click.Context]:
    """Innermost command that leading words name, and its context."""
    command: click.Command = cli
    context = click.Context(cli, info_name="barchain")
    for token in tokens:
        below = command.get_command(context, token) if isinstance(command, click.Group) else None
        if below is None:
            break
        command, context = below, click.Context(below, parent=context, info_name=token)
    return command, context


def after_flags(tokens: list[str]) -> list[str]:
    """Words without the leading flags of barchain itself, if a command follows them."""
    flags = {name for each in cli.params if isinstance(each, click.Option) and each.is_flag for name in each.opts}
    rest = [*itertools.dropwhile(flags.__contains__, tokens)]
    return rest or tokens


def complaint(words: str) -> str:
    """Message of the error that parsing a whole command line ends with; empty if it parses."""
    tokens = after_flags(shlex.split(words))
    command, context = descend(tokens)
    depth = len(context.command_path.split()) - 1
    try:
        command.make_context(command.name, tokens[depth:], parent=context.parent)
    except click.exceptions.Exit:  # --help and --version are done at once
        return ""
    except click.ClickException as error:
        return error.format_message()
    return ""
