"""Interface of the loads on bars, in plain floats: positions and rates in, accelerations out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array
    from scenarios.scene import Chain

BarPosition = tuple[float, float, float]  # a bar's centre in the frame (m, m), and its angle (rad)
BarRate = tuple[float, float, float]  # m/s, m/s, rad/s
Load = tuple[float, float, float]  # acceleration of a bar's centre and its angular acceleration, m/s², m/s², rad/s²


class FrameState(NamedTuple):
    """Position and velocity of the frame at an instant."""

    x: float
    """First component of the origin relative to the centre of the body, m"""
    y: float
    """Second component, m"""
    vx: float = 0.0
    """First component of the origin's velocity, m/s"""
    vy: float = 0.0
    """Second component, m/s"""
    t_s: float = 0.0
    """Instant, s"""
    inside_s: float = 0.0
    """An instant within the current event-free interval, s: at `t_s` itself an event may occur"""

    @classmethod
    def of_arrays(cls, origin_m: Array, drift_m_s: Array, t_s: float, inside_s: float) -> FrameState:
        """State from the frame's origin and its velocity, each of shape (2,), m and m/s."""
        (x, y), (vx, vy) = origin_m.tolist(), drift_m_s.tolist()
        return cls(x, y, vx, vy, t_s, inside_s)


class BarProperties(NamedTuple):
    """Mass properties of one bar."""

    mass_kg: float
    inertia_kg_m2: float
    """About its centre"""
    half_length_m: float
    left_m: float
    """Distance of its left end from its centre"""

    @property
    def right_m(self) -> float:
        """That of its right end, m."""
        return 2.0 * self.half_length_m - self.left_m


class BarLoad(ABC):
    """Load of one effect on all bars."""

    of_rates: bool = False
    """Whether the load depends on the bars' rates; they are computed only if some load does"""

    @abstractmethod
    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar; `rates` are empty where no load of the scene depends on them."""


class FaceDependentLoad(BarLoad):
    """Load that jumps, or whose slope does, where a bar turns its other face to the source."""

    held: Sequence[float] | None = None
    """Exposed face of each bar, +1 or -1, for an engine that stops where one turns; None: that of each state"""

    @abstractmethod
    def incidence(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Sine of the angle between each bar and the source; its sign is the exposed face."""


def bars_of(chain: Chain) -> list[BarProperties]:
    """Mass properties of each bar, in plain floats.

    Parameters
    ----------
    chain : Chain
        `Scene.chain`.

    Returns
    -------
    list of BarProperties
        With `mass_kg`, `inertia_kg_m2` about the centre, `half_length_m`, and `left_m` and `right_m`, the distances of
        the ends from the centre.
    """
    return [
        BarProperties(m, J, 0.5 * length, left)
        for m, J, length, left in zip(chain.mass_kg, chain.inertia_kg_m2, chain.length_m, chain.left_m, strict=True)
    ]
