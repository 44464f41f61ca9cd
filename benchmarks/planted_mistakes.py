"""Mistakes that authors of engines make, each planted in a right engine, and whether `barchain conform` names it.

    python benchmarks/planted_mistakes.py                        # all mistakes and pairs: half an hour
    python benchmarks/planted_mistakes.py --only "rate|drag"     # those whose names match
    python benchmarks/planted_mistakes.py --sound                # every installed engine as it is

A mistake alters the scene before `build`, the trajectory after `read`, or the engine between. With it stand the words
that a right diagnosis must contain; they do not follow the diagnosis' own list.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import re
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from mistake_parts import (
    MUJOCO,
    PINOCCHIO,
    SCIPY,
    Blunder,
    body,
    both,
    centres,
    chain,
    drifts,
    effect,
    effects,
    euler,
    fixed_tolerance,
    gravity,
    half_central,
    halved,
    impulses_apart,
    inertia_times,
    interpolated,
    late,
    leaves_file,
    left_end,
    loads_on_joints,
    longitude,
    lost_time,
    middle_joints,
    no_tides,
    no_velocity_terms,
    one_more,
    orbit,
    pair,
    relative,
    result,
    says,
    single_times,
    spin_times,
    stray,
    times,
    turned,
    without,
)

from adapters.registry import ENGINES, engines
from barchain.conform import conform
from barchain.conform.checks import CheckState, Group
from barchain.judge.diagnosis.own_motion import LIKELY
from scenarios import Gravity
from scenarios.effect_types import Actuator, Axes, End, Frame

if TYPE_CHECKING:
    from barchain.conform.checks import Check, ConformanceReport

HERE = Path(__file__).resolve().parent
MODULE = "planted"
SOURCE = """import sys
sys.path.append({folder!r})


def __getattr__(name):
    from planted_mistakes import wrong_engine

    return wrong_engine(name)
