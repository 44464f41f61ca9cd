"""Joint springs and dampers as torques on bars, in plain floats: docs/effects/joint_spring_damper.md."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import JointSpringDamper


class SpringLoad:
    """Joint springs without dampers."""

    of_rates: ClassVar[bool] = False

    def __init__(self, bars: list[BarProperties], springs: JointSpringDamper) -> None:
        """Springs of a scene."""
        self.inertia = [bar.inertia_kg_m2 for bar in bars]
        self.stiff = list(zip(springs.stiffness_N_m_rad, springs.rest_rad, strict=True))

    def torques(self, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Torque of each joint on the bar behind the joint, N m."""
        del rates
        return [
            -k * (b - a - rest) for (k, rest), ((*_, a), (*_, b)) in zip(self.stiff, pairwise(positions), strict=True)
        ]

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del frame
        found = self.torques(positions, rates)
        before, after = [0.0, *found], [*found, 0.0]
        return [(0.0, 0.0, (a - b) / J) for a, b, J in zip(before, after, self.inertia, strict=True)]


class DampedSpringLoad(SpringLoad):
    """Joint springs and dampers."""

    of_rates: ClassVar[bool] = True

    def __init__(self, bars: list[BarProperties], springs: JointSpringDamper) -> None:
        """Springs and dampers of a scene."""
        super().__init__(bars, springs)
        self.damping = springs.damping_N_m_s_rad

    def torques(self, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Torque of each joint on the bar behind the joint, N m."""
        found = super().torques(positions, rates)
        turning = [b - a for (*_, a), (*_, b) in pairwise(rates)]
        return [torque - c * w for torque, c, w in zip(found, self.damping, turning, strict=True)]
