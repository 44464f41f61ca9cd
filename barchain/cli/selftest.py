"""Command `selftest`: sensitivity of the harness to known faults."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.options import (
    ENGINE,
    executor_options,
    optional_scenes,
    out_option,
    programs_option,
    result_options,
)
from barchain.cli.common.result_folder import end_study, run_shown
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.runs.executors import Executor
    from barchain.studies.selftest.faults.fault import Fault
    from barchain.studies.selftest.matrix import SelftestStudy


@click.command(short_help="Insert faults into an engine, and test that checks detect them.")
@optional_scenes
@click.option("--fault", "faults", multiple=True, metavar="NAME",
              help="Insert this fault. May be repeated; default: every fault that `--list` shows.")  # fmt: skip
@click.option("--engine", metavar="NAME", type=ENGINE, default="reference", show_default=True,
              help="Insert the faults into this engine; faults in the code itself need the reference.")  # fmt: skip
@programs_option
@click.option(
    "--smallest", is_flag=True, help="Find the smallest size of each continuous fault that is still detected."
)
@click.option("--list", "listed", is_flag=True, help="List the faults, and run nothing.")
@out_option(None, help_text="Write tables and page into this folder; default: print only.")
@executor_options
@result_options
def selftest(
    scenes: tuple[str, ...], faults: tuple[str, ...], engine: str, smallest: bool, listed: bool, out: Path | None,
    executor: Executor, kept: dict[str, bool],
) -> None:  # fmt: skip
    """Insert known faults into an engine, and show which check detects each.

    SCENEs are names, files or folders; default: eight short scenes. Exits with 1 if a fault is detected by no check, or
    if a check rejects the unmodified engine.
    """
    from barchain.studies.selftest.faults.catalogue import FIXED_SCENES, UnknownFaultError

    if listed:
        show_faults(FIXED_SCENES.values())
        return
    try:
        result, rendered = run_shown(out, matrix(scenes, faults, engine, smallest, executor), kept)
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error
    show_matrix(rendered.view)
    end_study(result, rendered.page if out else None)


def show_faults(faults: Iterable[Fault]) -> None:
    """Name, group, size and words of each fault."""
    rows = []
    for fault in faults:
        size = f"{fault.natural:g} {fault.size.unit}".removesuffix(" 1") if fault.size else ""
        rows.append((fault.name, fault.group, size, fault.words))
    show_rows(("fault", "group", "size", "what is wrong"), rows)


def matrix(
    scenes: tuple[str, ...], faults: tuple[str, ...], engine: str, smallest: bool, executor: Executor
) -> SelftestStudy:
    """Self-test on chosen scenes; a note says which scenes the engine does not support."""
    from barchain.studies.selftest.matrix import selftest_study

    study = selftest_study(scenes, faults, host=engine, smallest=smallest, executor=executor)
    for name, reason in study.left_out.items():
        say(f"{name} is left out: {engine} {reason}", err=True)
    if not study.scenes:
        raise click.UsageError(f"--engine {engine}: supports none of these scenes")
    return study


def show_matrix(view: Any) -> None:
    """Print the matrix, survivors, smallest sizes, and the result."""
    show_rows(("fault", *view.scenes), [(row["name"], *(c["text"] for c in row["cells"])) for row in view.rows])
    say("; ".join(f"{sign} {name.replace('_', ' ')}" for sign, name, _ in view.signs))
    if view.smallest:
        rows = [(s["name"], f"{s['natural']:g} {s['unit']}".removesuffix(" 1"), *s["sizes"]) for s in view.smallest]
        show_rows(("smallest detected", "natural", *view.scenes), rows)
    for fault, cell in view.survivors:
        where = f"{fault['name']} on {cell['scene']} (detected in {fault['detected']} of {fault['tried']})"
        say(f"{cell['fate']} {where}: {cell['reason']}")
    for cell in view.wrong:
        say(f"{cell['fate']}: {cell['fault']} on {cell['scene']}: {cell['title']}")
    for sentence in (view.headline, *view.sentences):
        say(sentence)
