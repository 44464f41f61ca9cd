"""Scenes whose thrusts, impulses and joints' motors act elsewhere, otherwise or at other times."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING, Any

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.motion.changed_loads import choices, other, with_effects
from scenarios import Axes, End, Impulse, Thrust

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.motion.changed_loads import ChosenLoads, Fields, Made
    from scenarios import JointTorque, Scene

FORCES = (("kilograms-force", 9.80665), ("pounds-force", 4.4482216152605), ("kilonewtons", 1e3))
TORQUES = (("kilonewton metres", 1e3), ("newton millimetres", 1e-3))


def of_pushes(scene: Scene) -> Made:
    """Thrusts and impulses at another point, in other axes, on another bar, or missing."""
    angle = initial_state(scene).angle_rad
    yield from of_one_instant(scene, "thrust", lambda p: p.times_s[0])
    yield from of_one_instant(scene, "impulse", lambda p: p.at_s)
    together = [p for p in scene.effects.impulse if sum(q.at_s == p.at_s for q in scene.effects.impulse) > 1]
    for which, place in (("first", 0), ("last", -1)) if together else ():
        at_once = {p.at_s: [q for q in scene.effects.impulse if q.at_s == p.at_s][place] for p in scene.effects.impulse}
        words = f"of several impulses at one instant the {which} alone acts"
        yield f"impulses-{which}-at-once", words, with_effects(scene, impulse=tuple(at_once.values()))
    loaded = ("thrust", "impulse", "prescribed_rotation")
    by_digit = {kind: tuple(dataclasses.replace(p, bar=int(str(p.bar)[0])) for p in getattr(scene.effects, kind))
                for kind in loaded}  # fmt: skip
    yield ("bars-by-first-digit", "the loads on bars from 10 on act on the bar of the number's first digit",
           with_effects(scene, **by_digit))  # fmt: skip
    for some in (*choices(scene, "thrust"), *choices(scene, "impulse")):
        name, who, s, first = some.name, some.who, some.s, some.every[some.places[0]]
        yield f"{name}-missing", f"{who} {'is' if s else 'are'} missing", some.changed(lambda _: ())
        yield f"{name}-at-other-end", f"{who} act{s} at the bar's other end", some.each(lambda p: {"end": other(p.end)})
        for end, where in ((End.LEFT, "left"), (End.RIGHT, "right")):
            if len({p.end for p in some.every}) > 1:
                yield f"{name}-at-{where}-ends", f"{who} act{s} at the {where} end always", some.each(at_end(end))
        axes = f"{other(first.axes)} axes"
        yield (f"{name}-in-{axes.replace(' ', '-')}", f"{who} count{s} the direction in {axes}, the other ones",
               some.each(lambda p: {"axes": other(p.axes)}))  # fmt: skip

        def frozen(p: Any) -> dict[str, Any]:
            turned = float(angle[p.bar - 1]) if p.axes is Axes.BODY else 0.0
            return {"axes": Axes.INERTIAL, "direction_rad": p.direction_rad + turned}

        yield (f"{name}-clockwise", f"{who} count{s} the direction clockwise",
               some.each(lambda p: {"direction_rad": -p.direction_rad}))  # fmt: skip
        yield (
            f"{name}-from-normal",
            f"{who} count{s} a direction in body axes from the bar's normal",
            some.each(lambda p: {"direction_rad": p.direction_rad + (0.5 * math.pi if p.axes is Axes.BODY else 0.0)}),
        )
        yield f"{name}-frozen", f"{who} keep{s} the direction of the bar at t = 0", some.each(frozen)
        for shift in range(1, scene.bars):
            there = some.each(on_next(shift, scene.bars))
            where = {1: "the next bar", scene.bars - 1: "the previous bar"}.get(shift, f"the bar {shift} places on")
            if s:
                where = f"bar {getattr(there.effects, some.kind)[some.places[0]].bar}"
            yield f"{name}-on-{where.removeprefix('the ').replace(' ', '-')}", f"{who} act{s} on {where}", there
        yield f"{name}-at-centre", f"{who} act{s} at the bar's centre", some.changed(halves)
        yield f"{name}-of-positive-size", f"{who} lose{s} the sign of a negative size", some.each(positive)
        if some.kind == "thrust":
            yield from of_tables(some)
            yield from in_units(some, "newtons", FORCES)


def of_motors(scene: Scene) -> Made:
    """Torques of joints' motors that are missing, opposite, in another joint, in another unit or of another course."""
    for some in choices(scene, "joint_torque"):
        name, who, s = some.name, some.who, some.s
        yield f"{name}-missing", f"{who} {'is' if s else 'are'} missing", some.changed(lambda _: ())
        yield f"{name}-of-positive-size", f"{who} lose{s} the sign of a negative size", some.each(positive)
        for shift in range(1, scene.bars - 1):

            def on(motor: JointTorque, shift: int = shift) -> dict[str, Any]:
                return {"joint": (motor.joint - 1 + shift) % (scene.bars - 1) + 1}

            there = some.each(on)
            where = f"joint {there.effects.joint_torque[some.places[0]].joint}" if s else f"the joint {shift} places on"
            yield f"{name}-in-{where.removeprefix('the ').replace(' ', '-')}", f"{who} act{s} in {where}", there
        yield from of_tables(some)
        yield from in_units(some, "newton metres", TORQUES)


