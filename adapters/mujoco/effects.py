"""Effects beyond point and gradient gravity on MuJoCo's chain, and impulses."""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.thrusts import impulse_jumps
from adapters.bar_loads.tree import tree_rates
from adapters.engine import UnsupportedMotionError
from adapters.mujoco.chain import installed, reactions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.assemble import ChainLoads
    from adapters.bar_loads.interface import BarPosition, BarRate
    from adapters.trajectory import Array
    from scenarios import Impulse
    from scenarios.scene import Chain


class AppliedEffects:
    """Control callback: all loads on each bar, at a stage of a step.

    A step's last stage and the next step's first stage share one instant. At an event the former lies before the event
    and the latter after it. The previous call tells the callback which of the two it evaluates.
    """

    def __init__(self, chain: Chain, data: Any, effect_loads: ChainLoads, track: Array, half_s: float) -> None:
        """Prepare the callback.

        Parameters
        ----------
        chain : Chain
        data : MjData
        effect_loads : ChainLoads
        track : ndarray, shape (n, 4)
            Frame's origin and its velocity every half step from t = 0.
        half_s : float
            Half a step.
        """
        self.effect_loads, self.track, self.half_s, self.bars = effect_loads, track.tolist(), half_s, bars_of(chain)
        self.position, self.applied = data.xipos[1:, :2], data.xfrc_applied[1:]
        self.last: int | None = None
        self.faces: list[list[bool]] | None = None
        self.evaluations = 0

    def move_frame(self, index: int) -> None:
        """Prepare for the state at half step `index`, seen from the step that ends there; 0 for the start."""
        self.last = index - 1 if index else None

    def __call__(self, model: Any, data: Any) -> None:
        """Apply forces and torques.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        UnsupportedMotionError
            If a bar turned its other face to the wind or the Sun.
        """
        del model
        self.evaluations += 1
        index = round(data.time / self.half_s)
        ends = index % 2 == 0 and self.last == index - 1
        middle = index if index % 2 else index - 1 if ends else index + 1
        self.last = index
        x, y, vx, vy = self.track[index]
        frame = FrameState(x, y, vx, vy, index * self.half_s, middle * self.half_s)
        q = data.qpos.tolist()
        positions = [(x, y, angle) for (x, y), angle in zip(self.position.tolist(), accumulate(q[2:]), strict=True)]
        rates = list(tree_rates(q, data.qvel.tolist(), self.bars)) if self.effect_loads.of_rates else []
        self.check_faces(frame, positions, rates)
        self.applied[:] = [
            (bar.mass_kg * ax, bar.mass_kg * ay, 0.0, 0.0, 0.0, bar.inertia_kg_m2 * spin)
            for bar, (ax, ay, spin) in zip(self.bars, self.effect_loads(frame, positions, rates), strict=True)
        ]

    def check_faces(self, frame: FrameState, positions: list[BarPosition], rates: list[BarRate]) -> None:
        """Reject a motion in which a bar turns its other face: a slope jumps there, which costs RK4 its order."""
        if not self.effect_loads.faced:
            return
        faces = [[x > 0.0 for x in e.incidence(frame, positions, rates)] for e in self.effect_loads.faced]
        if self.faces is not None and faces != self.faces:
            raise UnsupportedMotionError(
                f"a bar turns its other face to the air or the Sun at t = {frame.t_s:.6g} s, within one of the equal "
                "steps; the slope of the load jumps there"
            )
        self.faces = faces


def apply_impulses(model: Any, data: Any, chain: Chain, impulses: Sequence[Impulse]) -> Array:
    """Apply `impulses` to the rates in `data`; impulsive reactions on each bar from the next, (N-1, 2), N s.

    With all rates zero, the same joint system gives jumps by impulses as accelerations by forces.
    """
    angle = np.cumsum(data.qpos[2:]).tolist()
    bars, q_t = bars_of(chain), data.qvel.copy()
    data.qvel = 0.0
    data.xfrc_applied[1:] = [
        (bar.mass_kg * x, bar.mass_kg * y, 0.0, 0.0, 0.0, bar.inertia_kg_m2 * turn)
        for bar, (x, y, turn) in zip(bars, impulse_jumps(bars, impulses, angle), strict=True)
    ]
    with installed(None):
        found = reactions(model, data)
    data.qvel = q_t + data.qacc
    data.xfrc_applied[:] = 0.0
    return found
