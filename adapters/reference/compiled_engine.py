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
        """Compile, or load compiled code from the cache."""
        from reference_impl.fast.simulate import FastSimulation

        state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
        return FastSimulation(model, *state, rtol=rtol)
