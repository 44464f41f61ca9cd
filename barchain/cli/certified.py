"""`barchain truths`: the committed truths of the scenes that come with barchain."""

from __future__ import annotations

import time

import click

from adapters.registry import find_engine
from scenarios import load_scene, nearest, scene_names


@click.command()
@click.argument("scenes", metavar="[SCENE]...", nargs=-1)
@click.option(
    "--check", "only_check", is_flag=True, help="Compare a fresh run with what is committed, and write nothing."
)
def certified_solutions(scenes: tuple[str, ...], only_check: bool) -> None:
    """Make the truths of SCENEs (all that come with barchain by default) again, or check them.

    A truth is a run in quadruple precision with its own error bar. The check fails, with exit code 1, where a
    fresh run is not inside the error bars.
    """
    missing = find_engine("heyoka-quad").missing
    if missing:
        raise click.UsageError(missing)
    unknown = [name for name in scenes if name not in scene_names()]
    if unknown:
        raise click.UsageError(
            f"{unknown[0]}: only scenes that come with barchain have committed truths"
            f"{nearest(unknown[0], scene_names())}; there are: {', '.join(scene_names())}"
        )
    agree = [(shown_check if only_check else shown_making)(name) for name in scenes or scene_names()]
    if not all(agree):
        raise click.exceptions.Exit(1)


def shown_making(name: str) -> bool:
    """Make a truth, and say how good it is."""
    from barchain.solutions.certified_commit import commit  # noqa: PLC0415  # asks for heyoka

    begun = time.perf_counter()
    table = commit(load_scene(name))
    worst = table.error["attitude"][-1]
    click.echo(f"{name}: attitude to {worst:.1e} rad at the end, in {time.perf_counter() - begun:.1f} s")
    return True


def shown_check(name: str) -> bool:
    """Check a truth, and say what came out."""
    from barchain.solutions.certified_commit import check  # noqa: PLC0415  # asks for heyoka

    found = check(load_scene(name))
    click.echo(found.said)
    return found.agrees
