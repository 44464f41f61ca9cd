"""A scene's physics, its judging solution and its model in words."""

from __future__ import annotations

import math

from reports.chapters.crossval.summary import SHORT_OF_THE_RUN
from reports.tables.crossval import LINEAR_GROWTH
from reports.text.numerals import each, number, power_of_ten, significant, span
from reports.text.record import SceneRecord, mapping

Fact = str | tuple[float, str]  # words, or a number and its unit
GRAVITY_WORDS = {
    "gradient": "point force and gradient torque",
    "point": "point mass at each bar",
    "quadrupole": "potential to each bar's second moment",
    "slender": "exact attraction of uniform bars",
    "none": "none",
}


def facts(scene: SceneRecord, *, of_track: bool = True) -> list[tuple[str, Fact]]:
    """Physics of a scene as pairs of a name and a value, without values that are not recorded.

    Parameters
    ----------
    scene : SceneRecord
    of_track : bool
        Whether an engine ran that follows the centre of mass alone: the model difference applies to such engines.
    """
    found: list[tuple[str, str | tuple[float | None, str]]] = [
        ("Bars", each(scene.values("length_m"), "m")),
        ("Masses", each(scene.values("mass_kg"), "kg")),
        ("Initial angles", initial_angles(scene)),
        ("Initial rates", initial_rates(scene)),
        ("Altitude", altitude(scene)),
        ("Orbit", orbit_words(scene)),
        ("Gravity", GRAVITY_WORDS.get(scene.text("gravity"), scene.text("gravity"))),
        *(("Effect", words) for words in scene.lines("effects")),
        ("Conserved", scene.text("conserved")),
        ("Non-conservation by the gradient model", gradient_defect(scene)),
        ("Period", span(scene.value("period_s")) if scene.closed else ""),
        ("Duration", duration(scene)),
        *((f"Bar {p.get('bar', '?')} turned", prescription_words(p)) for p in scene.prescribed),
        ("Judged by", judged_by(scene)),
        ("Solution valid", solution_valid(scene)),
        ("Solution error", (scene.value("solution_error_rad"), "rad")),
        ("Error amplification per orbit", (scene.value("amplification_per_orbit") if scene.closed else None, "times")),
        ("Total error amplification", amplification(scene)),
        ("Model difference", model_difference(scene) if of_track else ""),
    ]
    kept: list[tuple[str, Fact]] = []
    for name, value in found:
        if isinstance(value, str):
            kept += [(name, value)] if value else []
        elif value[0] is not None:
            kept.append((name, (value[0], value[1])))
    return kept


def judged_by(scene: SceneRecord) -> str:
    """Solution that judges the engines: its origin, its engine and the accuracy of its runs."""
    made = ", ".join(filter(None, [scene.text("solution_engine"), scene.text("solution_setting")]))
    source = scene.text("solution_source")
    return f"{source} ({made})" if source and made else source or made


def solution_valid(scene: SceneRecord) -> str:
    """``to 2.76 of 5 orbits``; empty where it is not recorded."""
    predictability_limit, end = scene.value("solution_limit_s"), scene.value("duration_s")
    if predictability_limit is None or end is None:
        return ""
    if predictability_limit > SHORT_OF_THE_RUN * end:
        return "to the end of the run"
    if not scene.in_orbits:
        return f"to {predictability_limit:.4g} of {end:.4g} s"
    return f"to {predictability_limit / scene.period_s:.2f} of {end / scene.period_s:.4g} orbits"


def altitude(scene: SceneRecord) -> str:
    """Height of the centre of mass at the start."""
    r, body = scene.value("radius0_m"), scene.value("body_radius_m")
    return "" if r is None or body is None or scene.text("gravity") == "none" else f"{(r - body) / 1e3:g} km"


def initial_angles(scene: SceneRecord) -> str:
    """``5 × 20° from the chain's local horizontal``; empty where they are not recorded."""
    angles = each(scene.values("angle_deg"), "°").replace(" °", "°")
    whose = "each bar's" if scene.text("angle_from") == "bar" else "the chain's"
    return f"{angles} from {whose} local horizontal" if angles else ""


def initial_rates(scene: SceneRecord) -> str:
    """``1 times the orbital rate, every bar``; empty where they are not recorded."""
    factors = scene.values("rate_factor")
    if len(factors) > 1 and len(set(factors)) == 1:
        return f"{factors[0]:g} times the orbital rate, every bar"
    return each(factors, "times the orbital rate")


def orbit_words(scene: SceneRecord) -> str:
    """Initial speed and the eccentricity that follows from it; empty without gravity."""
    factor = scene.value("speed_factor")
    if factor is None or scene.text("gravity") == "none":
        return ""
    if factor == 1.0:
        return "at the local circular speed"
    return f"at {factor:.6g} times the local circular speed: eccentricity {abs(factor**2 - 1.0):.3g}"


def amplification(scene: SceneRecord) -> str | tuple[float | None, str]:
    """Error amplification of the whole run; beyond :data:`LINEAR_GROWTH` a bound."""
    value = scene.value("amplification_total")
    if value is not None and value > LINEAR_GROWTH:
        return f"more than {power_of_ten(round(math.log10(LINEAR_GROWTH)))} times"
    return value, "times"


def duration(scene: SceneRecord) -> str:
    """``5 orbits in 501 samples``."""
    seconds, samples = scene.value("duration_s"), scene.value("samples")
    if seconds is None:
        return ""
    orbits = f"{seconds / scene.period_s:.4g}" if scene.in_orbits else ""
    length = f"{orbits} orbit{'' if orbits == '1' else 's'}" if orbits else f"{seconds:g} s"
    return length + (f" in {samples:.0f} samples" if samples else "")


def prescription_words(law: dict[str, object]) -> str:
    """One prescribed rotation in words."""
    by = {"external": "an external torque", "joint": "a motor in its joint"}.get(str(law.get("actuator")), "")
    against = str(law.get("frame", "")).replace("_", " ")
    angle, length, start = (number(law.get(k)) for k in ("amplitude_deg", "duration_s", "start_s"))
    parts = [f"by {angle:g}°" if angle is not None else "", f"in {length:g} s" if length is not None else ""]
    parts += [f"from {start:g} s" if start else "", f"by {by}" if by else ""]
    return " ".join(p for p in parts if p) + (f", against the {against} frame" if against else "")


def model_difference(scene: SceneRecord) -> str | tuple[float, str]:
    """Declared model difference: displacement of the centre of mass and its cause; empty where there is none."""
    declared = scene.model_difference
    com = SceneRecord("", declared).value("com_m")
    note = str(declared.get("note") or "")
    if com == 0.0:
        return ""
    return note if com is None else (com, f"m in the CM{': ' if note else ''}{note}")


def gradient_defect(scene: SceneRecord) -> str:
    """Relative change of energy and angular momentum that the paper's gravity does not conserve, beside (l/r)²."""
    found = SceneRecord("", mapping(scene.data.get("gradient_defect")))
    energy, momentum, square = (found.value(k) for k in ("energy", "angular_momentum", "size_squared"))
    if energy is None or momentum is None or square is None:
        return ""
    return (
        f"energy {significant(energy)}, angular momentum {significant(momentum)} relative to the totals, of order "
        f"(l/r)², {significant(square)} (a property of the model; quadrupole and slender gravity conserve both)"
    )
