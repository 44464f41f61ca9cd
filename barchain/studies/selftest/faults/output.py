"""Faults in the samples of an unmodified run: signs, axes, units, order, instants, holes."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size
from scenarios.channels import STORED, Judged, Of

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import NotApplicable, OutputChange
    from scenarios import Scene

IN_NAMES = {"com_velocity": "com-velocity"}
"""Channels that names of faults, which records hold, write in another way"""
JUDGED = sorted((c for c in STORED if c.judged), key=lambda channel: bool(channel.effects))
"""Channels of every scene, then those of an effect: the order of the catalogue, from which seeds choose"""
CHANNELS = {IN_NAMES.get(c.name, c.name): c.array for c in JUDGED}
ALWAYS = tuple(IN_NAMES.get(c.name, c.name) for c in JUDGED if c.of is Of.TRACK)
MEASURED = tuple(c.name for c in JUDGED if c.judged is Judged.DRIFT)
OUTPUT, ACCURACY, START = FaultGroup.OUTPUT, FaultGroup.ACCURACY, FaultGroup.START


def values(trajectory: Trajectory, channel: str) -> Array:
    """Values of a channel that is there."""
    found: Array = getattr(trajectory, CHANNELS[channel])
    return found


def changed(trajectory: Trajectory, channel: str, found: Array | None) -> Trajectory:
    """Trajectory with another channel in its place."""
    return trajectory.replace(**{CHANNELS[channel]: found})


def grown(channel: str) -> OutputChange:
    """Scale a channel by 1 + size."""
    return lambda seen, _, size: changed(seen, channel, values(seen, channel) * (1.0 + size))


def channelwise(change: Callable[[Array], Array]) -> Callable[[str], OutputChange]:
    """Change of all samples of one channel, whatever the scene and the size."""
    return lambda channel: lambda seen, *_: changed(seen, channel, change(values(seen, channel)))


def whole(change: Callable[[Trajectory], Trajectory]) -> OutputChange:
    """Change of a trajectory, whatever the scene and the size."""
    return lambda seen, *_: change(seen)


def late(found: Array) -> Array:
    """Values one sample late; the first sample stays."""
    return np.concatenate([found[:1], found[:-1]])


def single(found: Array) -> Array:
    """Values in single precision."""
    return found.astype(np.float32).astype(np.float64)


def one_nan(found: Array) -> Array:
    """Values with one NaN in the middle."""
    found = found.copy()
    found.reshape(len(found), -1)[len(found) // 2, -1] = np.nan
    return found


def one_repeated(found: Array) -> Array:
    """Values with the sample before the largest change in place of the one after."""
    found = found.copy()
    sample = 1 + int(np.argmax(np.abs(np.diff(found, axis=0)).reshape(len(found) - 1, -1).max(axis=1)))
    found[sample] = found[sample - 1]
    return found


def backwards(found: Array) -> Array:
    """Bars or joints from last to first."""
    return found[:, ::-1].copy()


def dropped(channel: str) -> OutputChange:
    """Remove a channel."""
    return lambda seen, *_: changed(seen, channel, None)


def repeated(trajectory: Trajectory) -> Trajectory:
    """One sample that is the one before in every channel but the time."""
    order = np.arange(len(trajectory.t_s))
    order[len(order) // 2] -= 1
    return dataclasses.replace(trajectory.samples(order), t_s=trajectory.t_s)


def twice(trajectory: Trajectory) -> Trajectory:
    """One sample written twice, its time with it."""
    middle = len(trajectory.t_s) // 2
    return trajectory.samples(np.insert(np.arange(len(trajectory.t_s)), middle, middle))


def cut(trajectory: Trajectory) -> Trajectory:
    """First half of the samples, without an end reason."""
    return dataclasses.replace(trajectory.samples(slice(0, len(trajectory.t_s) // 2)), ended="")


def by_angle(reaction: Array, angle: Array) -> Array:
    """Components of forces in axes turned by `angle`, which broadcasts to all but the last axis."""
    turned = (reaction[..., 0] + 1j * reaction[..., 1]) * np.exp(-1j * angle)
    return np.stack([turned.real, turned.imag], axis=-1)


def in_orbit_axes(trajectory: Trajectory) -> Trajectory:
    """Reactions in radial and transverse components."""
    longitude = np.arctan2(trajectory.com_m[:, 1], trajectory.com_m[:, 0])
    return changed(trajectory, "reaction", by_angle(values(trajectory, "reaction"), longitude[:, None]))


def in_bar_axes(trajectory: Trajectory) -> Trajectory:
    """Reactions in the axes of the bars they act on."""
    return changed(
        trajectory, "reaction", by_angle(values(trajectory, "reaction"), values(trajectory, "attitude")[:, :-1])
    )


def wrapped(trajectory: Trajectory) -> Trajectory:
    """Angles in (-pi, pi]."""
    angle = values(trajectory, "attitude")
    return changed(trajectory, "attitude", np.pi - np.mod(np.pi - angle, 2.0 * np.pi))


def from_horizontal(trajectory: Trajectory) -> Trajectory:
    """Angles from the horizontal through the centre of mass."""
    longitude = np.unwrap(np.arctan2(trajectory.com_m[:, 1], trajectory.com_m[:, 0]))
    return changed(trajectory, "attitude", values(trajectory, "attitude") - longitude[:, None] + 0.5 * np.pi)


def from_before(trajectory: Trajectory) -> Trajectory:
    """Angles from the bar before."""
    angle = values(trajectory, "attitude")
    return changed(trajectory, "attitude", np.diff(angle, axis=1, prepend=0.0))


def damped(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Rates that decrease linearly over the run, by a share of `size` in all."""
    lost = 1.0 - size * trajectory.t_s / scene.run.duration_s
    return changed(trajectory, "rate", values(trajectory, "rate") * lost[:, None])


