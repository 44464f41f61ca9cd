"""heyoka adapter: Taylor integration of equations derived independently.

See docs/explanation/certified_solutions.md.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, ClassVar, final

from adapters.engine import (
    GRAVITY_MODELS,
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    Setting,
)
from adapters.heyoka import CLOSE_START, CLOSE_START_RAD
from adapters.heyoka.compiled import DOUBLE, LONG, QUAD, Precision
from adapters.heyoka.run import HeyokaRun
from adapters.trajectory import Observable, Trajectory
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from scenarios import Scene

EVERYTHING = frozenset({
    *GRAVITY_MODELS, *PRESCRIBED_ROTATIONS, "oblateness", "third_body", "drag", "solar_pressure",
    "solar_pressure.shadow", "joint_spring_damper", "joint_torque", "thrust.body", "thrust.inertial", "impulse",
    COM_SHARE,
})  # fmt: skip


def tolerances(finest: int) -> tuple[float, ...]:
    """Requested errors 1e-4 to 1e-`finest`, a decade each."""
    return tuple(float(f"1e-{k}") for k in range(4, finest + 1))


class HeyokaEngine(Engine):
    """Common part of all precisions: centre of mass and inertial angles, without joint gaps."""

    coordinates = Coordinates.RELATIVE
    order = None
    effects = EVERYTHING
    observables = frozenset(
        {Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION, Observable.TORQUE}
        | {Observable.IMPULSE}
    )
    precision: ClassVar[Precision]
    start_perturbation_rad = ""
    """Perturbation of the initial angles and rates as a decimal number; none if empty"""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Derive and compile the equations."""
        begun = time.perf_counter()
        self.ran = HeyokaRun(scene, scene.times_s, self.precision, setting.value)
        if self.start_perturbation_rad:
            self.ran.perturb_start(self.start_perturbation_rad)
        self.compile_s = time.perf_counter() - begun

    def simulate(self) -> None:
        """Integrate; dense output gives the samples."""
        self.ran.walk()

    def read(self) -> Trajectory:
        """Observables at the samples; a compiled function of the states gives reactions and torques."""
        seen = self.ran.trajectory()
        seen.info["compile_s"] = self.compile_s
        return seen


@final
class Heyoka(HeyokaEngine):
    """Double precision."""

    title = "heyoka, Taylor series of adaptive order, double precision"
    sweep = AccuracySweep(AccuracyParameter.RTOL, tolerances(16), default=1e-12)
    precision = DOUBLE


@final
class HeyokaLong(HeyokaEngine):
    """Extended precision of x86, 64 bits of mantissa."""

    title = "heyoka, Taylor series of adaptive order, long double"
    sweep = AccuracySweep(AccuracyParameter.RTOL, tolerances(19), default=1e-15)
    precision = LONG


@final
class HeyokaQuad(HeyokaEngine):
    """Quadruple precision, in software."""

    title = "heyoka, Taylor series of adaptive order, quadruple precision"
    sweep = AccuracySweep(AccuracyParameter.RTOL, tolerances(30), default=1e-20)
    precision = QUAD
    options = frozenset({CLOSE_START})

    def __init__(self, *, close_start: bool = False) -> None:
        """Prepare a run; with `close_start` from initial angles and rates perturbed by :data:`CLOSE_START_RAD`.

        No number in double precision can hold so small a perturbation of an angle.
        """
        self.start_perturbation_rad = CLOSE_START_RAD if close_start else ""
