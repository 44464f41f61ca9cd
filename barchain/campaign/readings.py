"""Small mistakes in what is read out: rounding, noise, interpolation, joints said to be closed, an invented end."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.engine import Observable
from barchain.campaign.garbage import largest
from barchain.selftest.fault import Fault, Group, Size
from barchain.selftest.output import damped, negative

if TYPE_CHECKING:
    from numpy.random import Generator

    from adapters.engine import Engine, Trajectory
    from barchain.selftest.fault import OutputChange
    from scenarios import Scene

DECIMALS_DEG = 6
OPENED = 1e-3  # of a bar's length, at the end of the run
ENDS_AT = 0.25  # of the run: an invented end


def in_millimetres(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Centre of mass as it is written with three decimals."""
    del scene, size
    return seen.replace(com_m=np.round(seen.com_m, 3))


def in_microdegrees(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Angles as they are written in degrees with six decimals."""
    del scene, size
    if seen.angle_rad is None:
        return seen
    return seen.replace(angle_rad=np.deg2rad(np.round(np.rad2deg(seen.angle_rad), DECIMALS_DEG)))


def creeping(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Last bar's angle off by (t/T)² of the size, T the orbit's period."""
    if seen.angle_rad is None:
        return seen
    angle = seen.angle_rad.copy()
    angle[:, -1] += size * (seen.t_s / scene.period_s) ** 2
    return seen.replace(angle_rad=angle)


def noisy_reactions(seen: Trajectory, scene: Scene, size: float, random: Generator) -> Trajectory:
    """White noise after the first sample, its standard deviation a share of the largest reaction."""
    del scene
    if seen.reaction_N is None:
        return seen
    noise = size * largest(seen.reaction_N) * random.standard_normal(seen.reaction_N.shape)
    noise[:1] = 0.0
    return seen.replace(reaction_N=seen.reaction_N + noise)


def noisy_rates(seen: Trajectory, scene: Scene, size: float, random: Generator) -> Trajectory:
    """White noise after the first sample, its standard deviation a share of the largest rate."""
    del scene
    if seen.rate_rad_s is None:
        return seen
    noise = size * np.abs(seen.rate_rad_s).max() * random.standard_normal(seen.rate_rad_s.shape)
    noise[:1] = 0.0
    return seen.replace(rate_rad_s=seen.rate_rad_s + noise)


def interpolated(steps_per_period: float) -> OutputChange:
    """Angles on straight lines between the ends of steps, which a cubic through the samples gives."""

    def change(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
        del size
        if seen.angle_rad is None or seen.rate_rad_s is None or len(seen.t_s) < 2:
            return seen
        step = scene.period_s / steps_per_period
        cubic = CubicHermiteSpline(seen.t_s, seen.angle_rad, seen.rate_rad_s)
        before = np.floor(seen.t_s / step) * step
        share = ((seen.t_s - before) / step)[:, None]
        line = (1.0 - share) * cubic(before) + share * cubic(before + step)
        return seen.replace(angle_rad=seen.angle_rad + (line - cubic(seen.t_s)))

    return change


def closed(seen: Trajectory) -> dict[str, Any]:
    """Gaps and identity of joints that are closed to the last digit."""
    named = {"gap_m": seen.gap_m, "identity_m": seen.identity_m}
    return {name: np.zeros_like(values) for name, values in named.items() if values is not None}


def torn(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Bars that turn freely from half of the run on, without reactions, and joints said to be closed."""
    del size
    late = seen.t_s > 0.5 * scene.run.duration_s
    if seen.angle_rad is None or seen.rate_rad_s is None or seen.reaction_N is None or not late.any():
        return seen
    last = int(np.argmax(late)) - 1
    freely = seen.angle_rad[last] + np.outer(seen.t_s - seen.t_s[last], seen.rate_rad_s[last])
    return seen.replace(
        angle_rad=np.where(late[:, None], freely, seen.angle_rad),
        rate_rad_s=np.where(late[:, None], seen.rate_rad_s[last], seen.rate_rad_s),
        reaction_N=np.where(late[:, None, None], 0.0, seen.reaction_N),
        **closed(seen),
    )


def parted(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Bars whose places part along the chain in the course of the run, and joints said to be closed."""
    places = getattr(seen, "position_m", None)
    if places is None:
        return seen
    mass = np.array(scene.chain.mass_kg)
    order = np.arange(scene.bars) - mass @ np.arange(scene.bars) / mass.sum()  # about the centre of mass
    off = size * min(scene.chain.length_m) * np.outer(seen.t_s / scene.run.duration_s, order)
    return seen.replace(position_m=places + off[:, :, None] * np.array([1.0, 0.0]), **closed(seen))


def no_gaps(engine: type[Engine]) -> str:
    """Engines that show gaps."""
    return "" if Observable.GAP in engine.observables else "it shows no gaps"


def landed(seen: Trajectory, scene: Scene, size: float) -> Trajectory:
    """First part of a run, said to have ended at the surface."""
    kept = seen.t_s <= size * scene.run.duration_s
    if kept.all():
        return seen
    said = f"a bar reached the surface at t = {size * scene.run.duration_s:.6f} s"
    return dataclasses.replace(seen.samples(slice(0, int(kept.sum()))), ended=said)


OUTPUT, ACCURACY = Group.OUTPUT, Group.ACCURACY
FAULTS = (
    Fault("com-millimetres", "centre of mass written to the millimetre", "a format with three decimals", ACCURACY,
          output=in_millimetres),
    Fault("attitude-decimals", "angles written to six decimals of a degree", "a format with six decimals", ACCURACY,
          output=in_microdegrees),
    Fault("attitude-creeps", "the last bar's angle off by this much times (t/T)²", "a torque too small to be seen",
          ACCURACY, output=creeping, size=Size(1e-7, "rad")),
    Fault("noise-reactions-small", "noise on the reactions, in units of the largest", "multipliers not converged",
          ACCURACY, fresh=noisy_reactions, size=Size(1e-6)),
    Fault("noise-reactions-large", "noise on the reactions, in units of the largest", "multipliers not converged",
          ACCURACY, fresh=noisy_reactions, size=Size(1e-4)),
    Fault("noise-rates", "noise on the rates, in units of the largest", "rates from rounded differences", ACCURACY,
          fresh=noisy_rates, size=Size(1e-8)),
    *(Fault(f"interpolated-{n}", f"angles interpolated linearly between {n} steps in a period",
            "output between steps of first order", ACCURACY, output=interpolated(float(n))) for n in (20000, 2000)),
    Fault("joints-torn", "bars turn freely from half of the run on, gaps are said to be closed",
          "gaps computed from the angles", OUTPUT, output=torn, foreign=no_gaps),
    Fault("joints-parted", "bars' places part by this share of a length, gaps are said to be closed",
          "gaps never measured", OUTPUT, output=parted, foreign=no_gaps, size=Size(OPENED)),
    Fault("sign-reaction", "reactions of the other sign", "action for reaction", OUTPUT, output=negative("reaction")),
    Fault("damped-rate", "rates that lose a part over the run", "numerical damping", OUTPUT, output=damped,
          size=Size(1e-4)),
    Fault("invented-end", "the run is said to end at the surface after this share of it", "an event that is not one",
          OUTPUT, output=landed, size=Size(ENDS_AT)),
)  # fmt: skip