def opened(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Joint gaps that grow linearly over the run."""
    return changed(
        trajectory, "gap", values(trajectory, "gap") + size * (trajectory.t_s / scene.run.duration_s)[:, None]
    )


def off_centre(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Residual of the centre of mass raised by `size`."""
    del scene
    return changed(trajectory, "com_residual", values(trajectory, "com_residual") + size)


def from_start(trajectory: Trajectory) -> Trajectory:
    """Places counted from the first one."""
    return changed(trajectory, "com", trajectory.com_m - trajectory.com_m[0])


def stretched(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Instants multiplied by 1 + `size`."""
    del scene
    return trajectory.replace(t_s=trajectory.t_s * (1.0 + size))


def there(channel: str) -> NotApplicable:
    """Reason why a channel is empty in a scene."""
    if channel in (*ALWAYS, "attitude", "rate"):
        return lambda _: ""
    if channel == "torque":
        return reasons.SLEW
    return reasons.impulses if channel == "impulse" else reasons.joints


def varies(channel: str) -> NotApplicable:
    """Reason why a channel is empty or constant in a scene."""

    def nothing(solution: ReferenceSolution) -> str:
        lacking = there(channel)(solution)
        if lacking:
            return lacking
        found = values(solution.trajectory, channel)
        return f"{channel} stays as it is" if np.array_equal(found, np.broadcast_to(found[0], found.shape)) else ""

    return nothing


def each(
    channels: tuple[str, ...],
    name: str,
    words: str,
    stands: str,
    change: Callable[[str], OutputChange],
    group: FaultGroup,
) -> list[Fault]:
    """One fault in several channels."""
    nothing = varies if name in ("repeated", "late") else there
    return [
        Fault(f"{name}-{c}", f"{c.replace('-', ' ')} {words}", stands, group, output=change(c), nothing=nothing(c))
        for c in channels
    ]


ALL = tuple(CHANNELS)
FORCES = ("reaction", "torque", "impulse")
PERCENT = Size(1e-2, most=1.0)
FAULTS = (
    *each(FORCES, "sign", "of the other sign", "action for reaction", channelwise(np.negative), OUTPUT),
    *each((*FORCES, "com-velocity", "rate"), "late", "one sample late", "read before the step, not after it",
          channelwise(late), OUTPUT),
    *(Fault(f"scale-{c}", f"{c} too large", "a wrong unit or load factor", OUTPUT, output=grown(c), size=PERCENT,
            nothing=there(c)) for c in FORCES),
    Fault("zeros-reaction", "reactions all zero", "a channel never filled", OUTPUT, nothing=there("reaction"),
          output=lambda seen, *_: changed(seen, "reaction", 0.0 * values(seen, "reaction"))),
    Fault("orbit-axes-reaction", "reactions in radial and transverse components", "another frame", OUTPUT,
          output=whole(in_orbit_axes), nothing=there("reaction")),
    Fault("bar-axes-reaction", "reactions in the axes of the bars they act on", "another frame", OUTPUT,
          output=whole(in_bar_axes), nothing=there("reaction")),
    Fault("order-reaction", "joints from last to first", "another order of bodies", OUTPUT,
          output=channelwise(backwards)("reaction"), nothing=reasons.several_joints),
    Fault("order-attitude", "bars from last to first", "another order of bodies", OUTPUT,
          output=channelwise(backwards)("attitude"), nothing=there("reaction")),
    *each(("attitude", "rate"), "degrees", "in degrees", "a library's own unit", channelwise(np.rad2deg), OUTPUT),
    Fault("wrapped-attitude", "angles wrapped to (-180°, 180°]", "atan2 for an integrated angle", OUTPUT,
          output=whole(wrapped), nothing=reasons.turned_around),
    Fault("horizon-attitude", "angles from the local horizontal", "the paper's phi for theta", OUTPUT,
          output=whole(from_horizontal)),
    Fault("joint-angles", "angles from the bar before", "joint coordinates not summed", OUTPUT,
          output=whole(from_before), nothing=there("reaction")),
    Fault("start-com", "places counted from the first one", "another origin", OUTPUT, output=whole(from_start)),
    Fault("scale-com-velocity", "velocities that are not the track's derivative", "momentum over another mass", OUTPUT,
          output=grown("com-velocity"), size=Size(1e-6)),
    Fault("scale-rate", "rates that are not the angles' derivative", "rates in other axes", OUTPUT,
          output=grown("rate"), size=Size(1e-6)),
    Fault("damped-rate", "rates that lose a part over the run", "numerical damping", OUTPUT, output=damped,
          size=Size(1e-4)),
    Fault("opened-gap", "joints that open by this much in the course of the run", "drift of constraints", OUTPUT,
          output=opened, size=Size(1e-6, "m", most=1e3), nothing=there("gap")),
    Fault("off-com-residual", "bars' weighted centre beside the centre of mass", "places of two instants", OUTPUT,
          output=off_centre, size=Size(1e-6, "m"), nothing=there("com_residual")),
    *each(tuple(c for c in ALL if c not in ALWAYS), "dropped", "left out", "a channel that is declared and not there",
          dropped, OUTPUT),
    *each(ALL, "nan", "with one NaN", "a division by zero in one sample", channelwise(one_nan), OUTPUT),
    Fault("repeated", "one sample that is the one before, in every channel", "a buffer not advanced", OUTPUT,
          output=whole(repeated)),
    *each(tuple(c for c in ALL if c not in MEASURED), "repeated", "with one sample that is the one before",
          "a buffer not advanced", channelwise(one_repeated), OUTPUT),
    Fault("twice", "one sample written twice, its instant with it", "a restart", OUTPUT, output=whole(twice)),
    Fault("cut", "the first half of the samples, and no word why", "a run that ended early", OUTPUT, output=whole(cut)),
    Fault("clock-stretched", "instants stretched", "a step count times a rounded step", OUTPUT, output=stretched,
          size=Size(1e-6)),
    *each(tuple(c for c in ALL if c not in MEASURED), "float32", "in single precision", "one array declared float32",
          channelwise(single), ACCURACY),
)  # fmt: skip
