"""Sum of the loads on the bars of a scene: the frame's own load and one for each effect."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.frames.axes import FixedFrame, UniformFrame
from adapters.exudyn.frames.inertial_view import frame_origin
from adapters.exudyn.loads.fields import ExudynOblateness, ExudynQuadrupole, ExudynSlender, ExudynThirdBody
from adapters.exudyn.loads.gravity import LoadedBar, absolute_load, orbit_load
from adapters.exudyn.loads.surface_forces import ExudynDrag, ExudynSunlight
from adapters.exudyn.loads.thrust import ExudynThrust
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.inertial_view import FrameOrigin
    from adapters.exudyn.frames.numbers import BarMotion, Number, OrbitNumbers
    from adapters.exudyn.loads.interface import BarForce, ExudynLoad
    from adapters.trajectory import Array
    from scenarios import Scene

BY_TORQUE = (Gravity.GRADIENT, Gravity.QUADRUPOLE)  # both with the torque of eq. (17)


class Loading:
    """Loads on bars in one frame."""

    def __init__(self, scene: Scene, frame: ReferenceFrame) -> None:
        """Assemble the loads of the scene."""
        chain, gravity = scene.chain, scene.effects.gravity
        turned = gravity in BY_TORQUE
        self.bars = [LoadedBar(m, j, turned) for m, j in zip(chain.mass_kg, chain.inertia_kg_m2, strict=True)]
        self.mu = scene.central_body.mu_m3_s2
        self.absolute = isinstance(frame, FixedFrame)
        self.pulled = gravity is not Gravity.NONE
        self.framed = self.pulled and not isinstance(frame, UniformFrame)
        self.effects = effects_of(scene, frame)
        self.origin = frame_origin(frame, moving=scene.effects.drag is not None)
        self.parts: list[FrameOrigin | ExudynLoad] = [self.origin, *self.effects] if self.effects else []
        self.input_counts = [part.time_input_count for part in self.parts]

    @property
    def time_input_count(self) -> int:
        """Number of inputs of the effects that depend on time alone."""
        return sum(self.input_counts)

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, (k, time_input_count)."""
        return np.concatenate([part.time_inputs(at_s, inside_s) for part in self.parts], axis=1)

    def acts_on(self, bar: int) -> bool:
        """Whether any load acts on `bar`."""
        return self.framed or any(effect.acts_on(bar) for effect in self.effects)

    def on(self, bar: int, m: BarMotion, orbit: OrbitNumbers | None, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Sum of the loads on a bar with at least one load.

        Parameters
        ----------
        bar : int
            Counted from 0.
        m : BarMotion
        orbit : OrbitNumbers or None
            Orbit of a rotating frame.
        inputs : sequence of `time_input_count` numbers
        xp : module
            numpy, or Exudyn's symbolic.
        """
        loads = [self._frame_load(bar, m, orbit, xp)] if self.framed else []
        if self.effects:
            own, *others = split(inputs, self.input_counts)
            view = self.origin.view(m, orbit, own)
            acting = [(e, own) for e, own in zip(self.effects, others, strict=True) if e.acts_on(bar)]
            loads += [effect.load(bar, view, own, xp) for effect, own in acting]
        total = loads[0]
        for load in loads[1:]:
            total = sum_of_loads(total, load)
        return total

    def _frame_load(self, bar: int, m: BarMotion, orbit: OrbitNumbers | None, xp: Any) -> BarForce:
        if self.absolute:
            return absolute_load(self.bars[bar], self.mu, m, xp.sqrt)
        assert orbit is not None
        return orbit_load(self.bars[bar], orbit, m, xp)


def effects_of(scene: Scene, frame: ReferenceFrame) -> list[ExudynLoad]:
    """Effects on bars besides point-mass gravity, its gradient's torque and the frame's own forces."""
    effects = scene.effects
    found: list[ExudynLoad] = []
    if effects.gravity is Gravity.QUADRUPOLE:
        found.append(ExudynQuadrupole(scene))
    if effects.gravity is Gravity.SLENDER:
        found.append(ExudynSlender(scene))
    if effects.oblateness:
        found.append(ExudynOblateness(scene))
    found += [ExudynThirdBody(scene, body, frame) for body in effects.third_body]
    if effects.drag:
        found.append(ExudynDrag(scene))
    if effects.solar_pressure:
        found.append(ExudynSunlight(scene, frame))
    return found + [ExudynThrust(scene, thrust, frame) for thrust in effects.thrust]


def sum_of_loads(a: BarForce, b: BarForce) -> BarForce:
    """Sum of two loads."""
    torque = b[2] if a[2] is None else a[2] if b[2] is None else a[2] + b[2]
    return a[0] + b[0], a[1] + b[1], torque


def split(inputs: Sequence[Number], counts: list[int]) -> list[Sequence[Number]]:
    """Split into parts of given lengths."""
    ends = np.cumsum([0, *counts]).tolist()
    return [inputs[a:b] for a, b in itertools.pairwise(ends)]
