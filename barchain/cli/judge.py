"""Command `judge`: the verdict on a result that another program wrote into a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import WORDS, NamedPath, RealNumber
from barchain.cli.common.options import out_option, overwrite_option, scene_argument, time_limit_option
from barchain.cli.common.progress import working
from barchain.cli.common.terminal import say
from barchain.record.environment import typed
from barchain.runs.job import TIME_LIMIT_S

if TYPE_CHECKING:
    from barchain.result_files.judging import FileResult

FILE = NamedPath(path_type=Path, dir_okay=False)


@click.command(short_help="Judge a result that another program wrote into a file.")
@scene_argument
@click.argument("file", metavar="FILE", type=FILE)
@click.option("--finer", metavar="FILE", type=FILE,
              help="Estimate the error by this second result, of half the step or a tenth of the rtol.")  # fmt: skip
@click.option("--order", metavar="N", type=RealNumber(1.0, 40.0),
              help="With --finer: order of a method of equal steps; its error must fall by 2^N.")  # fmt: skip
@click.option("--rtol", metavar="X", type=RealNumber(1e-18, 1e-1),
              help="Requested error of one step, of a method that chooses its steps.")  # fmt: skip
@click.option("--absolute", is_flag=True,
              help="Allow for the round-off of places counted from the centre of the central body.")  # fmt: skip
@click.option("--noise", metavar="QUANTITY=X", multiple=True, type=WORDS,
              help="Allow for an error that does not fall with the step, in SI units, e.g. reaction=1e-9, as the "
                   "tolerance of iterations leaves. May be repeated.")  # fmt: skip
@click.option("--columns", "mapping_file", metavar="FILE", type=FILE,
              help='Read names of columns from this TOML file, e.g. "angle_1 [deg]" = "phi".')  # fmt: skip
@click.option("--column", "given", metavar="NAME=COLUMN", multiple=True, type=WORDS,
              help="Take a channel from this column, by its header or its number from 1, e.g. 'angle_1 [deg]=phi'. May "
                   "be repeated.")  # fmt: skip
@click.option(
    "--digits",
    metavar="N",
    type=click.IntRange(1, 17),
    help="Count N digits of each number, as of a curve that was read off: zeros at its end may be none.",
)
@out_option(None, help_text="Write report and tables into this folder; default: none.")
@time_limit_option(TIME_LIMIT_S)
@overwrite_option
def judge(
    scene: str, file: Path, finer: Path | None, order: float | None, rtol: float | None, absolute: bool,
    noise: tuple[str, ...], mapping_file: Path | None, given: tuple[str, ...], digits: int | None, out: Path | None,
    time_limit_s: float, overwrite: bool,
) -> None:  # fmt: skip
    """Judge FILE, a table of a run of SCENE: columns as `simulate --out run.csv` writes them.

    Columns may have units, e.g. `time [h]` or `angle_1 [deg]`. What is missing is not judged, and said. Digits that
    were not written are an error bar. Exits with 1 if the file does not pass.
    """
    from barchain.judge.written import Declared
    from barchain.result_files.channels import read_mapping
    from barchain.result_files.judging import judge_files
    from scenarios import scene_names

    if file.suffix == ".toml" or str(file) in scene_names():
        raise click.UsageError(f"{file} is a scene, which comes first: barchain judge {file} {scene}")
    if order is not None and finer is None:
        raise click.UsageError("--order goes with --finer, the result at half the step")
    mapping = ({} if mapping_file is None else read_mapping(mapping_file)) | dict(
        pair("--column", text, "NAME=COLUMN, e.g. 'angle_1 [deg]=phi'") for text in given
    )
    allowances = dict(allowance(text) for text in noise)
    with working(f"judging {file.name}"):
        result = judge_files(
            scene, file, finer, Declared(order, rtol, absolute, allowances), mapping, digits=digits, out=out,
            time_limit_s=time_limit_s, overwrite=overwrite, command=typed(), render=page,
        )  # fmt: skip
    show(file, result)
    if not result.passed:
        raise findings()


def page(folder: Path) -> Path:
    """Write the report of a folder, and return its page."""
    from reports.render import render

    return render(folder)[0]


def pair(option: str, text: str, form: str) -> tuple[str, str]:
    """Both sides of ``LEFT=RIGHT``; `form` is told where one is missing."""
    left, equals, right = text.partition("=")
    if not (left.strip() and equals and right.strip()):
        raise click.UsageError(f"{option} {text} given, allowed: {form}")
    return left.strip(), right.strip()


def allowance(text: str) -> tuple[str, float]:
    """Quantity and size of a declared noise."""
    from barchain.metrics.quantities import FIELDS
    from scenarios import nearest

    quantity, size = pair("--noise", text, "QUANTITY=X, e.g. reaction=1e-9")
    if quantity not in FIELDS:
        raise click.UsageError(f"--noise {text}: {quantity}{nearest(quantity, FIELDS)}; allowed: {', '.join(FIELDS)}")
    return quantity, float(RealNumber(0.0).convert(size, None, None))


def show(file: Path, result: FileResult) -> None:
    """Print the verdict, the reasons, what was done with the file, and the page."""
    first = f", of the first {result.until_s:.6g} of {result.duration_s:.6g} s"
    say(f"{file}: {result.scene}: {result.outcome}{first if result.until_s < result.duration_s else ''}")
    for line in filter(None, [*result.advice, result.mistakes, *result.reasons]):
        say(f"  {line}")
    for quantity, largest, unit in result.sizes:
        say(f"  {quantity}: largest difference {largest:.3g} {unit}")
    for note in result.notes:
        say(f"  - {note}")
    if result.report is not None:
        say(f"report: {result.report}")
