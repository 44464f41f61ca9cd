"""Whether the instant at which a run ends is that of the judging solution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.trajectory import ENDED
from barchain.run.trajectory_checks import TIME_SLACK

if TYPE_CHECKING:
    from barchain.judge.residuals import Residuals


def end_instant_fault(run: Residuals) -> str | None:
    """Say why, if both runs located the instant of their end and their errors do not explain its difference."""
    mine, theirs = (float(seen.info.get(ENDED, np.nan)) for seen in (run.main, run.solution.trajectory))
    if np.isnan(mine - theirs):
        return None
    apart, allowed = abs(mine - theirs), landing_tolerance_s(run)
    if apart <= allowed:
        return None
    return f"ended {apart:.3g} s apart from the reference, {apart / allowed:.3g} times the explained difference"


def landing_tolerance_s(run: Residuals) -> float:
    """Explained difference of the instants at which a bar reached the surface, s.

    The places of the chain's ends have the errors of track and attitude at the last sample, and of their rates until
    the next. Beyond the predictability limit a bar may point anywhere. The errors are divided by the speed of descent:
    that of the centre of mass less that of the bars' rotation about it. Where this difference is not positive, the
    chain grazes the surface, and the instant is judged to one sample.
    """
    seen, size, last = run.solution.trajectory, run.scene.size_m, run.n - 1
    spacing = run.scene.run.duration_s / (run.scene.run.samples - 1)
    if seen.rate_rad_s is None or not {"attitude", "rate"} <= run.difference.keys():
        return spacing
    place, velocity = seen.com_m[last], seen.com_velocity_m_s[last]
    turning = float(np.abs(seen.rate_rad_s[last]).max())
    down = -float(place @ velocity) / float(np.linalg.norm(place)) - size * turning
    off = {name: float(run.tolerance[name][last]) for name in ("com", "com_velocity", "attitude", "rate")}
    if run.t[last] > run.limit_s:
        off |= {"attitude": 1.0, "rate": turning}
    ends = off["com"] + size * off["attitude"]
    ends += spacing * (off["com_velocity"] + size * (off["rate"] + turning * off["attitude"]))
    return TIME_SLACK * run.scene.run.duration_s + ends / down if down > 0.0 else spacing
