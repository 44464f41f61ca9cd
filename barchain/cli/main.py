"""The command line: `barchain scenes | engines | schema | simulate | compare | crossval | report`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from adapters.engine import EngineError
from adapters.registry import UnknownEngineError, engines
from barchain import api
from barchain.cli import listing
from barchain.cli.certified import certified_solutions
from barchain.cli.cost import cost
from barchain.cli.effects import effects
from barchain.cli.ensemble import ensemble
from barchain.cli.progress import verdicts_shown
from barchain.cli.roundoff import roundoff
from barchain.cli.scaling import scaling
from barchain.cli.selftest import selftest
from barchain.cli.stability import stability
from barchain.crossval.run import run_comparison
from barchain.record.command import typed
from barchain.run.limits import TIME_LIMIT_S
from barchain.run.selection import chosen_engines
from barchain.run.settings import SettingError
from barchain.solutions.certified_table import DamagedTableError
from reports.tables.crossval import DamagedResultsError
from reports.tables.schema import SchemaVersionError
from scenarios import SceneError, SceneFile, load_scene, nearest, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene

CORE = ("paper/", "basics/")
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130
RESUMED = ("compare", "crossval", "cost", "scaling", "stability")


def main() -> None:
    """Entry point: bad input ends in one readable line a fault and exit code 2, never in a traceback."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Exit code of a command line."""
    try:
        return cli.main(arguments, prog_name="barchain", standalone_mode=False) or 0
    except click.ClickException as error:
        return complain(error.format_message(), BAD_INPUT)
    except (SceneError, UnknownEngineError, SettingError, SchemaVersionError) as error:
        return complain(str(error), BAD_INPUT)
    except OSError as error:  # a file or folder that is not there, not a folder, not to be written
        return complain(f"{error.filename}: {error.strerror}" if error.filename else str(error), BAD_INPUT)
    except (EngineError, DamagedTableError, DamagedResultsError, json.JSONDecodeError) as error:
        damaged = "a file of these results is damaged: " if isinstance(error, json.JSONDecodeError) else ""
        return complain(f"{damaged}{error}", FAILED)
    except (click.Abort, KeyboardInterrupt):
        more = ", and --resume goes on from it" if arguments[:1] and arguments[0] in RESUMED else ""
        return complain(f"interrupted; what was done is kept{more}", INTERRUPTED)


def complain(message: str, code: int) -> int:
    """Print one line for each fault to standard error, and give the exit code back."""
    for line in message.splitlines():
        print(f"barchain: {line}", file=sys.stderr)
    return code


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="barchain")
def cli() -> None:
    """Cross-validate multibody engines on a chain of rigid bars in orbit."""


@cli.command()
@click.option("--tag", help="Only scenes with this tag.")
def scenes(tag: str | None) -> None:
    """List the scenes that come with barchain."""
    found = [load_scene(name) for name in scene_names()]
    listing.show_scenes(found if tag is None else tagged(found, tag))


@cli.command(name="engines")
def list_engines() -> None:
    """List the engines: what each can do, and how to get those that are missing."""
    listing.show_engines(engines())


@cli.command()
def schema() -> None:
    """Print the JSON Schema of a scene file."""
    print(json.dumps(SceneFile.model_json_schema(), indent=2))


@cli.command()
@click.argument("scene")
@click.option("--engine", default="reference", show_default=True, help="Engine to run.")
@click.option("--set", "setting", metavar="KNOB=VALUE", help="Accuracy, e.g. rtol=1e-12 or steps_per_orbit=4000.")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Table to write: .parquet or .csv.")
@click.option("--time-limit", type=click.FloatRange(min=0, min_open=True), default=TIME_LIMIT_S, show_default=True,
              help="Wall time allowed, s.")  # fmt: skip
@click.option("--condition", is_flag=True, help="Add the joint system's condition number (reference).")
def simulate(scene: str, engine: str, setting: str | None, out: Path, time_limit: float, condition: bool) -> None:
    """Run SCENE (a name or a file) in one engine and write its samples."""
    if out.suffix not in listing.TABLE_WRITERS:
        raise click.UsageError(f"--out {out}: ending {out.suffix!r} given, allowed: .parquet, .csv")
    if not out.parent.is_dir():
        raise click.UsageError(f"--out {out}: there is no folder {out.parent}")
    try:
        seen = api.simulate(scene, engine, time_limit_s=time_limit, condition=condition, **parse_setting(setting))
    except (SceneError, SettingError):
        raise
    except ValueError as error:  # the engine can't carry this scene
        raise click.UsageError(str(error)) from error
    listing.TABLE_WRITERS[out.suffix](seen.to_frame(), out)
    click.echo(f"wrote {out}: {len(seen.t_s)} samples" + (f"; {seen.ended}" if seen.ended else ""))


