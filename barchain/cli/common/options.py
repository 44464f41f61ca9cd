"""Options and arguments with one meaning in every command: scenes, engines and their settings, folders, limits.

Scenes and engines are checked before anything runs, and completed by the shell.
"""

from __future__ import annotations

import functools
import os
import re
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from barchain.cli.common.exit_codes import MissingEngineError
from barchain.cli.common.numbers import (
    MINUTES,
    MOST_REPEATS,
    MOST_WORKERS,
    POSITIVE_SECONDS,
    WORDS,
    NamedPath,
    RealNumber,
)
from barchain.runs.executors import WORKERS_S, chosen_executor

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from adapters.registry import Registration
    from scenarios import Scene

FORM = "[ENGINE:]KEY=VALUE"
SOME_NUMBER = RealNumber()
EXAMPLE = "rtol=1e-12 or exudyn:steps_per_orbit=2000"
F = TypeVar("F", bound="Callable[..., object]")

JOINS = "Write tables and pages into this folder; beside a comparison, its report includes the study."
OWN_PAGE = "Write tables and a page into this folder."
CORE = ("paper", "basics")
"""Folders of the core suite, which can be named as one"""
ALL_WORDS = ", or `all` of the default set and the programs of engines.toml here"
WORKERS = "Run N runs side by side; default: as many as there are cores."


def shipped_scene_names() -> list[str]:
    """Names of the scenes that come with barchain, found without importing what reads them."""
    spec = find_spec("scenarios")
    folders = [Path(place) for place in (spec and spec.submodule_search_locations) or ()]
    return sorted(p.relative_to(f).with_suffix("").as_posix() for f in folders for p in f.rglob("*.toml"))


def scenes_of(given: str) -> list[str]:
    """Scenes that a word on the command line stands for: a folder's scenes, those of the core suite, or itself."""
    folder, every = given.rstrip("/"), shipped_scene_names()
    wanted = CORE if folder == "core" else (folder,)
    found = [name for name in every if name.rpartition("/")[0] in wanted]
    if given not in every and not found:
        found = sorted(str(file) for file in Path(given).glob("*.toml"))
    return found or [given]


def having(found: list[Scene], option: str, wanted: str, labels: Mapping[str, Iterable[str]]) -> list[Scene]:
    """Scenes that have a label, of some scenes.

    Raises
    ------
    UsageError
        If none has it; the message names the nearest label and all there are.
    """
    from scenarios import nearest

    known = sorted({label for own in labels.values() for label in own})
    if wanted not in known:
        there = f"there are: {', '.join(known)}" if known else "there are none"
        raise click.UsageError(f"--{option} {wanted}: no such scene has it{nearest(wanted, known)}; {there}")
    return [s for s in found if wanted in labels[s.name]]


