"""Engine of the compiled reference."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from adapters.engine import Coordinates
from adapters.reference.numpy_engines import ReferenceEngine, SimulationRun

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from reference_impl.model.chain import ChainModel


@final
class ReferenceFast(ReferenceEngine):
    """Relative formulation, minimal coordinates, compiled."""

    title = "Compiled reference, relative formulation, DOP853"
    coordinates = Coordinates.RELATIVE

    def prepare(self, model: ChainModel, start: InitialState, rtol: float) -> SimulationRun:
        """Load the kernel, and set up a run."""
        from reference_impl.kernel.simulate import KernelSimulation

        state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
        return KernelSimulation(model, *state, rtol=rtol)
