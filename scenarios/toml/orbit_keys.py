"""Keys of the forms of `[orbit]`, and the rule that one form is given, whole and alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet

INJECTION = ("altitude_m", "speed_factor", "flight_path_deg", "longitude_deg")
STATE = ("position_m", "velocity_m_s")
SHAPE = ("semi_major_axis_m", "eccentricity", "periapsis_altitude_m", "apoapsis_altitude_m")
ANOMALIES = ("true_anomaly_deg", "mean_anomaly_deg")
ELEMENTS = (*SHAPE, "argument_of_periapsis_deg", *ANOMALIES)
FORMS = (INJECTION, STATE, ELEMENTS)
"""Keys of each form; no key is of two"""
ALLOWED = (
    f"altitude_m (with {', '.join(INJECTION[1:])}); or {' and '.join(STATE)}; or two of {', '.join(SHAPE)} "
    f"(with argument_of_periapsis_deg, {' or '.join(ANOMALIES)})"
)


def check_form(given: AbstractSet[str]) -> None:
    """Check that the given keys of `[orbit]` are one form, and whole.

    Raises
    ------
    ValueError
        In one line, with the forms.
    """
    used = [[key for key in form if key in given] for form in FORMS]
    several = [keys[0] for keys in used if keys]
    if len(several) > 1:
        raise ValueError(f"{' and '.join(several)} are of different forms, allowed: {ALLOWED}")
    injection, state, elements = used
    if len(state) == 1:
        raise ValueError(f"{state[0]} alone is given, allowed: {' and '.join(STATE)}")
    shape = [key for key in SHAPE if key in elements]
    if elements and len(shape) != 2:
        said = ", ".join(shape) or "none"
        raise ValueError(f"{said} given, allowed: exactly two of {', '.join(SHAPE)}")
    if set(ANOMALIES) <= given:
        raise ValueError(f"{' and '.join(ANOMALIES)} are given, allowed: one of them")
    if not state and not elements and "altitude_m" not in injection:
        raise ValueError(f"no start of the centre of mass is given, allowed: {ALLOWED}")
