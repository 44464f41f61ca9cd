"""Write the scenes of conformance that combine effects: ``python benchmarks/covering_scenes.py [FOLDER]``.

Each scene has one level of each factor: a model of gravity, numbers of bars, thrusts and bodies, signs, an orbit, a
pattern of samples. Any two levels of two factors stand together in some scene. Such a covering array keeps this
property for an engine that supports some effects only: effects that it lacks are taken out of each scene.
"""

from __future__ import annotations

import itertools
import random
import sys
from pathlib import Path

from scenarios import load_scene

NONE = "none"
FACTORS: dict[str, tuple[str, ...]] = {
    "gravity": ("none", "point", "gradient", "quadrupole", "slender"),
    "bars": ("two", "six"),
    "length": ("short", "long"),
    "inertia": ("uniform", "given"),
    "orbit": ("slow", "open"),
    "samples": ("few", "many"),
    "body": ("Earth", "other"),
    "oblateness": ("some", NONE),
    "third bodies": ("one", "three", NONE),
    "joints": ("springs", "dampers"),
    "thrusts": ("one negative", "three"),
    "impulses": ("at the end of a thrust", "two at a time"),
    "air and light": ("some", "neither"),
    "rotations": ("some", "neither"),
}
IMPOSSIBLE = {
    (("gravity", "slender"), ("inertia", "given")),
    (("gravity", "none"), ("oblateness", "some")),
    (("gravity", "none"), ("third bodies", "one")),
    (("gravity", "none"), ("third bodies", "three")),
}
"""Exact gravity is that of uniform bars, and all fields presuppose gravity"""
ABSENT = {("oblateness", NONE), ("third bodies", NONE)}
"""Levels that need not stand with each other one: effects are absent in the scenes of one effect alone"""
MASS_KG = (100.0, 40.0, 70.0, 30.0, 55.0, 80.0)
LENGTH_M = (100.0, 60.0, 80.0, 70.0, 50.0, 90.0)
ANGLE_DEG = (20.0, 30.0, 15.0, 25.0, 10.0, 22.0)
RATE = {"few": (12.0, 4.2, 3.8, 4.1, 3.9, -2.0), "many": (4.0, 4.2, 3.8, 4.1, 3.9, 4.3)}
"""Past half a turn between few samples"""
GIVEN = (1.3, 0.8, 1.5, 0.7, 1.2, 1.1)
"""Moments of inertia relative to uniform bars'"""
LONG = 400.0
"""Length of long bars relative to short ones: the chain's centre of mass leaves a particle's track by metres"""
SEEDS = 300
"""Orders of the factors that are tried; the shortest array is taken"""
STIFF, DAMPED, REST = (2.0, 0.5, 1.0, 3.0, 0.7), (100.0, 50.0, 20.0, 70.0, 30.0), (10.0, -5.0, 3.0, 8.0, -12.0)

Row = dict[str, str]
Pair = frozenset[tuple[str, str]]


def pairs_of(row: Row) -> set[Pair]:
    """Pairs of levels in a row."""
    return set(map(frozenset, itertools.combinations(row.items(), 2)))


def possible(row: Row) -> bool:
    """Whether the levels of a part of a row go together."""
    return not any(row.get(a) == x and row.get(b) == y for (a, x), (b, y) in IMPOSSIBLE)


def covering_array(seed: int) -> list[Row]:
    """Rows such that every possible pair of levels stands in one, by greed: each level covers as much as it can."""
    order = list(FACTORS)
    random.Random(seed).shuffle(order)
    every = {
        frozenset({(a, x), (b, y)})
        for a, b in itertools.combinations(FACTORS, 2)
        for x, y in itertools.product(FACTORS[a], FACTORS[b])
        if possible({a: x, b: y}) and not {(a, x), (b, y)} & ABSENT
    }
    rows: list[Row] = []
    while left := every - set().union(*map(pairs_of, rows)):
        row = dict(min(left, key=lambda pair: sorted((order.index(factor), level) for factor, level in pair)))
        for factor in order:
            if factor not in row:
                able = [level for level in FACTORS[factor] if possible(row | {factor: level})]
                row[factor] = max(able, key=lambda level: len(pairs_of(row | {factor: level}) & left))
        rows.append({factor: row[factor] for factor in FACTORS})
    return rows


