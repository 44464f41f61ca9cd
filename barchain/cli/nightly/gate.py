"""`barchain gate`: two builds of an engine before a merge, compared by the rules of nights."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import WORDS, NamedPath, RealNumber
from barchain.cli.common.options import expanded, scenes_of
from barchain.cli.common.progress import quiet
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say
from barchain.nightly.errors import need_extra

LEAST_MINUTES, MOST_MINUTES = 0.5, 1440.0
DEFAULT = ("core", "conform")
"""Folders of scenes where none is named"""


@click.command(short_help="Compare two builds of an engine before a merge.")
@click.argument("engine", metavar="ENGINE", type=WORDS)
@click.argument("scenes", metavar="[SCENE]...", nargs=-1, type=WORDS, callback=expanded)
@click.option("--base", metavar="SPEC", required=True, type=WORDS,
              help="Compare with this build: pymunk==7.2.0, a wheel, a Python, or a file of programs.")  # fmt: skip
@click.option("--head", metavar="SPEC", required=True, type=WORDS, help="Judge this build.")
@click.option("--minutes", metavar="M", type=RealNumber(LEAST_MINUTES, MOST_MINUTES), default=5.0, show_default=True,
              help="Give the gate a budget of this wall time, in minutes.")  # fmt: skip
@click.option("--known", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Let the failures of this file pass; default: known_failures.toml, if it is here.")  # fmt: skip
@click.option("--out", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Write the comment in Markdown into this file too.")  # fmt: skip
def gate(
    engine: str, scenes: tuple[str, ...], base: str, head: str, minutes: float, known: Path | None, out: Path | None
) -> None:
    """Compare two builds of ENGINE in one job, and print a comment in Markdown for a pull request.

    SCENEs are names, folders or files; default: the core suite and the scenes of `barchain conform`. Verdicts, errors,
    counts, bits and times are judged by the rules of nights. Exits with 1 if something is worse and not listed.
    """
    need_extra("packaging", "uv")
    from barchain.nightly.gate.known import FILE, known_failures  # noqa: PLC0415
    from barchain.nightly.gate.run import run_gate  # noqa: PLC0415
    from reports.nightly.summary import gate_comment  # noqa: PLC0415

    if known is not None and not known.is_file():
        raise click.UsageError(f"--known {known}: no such file")
    listed = known_failures(known or Path(FILE))
    if out is not None:
        need_writable(out, "--out")
    chosen = scenes or [name for folder in DEFAULT for name in scenes_of(folder)]
    result = run_gate(
        engine, base, head, chosen, listed, minutes, lambda text: None if quiet() else say(f"  {text}", err=True)
    )  # fmt: skip
    comment = gate_comment(result)
    if out is not None:
        out.write_text(comment, "utf-8")
    say(comment.rstrip())
    if result.failed:
        raise findings()
