"""`barchain selftest --random`: how often the judge is wrong, on scenes that nobody chose."""

from __future__ import annotations

import functools
import os
import tempfile
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from barchain.record.command import typed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from barchain.studies.selftest.campaign.study import CampaignPlan
    from barchain.studies.selftest.faults.fault import Fault

FAILED = 1
NO_HOST = "none"


@dataclass(frozen=True)
class RandomOptions:
    """Options of the random campaign; None, or empty, where they are not given."""

    number: int | None
    """Of scenes; None: another self-test is meant"""
    seed: int | None
    hosts: tuple[str, ...]
    reruns: int | None
    shrink_seconds: float | None

    def refuse(self) -> None:
        """Refuse them without --random."""
        given = [f.name for f in fields(self) if getattr(self, f.name) not in (None, ())]
        if given:
            name = {"hosts": "host"}.get(given[0], given[0].replace("_", "-"))
            raise click.UsageError(f"--{name} goes with --random N")


def random_options(command: Callable[..., None]) -> Callable[..., None]:
    """Options of the random campaign, given to the command as one `asked`."""

    @functools.wraps(command)
    def gathered(**given: Any) -> None:
        own = {f.name: given.pop(f.name) for f in fields(RandomOptions)}
        command(**given, asked=RandomOptions(**own))

    found: Callable[..., None] = gathered
    for option in reversed((
        click.option("--random", "number", type=click.IntRange(min=1), metavar="N", help="Try N random scenes."),
        click.option("--seed", type=click.IntRange(min=0), metavar="S",
                     help="With --random: number of the first scene, 0 by default; the others follow."),
        click.option("--host", "hosts", multiple=True, metavar="NAME",
                     help="With --random: engine that faults are put into; may be repeated; reference, exudyn, "
                          "exudyn-tree and pymunk by default; none: engines as they are, and no faults."),
        click.option("--reruns", type=click.IntRange(min=0), metavar="K",
                     help="With --random: faults in one host on one scene that need runs of their own, chosen by the "
                          "scene; 3 by default."),
        click.option("--shrink-seconds", type=click.FloatRange(min=0), metavar="S",
                     help="With --random: time to look for a simpler scene of one finding, 60 by default; 0: none."),
    )):  # fmt: skip
        found = option(found)
    return found


def run_random(
    asked: RandomOptions, engines: tuple[str, ...], faults: tuple[str, ...], listed: bool, out: Path | None,
    workers: int | None,
) -> None:  # fmt: skip
    """Run a campaign, print what it found, and exit by that; or list its faults."""
    from barchain.cli.campaign_summary import show_campaign  # noqa: PLC0415
    from barchain.cli.progress import counted  # noqa: PLC0415
    from barchain.studies.selftest.campaign.faults.catalogue import FAULTS  # noqa: PLC0415
    from barchain.studies.selftest.campaign.judging import CourtRoom  # noqa: PLC0415  # what no other command needs
    from barchain.studies.selftest.campaign.runs import in_workers  # noqa: PLC0415
    from barchain.studies.selftest.campaign.study import CampaignStudy  # noqa: PLC0415
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415

    if listed:
        show_faults(FAULTS.values())
        return
    plan = plan_of(asked, engines, faults, workers)
    court = CourtRoom(workers or os.cpu_count() or 1)
    with tempfile.TemporaryDirectory() as scratch:
        folder = out or Path(scratch)
        try:
            study, reporter = CampaignStudy(in_workers(workers), court), Reporter(counted=counted)
            found = run_study(study, plan, folder, command=typed(), reporter=reporter)
        finally:
            court.close()
        show_campaign(found, kept=out is not None)
    if not found.passed:
        raise click.exceptions.Exit(FAILED)


def plan_of(
    asked: RandomOptions, engines: tuple[str, ...], faults: tuple[str, ...], workers: int | None
) -> CampaignPlan:
    """What is asked for; engines that are not installed are bad usage."""
    from adapters.registry import find_engine  # noqa: PLC0415
    from barchain.studies.selftest.campaign.study import HOSTS, CampaignOptions, make_plan  # noqa: PLC0415
    from barchain.studies.selftest.faults.catalogue import UnknownFaultError  # noqa: PLC0415

    hosts = () if asked.hosts == (NO_HOST,) else asked.hosts or HOSTS
    for name in dict.fromkeys((*engines, *hosts)):
        missing = find_engine(name).missing
        if missing:
            raise click.UsageError(f"{name}: {missing}")
    assert asked.number is not None
    given: dict[str, Any] = {"seed": asked.seed, "most_reruns": asked.reruns, "shrink_s": asked.shrink_seconds}
    options = CampaignOptions(asked.number, engines=engines, hosts=hosts, faults=faults, workers=workers)
    try:
        return make_plan(replace(options, **{name: value for name, value in given.items() if value is not None}))
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error


def show_faults(faults: Iterable[Fault]) -> None:
    """Name, size and words of each fault."""
    from rich.markup import escape  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    from barchain.cli.listing import show  # noqa: PLC0415

    table = Table(box=None, header_style="bold")
    for column in ("fault", "group", "size", "what is wrong"):
        table.add_column(column)
    for fault in faults:
        size = f"{fault.natural:g} {fault.size.unit}".removesuffix(" 1") if fault.size else ""
        table.add_row(fault.name, fault.group, size, escape(fault.words))
    show(table)