def text_of(row: Row, number: int) -> str:
    """Scene of a row."""
    n = {"two": 2, "six": 6}[row["bars"]]
    size = LONG if row["length"] == "long" else 1.0
    length = [size * x for x in LENGTH_M[:n]]
    inertia = [f * m * x**2 / 12.0 for f, m, x in zip(GIVEN, MASS_KG, length, strict=False)]
    words = "; ".join(f"{factor}: {level}" for factor, level in row.items())
    lines = [
        f'title = "Effects together, {number}"',
        'source = "Certified solution"',
        f'description = """\n{words}.\n"""',
        'tags = ["conform", "together"]',
        *(["[central_body]", "mu_m3_s2 = 3.7e14", "radius_m = 6.4e6"] if row["body"] == "other" else []),
        "[orbit]",
        "altitude_m = 350e3",
        "longitude_deg = 30.0",
        f"speed_factor = {0.98 if row['orbit'] == 'slow' else 1.5}",
        "[chain]",
        f"bars = {n}",
        f"mass_kg = {list(MASS_KG[:n])}",
        f"length_m = {length}",
        *([f"inertia_kg_m2 = {[float(f'{x:.3g}') for x in inertia]}"] if row["inertia"] == "given" else []),
        f"angle_deg = {list(ANGLE_DEG[:n])}",
        *(['angle_from = "bar"'] if row["length"] == "long" and row["rotations"] == "some" else []),
        f"rate_factor = {list(RATE[row['samples']][:n])}",
        "[effects]",
        f'gravity = "{row["gravity"]}"',
        *effects_of(row, n, size),
        "[run]",
        "duration_s = 900.0",
        f"samples = {4 if row['samples'] == 'few' else 151}",
    ]
    return "\n".join(f"\n{line}" if line.startswith("[") else line for line in lines) + "\n"


def effects_of(row: Row, n: int, size: float) -> list[str]:
    """Tables of the effects; forces grow with the bars, torques with the square of their length."""
    lines = ["[effects.oblateness]", "j2 = 2.5e-3", "radius_m = 6.5e6"] if row["oblateness"] == "some" else []
    bodies = [
        ("moon", "mu_m3_s2 = 8e12", 20e6, 40.0),
        ("sun", "", 6e9, -110.0),
        ("other", "mu_m3_s2 = 3e12", 25e6, 160.0),
    ]
    for name, mu, distance, longitude in bodies[: {NONE: 0, "one": 1, "three": 3}[row["third bodies"]]]:
        lines += ["[[effects.third_body]]", f'body = "{name}"', *filter(None, [mu])]
        lines += [f"distance_m = {distance:g}", f"longitude_deg = {longitude}"]
    if row["air and light"] == "some":
        lines += [
            "[effects.drag]", "density_kg_m3 = 1.2e-10", "altitude_m = 320e3", "scale_height_m = 45e3", "width_m = 0.1",
            "rotation_rad_s = 1.5e-4",
            "[effects.solar_pressure]", "width_m = 0.05", "reflectivity = 0.3", "sun_longitude_deg = 170.0",
        ]  # fmt: skip
    lines += ["[effects.joint_spring_damper]"]
    if row["joints"] == "springs":
        lines += [f"stiffness_N_m_rad = {[size**2 * k for k in STIFF[: n - 1]]}", f"rest_deg = {list(REST[: n - 1])}"]
    if row["joints"] == "dampers" or n > 2:  # springs of two bars have no dampers
        lines += [f"damping_N_m_s_rad = {[size**2 * c for c in DAMPED[: n - 1]]}"]
    thrusts = [
        (2, "right", "body", 80.0, f"force_N = {-0.01 * size}", "start_s = 150.0", "duration_s = 450.0"),
        (
            n,
            "left",
            "body",
            -70.0,
            f"force_N = {[0.01 * size, 0.03 * size, -0.02 * size]}",
            "times_s = [300.0, 450.0, 750.0]",
        ),
        (1, "left", "inertial", 200.0, f"force_N = {0.015 * size}"),
    ]
    for bar, end, axes, direction, *rest in thrusts[: 1 if row["thrusts"] == "one negative" else 3]:
        lines += [
            "[[effects.thrust]]",
            f"bar = {bar}",
            f'end = "{end}"',
            f'axes = "{axes}"',
            f"direction_deg = {direction}",
        ]
        lines += rest
    impulses = [(1, "right", "body", 90.0, 2.0), (n, "left", "inertial", 200.0, -3.0)]
    one = row["impulses"] == "at the end of a thrust"
    for bar, end, axes, direction, strength in impulses[: 1 if one else 2]:
        lines += [
            "[[effects.impulse]]",
            f"bar = {bar}",
            f'end = "{end}"',
            f'axes = "{axes}"',
            f"direction_deg = {direction}",
        ]
        lines += [f"impulse_N_s = {size * strength}", f"at_s = {600.0 if one else 450.0}"]
    rotations = [(2, 25.0, "local_horizontal", "external"), (4, -35.0, "inertial", "external")]
    if n == 2:  # in long chains a joint's motor meets positions in which it can't turn its bar
        rotations = [(2, 25.0, "inertial" if row["length"] == "long" else "local_horizontal", "joint")]
    for bar, angle, frame, actuator in rotations if row["rotations"] == "some" else ():
        lines += ["[[effects.prescribed_rotation]]", f"bar = {bar}", f"amplitude_deg = {angle}", "duration_s = 450.0"]
        lines += ["start_s = 300.0", f'frame = "{frame}"', f'actuator = "{actuator}"']
    return lines


def main(folder: Path) -> None:
    """Write all scenes, and check each."""
    for number, row in enumerate(min(map(covering_array, range(SEEDS)), key=len), start=1):
        path = folder / f"together_{number}.toml"
        path.write_text(text_of(row, number), encoding="utf-8", newline="\n")
        load_scene(str(path))
        print(path.name, *row.values(), sep="  ")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "scenarios/conform"))