def parse_setting(text: str | None) -> dict[str, float]:
    """``{"rtol": 1e-12}`` from ``rtol=1e-12``."""
    if text is None:
        return {}
    name, equals, value = text.partition("=")
    try:
        return {name.strip(): float(value)}
    except ValueError:
        given = f"{text!r} given" if equals else f"{text!r} given (no value)"
        raise click.UsageError(f"--set: {given}, allowed: KNOB=NUMBER, e.g. rtol=1e-12") from None


def parse_settings(texts: tuple[str, ...]) -> dict[str, dict[str, float]]:
    """``{"exudyn": {"steps_per_orbit": 2000}}`` from ``exudyn:steps_per_orbit=2000``."""
    found: dict[str, dict[str, float]] = {}
    for text in texts:
        engine, colon, setting = text.partition(":")
        if not colon:
            raise click.UsageError(
                f"--set: {text!r} given, allowed: ENGINE:KNOB=NUMBER, e.g. exudyn:steps_per_orbit=2000"
            )
        found[engine] = parse_setting(setting)
    return found


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Options that compare and crossval share."""
    for option in (
        click.option(
            "--set",
            "settings",
            multiple=True,
            metavar="ENGINE:KNOB=VALUE",
            help="Judge an engine at another setting.",
        ),
        click.option(
            "--time-limit",
            type=click.FloatRange(min=0, min_open=True),
            default=TIME_LIMIT_S,
            show_default=True,
            help="Wall time allowed to one run, s.",
        ),
        click.option("--workers", type=click.IntRange(min=1), help="Processes side by side; all cores by default."),
        click.option("--resume", is_flag=True, help="Go on from what an earlier, cut-off run left in the folder."),
    ):
        command = option(command)
    return command


@cli.command()
@click.argument("scenes", metavar="SCENE...", nargs=-1, required=True)
@click.option(
    "--engine",
    "names",
    multiple=True,
    metavar="NAME",
    help="Engine to compare; may be repeated; all by default.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder for report and tables.",
)
@run_options
def compare(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, settings: tuple[str, ...], time_limit: float,
    workers: int | None, resume: bool,
) -> None:  # fmt: skip
    """Compare engines on SCENEs (names or files) and write a report."""
    found = [load_scene(s) for s in scenes]
    compare_and_render(found, names or None, out, settings, time_limit, workers, resume, need_external=False)


@cli.command()
@click.option("--tag", help="Only scenes of the core suite with this tag.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("report"),
    show_default=True,
    help="Folder for report and tables.",
)
@run_options
def crossval(
    tag: str | None, out: Path, settings: tuple[str, ...], time_limit: float, workers: int | None, resume: bool
) -> None:  # fmt: skip
    """Compare all engines on the core suite: the paper's scenes and those with closed-form answers."""
    core = [load_scene(name) for name in scene_names() if name.startswith(CORE)]
    if tag is not None:
        core = tagged(core, tag)
    compare_and_render(core, None, out, settings, time_limit, workers, resume, need_external=True)


def tagged(found: list[Scene], tag: str) -> list[Scene]:
    """Those of some scenes that carry `tag`; none is bad usage."""
    tags = sorted({t for s in found for t in s.tags})
    if tag not in tags:
        raise click.UsageError(f"--tag {tag}: no such scene has it{nearest(tag, tags)}; there are: {', '.join(tags)}")
    return [s for s in found if tag in s.tags]


def compare_and_render(
    scenes: list[Scene], names: tuple[str, ...] | None, out: Path, settings: tuple[str, ...], time_limit: float,
    workers: int | None, resume: bool, *, need_external: bool,
) -> None:  # fmt: skip
    """Run the comparison with progress, render the report, and exit by its outcome."""
    chosen = parse_settings(settings)
    total = len(scenes) * len(chosen_engines(names))
    with verdicts_shown(total) as show:
        result = run_comparison(
            scenes, names, out, time_limit_s=time_limit, workers=workers, settings=chosen, resume=resume,
            need_external=need_external, command=typed(), progress=show,
            notes=show.note,
        )  # fmt: skip
    from reports.render import render  # noqa: PLC0415  # plots take a second to import

    html, _ = render(out)
    listing.show_verdict(result, html)
    if not result.passed:
        raise click.exceptions.Exit(FAILED)


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def report(folder: Path) -> None:
    """Render the report of DIR again, and the chapters of studies there, from stored tables alone."""
    from reports.render import render_all  # noqa: PLC0415

    click.echo(f"wrote {', '.join(map(str, render_all(folder)))}")


cli.add_command(cost)
cli.add_command(effects)
cli.add_command(ensemble)
cli.add_command(roundoff)
cli.add_command(scaling)
cli.add_command(selftest)
cli.add_command(stability)
cli.add_command(certified_solutions)
