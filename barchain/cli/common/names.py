"""Scenes and engines as arguments: checked before anything runs, and completed by the shell."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from barchain.cli.common.exit_codes import MissingEngineError


def shipped_scene_names() -> list[str]:
    """Names of the scenes that come with barchain, found without importing what reads them."""
    spec = find_spec("scenarios")
    folders = [Path(place) for place in (spec and spec.submodule_search_locations) or ()]
    return sorted(p.relative_to(f).with_suffix("").as_posix() for f in folders for p in f.rglob("*.toml"))


CORE = ("paper", "basics")
"""Folders of the core suite, which can be named as one"""


def scenes_of(given: str) -> list[str]:
    """Scenes that a word on the command line stands for: a folder's scenes, those of the core suite, or itself."""
    folder, every = given.rstrip("/"), shipped_scene_names()
    wanted = CORE if folder == "core" else (folder,)
    found = [name for name in every if name.rpartition("/")[0] in wanted]
    if given not in every and not found:
        found = sorted(str(file) for file in Path(given).glob("*.toml"))
    return found or [given]


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
    """Name of an installed engine; a missing one ends the command with its own exit code."""

    name = "engine"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Check that the engine is registered and installed."""
        from adapters.registry import UnknownEngineError  # noqa: PLC0415

        try:
            need_engine(str(value))
        except UnknownEngineError as error:
            self.fail(str(error), param, ctx)
        return str(value)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:  # noqa: ARG002
        """Registered names that begin with `incomplete`."""
        from adapters.registry import engines  # noqa: PLC0415

        return [
            CompletionItem(name, help=r.missing or "installed")
            for name, r in engines().items()
            if name.startswith(incomplete)
        ]


class HostType(EngineType):
    """Name of an installed engine, or "none"."""

    name = "host"
    NONE = "none"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Check an engine's name; let "none" pass."""
        return self.NONE if value == self.NONE else super().convert(value, param, ctx)


SCENE, ENGINE, HOST = SceneType(), EngineType(), HostType()


def need_engine(name: str) -> None:
    """Check that an engine is installed.

    Raises
    ------
    UnknownEngineError
        If no engine has that name.
    MissingEngineError
        If it is not installed; the message says how to get it.
    """
    from adapters.registry import find_engine  # noqa: PLC0415

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
    from adapters.registry import find_engine  # noqa: PLC0415
    from barchain.runs.declared import engine_class  # noqa: PLC0415

    need_engine(name)
    engine_class(find_engine(name))
