"""Engines of the compiled reference, in double precision and in the kernel's wide type."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Setting
from adapters.reference import CLOSE_START_RAD, WIDE_UNTIL
from adapters.reference.numpy_engines import ReferenceEngine
from reference_impl.integrate.stiffness import SUSPECTED_RAD

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Trajectory
    from reference_impl.kernel.simulate import KernelSimulation
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

DOUBLE_RTOL, DOUBLE_CHECK_RTOL = 1e-13, 1e-12
"""Tolerances of a judging run where it is one of double precision, the tightest and a looser one"""
APART_RAD, PARTED_RAD = 1e-10, 0.1
WORTHLESS_AFTER = 2.0
"""Times the time in which 1e-10 rad grow to 0.1 rad, nine decades: an error of 1e-18 rad has grown as far by then where
the growth goes on"""
AFFORDED = 4e5
"""Evaluations in double precision times bars whose run in extended precision takes about a second, 3 times as many
evaluations: it is made whatever the growth"""


class KernelEngine(ReferenceEngine):
    """Common part of both types of numbers."""

    coordinates = Coordinates.RELATIVE
    wide: ClassVar[bool]
    shift_rad = 0.0

    def prepare(self, model: ChainModel, start: InitialState, rtol: float) -> KernelSimulation:
        """Load the kernel, and set up a run."""
        from reference_impl.kernel.packing import DOUBLE, WIDE
        from reference_impl.kernel.simulate import KernelSimulation

        state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
        number = WIDE if self.wide else DOUBLE
        return KernelSimulation(model, *state, rtol=rtol, number=number, shift_rad=self.shift_rad)


@final
class ReferenceFast(KernelEngine):
    """Relative formulation, minimal coordinates, compiled."""

    title = "Compiled reference, relative formulation, DOP853"
    wide = False


@final
class ReferenceWide(KernelEngine):
    """Relative formulation, minimal coordinates, compiled with 64 bits of mantissa or more."""

    title = "Compiled reference in extended precision, DOP853"
    wide = True
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (*ReferenceEngine.sweep.values, 1e-15, 1e-16, 1e-17, 1e-18), default=1e-16
    )
    options = frozenset({"judging", "close_start"})

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Machines without a wider type, and stiff scenes, whose implicit method is one of double precision."""
        from reference_impl.kernel.simulate import has_wide_type

        if not has_wide_type():
            return "C's long double has no more digits than double on this machine"
        if scene.spring_rate_rad_s * scene.run.duration_s >= SUSPECTED_RAD:
            return "stiff springs: the implicit method is one of double precision"
        return super().unsupported(scene)

    def __init__(self, *, judging: bool = False, close_start: bool = False) -> None:
        """Prepare a run.

        Parameters
        ----------
        judging : bool
            Whether samples are those of double precision where the scene's error amplification has made the digits of
            extended precision worthless.
        close_start : bool
            Whether to start from angles shifted by :data:`CLOSE_START_RAD`.
        """
        super().__init__()
        self.judging, self.shift_rad = judging, CLOSE_START_RAD * close_start

    def build(self, scene: Scene, setting: Setting) -> None:
        """Set up the integrator; a judging run makes its runs in double precision first."""
        super().build(scene, setting)
        self.beyond: Trajectory | None = None
        if self.judging:
            plain, shifted = ReferenceFast(), ReferenceFast()
            shifted.shift_rad = APART_RAD
            tightest = setting.value <= min(self.sweep.values)
            double = Setting(setting.parameter, DOUBLE_RTOL if tightest else DOUBLE_CHECK_RTOL)
            found, apart = plain.run(scene, double), shifted.run(scene, double)
            self.beyond = apart if self.shift_rad else found
            self.times_s = self.times_s[: worthwhile_samples(found, apart)]

    def read(self) -> Trajectory:
        """Observables at the samples."""
        seen = super().read()
        seen.info[WIDE_UNTIL] = float(seen.t_s[-1])
        if self.beyond is None or len(seen.t_s) < len(self.times_s):
            return seen
        return seen.continued(self.beyond.samples(slice(len(seen.t_s), None)))


def worthwhile_samples(found: Trajectory, apart: Trajectory) -> int:
    """Number of samples whose digits beyond double precision mean something or are cheap, by runs 1e-10 rad apart."""
    n = min(len(found.t_s), len(apart.t_s))
    assert found.angle_rad is not None
    assert apart.angle_rad is not None
    parted = np.abs(found.angle_rad[:n] - apart.angle_rad[:n]).max(axis=1) > PARTED_RAD
    if not parted.any():
        return len(found.t_s)
    afforded = AFFORDED / (float(found.info["evaluations"]) * found.angle_rad.shape[1])
    last_s = max(WORTHLESS_AFTER * found.t_s[parted.argmax()], afforded * found.t_s[-1])
    return max(2, int(np.searchsorted(found.t_s, last_s, side="right")))