class SceneType(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.5 on
    """Name of a scene that comes with barchain, or path of a scene file."""

    name = "scene"

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:  # noqa: ARG002
        """Names that begin with `incomplete`; the shell's own files if none does."""
        every = shipped_scene_names()
        folders = {n.rpartition("/")[0] for n in every} if param.nargs == -1 else ()
        names = [CompletionItem(n) for n in (*sorted(folders), *every) if n.startswith(incomplete)]
        return names or [CompletionItem(incomplete, type="file")]


class EngineType(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.5 on
    """Name of an installed engine; a missing one ends the command with its own exit code.

    ``MODULE:CLASS``, whose import a run tells of, and `all` pass where `classes` may be given.
    """

    name = "engine"

    def __init__(self, *, classes: bool = False) -> None:
        self.classes = classes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Check that the engine is registered and installed."""
        from adapters.registry import ALL, TARGET, UnknownEngineError

        given = str(value)
        if self.classes and re.fullmatch(f"{TARGET}|{ALL}", given):
            return given
        try:
            need_engine(given)
        except UnknownEngineError as error:
            self.fail(str(error), param, ctx)
        return given

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:  # noqa: ARG002
        """Registered names that begin with `incomplete`."""
        from adapters.registry import engines

        return [
            CompletionItem(name, help=r.missing or "installed")
            for name, r in engines().items()
            if name.startswith(incomplete)
        ]


SCENE, ENGINE = SceneType(), EngineType()


def need_engine(name: str) -> None:
    """Check that an engine is installed.

    Raises
    ------
    UnknownEngineError
        If no engine has that name.
    MissingEngineError
        If it is not installed; the message says how to get it.
    """
    from adapters.registry import find_engine

    missing = find_engine(name).missing
    if missing:
        raise MissingEngineError(f"{name}: {missing}")


def need_loaded(name: str) -> None:
    """Check that an engine that a command can't do without is installed, and that its adapter loads.

    Raises
    ------
    UnknownEngineError, MissingEngineError
        As :func:`need_engine`.
    AdapterLoadError
        If its adapter does not load.
    """
    from adapters.registry import find_engine
    from barchain.runs.asking import declarations_of

    need_engine(name)
    declarations_of(find_engine(name))


@dataclass(frozen=True)
class GivenSetting:
    """One `--set` as it was given."""

    engine: str
    """Empty where none is named"""
    key: str
    value: float

    def __str__(self) -> str:
        """``exudyn:steps_per_orbit=2000``."""
        return f"{self.engine}:{self.key}={self.value:g}".lstrip(":")


class SettingType(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.5 on
    """Text of the form ``[ENGINE:]KEY=VALUE``."""

    name = FORM

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> GivenSetting:
        """Take the text apart; whether the engine takes part is checked with the engines."""
        if isinstance(value, GivenSetting):
            return value
        engine, _, rest = str(value).rpartition(":")
        key, equals, number = rest.partition("=")
        try:
            found = SOME_NUMBER.convert(number, param, ctx)
        except click.BadParameter:
            given = f"{value} given" if equals else f"{value} given (no value)"
            self.fail(f"{given}, allowed: {FORM} with a number, e.g. {EXAMPLE}", param, ctx)
        return GivenSetting(engine, key.strip(), found)


SETTING = SettingType()


def settings_by_engine(
    given: Iterable[GivenSetting], chosen: Mapping[str, Registration]
) -> dict[str, dict[str, float]]:
    """``{"exudyn": {"steps_per_orbit": 2000}}``; a setting without an engine goes to every chosen engine that has it.

    Raises
    ------
    UsageError
        If a setting is for no chosen engine.
    SettingError
        If its engine has another accuracy parameter, or the value is out of range.
    """
    from barchain.runs.choices import choose_setting

    found: dict[str, dict[str, float]] = {}
    for setting in given:
        for engine in engines_of(setting, chosen):
            choose_setting(engine, {setting.key: setting.value}, chosen)
            found.setdefault(engine, {})[setting.key] = setting.value
    return found


def engines_of(setting: GivenSetting, chosen: Mapping[str, Registration]) -> list[str]:
    """Chosen engines that a setting is for.

    Raises
    ------
    UsageError
        If there is none.
    """
    from adapters.registry import UnknownEngineError
    from barchain.runs.asking import declarations_of
    from scenarios import nearest

    names = list(chosen)
    if setting.engine and setting.engine not in names:
        try:
            need_engine(setting.engine)
        except UnknownEngineError as error:
            raise click.UsageError(f"--set {setting}: {error}") from None
        raise click.UsageError(f"--set {setting}: {setting.engine} does not take part; there are: {', '.join(names)}")
    if setting.engine or len(names) == 1:  # whose own error then names its parameter
        return [setting.engine or names[0]]
    keys = {name: str(declarations_of(r).sweep.parameter) for name, r in chosen.items() if not r.missing}
    found = [name for name, key in keys.items() if key == setting.key]
    if found:
        return found
    allowed = sorted(set(keys.values()))
    near = nearest(setting.key, allowed)
    raise click.UsageError(f"--set {setting}: no engine has {setting.key}{near}; allowed: {', '.join(allowed)}")


def expanded(_ctx: click.Context, _param: click.Parameter, given: tuple[str, ...]) -> tuple[str, ...]:
    """Scenes with those of each named folder in its place."""
    return tuple(dict.fromkeys(name for word in given for name in scenes_of(word)))


scene_argument = click.argument("scene", metavar="SCENE", type=SCENE)
optional_scenes = click.argument("scenes", metavar="[SCENE]...", nargs=-1, type=SCENE, callback=expanded)
required_scenes = click.argument("scenes", metavar="SCENE...", nargs=-1, required=True, type=SCENE, callback=expanded)

set_option = click.option(
    "--set", "settings", multiple=True, metavar=FORM, type=SETTING,
    help="Set an engine's accuracy parameter, e.g. rtol=1e-12 or exudyn:steps_per_orbit=2000; without ENGINE: of every "
         "chosen engine that has it. May be repeated; default: each engine's own.",
)  # fmt: skip
workers_option = click.option("--workers", type=click.IntRange(1, MOST_WORKERS), metavar="N", help=WORKERS)
dask_option = click.option(
    "--dask",
    metavar="ADDRESS",
    type=WORDS,
    help="Make the runs on the workers of this Dask scheduler, e.g. tcp://10.0.0.1:8786; default: on this machine.",
)
dask_wait_option = click.option(
    "--dask-wait", metavar="S", type=POSITIVE_SECONDS, default=WORKERS_S, show_default=True,
    help="With --dask: give up if the scheduler has no worker for this time, in seconds.",
)  # fmt: skip
resume_option = click.option("--resume", is_flag=True, help="Go on from results in the folder that the same code made.")
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace results that are already there.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")


def result_options(command: Callable[..., None]) -> Callable[..., None]:
    """`--resume` and `--overwrite`, given to the command as one `kept`."""

    @functools.wraps(command)
    def gathered(**given: Any) -> None:
        kept = {name: given.pop(name) for name in ("resume", "overwrite")}
        command(**given, kept=kept)

    return resume_option(overwrite_option(gathered))


def executor_options(command: Callable[..., None]) -> Callable[..., None]:
    """`--workers`, `--dask` and `--dask-wait`, given to the command as one `executor`."""

    @functools.wraps(command)
    def gathered(**given: Any) -> None:
        workers, dask, wait_s = (given.pop(name) for name in ("workers", "dask", "dask_wait"))
        if dask is not None and workers is not None:
            raise click.UsageError("--workers counts runs on this machine; with --dask the cluster's threads decide")
        command(**given, executor=chosen_executor(workers, dask, wait_s))

    return workers_option(dask_option(dask_wait_option(gathered)))


def use_programs(_ctx: click.Context, _param: click.Parameter, files: tuple[Path, ...]) -> None:
    """Register the programs of files of engines, for this process and those that it starts."""
    if not files:
        return
    from adapters.command.entries import FILES, read_entries

    for file in files:
        if not file.is_file():
            raise click.UsageError(f"--engines {file}: no such file; --engine NAME takes an engine by its name")
        read_entries(file)
    earlier = os.environ.get(FILES)
    os.environ[FILES] = os.pathsep.join([*(str(file.resolve()) for file in files), *([earlier] if earlier else [])])


programs_option = click.option(
    "--engines", "program_files", metavar="FILE", multiple=True, expose_value=False, is_eager=True,
    callback=use_programs, type=NamedPath(path_type=Path, dir_okay=False),
    help="Read engines that are programs from this file too; those of engines.toml here run where they are named.",
)  # fmt: skip


def engine_option(default: str, names: str = "names", *, classes: bool = False) -> Callable[[F], F]:
    """`--engine NAME`, repeatable, with `--engines FILE`; `default` says which engines take part without it.

    With `classes` also `--engine MODULE:CLASS`, a class that no package registers, and `--engine all`.
    """
    named = click.option(
        "--engine", names, multiple=True, metavar="NAME|MODULE:CLASS|all" if classes else "NAME",
        type=EngineType(classes=classes),
        help=f"Take this engine{ALL_WORDS if classes else ''}. May be repeated; default: {default}.",
    )  # fmt: skip
    return lambda command: named(programs_option(command))


def out_option(default: str | None = "report", *, required: bool = False, help_text: str = "") -> Callable[[F], F]:
    """`--out DIR`: where results are written."""
    return click.option(
        "--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False), required=required,
        default=Path(default) if default and not required else None, show_default=bool(default) and not required,
        help=help_text or JOINS,
    )  # fmt: skip


def time_limit_option(default_s: float, more: str = "") -> Callable[[F], F]:
    """`--time-limit S`: wall time after which one run is ended."""
    return click.option(
        "--time-limit", "time_limit_s", metavar="S", type=POSITIVE_SECONDS, default=default_s, show_default=True,
        help=f"End a run after this wall time, in seconds{more}.",
    )  # fmt: skip


def minutes_option(default: float, more: str = "") -> Callable[[F], F]:
    """`--minutes M`: wall time that a study may take."""
    return click.option(
        "--minutes", metavar="M", type=MINUTES, default=default, show_default=True,
        help=f"Give the study a budget of this wall time, in minutes{more}.",
    )  # fmt: skip


def repeats_option(default: int) -> Callable[[F], F]:
    """`--repeats N`: how often each point is timed."""
    return click.option(
        "--repeats", metavar="N", type=click.IntRange(1, MOST_REPEATS), default=default, show_default=True,
        help="Time each point N times, as far as the budget goes.",
    )  # fmt: skip
