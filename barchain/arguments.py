"""Arguments of the Python functions, checked before anything runs: wrong ones end in one sentence."""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from adapters.engine import SettingError, is_number
from adapters.registry import engines, find_engine
from scenarios import Scene, scene_names
from scenarios.nearest import nearest_name, nearest_scene
from scenarios.text import shorten, visible

if TYPE_CHECKING:
    from pathlib import Path


class ArgumentError(ValueError):
    """Argument of the wrong kind; the message gives its name, the given and the allowed values."""


def wrong(name: str, given: object, allowed: str) -> ArgumentError:
    """Error of an argument: what was given, what is allowed."""
    return ArgumentError(f"{name}: {visible(shorten(given))} given, allowed: {allowed}")


def scene_list(given: Any) -> list[Scene | str | Path]:
    """Scenes as a list.

    Raises
    ------
    ArgumentError
        If a text, a single scene, or nothing is given.
    """
    match = nearest_scene(given, scene_names()) if isinstance(given, str) else None
    hint = f' (did you mean ["{match}"]?)' if match else ', e.g. ["paper/fig05"]'
    return items("scenes", given, f"a list of scenes, each a name, a file's path or a Scene{hint}")


def engine_list(given: Any) -> list[str] | None:
    """Names of engines as a list; None where the default engines are meant.

    Raises
    ------
    ArgumentError
        If a text or an empty list is given.
    """
    match = nearest_name(given, engines()) if isinstance(given, str) else None
    hint = f' (did you mean ["{match}"]?)' if match else ', e.g. ["reference", "exudyn"]'
    allowed = f"None for the default engines, or a list of engines' names{hint}"
    return None if given is None else items("engines", given, allowed)


def items(name: str, given: Any, allowed: str) -> list[Any]:
    """Items of an iterable that is no text and not empty."""
    if isinstance(given, (str, bytes, os.PathLike)) or not isinstance(given, Iterable):
        raise wrong(name, given, allowed)
    found = list(given)
    if not found:
        raise wrong(name, given, allowed)
    return found


def check_settings(given: Any, chosen: Iterable[str]) -> None:
    """Check that settings are a mapping of mappings, and that each engine is one of the comparison's.

    Raises
    ------
    SettingError
        With the given and the allowed settings.
    UnknownEngineError
        If no engine has a name that is given.
    """
    if given is None:
        return
    example = '{"exudyn": {"steps_per_orbit": 2000}}'
    if not isinstance(given, Mapping) or not all(isinstance(values, Mapping) for values in given.values()):
        raise SettingError(f"settings: {visible(shorten(given))} given, allowed: a dict of dicts, e.g. {example}")
    compared = [*chosen]
    for engine in given:
        if engine not in compared:
            find_engine(engine)
            raise SettingError(f"settings: {engine} given, which is not compared; allowed: {', '.join(compared)}")


def check_seconds(name: str, given: Any) -> None:
    """Check a time.

    Raises
    ------
    ArgumentError
        If it is no number above 0.
    """
    if not is_number(given) or math.isnan(given) or given <= 0:
        raise wrong(name, given, "a number of seconds above 0")


def check_count(name: str, given: Any, otherwise: str) -> None:
    """Check a number of things that may be None.

    Raises
    ------
    ArgumentError
        If it is no whole number above 0; `otherwise` tells what None means.
    """
    if given is not None and not (is_number(given) and isinstance(given, numbers.Integral) and int(given) > 0):
        raise wrong(name, given, f"a whole number above 0, or None for {otherwise}")


def check_switch(name: str, given: Any) -> None:
    """Check a value that is true or false.

    Raises
    ------
    ArgumentError
        If it is neither.
    """
    if not isinstance(given, int) or given not in (0, 1):
        raise wrong(name, given, "True or False")


def check_folder(name: str, given: Any, *, optional: bool = False) -> None:
    """Check the path of a folder.

    Raises
    ------
    ArgumentError
        If it is neither text nor a path.
    """
    if not (isinstance(given, (str, os.PathLike)) or (optional and given is None)):
        raise wrong(name, given, f"a folder's path{', or None to keep nothing' if optional else ''}")


def check_text(name: str, given: Any, allowed: str) -> None:
    """Check a text that may be None.

    Raises
    ------
    ArgumentError
        If it is something else.
    """
    if given is not None and not isinstance(given, str):
        raise wrong(name, given, f"{allowed}, or None")


def check_callable(name: str, given: Any, arguments: str) -> None:
    """Check a function that may be None.

    Raises
    ------
    ArgumentError
        If it can't be called.
    """
    if given is not None and not callable(given):
        raise wrong(name, given, f"a function of {arguments}, or None")
