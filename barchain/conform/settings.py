"""Setting of an examined engine on a scene: the default, or one at which the whole scene is judged point by point."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from barchain.conform.scenes import solved
from barchain.judge.error_model import ErrorModel

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Engine, Setting

MOST_FINER = 10.0
"""Largest ratio of the steps, or of the requested errors, to the default: finer runs take too long"""
FINER = {AccuracyParameter.RTOL: 0.1, AccuracyParameter.STEPS_PER_ORBIT: 2.0}
"""Factor from a setting to the next finer one; `AccuracySweep.finer_rtol` is that of a second run beside the first"""
LASTING = 0.9
"""Least share of a scene in which right runs agree; the rest is judged in restarts"""


def setting_of(engine: type[Engine], name: str) -> Setting:
    """Setting at which an engine is examined on a scene.

    The default, or the first of the next finer settings at which two right runs agree in most of the scene. Beyond
    the predictability limit only restarts, the track and invariants are judged, and a weak force that is missing may
    pass. Where no setting up to :data:`MOST_FINER` agrees so long, the finest of these.

    Parameters
    ----------
    engine : type
        Subclass of `Engine`.
    name : str
        Scene of conformance.
    """
    tried = list(from_default_on(engine))
    return next((setting for setting in tried if lasts(engine, setting, name)), tried[-1])


def from_default_on(engine: type[Engine]) -> Iterator[Setting]:
    """The default, and settings of twice the steps or a tenth of the requested error each, up to `MOST_FINER`."""
    setting = default = engine.sweep.setting()
    factor = FINER[setting.parameter]
    while finer_than(setting, default) <= MOST_FINER * (1.0 + 1e-9):
        yield setting
        setting = replace(setting, value=setting.value * factor)


def finer_than(setting: Setting, default: Setting) -> float:
    """Ratio of the steps, or of the requested errors, of two settings."""
    ratio = setting.value / default.value
    return 1.0 / ratio if default.parameter is AccuracyParameter.RTOL else ratio


def lasts(engine: type[Engine], setting: Setting, name: str) -> bool:
    """Whether two right runs at a setting agree for :data:`LASTING` of a scene."""
    solution = solved(name)
    errors = ErrorModel(engine, setting, solution, solution.trajectory)
    return bool(errors.limit_s >= LASTING * errors.t_s[-1])