"""
TOLD_OF_EVERY_CLASS = ("entry point", "time of import", "order")
"""Checks whose warnings are no finding: the classes have no entry point, and few settings show an order"""

UNKNOWN = "No known mistake"
"""Start of a diagnosis that names nothing"""

G0 = 9.80665
REVERSED = "revers|last (bar )?first|from the (last|right|other)|order"
MISSING = "missing|without|lack|no |left out|omit|absent|not|ignor"
OPPOSITE = "sign|opposite|negat|revers"
LATE = "late|delay|earlier|previous|before|behind|lag|old"
EARLY = "early|ahead|next|later|advance|too soon"
SWAP = "swap|exchang|interchang|transpos|permut"
COM = "centre of mass|com_m|position|com\\b"
ORBITAL = "local (frame|vertical)|orbital (frame|axes)|radial|rotating|turns? with the orbit|horizontal"

MISTAKES = [
    # units
    Blunder("angles in degrees", says("angle", "degree|180/"), read=times("angle_rad", 180 / math.pi)),
    Blunder("rates in degrees per second", says("rate", "degree|180/"), read=times("rate_rad_s", 180 / math.pi)),
    Blunder("rates in turns per minute", says("rate", "turn|rev|rpm"), read=times("rate_rad_s", 30 / math.pi)),
    Blunder("rates in units of v0/r0", says("rate", "v0/r0|orbital rate|orbital|unit"),
            read=result(rate_rad_s=lambda t, s: t.rate_rad_s / s.orbital_rate_rad_s)),
    Blunder("reactions in kN", says("reaction", "kN|kilonewton|0\\.001|1000"), read=times("reaction_N", 1e-3)),
    Blunder("reactions in kilogram-force", says("reaction", "kgf|kilogram|9\\.8|kilopond"), base=PINOCCHIO,
            read=times("reaction_N", 1 / G0)),
    Blunder("orbit in km and km/s", says(COM, "km|kilomet|0\\.001|1000"),
            read=lambda t, s: times("com_velocity_m_s", 1e-3)(times("com_m", 1e-3)(t, s), s)),
    Blunder("longitude in degrees taken as radians", says("longitude|angle|start", "degree|longitude"),
            scene=orbit(longitude_rad=lambda s: math.degrees(s.orbit.longitude_rad))),
    # signs and axes
    Blunder("angles clockwise", says("angle", f"clockwise|{OPPOSITE}"), base=PINOCCHIO, read=times("angle_rad", -1.0)),
    Blunder("rates clockwise", says("rate", f"clockwise|{OPPOSITE}"), read=times("rate_rad_s", -1.0)),
    Blunder("reactions on the next bar", says("reaction", OPPOSITE + "|next bar|j ?\\+ ?1"), base=MUJOCO,
            read=times("reaction_N", -1.0)),
    Blunder("reactions in the bar's axes", says("reaction", "bar.{0,12}axes|axes of .{0,20}bar|body"), base=MUJOCO,
            read=result(reaction_N=lambda t, _: turned(t.reaction_N, t.angle_rad[:, :-1]))),
    Blunder("reactions in the next bar's axes", says("reaction", "next bar|bar after|following bar"), base=PINOCCHIO,
            read=result(reaction_N=lambda t, _: turned(t.reaction_N, t.angle_rad[:, 1:]))),
    Blunder("reactions in the local orbital frame", says("reaction", ORBITAL),
            read=result(reaction_N=lambda t, _: turned(t.reaction_N, longitude(t)[:, None] + 0 * t.angle_rad[:, 1:]))),
    Blunder("reactions with x and y swapped", says("reaction", f"{SWAP}|x and y|order"),
            read=result(reaction_N=lambda t, _: t.reaction_N[..., ::-1].copy())),
    Blunder("velocity in radial and transverse components", says("velocity", ORBITAL + "|transverse"),
            read=result(com_velocity_m_s=lambda t, _: turned(t.com_velocity_m_s, longitude(t)))),
    Blunder("centre of mass relative to its start", says(COM, "start|initial|t = 0|first sample|offset"),
            read=result(com_m=lambda t, _: t.com_m - t.com_m[0])),
    Blunder("axes along the orbit at the start", says("longitude|rotated|turned|axes|initial (radius|position)"),
            scene=orbit(longitude_rad=lambda _: 0.0)),
    Blunder("clockwise orbit", says("velocity|orbit", f"clockwise|retrograde|{OPPOSITE}|direction"),
            scene=both(orbit(speed_factor=lambda s: -s.orbit.speed_factor),
                chain(rate_factor=lambda c: tuple(-a for a in c.rate_factor)))),
    # definitions of angles and rates
    Blunder("angles wrapped to (-pi, pi]", says("angle", "wrap|modul|turns"),
            read=result(angle_rad=lambda t, _: np.arctan2(np.sin(t.angle_rad), np.cos(t.angle_rad)))),
    Blunder("angles relative to the bar before", says("angle", "bar before|previous|joint angle|relative to"),
            base=MUJOCO, read=result(angle_rad=lambda t, _: relative(t.angle_rad))),
    Blunder("rates relative to the bar before", says("rate", "bar before|previous|joint|relative to"), base=PINOCCHIO,
            read=result(rate_rad_s=lambda t, _: relative(t.rate_rad_s))),
    Blunder("angles from the local horizontal", says("angle", "horizontal"),
            read=result(angle_rad=lambda t, _: t.angle_rad - longitude(t)[:, None] + 0.5 * math.pi)),
    Blunder("angles from the z2 axis", says("angle", "90|pi/2|z2|quarter|right angle|1\\.57"),
            read=result(angle_rad=lambda t, _: t.angle_rad - 0.5 * math.pi)),
    Blunder("bars counted from their right ends", says("angle", "180|pi\\b|half a turn|right end|-z1"),
            read=result(angle_rad=lambda t, _: t.angle_rad + math.pi)),
    Blunder("rates in the orbital frame", says("rate", f"orbital rate|{ORBITAL}|orbit"),
            read=result(rate_rad_s=lambda t, s: t.rate_rad_s - s.orbital_rate_rad_s)),
    # order
    Blunder("bars in reverse order", says("bar", REVERSED),
            read=result(angle_rad=lambda t, _: t.angle_rad[:, ::-1].copy(),
                rate_rad_s=lambda t, _: t.rate_rad_s[:, ::-1].copy())),
    Blunder("joints in reverse order", says("joint|reaction", REVERSED),
            read=result(reaction_N=lambda t, _: t.reaction_N[:, ::-1].copy())),
    Blunder("masses in reverse order", says("mass", REVERSED), scene=chain(mass_kg=lambda c: c.mass_kg[::-1])),
    Blunder("masses and their inertias in reverse order", says("mass", REVERSED),
            scene=chain(mass_kg=lambda c: c.mass_kg[::-1],
                inertia_kg_m2=lambda c: tuple(
                    m * b * b / 12 for m, b in zip(c.mass_kg[::-1], c.length_m, strict=True)))),
    Blunder("angles of bars 1 and 2 exchanged", says("angle|bar", f"{SWAP}|order"),
            read=result(angle_rad=lambda t, _: np.hstack([t.angle_rad[:, 1::-1], t.angle_rad[:, 2:]]))),
    # sample timing
    Blunder("all a sample late", says("sample", LATE),
            read=lambda t, _: t.samples(np.maximum(np.arange(len(t.t_s)) - 1, 0)).replace(t_s=t.t_s)),
    Blunder("angles a sample early", says("angle", "sample", EARLY), base=MUJOCO, scene=one_more,
            read=lambda t, _: t.samples(slice(0, -1)).replace(angle_rad=t.angle_rad[1:])),
    Blunder("reactions of the sample before", says("reaction", "sample", LATE),
            read=result(reaction_N=lambda t, _: late(t.reaction_N))),
    Blunder("rates half a sample late", says("rate", "half"), scene=halved,
            read=lambda t, _: t.samples(slice(0, None, 2)).replace(rate_rad_s=late(t.rate_rad_s)[::2])),
    Blunder("rates by the mean of two samples", says("rate", "half|mean|average"),
            read=result(rate_rad_s=lambda t, _: 0.5 * (t.rate_rad_s + late(t.rate_rad_s)))),
    Blunder("samples without the end point", says("time|instant|sample|interval", "end|time|interval|factor|slow"),
            scene=lost_time, read=result(t_s=lambda _, s: s.times_s)),
    Blunder("times in minutes", says("time|instant|t_s"), read=times("t_s", 1 / 60)),
    Blunder("samples by straight lines", says("interpol|straight line|linear"),
            read=result(angle_rad=lambda t, _: interpolated(t.angle_rad),
                rate_rad_s=lambda t, _: interpolated(t.rate_rad_s))),
    Blunder("rates by differences of angles", says("rate", "differenc|numerical"),
            read=result(rate_rad_s=lambda t, _: np.gradient(t.angle_rad, t.t_s, axis=0))),
    # initial state
    Blunder("initial rates relative to the horizontal", says("rate", f"{ORBITAL}|orbital rate|orbit"),
            scene=chain(rate_factor=lambda c: tuple(a + 1 for a in c.rate_factor))),
    Blunder("initial angles from the z1 axis", says("angle", "z1|horizontal|inertial|longitude"),
            scene=lambda s: chain(
                angle_rad=lambda c: tuple(a + 0.5 * math.pi - s.orbit.longitude_rad for a in c.angle_rad))(s)),
    Blunder("initial angles always from the chain's horizontal",
            says("angle", "each bar|own|other horizontal|angle_from"), scene=chain(angle_from=lambda _: "chain")),
    Blunder("circular speed always", says("speed|velocity", "circular|speed_factor|factor|beta"),
            scene=orbit(speed_factor=lambda _: 1.0)),
    Blunder("mean radius of the Earth", says("radius|altitude|distance"), scene=body(radius_m=lambda _: 6371.0e3)),
    Blunder("first bar's left end in the place of the centre of mass", says("left end|first bar|bar 1|end of"),
            read=result(com_m=lambda t, s: t.com_m - left_end(t, s)[0])),
    Blunder("bar 1's centre reported as centre of mass", says("first bar|bar 1"), base=PINOCCHIO,
            read=result(com_m=lambda t, s: t.com_m + centres(t, s)[:, 0],
                com_velocity_m_s=lambda t, s: t.com_velocity_m_s + drifts(t, s)[:, 0])),
    Blunder("bar 1's centre as centre of mass, in positions alone", says("first bar|bar 1"), base=PINOCCHIO,
            read=result(com_m=lambda t, s: t.com_m + centres(t, s)[:, 0])),
    Blunder("mean of the bars' centres as centre of mass",
            says("mean|unweighted|equal (mass|weight)|without (the )?mass|masses|geometric"),
            read=result(com_m=lambda t, s: t.com_m + centres(t, s).mean(axis=1),
                com_velocity_m_s=lambda t, s: t.com_velocity_m_s + drifts(t, s).mean(axis=1))),
    # gravity parameter, inertia, mass, length
    Blunder("mu = 3.986e14", says("\\bmu\\b|gravitational parameter|GM|gravity"),
            scene=body(mu_m3_s2=lambda _: 3.986e14)),
    Blunder("mu from g = 9.81 m/s^2", says("\\bmu\\b|gravitational parameter|GM|9\\.8"), base=PINOCCHIO,
            scene=body(mu_m3_s2=lambda b: 9.81 * b.radius_m**2)),
    Blunder("inertia about the end", says("inertia", "end|1/3|/ ?3|4 times|times 4|factor (of )?4|joint"),
            scene=inertia_times(4.0)),
    Blunder("inertia with half the length", says("inertia", "half|quarter|1/4|0\\.25|48"), base=MUJOCO,
            scene=inertia_times(0.25)),
    Blunder("half lengths taken as lengths", says("length", "half|0\\.5|twice|2"),
            scene=chain(length_m=lambda c: tuple(0.5 * b for b in c.length_m))),
    # missing and wrong terms
    Blunder("no gradient torque", says("gradient|torque", MISSING), scene=gravity(Gravity.GRADIENT, Gravity.POINT)),
    Blunder("half the gradient torque", says("gradient|torque", "half|0\\.5|1\\.5|3/2"), base=PINOCCHIO,
            engine=spin_times(0.5)),
    Blunder("gradient torque with the wrong sign", says("gradient|torque", OPPOSITE), base=PINOCCHIO,
            engine=spin_times(-1.0)),
    Blunder("the same gravity on all bars", says("tid|same gravity|centre of mass|uniform|point"), base=PINOCCHIO,
            engine=no_tides),
    Blunder("no centrifugal terms", says("centrifugal|coriolis|velocity|rate.{0,20}squared|quadratic"), base=PINOCCHIO,
            engine=no_velocity_terms),
    Blunder("gravity on the left ends", says("left end|end of|joint|point of|applied|acts?", "gravity|load|force"),
            base=PINOCCHIO, engine=loads_on_joints),
    Blunder("joints in the middle of the bar before", says("joint|hinge", "middle|centre|half|place"), base=PINOCCHIO,
            engine=middle_joints),
    Blunder("friction in joints", says("joint|dissip|energy", "friction|damp|dissip"), base=PINOCCHIO,
            scene=stray(0.0, 20.0)),
    Blunder("exact gravity as gradient", says("slender|gradient|third-order|point"),
            scene=gravity(Gravity.SLENDER, Gravity.GRADIENT)),
    Blunder("quadrupole gravity as gradient", says("quadrupole|gradient|third"),
            scene=gravity(Gravity.QUADRUPOLE, Gravity.GRADIENT)),
    # effects
    Blunder("no oblateness", says("oblate|J2", MISSING), scene=without("oblateness")),
    Blunder("oblateness without its factor 3/2", says("oblate|J2", "2/3|0\\.66|3/2|1\\.5"),
            scene=effect("oblateness", j2=lambda o: o.j2 / 1.5)),
    Blunder("polar instead of equatorial oblateness", says("oblate|J2", "pol|-2|sign"),
            scene=effect("oblateness", j2=lambda o: -2 * o.j2)),
    Blunder("no Sun", says("sun", MISSING), scene=lambda s: effects(s, third_body=s.effects.third_body[:1])),
    Blunder("atmosphere at rest", says("atmosphere|air|drag", "rotat|turn|rest"),
            scene=effect("drag", rotation_rad_s=lambda _: 0.0)),
    Blunder("drag without its factor 1/2", says("drag|air", "twice|1/2|half|2|double"), base=PINOCCHIO,
            scene=effect("drag", density_kg_m3=lambda d: 2 * d.density_kg_m3)),
    Blunder("normal and tangential drag exchanged", says("drag|coefficient", f"{SWAP}|normal|tangential"),
            scene=effect("drag", normal_coefficient=lambda d: d.tangential_coefficient,
                tangential_coefficient=lambda d: d.normal_coefficient)),
    Blunder("black bars in sunlight", says("reflect"), scene=effect("solar_pressure", reflectivity=lambda _: 0.0)),
    Blunder("sunlight towards the Sun", says("sun|light", f"{OPPOSITE}|direction|towards"),
            scene=effect("solar_pressure", sun_longitude_rad=lambda p: p.sun_longitude_rad + math.pi)),
    Blunder("no shadow", says("shadow"), scene=effect("solar_pressure", shadow=lambda _: False)),
    Blunder("springs at rest at zero", says("spring|joint", "rest"),
            scene=effect("joint_spring_damper", rest_rad=lambda j: (0.0,) * len(j.rest_rad))),
    Blunder("no dampers", says("damp", MISSING), base=MUJOCO,
            scene=effect("joint_spring_damper", damping_N_m_s_rad=lambda j: (0.0,) * len(j.rest_rad))),
    Blunder("thrust on the other end", says("thrust|force", "other end|wrong end|left|right|end"),
            scene=effect("thrust", end=lambda p: End.LEFT if p.end is End.RIGHT else End.RIGHT)),
    Blunder("thrust on the bar's centre", says("thrust|force", "centre|middle|torque|moment"), base=PINOCCHIO,
            scene=half_central),
    Blunder("body thrust in inertial axes", says("thrust", "inertial|axes"),
            scene=effect("thrust", axes=lambda _: Axes.INERTIAL)),
    Blunder("bars of thrusts counted from zero", says("thrust", "bar"),
            scene=effect("thrust", bar=lambda p: p.bar % 3 + 1)),
    Blunder("no impulses", says("impulse", MISSING), scene=without("impulse"),
            read=lambda t, s: t.replace(impulse_N_s=np.zeros_like(t.reaction_N) if s.effects.impulse else None)),
    Blunder("impulses a sample late", says("impulse", "late|delay|time|instant"),
            scene=lambda s: effect("impulse", at_s=lambda p: p.at_s + s.run.duration_s / (s.run.samples - 1))(s)),
    Blunder("impulsive reactions of each event alone", says("impuls", "sum|cumul|accumul|running|so far|event"),
            read=impulses_apart),
    Blunder("prescribed angles always inertial", says("prescri|law|rotation", "inertial|horizontal|other direction"),
            scene=effect("prescribed_rotation", frame=lambda _: Frame.INERTIAL)),
    Blunder("joint actuators as external torques", says("actuator|external|neighbour|reacts?|joint|torque"),
            scene=effect("prescribed_rotation", actuator=lambda _: Actuator.EXTERNAL)),
    Blunder("torques on the neighbour", says("torque", OPPOSITE),
            read=lambda t, _: t if t.torque_N_m is None else t.replace(torque_N_m=-t.torque_N_m)),
    # numbers, accuracy and behaviour
    Blunder("reactions twice", says("reaction", "twice|double|2"), read=times("reaction_N", 2.0)),
    Blunder("reactions all zero", says("reaction", "zero|0"), read=times("reaction_N", 0.0)),
    Blunder("angles never updated", says("angle", "constant|stale|first sample|start|same|change"),
            read=result(angle_rad=lambda t, _: t.angle_rad[:1].repeat(len(t.t_s), axis=0))),
    Blunder("angles in single precision", says("single|float32|24 bit|digits|round"),
            read=result(angle_rad=lambda t, _: t.angle_rad.astype(np.float32).astype(float))),
    Blunder("instants in single precision",
            says("(times|instants|clock) (is|are|has|have)", "single|float32|24 bit|digits|round"), base=SCIPY,
            engine=single_times),
    Blunder("reactions of all ends", says("reaction", "shape|expected"),
            read=result(reaction_N=lambda t, _: np.pad(t.reaction_N, ((0, 0), (0, 1), (0, 0))))),
    Blunder("not a number in the last sample", says("rate", "nan|finite|number"),
            read=result(rate_rad_s=lambda t, _: np.vstack([t.rate_rad_s[:-1], np.nan * t.rate_rad_s[-1:]]))),
    Blunder("a fixed tolerance", says("setting|request|tolerance|rtol|bound"), engine=fixed_tolerance),
    Blunder("Euler's method", says("order|integrat|method"), base=MUJOCO, engine=euler),
    Blunder("noise of a random start", says("two runs|differ|random|noise|same bits"),
            read=result(
                angle_rad=lambda t, _: t.angle_rad + 1e-13 * np.random.default_rng().normal(size=t.angle_rad.shape))),
    Blunder("a log in the working folder", says("engine.log|file"), engine=leaves_file),
]  # fmt: skip
PAIRS = [
    ("angles in degrees", "rates in degrees per second"),
    ("angles clockwise", "rates clockwise"),
    ("rates clockwise", "reactions on the next bar"),
    ("angles in degrees", "reactions on the next bar"),
    ("reactions in kN", "reactions on the next bar"),
    ("bars in reverse order", "joints in reverse order"),
    ("angles relative to the bar before", "rates relative to the bar before"),
    ("angles from the z2 axis", "reactions of the sample before"),
    ("rates in degrees per second", "angles wrapped to (-pi, pi]"),
    ("inertia about the end", "no gradient torque"),
    ("rates half a sample late", "reactions in the bar's axes"),
    ("orbit in km and km/s", "no gradient torque"),
    ("mu from g = 9.81 m/s^2", "rates clockwise"),
    ("inertia with half the length", "reactions twice"),
    ("initial rates relative to the horizontal", "reactions on the next bar"),
    ("drag without its factor 1/2", "thrust on the other end"),
    ("reactions in kilogram-force", "joints in reverse order"),
    ("longitude in degrees taken as radians", "reactions in kN"),
]


def all_mistakes() -> dict[str, Blunder]:
    """Mistakes and pairs by the names of their classes."""
    single = {m.name: m for m in MISTAKES}
    every = [*MISTAKES, *(pair(single[a], single[b]) for a, b in PAIRS)]
    return {"".join(re.findall(r"\w+", m.name.title())): m for m in every}


def wrong_engine(name: str) -> type[Any]:
    """Class of a wrong engine."""
    mistake = all_mistakes()[name]
    return mistake.apply(ENGINES[mistake.base].load())


def statements(report: ConformanceReport) -> list[Check]:
    """Checks that tell of something."""
    return [c for c in report.checks if c.state is CheckState.FAILED or
            (c.state is CheckState.WARNING and c.name not in TOLD_OF_EVERY_CLASS)]  # fmt: skip


def named_by(check: Check) -> str:
    """Words of a check on a mistake, without the sizes of the differences; empty if it names none."""
    words = check.words.partition(" Off: ")[0]
    return "" if words.startswith(UNKNOWN) else words


def likely_by(check: Check) -> str:
    """Words of a check on a mistake that leaves little, and yet more than the engine's own noise."""
    return check.words.partition(" Off: ")[0].partition(LIKELY)[2]


