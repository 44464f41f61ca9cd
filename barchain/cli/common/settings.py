"""`--set [ENGINE:]KEY=VALUE`: values of engines' accuracy parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.names import ENGINE
from barchain.cli.common.numbers import RealNumber

if TYPE_CHECKING:
    from collections.abc import Iterable

FORM = "[ENGINE:]KEY=VALUE"
SOME_NUMBER = RealNumber()
EXAMPLE = "rtol=1e-12 or exudyn:steps_per_orbit=2000"


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
        """Take the text apart; an engine that it names must be installed."""
        if isinstance(value, GivenSetting):
            return value
        engine, colon, rest = str(value).rpartition(":")
        key, equals, number = rest.partition("=")
        try:
            found = SOME_NUMBER.convert(number, param, ctx)
        except click.BadParameter:
            given = f"{value} given" if equals else f"{value} given (no value)"
            self.fail(f"{given}, allowed: {FORM} with a number, e.g. {EXAMPLE}", param, ctx)
        return GivenSetting(str(ENGINE.convert(engine, param, ctx)) if colon else "", key.strip(), found)


SETTING = SettingType()


def settings_by_engine(given: Iterable[GivenSetting], chosen: Iterable[str]) -> dict[str, dict[str, float]]:
    """``{"exudyn": {"steps_per_orbit": 2000}}``; a setting without an engine goes to every chosen engine that has it.

    Raises
    ------
    UsageError
        If a setting is for no chosen engine.
    SettingError
        If its engine has another accuracy parameter, or the value is out of range.
    """
    from barchain.runs.settings import choose_setting  # noqa: PLC0415

    names = list(chosen)
    found: dict[str, dict[str, float]] = {}
    for setting in given:
        for engine in engines_of(setting, names):
            choose_setting(engine, {setting.key: setting.value})
            found.setdefault(engine, {})[setting.key] = setting.value
    return found


def engines_of(setting: GivenSetting, names: list[str]) -> list[str]:
    """Chosen engines that a setting is for."""
    if setting.engine:
        if setting.engine not in names:
            raise click.UsageError(
                f"--set {setting}: {setting.engine} does not take part; there are: {', '.join(names)}"
            )
        return [setting.engine]
    if len(names) == 1:  # whose own error then names its parameter
        return names
    return [name for name, key in keys(names).items() if key == setting.key] or unknown_key(setting, names)


def keys(names: Iterable[str]) -> dict[str, str]:
    """Accuracy parameter of each engine that is installed."""
    from adapters.registry import find_engine  # noqa: PLC0415
    from barchain.runs.declared import engine_class  # noqa: PLC0415

    found = {name: find_engine(name) for name in names}
    return {name: str(engine_class(r).sweep.parameter) for name, r in found.items() if not r.missing}


def unknown_key(setting: GivenSetting, names: list[str]) -> list[str]:
    """Say that no engine has a setting."""
    from scenarios import nearest  # noqa: PLC0415

    allowed = sorted(set(keys(names).values()))
    raise click.UsageError(
        f"--set {setting}: no engine has {setting.key}{nearest(setting.key, allowed)}; allowed: {', '.join(allowed)}"
    )
