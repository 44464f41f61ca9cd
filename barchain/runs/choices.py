"""Engines, their settings and scenes, as users choose them and as a record has them."""

from __future__ import annotations

import dataclasses
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter, Setting, SettingError, check_number
from adapters.registry import ALL, ENGINES, RESERVED, TARGET, Registration, UnknownEngineError, engines, find_engine
from barchain.runs.asking import declarations_of, engine_fault
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.engine import AccuracySweep
    from scenarios import Scene

LEAST_RTOL, MOST_STEPS = 1e-15, 1e9


def choose_setting(
    engine: str, given: Mapping[str, float], registered: Mapping[str, Registration] | None = None
) -> Setting:
    """Setting of an engine from the values that a user gave.

    Parameters
    ----------
    engine : str
        A registered name.
    given : mapping
        Value by the name of the accuracy parameter: ``rtol`` (1) or ``steps_per_orbit`` (1). Empty for the default.
    registered : mapping of str to Registration, optional
        Engines that take part, where not all of them are installed ones.

    Raises
    ------
    UnknownEngineError
        If no engine has that name.
    SettingError
        If the engine has another accuracy parameter, or the value is no number or out of its range.
    """
    sweep = declarations_of((registered or {}).get(engine) or find_engine(engine)).sweep
    for name in given:
        if name != sweep.parameter:
            raise SettingError(
                f"{engine} has no setting {name}{nearest(str(name), [sweep.parameter])}; allowed: {sweep.parameter}"
            )
    for name, value in given.items():
        least, most = allowed_range(sweep)
        try:
            check_number(name, value)
        except SettingError as error:
            raise SettingError(f"{engine}: {error} from {least:g} to {most:g}") from None
        if not least <= value <= most:
            raise SettingError(f"{engine}: {name}={value:g} given, allowed: {least:g} to {most:g}")
        return Setting(sweep.parameter, float(value))
    return sweep.setting()


def allowed_range(sweep: AccuracySweep) -> tuple[float, float]:
    """Least and largest value of an accuracy parameter."""
    if sweep.parameter is AccuracyParameter.RTOL:
        return min(LEAST_RTOL, *sweep.values), 1.0
    return 1.0, MOST_STEPS


def chosen_engines(names: Iterable[str] | None) -> dict[str, Registration]:
    """Registrations by name, in the order given; without names all default engines. Errors as :func:`named_engine`.

    The name `ALL` stands for all default engines and the programs of the working folder.
    """
    chosen: dict[str, Registration] = {}
    for name in [None] if names is None else names:
        if name is None or name == ALL:
            here = programs_here() if name else []
            chosen |= {n: r for n, r in engines().items() if r.by_default or n in here}
        else:
            chosen |= [named_engine(name)]
    return chosen


def programs_here() -> list[str]:
    """Names of the programs of the working folder's file, which run where they are named."""
    return [name for name, r in engines().items() if r.entry and not (r.in_default_set or r.optional or r.rejected)]


def named_engine(given: str) -> tuple[str, Registration]:
    """Name and registration of a registered engine, or of ``module:Class`` on Python's path or in the current folder.

    Raises
    ------
    UnknownEngineError
        If no engine has the name; the message tells how a class or a package is given.
    """
    if isinstance(given, str) and re.fullmatch(TARGET, given):
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.append(here)
        return short_name(given), Registration(given)
    try:
        return given, find_engine(given)
    except UnknownEngineError as error:
        raise UnknownEngineError(f"{error}; {how_to_give(str(given))}") from None


def how_to_give(given: str) -> str:
    """How an engine is given that no package registers."""
    module, _, name = given.rpartition(".")
    if module and re.fullmatch(TARGET, f"{module}:{name}"):
        return f"a class is given as MODULE:CLASS (did you mean {module}:{name}?)"
    return "the engine of a package is there after `pip install -e FOLDER`; a class is given as MODULE:CLASS"


def short_name(target: str) -> str:
    """Name of a class that has no entry point yet: ``MyEngine`` becomes ``my-engine``."""
    words = re.findall(r"[A-Z]*[^A-Z]+|[A-Z]+", target.partition(":")[2])
    name = "-".join(w.lower().strip("_") for w in words if w.strip("_")) or "engine"
    return f"{name}-engine" if name in {*ENGINES, *RESERVED} else name


def one_of_each(registered: dict[str, Registration]) -> dict[str, Registration]:
    """First engine of each library, and the first of those built on barchain's own equations, in their order."""
    first: dict[str, str] = {}
    for name, r in registered.items():
        first.setdefault("" if r.ours else r.requires or r.distribution or name, name)
    return {name: registered[name] for name in first.values()}


def unique_names(scenes: list[Scene]) -> list[Scene]:
    """Scenes with different names, so that no scene overwrites files of another; duplicates are dropped."""
    kept: dict[str, Scene] = {}
    for scene in scenes:
        name, count = scene.name, 1
        while name in kept and kept[name].digest != scene.digest:
            count += 1
            name = f"{scene.name}-{count}"
        kept[name] = dataclasses.replace(scene, name=name)
    return list(kept.values())


def engine_facts(registration: Registration) -> dict[str, Any]:
    """Entry of an engine in the record."""
    facts: dict[str, Any] = {
        "external": registration.external,
        "version": registration.version_words,
        "missing": registration.missing,
    }
    if registration.entry:
        facts["digest"] = registration.version
    try:
        loaded = declarations_of(registration)
    except Exception as error:
        return facts | {"missing": facts["missing"] or engine_fault(error)}
    return facts | {
        "title": loaded.title,
        "coordinates": str(loaded.coordinates),
        "parameter": str(loaded.sweep.parameter),
        "default": loaded.sweep.default,
        "order": loaded.order,
    }
