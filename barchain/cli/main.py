"""Command line: all commands in sections, standard streams, and the exit code that each command ends with.

A stream that is closed or full costs the output, not the runs (:func:`barchain.cli.common.terminal.say`).
"""

from __future__ import annotations

import os
import select
import sys
import traceback
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.certified import certified_solutions
from barchain.cli.common.exit_codes import ExitCode, failure
from barchain.cli.common.progress import choose_verbosity, verbose
from barchain.cli.common.terminal import plain, say
from barchain.cli.compare import compare, crossval
from barchain.cli.conform import conform
from barchain.cli.doctor import doctor
from barchain.cli.engines import engines, new_engine
from barchain.cli.explain import explain
from barchain.cli.export import export
from barchain.cli.judge import judge
from barchain.cli.nightly.attribute import attribute_night, bisect_figure
from barchain.cli.nightly.gate import gate
from barchain.cli.nightly.history import history
from barchain.cli.nightly.nightly import nightly
from barchain.cli.nightly.releases import releases
from barchain.cli.plot import plot
from barchain.cli.scenes import scenes, schema, validate
from barchain.cli.selftest import selftest
from barchain.cli.show import report, show
from barchain.cli.simulate import simulate
from barchain.cli.studies import cost, effects, ensemble, roundoff, scaling, stability, sweep
from barchain.runs.environment import fill_standard_streams

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

WHOLE = 1000  # characters: enough never to cut a sentence off
MOST_LINE = 4000  # characters of a line on standard error; the list of all scenes has 2000
MOST_SHOWN = 60  # characters of an argument that is shown

SECTIONS = {
    "Run and compare": (scenes, engines, simulate, plot, compare, crossval, judge, show, report, explain, doctor),
    "Studies": (cost, scaling, roundoff, stability, effects, selftest, ensemble, sweep),
    "Nights": (nightly, gate, history, attribute_night, bisect_figure, releases),
    "Scenes and engines of your own": (validate, schema, export, certified_solutions, new_engine, conform),
}


COMPLETION = "_BARCHAIN_COMPLETE"
"""Environment variable by which a shell asks for completions; click ends the process itself then"""


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
        """Write each section with its commands and their short help, without blank lines: the help fits a screen."""
        formatter.write_paragraph()
        width = max(map(len, self.commands))
        for title, commands in self.sections.items():
            formatter.write_heading(title)
            for command in commands:
                formatter.write(f"  {command.name:<{width}}  {command.get_short_help_str(WHOLE)}\n")


def main() -> None:
    """Entry point: every fault ends in one readable line and an exit code of its own, but for barchain's own faults."""
    fill_standard_streams()
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123, SIM115  # to the end
    try:
        code = run(sys.argv[1:])
    except BaseException as error:
        if isinstance(error, SystemExit) and COMPLETION in os.environ:
            raise
        traceback.print_exc()
        code = ExitCode.INTERNAL_ERROR
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # full, or without a reader: what is left goes nowhere, and ends nothing
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    sys.exit(code)


def run(arguments: list[str]) -> int:
    """Exit code of a command line; 0 only of a command that came to its own end."""
    wrong = hidden_argument(arguments)
    if wrong:
        return complain(wrong, ExitCode.BAD_INPUT)
    try:
        return cli.main(arguments, prog_name="barchain", standalone_mode=False) or ExitCode.OK
    except (click.Abort, KeyboardInterrupt):
        return complain(f"interrupted{kept_words(arguments)}", ExitCode.INTERRUPTED)
    except SystemExit as ended:
        if COMPLETION in os.environ:
            raise
        if isinstance(ended.__context__, BrokenPipeError) or output_is_unread():  # Rich and click ask for the end then
            return ExitCode.UNREAD
        raise RuntimeError(f"something inside asked the process to end with {ended.code!r}") from ended
    except Exception as error:
        try:
            known = failure(error)
        except (MemoryError, ImportError) as scarce:  # while the kinds of errors were imported
            known = failure(scarce)
        if known is None:
            raise
        if verbose():
            traceback.print_exc()
        return complain(*known)


def output_is_unread() -> bool:
    """Whether the reader at the other end of the command's output has ended."""
    if not hasattr(select, "poll"):
        return False
    asked = select.poll()
    asked.register(1, select.POLLOUT)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in asked.poll(0))


def kept_words(arguments: list[str]) -> str:
    """What is left of an interrupted command; empty of a command that keeps no results."""
    command = next((cli.commands[a] for a in arguments if a in cli.commands), None)
    options = {p.name for p in command.params} if command is not None else set()
    if "resume" in options:
        return "; results so far are kept, `barchain report` shows them, and --resume goes on from them"
    return "; results so far are kept" if options & {"out", "history"} else ""


def complain(message: str, code: ExitCode) -> ExitCode:
    """Print one line for each fault to standard error, and return the exit code."""
    for line in message.split("\n"):
        say(f"barchain: {line if len(line) <= MOST_LINE else line[: MOST_LINE - 3] + '...'}", err=True)
    return code


def hidden_argument(arguments: list[str]) -> str:
    """Why an argument is no text; empty if all are. A message repeats what was given, and is one line."""
    for k, given in enumerate(arguments, start=1):
        if not given.isprintable() and plain(given, but="") != given:
            shown = plain(given[:MOST_SHOWN], but="")
            return f"argument {k}: {shown} given, allowed: text without control characters and invisible characters"
    return ""


@click.group(
    cls=SectionedGroup,
    sections=SECTIONS,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.option("-q", "--quiet", is_flag=True, help="Print no progress and no notes.")
@click.option("-v", "--verbose", "talkative", is_flag=True, help="Print every verdict, and the traceback of an error.")
@click.version_option(package_name="barchain")
@click.pass_context
def cli(ctx: click.Context, quiet: bool, talkative: bool) -> None:
    """Cross-validate multibody engines on a chain of rigid bars in orbit."""
    choose_verbosity(int(talkative) - int(quiet))
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
