"""Command line: all commands in sections, and the exit code that each command ends with."""

from __future__ import annotations

import os
import select
import sys
import traceback

import click

from barchain.cli.common import verbosity
from barchain.cli.common.exit_codes import ExitCode, failure
from barchain.cli.common.sections import EndedEarlyError, SectionedGroup
from barchain.cli.common.streams import guard_streams, lost_output
from barchain.cli.common.terminal import plain, say
from barchain.cli.conform import conform
from barchain.cli.cost import cost
from barchain.cli.effects import effects
from barchain.cli.ensemble import ensemble
from barchain.cli.maintain.certified import certified_solutions
from barchain.cli.maintain.doctor import doctor
from barchain.cli.maintain.new_engine import new_engine
from barchain.cli.maintain.schema import schema
from barchain.cli.maintain.validate import validate
from barchain.cli.nightly.attribute import attribute_night, bisect_figure
from barchain.cli.nightly.commands import history
from barchain.cli.nightly.nightly import nightly
from barchain.cli.nightly.releases import releases
from barchain.cli.roundoff import roundoff
from barchain.cli.run.compare import compare, crossval
from barchain.cli.run.engines import engines
from barchain.cli.run.report import report
from barchain.cli.run.scenes import scenes
from barchain.cli.run.show import show
from barchain.cli.run.simulate import simulate
from barchain.cli.scaling import scaling
from barchain.cli.selftest import selftest
from barchain.cli.stability import stability

MOST_LINE = 4000  # characters of a line on standard error; the list of all scenes has 2000
MOST_SHOWN = 60  # characters of an argument that is shown

SECTIONS = {
    "Run and compare": (scenes, engines, simulate, compare, crossval, show, report, doctor),
    "Studies": (cost, scaling, roundoff, stability, effects, selftest, ensemble),
    "Nights": (nightly, history, attribute_night, bisect_figure, releases),
    "Scenes and engines of your own": (validate, schema, certified_solutions, new_engine, conform),
}


COMPLETION = "_BARCHAIN_COMPLETE"
"""Environment variable by which a shell asks for completions; click ends the process itself then"""


def main() -> None:
    """Entry point: every fault ends in one readable line and an exit code of its own, but for barchain's own faults."""
    output = guard_streams()
    try:
        code = run(sys.argv[1:])
        lost = lost_output(output)
        if lost:
            code = complain(f"standard output is lost: {lost}; the work was done", ExitCode(code or ExitCode.BAD_INPUT))
    except BaseException as error:
        if isinstance(error, SystemExit) and COMPLETION in os.environ:
            raise
        traceback.print_exc()
        code = ExitCode.INTERNAL_ERROR
    sys.exit(code)


def run(arguments: list[str]) -> int:
    """Exit code of a command line; 0 only of a command that came to its own end."""
    wrong = hidden_argument(arguments)
    if wrong:
        return complain(wrong, ExitCode.BAD_INPUT)
    try:
        return cli.main(arguments, prog_name="barchain", standalone_mode=False) or ExitCode.OK
    except (click.Abort, KeyboardInterrupt):
        return complain(f"interrupted; results so far are kept{resume_hint(arguments)}", ExitCode.INTERRUPTED)
    except SystemExit as ended:
        if COMPLETION in os.environ:
            raise
        if isinstance(ended.__context__, BrokenPipeError) or output_is_unread():  # Rich and click ask for the end then
            return ExitCode.UNREAD
        raise EndedEarlyError(f"something inside asked the process to end with {ended.code!r}") from ended
    except Exception as error:
        known = failure(error)
        if known is None:
            raise
        if verbosity.verbose():
            traceback.print_exc()
        return complain(*known)


def output_is_unread() -> bool:
    """Whether the reader at the other end of the command's output has ended."""
    if not hasattr(select, "poll"):
        return False
    asked = select.poll()
    asked.register(1, select.POLLOUT)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in asked.poll(0))


def resume_hint(arguments: list[str]) -> str:
    """Advice on going on with an interrupted command; empty of a command that can't."""
    command = next((cli.commands[a] for a in arguments if a in cli.commands), None)
    resumable = command is not None and any(p.name == "resume" for p in command.params)
    return ", and --resume goes on from them" if resumable else ""


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
@click.option("-v", "--verbose", is_flag=True, help="Print every verdict, and the traceback of an error.")
@click.version_option(package_name="barchain")
@click.pass_context
def cli(ctx: click.Context, quiet: bool, verbose: bool) -> None:
    """Cross-validate multibody engines on a chain of rigid bars in orbit."""
    verbosity.choose(quiet=quiet, verbose=verbose)
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
