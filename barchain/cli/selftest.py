"""`barchain selftest`: whether the harness catches wrong physics."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.selftest_random import RandomOptions, random_options, run_random, show_faults
from barchain.record.command import typed

if TYPE_CHECKING:
    from barchain.studies.selftest.study import SelftestPlan
    from reports.chapters.selftest.view import SelftestView

FAILED = 1


@click.command()
@click.option("--scene", "scenes", multiple=True, metavar="SCENE",
              help="Scene to put faults into; may be repeated; eight short ones by default.")  # fmt: skip
@click.option(
    "--fault", "faults", multiple=True, metavar="NAME", help="Fault to put in; may be repeated; all by default."
)
@click.option("--engine", "engines", multiple=True, metavar="NAME",
              help="Engine that is spoilt, the reference by default; faults in the code itself need that. With "
                   "--random: engine that is judged as it is; may be repeated; all installed by default.")  # fmt: skip
@click.option("--smallest", is_flag=True, help="Find the smallest size of each continuous fault that is still caught.")
@click.option("--list", "listed", is_flag=True, help="List the faults, and run nothing.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for tables and page.")
@click.option("--workers", type=click.IntRange(min=1), help="Processes side by side; all cores by default.")
@random_options
def selftest(
    scenes: tuple[str, ...], faults: tuple[str, ...], engines: tuple[str, ...], smallest: bool, listed: bool,
    out: Path | None, workers: int | None, asked: RandomOptions,
) -> None:  # fmt: skip
    """Put known faults into an engine, and show which check catches each.

    Ends with exit code 1 if a fault is killed by nothing, or if a check refuses the sound engine.

    With --random N it draws N scenes, judges all engines on them, and puts faults into some. It ends with exit code 1
    if a fault is missed that is larger than the verdict says it would detect, or if more than 0.5 % of the verdicts on
    sound engines are false alarms.
    """
    if asked.number is not None:
        if scenes or smallest:
            raise click.UsageError("--random draws its scenes: leave out --scene and --smallest")
        run_random(asked, engines, faults, listed, out, workers)
        return
    asked.refuse()
    if len(engines) > 1:
        raise click.UsageError("--engine: one engine is spoilt; several go with --random N")
    (engine,) = engines or ("reference",)
    from barchain.cli.progress import counted  # noqa: PLC0415
    from barchain.studies.selftest.faults.catalogue import FAULTS  # noqa: PLC0415
    from barchain.studies.selftest.study import SelftestStudy  # noqa: PLC0415  # what no other command needs
    from barchain.studies.selftest.trial import SelftestError  # noqa: PLC0415
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.chapters.selftest.view import view_selftest  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    if listed:
        show_faults(FAULTS.values())
        return
    plan = plan_of(scenes, faults, engine, smallest, workers)
    with tempfile.TemporaryDirectory() as scratch:
        folder = out or Path(scratch)
        try:
            tried = run_study(SelftestStudy(), plan, folder, command=typed(), reporter=Reporter(counted=counted))
        except SelftestError as error:
            raise click.ClickException(str(error)) from error
        page = render_study("selftest", folder).page if out else None
        view = view_selftest(folder)
    assert view is not None
    show_view(view)
    if page:
        click.echo(f"selftest: {page}")
    if not tried.passed:
        raise click.exceptions.Exit(FAILED)


def plan_of(
    scenes: tuple[str, ...], faults: tuple[str, ...], engine: str, smallest: bool, workers: int | None
) -> SelftestPlan:
    """What is asked for; scenes that the engine can't do are left out, and said so."""
    from adapters.registry import find_engine  # noqa: PLC0415
    from barchain.studies.selftest.faults.catalogue import UnknownFaultError  # noqa: PLC0415
    from barchain.studies.selftest.study import SelftestOptions, SelftestStudy  # noqa: PLC0415

    registration = find_engine(engine)
    if registration.missing:
        raise click.UsageError(f"--engine {engine}: {registration.missing}")
    try:
        plan = SelftestStudy().plan(SelftestOptions(scenes, faults, engine, smallest, workers))
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error
    for name, reason in plan.left_out.items():
        click.echo(f"{name} is left out: {engine} {reason}", err=True)
    if not plan.scenes:
        raise click.UsageError(f"--engine {engine}: can do none of these scenes")
    return plan


def show_view(view: SelftestView) -> None:
    """Print the matrix, survivors, smallest sizes, and the result."""
    from rich.markup import escape  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    from barchain.cli.listing import show  # noqa: PLC0415

    table = Table("fault", *view.scenes, box=None, header_style="bold")
    for row in view.rows:
        table.add_row(row.name, *(escape(c.text) for c in row.cells))
    show(table)
    click.echo("; ".join(f"{sign} {name.replace('_', ' ')}" for sign, name, _ in view.signs))
    if view.smallest:
        sizes = Table("smallest caught", "natural", *view.scenes, box=None, header_style="bold")
        for small in view.smallest:
            sizes.add_row(small.name, f"{small.natural:g} {small.unit}".removesuffix(" 1"), *small.sizes)
        show(sizes)
    for fault, cell in view.survivors:
        click.echo(
            f"{cell.fate} {fault.name} on {cell.scene} (killed in {fault.killed} of {fault.tried}): {cell.reason}"
        )
    for cell in view.wrong:
        click.echo(f"{cell.fate}: {cell.fault} on {cell.scene}: {cell.title}")
    for sentence in (view.headline, *view.sentences):
        click.echo(sentence)