def verdict(mistake: Blunder, report: ConformanceReport) -> tuple[str, str]:
    """Whether a report names a mistake, and what it says."""
    said = statements(report)
    if not said:
        return "missed", ""
    expected = [w for w in (mistake.words, mistake.more) if w]
    where = [[c for c in said if re.search(w, named_by(c), re.I)] for w in expected]
    rightly = sum(map(bool, where))
    state = "named rightly" if rightly == len(where) else "one of two named" if rightly else "only detected"
    if not rightly and any(all(re.search(w, likely_by(c), re.I) for w in expected) for c in said):
        state = "named as most likely"
    physics = [c for c in said if c.group is Group.PHYSICS]
    shown = [found[0] for found in where if found] or physics[:1] or said[:1]
    return state, "; ".join(dict.fromkeys(f"{c.name}: {c.words.partition(' Off: ')[0]}" for c in shown))


def planted(only: str, full: bool) -> None:
    """Table of mistakes."""
    counts: dict[str, int] = {}
    print("| mistake | engine | result | what was said |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path(f"{MODULE}.py").write_text(SOURCE.format(folder=str(HERE)), "utf-8")
        for name, mistake in all_mistakes().items():
            if not re.search(only, mistake.name):
                continue
            report = conform(f"{MODULE}:{name}")
            state, said = verdict(mistake, report)
            counts[state] = counts.get(state, 0) + 1
            print(f"| {mistake.name} | {mistake.base} | {state} | {said[:300]} |", flush=True)
            for check in statements(report) if full else ():
                print(f"    [{report.seconds:.0f} s] {check.group}, {check.name}: {check.words}")
    print(f"\n{sum(counts.values())} mistakes: {', '.join(f'{n} {state}' for state, n in counts.items())}")


def sound(only: str) -> None:
    """All installed engines as they are."""
    print("| engine | s | failed or warned |\n|---|---:|---|")
    for name, registration in engines().items():
        if registration.missing or not re.search(only, name):
            continue
        report = conform(name)
        told = "; ".join(f"{c.state}: {c.group}, {c.name}: {c.words}" for c in report.checks
                         if c.state in {CheckState.FAILED, CheckState.WARNING})  # fmt: skip
        print(f"| {name} | {report.seconds:.1f} | {told} |", flush=True)


def main() -> None:
    """Plant mistakes, or examine engines without any."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="Regular expression of names.")
    parser.add_argument("--full", action="store_true", help="Print all that is said.")
    parser.add_argument("--sound", action="store_true", help="Examine the engines as they are.")
    given = parser.parse_args()
    if given.sound:
        sound(given.only)
    else:
        planted(given.only, given.full)


if __name__ == "__main__":
    main()
