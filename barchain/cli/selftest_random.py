"""`barchain selftest --random`: rates of false and missed alarms on random scenes."""

from __future__ import annotations

import functools
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.names import HOST, HostType
from barchain.cli.common.numbers import MOST_REPEATS, MOST_SCENES, SECONDS, SEED
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import literal, say

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from barchain.faults.fault import Fault
    from barchain.runs.executors import Executor
    from barchain.studies.selftest.campaign import CampaignOptions, CampaignPlan, CampaignStudy


@dataclass(frozen=True)
class RandomOptions:
    """Options of the random campaign; None, or empty, where they are not given."""

    number: int | None
    """Of scenes; None: another self-test is meant"""
    seed: int | None
    hosts: tuple[str, ...]
    reruns: int | None
    shrink_seconds: float | None

    def reject(self) -> None:
        """Reject them without --random."""
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
        click.option("--random", "number", type=click.IntRange(1, MOST_SCENES), metavar="N",
                     help="Draw N random scenes instead."),
        click.option("--seed", type=SEED, metavar="N",
                     help="With --random: begin with scene number N; default: 0."),
        click.option("--host", "hosts", multiple=True, metavar="NAME", type=HOST,
                     help="With --random: insert faults into this engine, or none for no faults. May be repeated; "
                          "default: reference, exudyn, exudyn-tree and pymunk."),
        click.option("--reruns", type=click.IntRange(0, MOST_REPEATS), metavar="K",
                     help="With --random: run K faults that need an own run in each host and scene; default: 3."),
        click.option("--shrink-seconds", type=SECONDS, metavar="S",
                     help="With --random: look for a simpler scene of each finding for this time, in seconds; default: "
                          "60; 0: not at all. Needs hypothesis: pip install '.[selftest]'."),
    )):  # fmt: skip
        found = option(found)
    return found


def run_random(
    asked: RandomOptions, engines: tuple[str, ...], faults: tuple[str, ...], listed: bool, out: Path | None,
    executor: Executor, *, resume: bool = False, overwrite: bool = False,
) -> None:  # fmt: skip
    """Run a campaign, print its findings, and exit by them; or list its faults."""
    from barchain.cli.campaign_summary import show_campaign  # noqa: PLC0415
    from barchain.cli.common.progress import counted  # noqa: PLC0415
    from barchain.faults.catalogue import RANDOM_SCENES  # noqa: PLC0415
    from barchain.runs.environment import kept_or_temporary  # noqa: PLC0415
    from barchain.studies.selftest.campaign import CampaignStudy  # noqa: PLC0415  # what no other command needs
    from barchain.studies.study import Reporter  # noqa: PLC0415

    if listed:
        show_faults(RANDOM_SCENES.values())
        return
    study, reporter = CampaignStudy(), Reporter(counted=counted)
    plan = plan_of(study, options_of(asked, engines, faults, executor))
    with kept_or_temporary(out) as folder:
        found, rendered = run_study_in(folder, study, plan, reporter, resume=resume, overwrite=overwrite)
        show_campaign(found, kept=out is not None)
    if out:
        say(f"selftest: {rendered.page}")
    end_study(found)


def options_of(
    asked: RandomOptions, engines: tuple[str, ...], faults: tuple[str, ...], executor: Executor
) -> CampaignOptions:
    """Options of a campaign; a missing engine ends the command."""
    from barchain.cli.common.names import need_engine  # noqa: PLC0415
    from barchain.studies.selftest.campaign import HOSTS, CampaignOptions  # noqa: PLC0415

    hosts = () if asked.hosts == (HostType.NONE,) else asked.hosts or HOSTS
    for name in dict.fromkeys((*engines, *hosts)):
        need_engine(name)
    assert asked.number is not None
    given: dict[str, Any] = {"seed": asked.seed, "most_reruns": asked.reruns, "shrink_s": asked.shrink_seconds}
    options = CampaignOptions(asked.number, engines=engines, hosts=hosts, faults=faults, executor=executor)
    return replace(options, **{name: value for name, value in given.items() if value is not None})


def plan_of(study: CampaignStudy, options: CampaignOptions) -> CampaignPlan:
    """Plan of a campaign; an unknown fault ends the command."""
    from barchain.faults.catalogue import UnknownFaultError  # noqa: PLC0415

    try:
        return study.plan(options)
    except UnknownFaultError as error:
        raise click.UsageError(f"--fault {error}") from error


def show_faults(faults: Iterable[Fault]) -> None:
    """Name, size and words of each fault."""
    from rich.table import Table  # noqa: PLC0415

    from barchain.cli.common.terminal import show  # noqa: PLC0415

    table = Table(box=None, header_style="bold")
    for column in ("fault", "group", "size", "what is wrong"):
        table.add_column(column)
    for fault in faults:
        size = f"{fault.natural:g} {fault.size.unit}".removesuffix(" 1") if fault.size else ""
        table.add_row(fault.name, fault.group, size, literal(fault.words))
    show(table)
