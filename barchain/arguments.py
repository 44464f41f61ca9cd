"""Arguments of the Python functions, checked before anything runs: wrong ones end in one sentence."""

from __future__ import annotations

import numbers
import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from adapters.engine import SettingError, is_number
from adapters.registry import engines, find_engine
from scenarios import Scene, scene_names
from scenarios.nearest import nearest_name, nearest_scene
from scenarios.text import shorten, visible

if TYPE_CHECKING:
    from pathlib import Path


Kind = tuple[Callable[[Any], bool], str]
"""Whether a value is of a kind, and words for what is"""


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


SECONDS: Kind = lambda given: is_number(given) and given > 0, "a number of seconds above 0"
WORKERS: Kind = (
    lambda given: given is None or (is_number(given) and isinstance(given, numbers.Integral) and int(given) > 0),
    "a whole number above 0, or None for all cores",
)
REPETITION: Kind = lambda given: type(given) is int and given >= 0, "a whole number, 0 or more"
AMOUNT: Kind = lambda given: is_number(given) and given > 0, "a number above 0"
SWITCH: Kind = lambda given: isinstance(given, int) and given in (0, 1), "True or False"
FOLDER: Kind = lambda given: isinstance(given, (str, os.PathLike)), "a folder's path"
OPTIONAL_FOLDER: Kind = (
    lambda given: given is None or isinstance(given, (str, os.PathLike)),
    "a folder's path, or None to keep nothing",
)
TAG: Kind = lambda given: given is None or isinstance(given, str), 'a tag, e.g. "paper", or None'
ADDRESS: Kind = (
    lambda given: given is None or isinstance(given, str),
    'the address of a Dask scheduler, e.g. "tcp://host:8786", or None',
)
PROGRESS: Kind = (
    lambda given: given is None or callable(given),
    "a function of scene, engine and outcome, or None",
)


def check(kind: Kind, **given: Any) -> None:
    """Check arguments of one kind, by their names.

    Raises
    ------
    ArgumentError
        On the first that is of another kind.
    """
    fits, allowed = kind
    for name, value in given.items():
        if not fits(value):
            raise wrong(name, value, allowed)
