"""All mistakes of reading."""

from __future__ import annotations

from barchain.judge.diagnosis.readings import angles, differences, joints, signs_and_axes, timing, track, units

READINGS = (
    *signs_and_axes.MISTAKES,
    *units.MISTAKES,
    *angles.MISTAKES,
    *joints.MISTAKES,
    *track.MISTAKES,
    *differences.MISTAKES,
    *timing.HELD_MISTAKES,
)
TIMINGS = timing.MISTAKES
