"""`barchain selftest`: sensitivity of the harness to known faults."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.options import (
    engine_option,
    executor_options,
    optional_scenes,
    out_option,
    overwrite_option,
    resume_option,
)
from barchain.cli.common.result_folder import need_kept, run_study_in
from barchain.cli.common.terminal import literal, say
from barchain.cli.selftest_random import RandomOptions, random_options, run_random, show_faults

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.executors import Executor
    from barchain.studies.selftest.matrix import SelftestPlan


@click.command(short_help="Insert faults into an engine, and test that checks detect them.")
@optional_scenes
@click.option("--fault", "faults", multiple=True, metavar="NAME",
              help="Insert this fault. May be repeated; default: every fault that `--list` shows.")  # fmt: skip
@engine_option("reference, which faults in the code itself need; with --random: the engines of the default set in "
               "`barchain engines`, judged unmodified", "engines")  # fmt: skip
@click.option(
    "--smallest", is_flag=True, help="Find the smallest size of each continuous fault that is still detected."
)
@click.option("--list", "listed", is_flag=True, help="List the faults, and run nothing.")
@out_option(None, help_text="Write tables and page into this folder; default: print only.")
@executor_options
@resume_option
@overwrite_option
@random_options
def selftest(
    scenes: tuple[str, ...], faults: tuple[str, ...], engines: tuple[str, ...], smallest: bool, listed: bool,
    out: Path | None, executor: Executor, resume: bool, overwrite: bool, asked: RandomOptions,
) -> None:  # fmt: skip
    """Insert known faults into an engine, and show which check detects each.

    SCENEs are names, files or folders; default: eight short scenes. Exits with 1 if a fault is detected by no check, or
    if a check rejects the unmodified engine.

    With --random N: draw N scenes, judge engines on them, and insert faults into some. Exits with 1 if a fault is
    missed that is larger than the verdict's own limit of detection, or if more than 0.5 % of the verdicts on
    unmodified engines are false alarms.
    """
    need_kept(out, resume=resume)
    if asked.number is not None:
        if scenes or smallest:
            raise click.UsageError("--random draws its scenes: leave out SCENE and --smallest")
        run_random(asked, engines, faults, listed, out, executor, resume=resume, overwrite=overwrite)
        return
    asked.reject()
    if len(engines) > 1:
        raise click.UsageError("--engine: faults are inserted into one engine; several go with --random N")
    if listed:
        list_faults()
        return
    (engine,) = engines or ("reference",)
    run_matrix(plan_of(scenes, faults, engine, smallest, executor), out, resume=resume, overwrite=overwrite)


def list_faults() -> None:
    """Print all faults of the kill matrix."""
    from barchain.faults.catalogue import FIXED_SCENES  # noqa: PLC0415  # what no other command needs

    show_faults(FIXED_SCENES.values())


def run_matrix(plan: SelftestPlan, out: Path | None, *, resume: bool = False, overwrite: bool = False) -> None:
    """Run the kill matrix, print it, and end with exit code 1 if a fault is missed."""
    from barchain.cli.common.progress import counted  # noqa: PLC0415
    from barchain.runs.environment import kept_or_temporary  # noqa: PLC0415
    from barchain.studies.selftest.matrix import SelftestStudy  # noqa: PLC0415
    from barchain.studies.study import Reporter  # noqa: PLC0415

    with kept_or_temporary(out) as folder:
        reporter = Reporter(counted=counted)
        tried, rendered = run_study_in(folder, SelftestStudy(), plan, reporter, resume=resume, overwrite=overwrite)
    show_view(rendered.view)
    if out:
        say(f"selftest: {rendered.page}")
    end_study(tried)


def plan_of(
    scenes: tuple[str, ...], faults: tuple[str, ...], engine: str, smallest: bool, executor: Executor
) -> SelftestPlan:
    """Plan of a self-test; a note says which scenes the engine does not support."""
    from barchain.cli.common.names import need_engine  # noqa: PLC0415
    from barchain.faults.catalogue import UnknownFaultError  # noqa: PLC0415
    from barchain.studies.selftest.matrix import SelftestOptions, SelftestStudy  # noqa: PLC0415

    need_engine(engine)
    try:
        plan = SelftestStudy().plan(SelftestOptions(scenes, faults, engine, smallest, executor))
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error
    for name, reason in plan.left_out.items():
        say(f"{name} is left out: {engine} {reason}", err=True)
    if not plan.scenes:
        raise click.UsageError(f"--engine {engine}: supports none of these scenes")
    return plan


def show_view(view: Any) -> None:
    """Print the matrix, survivors, smallest sizes, and the result."""
    from rich.table import Table  # noqa: PLC0415

    from barchain.cli.common.terminal import show  # noqa: PLC0415

    table = Table("fault", *view.scenes, box=None, header_style="bold")
    for row in view.rows:
        table.add_row(row["name"], *(literal(c["text"]) for c in row["cells"]))
    show(table)
    say("; ".join(f"{sign} {name.replace('_', ' ')}" for sign, name, _ in view.signs))
    if view.smallest:
        sizes = Table("smallest detected", "natural", *view.scenes, box=None, header_style="bold")
        for small in view.smallest:
            sizes.add_row(small["name"], f"{small['natural']:g} {small['unit']}".removesuffix(" 1"), *small["sizes"])
        show(sizes)
    for fault, cell in view.survivors:
        where = f"{fault['name']} on {cell['scene']} (detected in {fault['detected']} of {fault['tried']})"
        say(f"{cell['fate']} {where}: {cell['reason']}")
    for cell in view.wrong:
        say(f"{cell['fate']}: {cell['fault']} on {cell['scene']}: {cell['title']}")
    for sentence in (view.headline, *view.sentences):
        say(sentence)
