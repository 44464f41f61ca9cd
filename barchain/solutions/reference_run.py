"""Runs of the reference in the process that judges: at other instants, from another start, of another model."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, cast

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.registry import COMPILED, ENGINES

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from adapters.engine import Setting
    from adapters.reference.numpy_engines import ReferenceEngine
    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene


NUMPY = "reference"


def solution_engine() -> str:
    """Engine of reference solutions: the compiled reference if it is installed, for its speed, else the NumPy form."""
    return NUMPY if ENGINES[COMPILED].missing else COMPILED


def reference_run(
    scene: Scene,
    setting: Setting,
    *,
    t_s: Array | None = None,
    start: InitialState | None = None,
    model: ChainModel | None = None,
    most_events: float = math.inf,
) -> Trajectory:
    """Run of the engine of reference solutions.

    Parameters
    ----------
    scene : Scene
    setting : Setting
    t_s : ndarray, shape (n,), optional
        Rising instants of the samples, s, the first one that of the start; the scene's by default.
    start : InitialState, optional
        The scene's by default.
    model : ChainModel, optional
        The scene's by default.
    most_events : float
        Faces that turn and edges of the shadow after which the run gives up.

    Raises
    ------
    EngineError
        If the reference fails, or meets more events.
    """
    engine = cast("ReferenceEngine", ENGINES[solution_engine()].engine())
    engine.times_s = scene.times_s if t_s is None else t_s
    engine.prepared = engine.prepare(model or chain_model(scene), start or initial_state(scene), setting.value)
    engine.prepared.most_events = most_events
    engine.simulate()
    return engine.read()
