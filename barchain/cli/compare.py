"""Commands `compare` and `crossval`: engines against the judging solution, scene by scene."""

from __future__ import annotations

from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.options import (
    engine_option,
    executor_options,
    having,
    out_option,
    required_scenes,
    result_options,
    scenes_of,
    set_option,
    time_limit_option,
)
from barchain.cli.common.progress import verbose
from barchain.cli.common.result_folder import end_study
from barchain.cli.common.terminal import counts_of, say
from barchain.cli.scenes import warn_of_height
from barchain.record.environment import typed
from barchain.runs.job import SOLUTION_PATIENCE, TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    import pandas as pd

    from adapters.registry import Registration
    from barchain.cli.common.options import GivenSetting
    from barchain.studies.comparison.run import ComparisonResult
    from reports.results.outcome import Outcome
    from scenarios import Scene

LOOK = "comparison"
MOST_SHOWN = 10  # failures
OUT = "Write report and tables into this folder."
PATIENT = f"; a run for the judging solution after {SOLUTION_PATIENCE:g} times that"


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Options that compare and crossval share."""
    return set_option(time_limit_option(TIME_LIMIT_S, PATIENT)(executor_options(result_options(command))))


@click.command(short_help="Compare engines on the scenes that you name.")
@required_scenes
@engine_option("one of each library", classes=True)
@out_option(LOOK, help_text=OUT)
@click.option("--certify", is_flag=True,
              help="Judge your own scenes by heyoka (extra certified): independent, but slower.")  # fmt: skip
@run_options
def compare(scenes: tuple[str, ...], names: tuple[str, ...], out: Path, **options: Any) -> None:
    """Compare engines on the SCENEs that you name, and write a report.

    SCENEs are names, files, or folders of scenes such as `paper`, `hard` or your own; `core` is the core suite. Exits
    with 1 if a comparison fails, if a scene's reference solution could not be run, or if an engine that was named, or
    had several scenes to do, was compared on none. `barchain crossval` does the same for a fixed set of scenes and
    engines, and asks for more.
    """
    from adapters.registry import ENGINES
    from barchain.solutions.judging import CERTIFIER
    from scenarios import load_scene, scene_names

    if options["certify"] and (missing := ENGINES[CERTIFIER].missing):
        raise click.UsageError(f"--certify: {missing}")
    loaded = [load_scene(s) for s in scenes]
    for file, scene in zip(scenes, loaded, strict=True):
        if file not in scene_names():
            warn_of_height(file, scene)
    compare_and_render(loaded, names or None, out, need_external=False, quick=True, **options)


@click.command(short_help="Compare all default engines on the core suite.")
@click.option("--tag", metavar="T", help="Take only scenes of the core suite with this tag.")
@out_option(help_text=OUT)
@run_options
def crossval(tag: str | None, out: Path, **options: Any) -> None:
    """Compare all default engines on the core suite, and write a report.

    The core suite is the scenes of paper/ and basics/; the engines are those of the default set in `barchain engines`.
    Exits with 1 where `barchain compare` does, and also for each scene that no engine with independent physics passes.
    """
    from scenarios import load_scene

    core = [load_scene(name) for name in scenes_of("core")]
    chosen = core if tag is None else having(core, "tag", tag, {s.name: s.tags for s in core})
    compare_and_render(chosen, None, out, need_external=True, **options)


def compare_and_render(
    scenes: list[Scene], names: tuple[str, ...] | None, out: Path, *, need_external: bool, quick: bool = False,
    settings: tuple[GivenSetting, ...], kept: dict[str, Any], **how: Any,
) -> None:  # fmt: skip
    """Run the comparison with progress, render the report, print the verdicts, and exit with 1 if it did not pass.

    Without `names` all default engines take part, or with `quick` one of each library.
    """
    from barchain.cli.common.options import settings_by_engine
    from barchain.cli.common.progress import verdicts_shown
    from barchain.runs.choices import chosen_engines, one_of_each, programs_here
    from barchain.studies.comparison.run import run_comparison
    from reports.render import check_others, render
    from scenarios.plural import plural

    engines = chosen_engines(names)
    if names is None and quick:
        engines = one_of_each(engines)
    chosen = settings_by_engine(settings, engines)
    check_others("crossval", out)
    if names is None and (left := programs_here()):
        say(f"engines.toml here has {plural(len(left), 'program')}, which run where they are named: {', '.join(left)}")
    with verdicts_shown(len(scenes) * len(engines)) as reporter:
        result = run_comparison(
            scenes, names, out, settings=chosen, need_external=need_external, registered=engines,
            render=lambda folder: render(folder)[0], command=typed(), reporter=reporter, **kept, **how,
        )  # fmt: skip
    show_verdict(result, out)
    show_unchecked(result, engines, out)
    show_advice(scenes, engines)
    end_study(result, result.report)


def show_verdict(result: ComparisonResult, out: Path) -> None:
    """Print the number of each outcome, the gravest failures, and the unsupported pairs with reasons."""
    from reports.results.outcome import SEVERITY, Outcome

    say(counts_of(result.outcomes.values()))
    wrong = [(pair, o) for pair, o in result.outcomes.items() if not o.ok or o is Outcome.TOO_COARSE]
    wrong.sort(key=lambda found: SEVERITY.index(found[1]), reverse=True)
    shown = len(wrong) if verbose() else MOST_SHOWN
    for (scene, engine), outcome in wrong[:shown]:
        say(f"  {scene}  {engine}  {outcome}: {why(result.metrics, scene, engine, outcome)}")
    if len(wrong) > shown:
        say(f"  and {len(wrong) - shown} more: barchain show {quote(str(out))} --where metric=verdict")
    idle = {engine for (_, engine), outcome in wrong if outcome is Outcome.NOTHING_COMPARED}
    rows = result.metrics[(result.metrics.outcome == "unsupported") & ~result.metrics.engine.isin(idle)]
    left = rows.drop_duplicates(["scene", "engine"])
    for (name, reason), own in left.groupby(["engine", "reason"], sort=False):
        say(f"  {', '.join(own.scene)}  {name}  unsupported: {reason}")


def why(metrics: pd.DataFrame, scene: str, engine: str, outcome: Outcome) -> str:
    """Reason of a failed pair in one line: that of the whole run, or of its first quantity, and which others fail."""
    own = metrics[(metrics.scene == scene) & (metrics.engine == engine) & (metrics.outcome == outcome.value)]
    first, *others = dict.fromkeys(sorted(own.quantity, key=lambda quantity: quantity != "run"))
    reason = next((text for text in own.reason[own.quantity == first] if text), outcome.advice)
    also = f" (also {', '.join(others)})" if others else ""
    return f"{first}: {' '.join(reason.split())}{also}"


def show_unchecked(result: ComparisonResult, engines: Mapping[str, Registration], out: Path) -> None:
    """Print the scenes in which no attitude that passed has an independent check."""
    from barchain.studies.comparison.external_coverage import unchecked_attitudes
    from reports.results.comparison import FILES

    independent = {name for name, registration in engines.items() if registration.external}
    found = unchecked_attitudes(result.metrics, result.outcomes, independent, FILES.sound_record(out))
    for scene, names in found.items():
        said = "no independent check of the attitude; the judging solution has the same equations as"
        say(f"  {scene}: {said} {', '.join(names)}")


def show_advice(scenes: list[Scene], engines: Mapping[str, Registration]) -> None:
    """Print how independent engines that reject only the instants of a scene would support it."""
    from barchain.studies.comparison.external_coverage import instants_advice

    for scene in scenes:
        if advice := instants_advice(scene, engines):
            say(f"  {scene.name}: {advice}")
