"""Settings of engines' accuracy parameters, as users give them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting, SettingError, check_number
from adapters.registry import find_engine
from barchain.runs.declared import engine_class
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import AccuracySweep

__all__ = ["LEAST_RTOL", "MOST_STEPS", "SettingError", "allowed_range", "choose_setting"]

LEAST_RTOL, MOST_STEPS = 1e-15, 1e9


def choose_setting(engine: str, given: Mapping[str, float]) -> Setting:
    """Setting of an engine from the values that a user gave.

    Parameters
    ----------
    engine : str
        A registered name.
    given : mapping
        Value by the name of the accuracy parameter: ``rtol`` (1) or ``steps_per_orbit`` (1). Empty for the default.

    Raises
    ------
    UnknownEngineError
        If no engine has that name.
    SettingError
        If the engine has another accuracy parameter, or the value is no number or out of its range.
    """
    sweep = engine_class(find_engine(engine)).sweep
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
