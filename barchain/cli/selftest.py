"""Command `selftest`: sensitivity of the harness to known faults, on chosen scenes or on random ones."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.numbers import MOST_REPEATS, MOST_SCENES, SECONDS, SEED
from barchain.cli.common.options import (
    HOST,
    NONE,
    engine_option,
    executor_options,
    need_engine,
    optional_scenes,
    out_option,
    result_options,
)
from barchain.cli.common.result_folder import end_study, run_shown
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.runs.executors import Executor
    from barchain.studies.selftest.campaign import Campaign, CampaignStudy
    from barchain.studies.selftest.faults.fault import Fault
    from barchain.studies.selftest.matrix import SelftestStudy
    from barchain.studies.selftest.shrinking import KeptFinding
    from barchain.studies.study import StudyResult
    from reports.results.faults.campaign import CellClass


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
@result_options
@click.option("--random", "number", type=click.IntRange(1, MOST_SCENES), metavar="N",
              help="Draw N random scenes instead.")  # fmt: skip
@click.option("--seed", type=SEED, metavar="N", help="With --random: begin with scene number N; default: 0.")
@click.option("--host", "hosts", multiple=True, metavar="NAME", type=HOST,
              help="With --random: insert faults into this engine, or none for no faults. May be repeated; "
                   "default: reference, exudyn, exudyn-tree and pymunk.")  # fmt: skip
@click.option("--reruns", type=click.IntRange(0, MOST_REPEATS), metavar="K",
              help="With --random: run K faults that need an own run in each host and scene; default: 3.")  # fmt: skip
@click.option("--shrink-seconds", type=SECONDS, metavar="S",
              help="With --random: look for a simpler scene of each finding for this time, in seconds; default: "
                   "60; 0: not at all.")  # fmt: skip
def selftest(
    scenes: tuple[str, ...], faults: tuple[str, ...], engines: tuple[str, ...], smallest: bool, listed: bool,
    out: Path | None, executor: Executor, number: int | None, seed: int | None, hosts: tuple[str, ...],
    reruns: int | None, shrink_seconds: float | None, kept: dict[str, bool],
) -> None:  # fmt: skip
    """Insert known faults into an engine, and show which check detects each.

    SCENEs are names, files or folders; default: eight short scenes. Exits with 1 if a fault is detected by no check, or
    if a check rejects the unmodified engine.

    With --random N: draw N scenes, judge engines on them, and insert faults into some. Exits with 1 if a fault is
    missed that is larger than the verdict's own limit of detection, or if more than 0.5 % of the verdicts on
    unmodified engines are false alarms.
    """
    from barchain.studies.selftest.faults.catalogue import FIXED_SCENES, RANDOM_SCENES, UnknownFaultError

    own = {"--seed": seed, "--host": hosts or None, "--reruns": reruns, "--shrink-seconds": shrink_seconds}
    if number is not None and (scenes or smallest):
        raise click.UsageError("--random draws its scenes: leave out SCENE and --smallest")
    if number is None and (given := [name for name, value in own.items() if value is not None]):
        raise click.UsageError(f"{given[0]} goes with --random N")
    if number is None and len(engines) > 1:
        raise click.UsageError("--engine: faults are inserted into one engine; several go with --random N")
    if listed:
        show_faults((FIXED_SCENES if number is None else RANDOM_SCENES).values())
        return
    try:
        if number is None:
            (engine,) = engines or ("reference",)
            result: StudyResult
            result, rendered = run_shown(out, matrix(scenes, faults, engine, smallest, executor), kept)
            show_matrix(rendered.view)
        else:
            chosen = {"seed": seed, "most_reruns": reruns, "shrink_s": shrink_seconds, "executor": executor}
            campaign, rendered = run_shown(out, campaign_of(number, engines, hosts, faults, chosen), kept)
            show_campaign(campaign, kept=out is not None)
            result = campaign
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error
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

    need_engine(engine)
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


def campaign_of(
    number: int, engines: tuple[str, ...], hosts: tuple[str, ...], faults: tuple[str, ...], chosen: dict[str, Any]
) -> CampaignStudy:
    """Campaign on random scenes; `chosen` are its other options, None for the default of each."""
    from barchain.studies.selftest.campaign import HOSTS, campaign_study

    hosts = () if hosts == (NONE,) else hosts or HOSTS
    for name in dict.fromkeys((*engines, *hosts)):
        need_engine(name)
    given = {name: value for name, value in chosen.items() if value is not None}
    return campaign_study(number, engines, faults, hosts=hosts, **given)


def show_campaign(found: Campaign, *, kept: bool) -> None:
    """Print the cells' classes by engine and by fault, the findings, and the rates; `kept`: scenes can be looked at."""
    from reports.results.faults.campaign import ALL, ENGINE_CLASSES, FAULT_CLASSES

    sound, faulty = ([c for c in found.cells if bool(c.fault) is planted] for planted in (False, True))
    show_counts("engine", found.study.unmodified, [(c.engine, c.kind) for c in sound], ENGINE_CLASSES)
    if faulty:
        show_counts("fault", found.study.faults, [(c.fault, c.kind) for c in faulty], FAULT_CLASSES)
    for one in found.findings:
        say(finding_words(one, kept=kept))
    for rate in found.rates:
        if rate["by"] in (ALL, "outcome"):
            say(rate_words(rate))
    say("passed" if found.passed else "not passed")


def show_counts(
    what: str, names: tuple[str, ...], cells: list[tuple[str, CellClass]], columns: tuple[CellClass, ...]
) -> None:
    """Print the numbers of cells by name and class."""
    counts, headings = Counter(cells), list(map(str, columns))
    rows = [(name, *(str(counts[name, k] or "") for k in columns)) for name in names]
    show_rows((what, *headings), rows, right=headings)


def finding_words(found: KeptFinding, *, kept: bool) -> str:
    """Finding as one line of text."""
    cell = found.cell
    what = f"{cell.fault} in {cell.engine}" if cell.fault else cell.engine
    times = f" ({found.times} times)" if found.times > 1 else ""
    size = "" if cell.size is None else f" {cell.size:.2g}, stated as detected from {cell.limit or 0.0:.2g} on"
    said = f"{cell.kind}: {what} on {cell.scene}{times}: {cell.outcome}, {cell.quantity}{size}"
    return " ".join(f"{said} {cell.reason}".split()) + (f"; {found.path}" if kept else "")


def rate_words(rate: dict[str, Any]) -> str:
    """``false alarm: 2 of 400, 0.50 % (0.14 % to 1.80 %)``."""
    from reports.results.faults.campaign import ALL

    name = "" if rate["by"] == ALL else f", {rate['name']}"
    value, low, high = (100.0 * rate[key] for key in ("rate", "low", "high"))
    share = f"{value:.2f} % ({low:.2f} % to {high:.2f} %)" if rate["n"] else "none tried"
    return f"{rate['what']}{name}: {rate['count']} of {rate['n']}, {share}"
