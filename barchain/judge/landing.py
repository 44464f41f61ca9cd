"""Whether the instant at which a run ends is that of the reference solution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.trajectory import ENDED
from barchain.run.trajectory_checks import TIME_SLACK

if TYPE_CHECKING:
    from barchain.judge.residuals import Residuals


def ended_elsewhen(run: Residuals) -> str | None:
    """Say why, if both located the instant of their end, and their errors don't explain that it is not the same."""
    mine, theirs = (float(seen.info.get(ENDED, np.nan)) for seen in (run.main, run.solution.trajectory))
    if np.isnan(mine - theirs):
        return None
    apart, allowed = abs(mine - theirs), landing_tolerance_s(run)
    if apart <= allowed:
        return None
    return f"ended {apart:.3g} s apart from the reference, {apart / allowed:.3g} times what is explained"


def landing_tolerance_s(run: Residuals) -> float:
    """What explains a difference of the instants at which a bar reached the surface, s.

    The chain's ends are where they are to the errors of track and attitude at the last sample, and of their rates
    until the next; beyond the predictability limit a bar may point anywhere. That over the speed at which they come
    down, at least the centre of mass' less what they turn with about it. Where that is nothing, the chain grazes
    the surface, and no instant is judged but to a sample.
    """
    seen, size, last = run.solution.trajectory, run.scene.size_m, run.n - 1
    spacing = run.scene.run.duration_s / (run.scene.run.samples - 1)
    if seen.rate_rad_s is None or not {"attitude", "rate"} <= run.found.keys():
        return spacing
    place, velocity = seen.com_m[last], seen.com_velocity_m_s[last]
    turning = float(np.abs(seen.rate_rad_s[last]).max())
    down = -float(place @ velocity) / float(np.linalg.norm(place)) - size * turning
    off = {name: float(run.tolerance(name)[last]) for name in ("com", "com_velocity", "attitude", "rate")}
    if run.t[last] > run.limit_s:
        off |= {"attitude": 1.0, "rate": turning}
    ends = off["com"] + size * off["attitude"]
    ends += spacing * (off["com_velocity"] + size * (off["rate"] + turning * off["attitude"]))
    return TIME_SLACK * run.scene.run.duration_s + ends / down if down > 0.0 else spacing
