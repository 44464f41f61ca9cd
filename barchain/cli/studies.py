"""Commands of studies: `cost`, `scaling`, `roundoff`, `stability`, `effects`, `ensemble` and `sweep`.

Each command gives its options to a study, which makes the runs, the tables and the page.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.numbers import MOST_BARS, MOST_RUNS, MOST_SAMPLES, ORBITS, SEED, NamedPath, RealNumber
from barchain.cli.common.options import (
    JOINS,
    OWN_PAGE,
    engine_option,
    executor_options,
    minutes_option,
    need_loaded,
    optional_scenes,
    out_option,
    repeats_option,
    result_options,
    scene_argument,
    set_option,
    settings_by_engine,
    time_limit_option,
)
from barchain.cli.common.result_folder import end_study, need_writable, run_shown
from barchain.cli.common.terminal import counts_of, literal, say, show, show_rows
from barchain.cli.show import MOST_SHOWN, show_table
from barchain.runs.job import TIME_LIMIT_S
from barchain.studies.defaults import (
    BARS,
    COST,
    DIVIDED_SCENE,
    EFFECTS,
    FAST,
    MATTERS,
    RTOL,
    RTOLS,
    SCALING,
    SLOW,
    STABILITY_LIMIT_S,
    WIDTHS_M,
)

if TYPE_CHECKING:
    from rich.table import Table

    from barchain.cli.common.options import GivenSetting
    from barchain.runs.executors import Executor
    from barchain.studies.stability.study import StabilityResult
    from barchain.studies.study import StudyEnd
    from reports.chapters.effects import BudgetTable
    from reports.render import Rendered

STUDIED = "all that are installed, also those that only studies need"
SHOWN_RAD = (1e-4, 1e-6, 1e-8)  # errors whose times the command prints; the page has more
HOW_REACHED = (
    "Times are interpolated between an engine's runs; beside each is the setting of the cheapest run that reaches the "
    "error. ≤: the coarsest run is already more accurate."
)
PARTS = ("evaluation", "trajectories", "engines", "times")
ENSEMBLE_ENGINE = "reference-fast"
SCREEN, WORDS, NUMBERS = 120, 20, 28  # columns of the screen, and at most of a cell of words or of numbers


@click.command(short_help="Measure errors against run times.")
@optional_scenes
@engine_option(STUDIED)
@out_option()
@click.option("--orbits", metavar="N", type=ORBITS, default=1.0, show_default=True,
              help="Run each scene for this many orbits from its start, or to its end.")  # fmt: skip
@repeats_option(COST.repeats)
@minutes_option(COST.minutes, more="; the coarsest setting of each engine is run in any case")
@time_limit_option(COST.time_limit_s, more=", and leave out a run that is expected to take longer")
@result_options
def cost(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, orbits: float, kept: dict[str, bool], **limits: Any
) -> None:
    """Measure errors and run times of every setting of every engine.

    SCENEs are names, files or folders; default: those of paper/. Errors are against the certified solution. Exits with
    1 if an engine fails at all of its settings in a scene, if an engine that was named runs in none of the scenes, or
    if nothing is measured.
    """
    from barchain.studies.cost.study import cost_study

    result, rendered = run_shown(out, cost_study(scenes or None, names or None, orbits, **limits), kept)
    show_reach(out)
    show_points(result, rendered)


def show_reach(out: Path) -> None:
    """Print time and setting with which each engine reaches some errors of the attitude, scene by scene."""
    from reports.results.cost import busy_machine, read_cost
    from reports.text.numerals import decade

    tables = read_cost(out)
    reach = tables.reach
    own = reach[(reach.quantity == "attitude") & (reach.measure == "seconds") & reach.target.isin(SHOWN_RAD)]
    for scene, found in own.groupby("scene", sort=False):
        rows = [
            (str(engine), *map(reach_words, targets.sort_values("target", ascending=False).itertuples()))
            for engine, targets in found.groupby("engine", sort=False)
        ]
        show_rows((str(scene), *(f"{decade(target)} rad" for target in SHOWN_RAD)), rows)
    if len(own):
        say(HOW_REACHED)
        if busy := busy_machine(tables.record):
            say(f"The machine was busy: {busy} while times were taken. Ratios of times may be off.")


def reach_words(row: Any) -> str:
    """Time in which an engine reaches an error, and the setting of a run that does; or why it reaches none."""
    from reports.text.numerals import span

    if not row.reached_by:
        return str(row.reason or row.status)
    return f"{'≤ ' if row.status == 'at most' else ''}{span(row.cost)}  {row.reached_by}"


@click.command(
    short_help="Measure time and memory against the number of bars.",
    help=f"""Measure time and memory against the number of bars.

    The times are those of an evaluation and of an orbit. The chain is that of {DIVIDED_SCENE}, cut into N bars. Exits
    with 1 if an engine fails at every number of bars, if an engine that was named does not run at all, or if nothing
    is measured.
    """,
)
@engine_option(STUDIED)
@click.option("--bars", multiple=True, type=click.IntRange(2, MOST_BARS), metavar="N", default=BARS,
              help=f"Cut the chain into N bars. May be repeated; default: 2 to {BARS[-1]}.")  # fmt: skip
@out_option()
@repeats_option(SCALING.repeats)
@minutes_option(SCALING.minutes, more="; nothing more is begun after it")
@time_limit_option(
    SCALING.time_limit_s, more=", and run an orbit that is expected to take longer in part, or not at all"
)
@result_options
def scaling(names: tuple[str, ...], bars: tuple[int, ...], out: Path, kept: dict[str, bool], **limits: Any) -> None:
    """Measure time and memory against the number of bars."""
    from barchain.studies.scaling.study import scaling_study

    show_points(*run_shown(out, scaling_study(names or None, bars, **limits), kept))


def show_points(result: StudyEnd, rendered: Rendered) -> None:
    """Print how many points of a study of times ended how, and end by it."""
    say(counts_of(result.ends))
    end_study(result, rendered.page)


@click.command(short_help="Measure the digits left by round-off, and the floor of an engine.")
@optional_scenes
@engine_option("none, and the digits of SCENE in relative and absolute coordinates", classes=True)
@set_option
@click.option("--orbits", metavar="N", type=ORBITS, help="Run N orbits of each SCENE; default: its whole run.")
@out_option()
@click.option("--part", "parts", multiple=True, metavar="PART", type=click.Choice(PARTS),
              help=f"Without SCENE: run this part of the study: {', '.join(PARTS)}. May be repeated; default: all "
                   "four.")  # fmt: skip
@click.option("--size", "sizes", multiple=True, metavar="R", type=RealNumber(1e-12, 1e-2),
              help="Without SCENE: judge one evaluation at this size: a bar's length over the Earth's radius, a power "
                   "of ten. May be repeated; default: eleven sizes from 1e-2 to 1e-12.")  # fmt: skip
@click.option("--full", is_flag=True,
              help="Without SCENE: all sizes, arithmetics and numbers of bars, finer steps, longer runs.")  # fmt: skip
@executor_options
@result_options
def roundoff(
    scenes: tuple[str, ...], names: tuple[str, ...], settings: tuple[GivenSetting, ...], orbits: float | None,
    out: Path, parts: tuple[str, ...], sizes: tuple[float, ...], executor: Executor, kept: dict[str, bool], *,
    full: bool,
) -> None:  # fmt: skip
    """Measure the digits that round-off leaves.

    Of SCENEs, names, files or folders: those of reactions, angles and track over time, in relative and absolute
    coordinates, from single to quadruple precision. With --engine: the floor of an engine in them, from runs whose
    inputs lie two units in the last place away, with a tolerance for each channel, and the precision in which the
    engine computes. Without SCENE: those of the reactions against the size of a bar. Exits with 1 if a task or a run
    fails.
    """
    from barchain.runs.choices import chosen_engines
    from barchain.studies.roundoff.study import roundoff_study, scene_study

    if any((parts, sizes, full) if scenes else (names, settings, orbits)):
        raise click.UsageError(
            "--part, --size and --full go without SCENE" if scenes else "--engine, --set and --orbits go with SCENE"
        )
    if scenes:
        engines = chosen_engines(names) if names else {}
        study = scene_study(scenes, engines, settings_by_engine(settings, engines), orbits, executor)
    else:
        try:
            study = roundoff_study(parts or PARTS, sizes, full=full, executor=executor)
        except ValueError as error:
            raise click.UsageError(f"--size: {error}") from error
    result, rendered = run_shown(out, study, kept)
    show_scenes(rendered.view, study.parts)
    end_study(result, rendered.page)


def show_scenes(view: Any, parts: tuple[str, ...]) -> None:
    """Print the fewest digits of scenes in each precision, or the floors of engines with their tolerances."""
    from reports.text.numerals import typed

    for found in view.scene_digits if "scenes" in parts else ():
        say(found.headline)
        cells = [[name, *(f"{d.least:.1f}" if d else "" for d in left)] for name, left in found.lines]
        show_rows(("digits", *found.heads), cells, right=found.heads)
    heads = {"median": "median", "q95": "95 %", "floor": "floor", "tolerance": "tolerance", "rtol": "rtol",
             "run_tolerance": "for the whole run", "run_rtol": "its rtol"}  # fmt: skip
    for found in view.scene_floors if "floors" in parts else ():
        for words in found.headlines:
            say(f"{found.scene}  {words}")
        rows = [(r["engine"], r["title"], r["unit"], *(typed(r[c], 2) or "none" for c in heads)) for r in found.lines]
        show_rows(("engine", "channel", "unit", *heads.values()), rows, right=[*heads.values()])


@click.command(short_help="Classify the stability of engines in hard scenes.")
@optional_scenes
@engine_option("the engines marked so in `barchain engines`, and SciPy's solvers")
@out_option(help_text=OWN_PAGE)
@time_limit_option(STABILITY_LIMIT_S, more="; a run of a form of the reference after ten times that")
@executor_options
@click.option("--full", is_flag=True, help="Run pairs that take minutes too, e.g. NumPy in long scenes.")
@result_options
@click.option("--accept", "accepted", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Record these outcomes as expected in this file, and keep those of other pairs there.")  # fmt: skip
def stability(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, accepted: Path | None, kept: dict[str, bool],
    **how: Any,
) -> None:  # fmt: skip
    """Run every engine on every hard scene at three settings, and classify its stability.

    SCENEs are names, files or folders; default: all of hard/ but those tagged huge. Exits with 1 if a form of the
    reference is not stable in a well-posed scene, or if an outcome differs from the recorded one.
    """
    from barchain.studies.stability.plan import accept, recorded
    from barchain.studies.stability.study import stability_study
    from scenarios import scene_names

    study = stability_study(scenes, names, **how)
    if accepted:
        recorded(accepted)
        need_writable(accepted, "--accept")
    result, rendered = run_shown(out, study, kept)
    show_stability(result)
    if accepted:
        shipped = set(scene_names())
        accept({pair: f for pair, f in result.findings.items() if pair[0] in shipped}, accepted)
        say(f"recorded in {accepted}")
        result = dataclasses.replace(result, changes=())
    end_study(result, rendered.page)


def show_stability(result: StabilityResult) -> None:
    """Print how many ended how, what changed, and where the reference is not stable."""
    say(counts_of(f.stability for f in result.findings.values()))
    for changed in result.changes:
        say(changed.words)
    for scene, engine in result.ours:
        found = result.findings[scene, engine]
        say(f"{scene}  {engine} must be stable, and is {found.stability}: {found.reason}")


@click.command(short_help="Measure relevance and run time of each effect.")
@scene_argument
@out_option(None, help_text=f"{JOINS[:-1]}; default: print only.")
@click.option("--rtol", metavar="R", type=RealNumber(*RTOLS), default=RTOL, show_default=True,
              help="Request this relative accuracy of a step; a run at 10 R shows the numerical error.")  # fmt: skip
@click.option("--matters", metavar="X", type=RealNumber(0.0, 1.0, min_open=True), default=MATTERS, show_default=True,
              help="Call an effect relevant from this change on: rad of attitude, or relative to the largest reaction "
                   "or to the initial distance from the centre.")  # fmt: skip
@click.option("--width", "width_m", metavar="M", type=RealNumber(*WIDTHS_M),
              help="Take every bar to be so wide, in m, for drag and sunlight that SCENE does not have; default: the "
                   "width of the one that it has. Without a width there is no conclusion on them.")  # fmt: skip
@click.option("--engine", metavar="NAME", type=click.Choice([FAST, SLOW]),
              help=f"Run this form of the reference, {FAST} or {SLOW}; default: {FAST} where it is installed and "
                   "supports the scene.")  # fmt: skip
@repeats_option(EFFECTS.repeats)
@minutes_option(EFFECTS.minutes, more="; no further round of timing is begun after it")
@executor_options
@result_options
def effects(
    scene: str, out: Path | None, engine: str | None, minutes: float, kept: dict[str, bool], **options: Any
) -> None:
    """Measure relevance and run time of each effect in SCENE.

    SCENE is a name or a file. Each effect is switched off, or on with stated defaults where the scene does not
    have it. Exits with 1 if a run fails.
    """
    from barchain.studies.effects.study import WidthError, effects_study
    from scenarios import load_scene

    if engine:
        need_loaded(engine)
    try:
        study = effects_study(load_scene(scene), engine=engine, seconds=60.0 * minutes, **options)
    except WidthError as error:
        raise click.UsageError(f"--width: {error}") from error
    result, rendered = run_shown(out, study, kept)
    show_effects(rendered.view)
    end_study(result, rendered.page if out else None)


def show_effects(view: Any) -> None:
    """Print the tables, the effects by relevance, and what limits the conclusions."""
    for table in view.tables:
        show(printed(table))
    for name, titles in view.groups.items():
        say(f"{name}: {', '.join(titles)}")
    for remark in view.remarks:
        say(f"  {remark}")
    if view.rounds:
        say(f"rounds of timing: {view.rounds}; more --minutes, and more --repeats, narrow the intervals")


def printed(table: BudgetTable) -> Table:
    """Table for the terminal: it fits 120 columns, its longest words folded."""
    from rich.table import Table

    made = Table(box=None, header_style="bold", title=table.title, title_justify="left", title_style="")
    columns = len(table.headings)
    room = (SCREEN - WORDS * table.wordy - 2 * columns) // (columns - table.wordy)
    for k, heading in enumerate(table.headings):
        wordy = k < table.wordy
        width = WORDS if wordy else min(NUMBERS, room)
        made.add_column(literal(heading), justify="left" if wordy else "right", max_width=width)
    for row in table.rows:
        made.add_row(*map(literal, row))
    return made


@click.command(short_help="Run perturbed copies of a scene, and take quantiles.")
@scene_argument
@click.option("--vary", multiple=True, required=True, metavar="KEY=DISTRIBUTION(...)",
              help="Draw a value of the scene, e.g. 'angle_deg=normal(80, 1)' (all bars alike), "
                   "'mass_kg[2]=lognormal(100, 0.1)' (bar 2), 'rate_factor[*]=uniform(0.9, 1.1)' (each bar by itself). "
                   "May be repeated.")  # fmt: skip
@click.option("--runs", metavar="N", type=click.IntRange(1, MOST_RUNS), default=1000, show_default=True,
              help="Run N perturbed copies.")  # fmt: skip
@out_option(help_text=OWN_PAGE)
@click.option("--orbits", metavar="N", type=ORBITS, help="Run N orbits; default: the scene's whole run.")
@click.option("--samples", metavar="N", type=click.IntRange(2, MOST_SAMPLES), default=101, show_default=True,
              help="Take quantiles at N instants.")  # fmt: skip
@click.option("--rtol", metavar="R", type=RealNumber(1e-15, 1.0), default=1e-8, show_default=True,
              help="Request this relative accuracy of a step.")  # fmt: skip
@click.option("--seed", metavar="N", type=SEED, default=1, show_default=True,
              help="Draw with this seed; equal seeds draw equal copies.")  # fmt: skip
@executor_options
@result_options
def ensemble(scene: str, vary: tuple[str, ...], runs: int, out: Path, kept: dict[str, bool], **options: Any) -> None:
    """Run many perturbed copies of SCENE, and take quantiles of attitude and reactions over time.

    SCENE is a name or a file. Runs are compiled: the engine reference-fast is needed. Exits with 1 if a run fails,
    or if a Dask cluster fails while runs are on it; --resume goes on from the runs that were done.
    """
    need_loaded(ENSEMBLE_ENGINE)
    from barchain.studies.distributions import VariationError
    from barchain.studies.ensemble.study import ensemble_study

    try:
        result, rendered = run_shown(out, ensemble_study(scene, vary, runs, **options), kept)
    except VariationError as error:
        raise click.UsageError(str(error)) from error
    say(f"{runs} runs in {result.seconds['run']:.2f} s: {counts_of(result.tally.outcomes.elements())}")
    end_study(result, rendered.page)


@click.command(short_help="Vary numbers of a scene, and measure each run.")
@scene_argument
@click.option("--vary", multiple=True, required=True, metavar="KEY=VALUES",
              help="Vary a number of the scene's file: a grid, orbit.speed_factor=1:1.3:7 (low, high, count), a list, "
                   "chain.bars=2,4,8, or a distribution, 'chain.angle_deg[2]=normal(80, 1)', of bar 2. "
                   "May be repeated; grids and lists make all combinations, draws are made together. Keys go "
                   "together: 'chain.length_m=10,20 with chain.mass_kg=1,3', "
                   "chain.mass_kg=0.2*chain.length_m.")  # fmt: skip
@click.option("--measure", "measures", multiple=True, metavar="MEASURE",
              help="Measure this of each run: largest, least, peak (size), final, rms or p95 of a channel, e.g. "
                   "'largest(tension)', 'final(attitude[2])' (of bar 2); `barchain explain channels` lists them. "
                   "May be repeated; default: largest reaction, both ends of the altitude.")  # fmt: skip
@click.option("--runs", metavar="N", type=click.IntRange(1, MOST_RUNS),
              help="Draw N times from the distributions; default: 1000.")  # fmt: skip
@click.option("--seed", metavar="N", type=SEED, default=1, show_default=True,
              help="Draw with this seed; equal seeds draw equal numbers.")  # fmt: skip
@engine_option("reference-fast where it is built and supports the scene, else reference")
@set_option
@out_option(help_text=OWN_PAGE)
@time_limit_option(TIME_LIMIT_S)
@executor_options
@result_options
def sweep(
    scene: str, vary: tuple[str, ...], names: tuple[str, ...], settings: tuple[GivenSetting, ...], out: Path,
    kept: dict[str, bool], **options: Any,
) -> None:  # fmt: skip
    """Run SCENE with other numbers, in some engines, and measure each run: charts, maps or histograms.

    SCENE is a name or a file. Every value is checked before the first run. Exits with 1 if a run fails, or if a
    measure has no value in any run.
    """
    from barchain.runs.choices import chosen_engines
    from barchain.runs.other_settings import default_engine
    from barchain.studies.distributions import VariationError
    from barchain.studies.sweep.measure import MeasureError
    from barchain.studies.sweep.study import sweep_study
    from scenarios import load_scene

    loaded = load_scene(scene)
    engines = names or (default_engine(loaded),)
    try:
        by_engine = settings_by_engine(settings, chosen_engines(engines))
        study = sweep_study(loaded, vary, engines=engines, settings=by_engine, **options)
    except (VariationError, MeasureError) as error:
        raise click.UsageError(str(error)) from error
    result, rendered = run_shown(out, study, kept)
    say(f"{len(result.samples)} runs: {counts_of(result.samples['outcome'])}")
    if len(result.samples) <= MOST_SHOWN:
        show_table(result.samples.drop(columns=["run", "setting", "seconds"]))
    end_study(result, rendered.page)