def of_one_instant(scene: Scene, kind: str, at_s: Callable[[Any], float]) -> Made:
    """Thrusts or impulses of the first or of the last instant alone."""
    every = getattr(scene.effects, kind)
    instants = {at_s(push) for push in every}
    for which, rest, instant in (("first", "later", min), ("last", "earlier", max)) if len(instants) > 1 else ():
        kept = tuple(push for push in every if at_s(push) == instant(instants))
        words = f"the {kind}s of the {which} instant act, and the {rest} ones are missing"
        yield f"{kind}s-of-{which}-instant", words, with_effects(scene, **{kind: kept})


def halves(push: Any) -> tuple[Any, ...]:
    """Half a push at each end."""
    if isinstance(push, Impulse):
        half = {"impulse_N_s": 0.5 * push.impulse_N_s}
    else:
        half = with_sizes(push, tuple(0.5 * size for size in push.sizes))
    return tuple(dataclasses.replace(push, end=end, **half) for end in End)


def at_end(end: End) -> Fields:
    """Push at an end, whichever the scene has."""
    return lambda _: {"end": end}


def on_next(shift: int, bars: int) -> Fields:
    """Bar that is some places on, round the chain."""
    return lambda push: {"bar": (push.bar - 1 + shift) % bars + 1}


def positive(push: Any) -> dict[str, Any]:
    """Push of a size without its sign."""
    if isinstance(push, Impulse):
        return {"impulse_N_s": abs(push.impulse_N_s)}
    return with_sizes(push, tuple(map(abs, push.sizes)))


def with_sizes(table: Thrust | JointTorque, sizes: tuple[float, ...]) -> dict[str, Any]:
    """Field of the sizes of a thrust or a joint's motor."""
    return {"force_N" if isinstance(table, Thrust) else "torque_N_m": sizes}


def in_units(some: ChosenLoads, right: str, units: tuple[tuple[str, float], ...]) -> Made:
    """Thrusts or motors whose sizes are taken in other units."""
    for unit, factor in units:

        def times(p: Any, factor: float = factor) -> dict[str, Any]:
            return with_sizes(p, tuple(factor * f for f in p.sizes))

        ending = unit.replace(" ", "-")
        yield f"{some.name}-in-{ending}", f"{some.who} take{some.s} {right} as {unit}", some.each(times)


def of_tables(some: ChosenLoads) -> Made:
    """Thrusts or motors with another course in time."""
    name, who, s, end_s = some.name, some.who, some.s, some.scene.run.duration_s
    for which, words, before, after in (
        ("from-the-start", f"act{s} from the start of the run on", True, False),
        ("without-end", f"act{s} without end", False, True),
        ("all-along", f"act{s} from the start to the end of the run", True, True),
    ):

        def longer(p: Any, before: bool = before, after: bool = after) -> dict[str, Any]:
            early = before and p.times_s[0] > 0.0
            late = after and p.times_s[-1] < end_s
            times_s = (*((0.0,) if early else ()), *p.times_s, *((end_s,) if late else ()))
            sizes = (*(p.sizes[:1] if early else ()), *p.sizes, *(p.sizes[-1:] if late else ()))
            return {"times_s": times_s, **with_sizes(p, sizes)}

        yield f"{name}-{which}", f"{who} {words}", some.each(longer)
    for which, words, size in (
        ("table-held", "size from one instant of the table to the next", held),
        ("table-ahead", "size of the next instant of the table, up to it", lambda p: held(p, 0.0)),
        ("table-of-means", "mean of two sizes between their instants in the table", lambda p: held(p, 0.5)),
        ("mean-size", "mean size of the table",
         lambda p: with_sizes(p, (sum(p.sizes) / len(p.sizes),) * len(p.sizes))),
        ("first-size", "first size of the table", lambda p: with_sizes(p, p.sizes[:1] * len(p.sizes))),
    ):  # fmt: skip
        yield f"{name}-{which}", f"{who} keep{s} the {words}", some.each(size)


def held(table: Thrust | JointTorque, share: float = 1.0) -> dict[str, Any]:
    """Table whose size jumps at each instant: between two, a share of the first, the rest of the next."""
    if len(set(table.sizes)) == 1:
        return {}
    steps = [share * a + (1.0 - share) * b for a, b in itertools.pairwise(table.sizes)]
    times_s, sizes = [table.times_s[0]], [steps[0]]
    for at_s, before, after in zip(table.times_s[1:-1], steps, steps[1:], strict=False):
        times_s += [at_s, at_s]
        sizes += [before, after]
    return {"times_s": (*times_s, table.times_s[-1]), **with_sizes(table, (*sizes, steps[-1]))}
