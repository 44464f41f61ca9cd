"""What an effect on the bars is, in plain floats: where they are and how they move in, accelerations out."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenarios.scene import Chain

Place = tuple[float, float, float]  # a bar's centre in the frame (m, m), and its angle (rad)
Rate = tuple[float, float, float]  # m/s, m/s, rad/s
Load = tuple[float, float, float]  # acceleration of a bar's centre and its angular acceleration, m/s², m/s², rad/s²


class FrameState(NamedTuple):
    """Where and when the frame is."""

    x: float
    """Origin from the centre of the body, m"""
    y: float
    vx: float = 0.0
    """Its velocity, m/s"""
    vy: float = 0.0
    t_s: float = 0.0
    inside_s: float = 0.0
    """An instant within the piece of time that is meant: at `t_s` itself something may jump"""


class BarProperties(NamedTuple):
    """One bar's numbers."""

    mass: float
    """kg"""
    inertia: float
    """About its own centre, kg m²"""
    half: float
    """Half its length, m"""


class BarLoad(Protocol):
    """One effect on all bars."""

    of_rates: ClassVar[bool]
    """Whether it asks for the bars' rates; where nobody does, nobody works them out"""

    def __call__(self, frame: FrameState, places: Sequence[Place], rates: Sequence[Rate]) -> list[Load]:
        """Load of each bar; `rates` are empty where `of_rates` is false."""


@runtime_checkable
class FaceDependentLoad(Protocol):
    """An effect whose slope jumps where a bar turns its other face to it."""

    def faces(self, frame: FrameState, places: Sequence[Place], rates: Sequence[Rate]) -> list[bool]:
        """Which face of each bar it is that it meets."""


def bars_of(chain: Chain) -> list[BarProperties]:
    """Numbers of each bar."""
    return [
        BarProperties(m, J, 0.5 * length)
        for m, J, length in zip(chain.mass_kg, chain.inertia_kg_m2, chain.length_m, strict=True)
    ]
