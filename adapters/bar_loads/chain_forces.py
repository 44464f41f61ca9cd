"""Forces and torques of every effect of a scene on the bars, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.assemble import ChainLoads, effects_of
from adapters.bar_loads.gravity import AbsoluteLoads, MovingLoads
from adapters.bar_loads.interface import bars_of

if TYPE_CHECKING:
    from adapters.bar_loads.interface import FrameState
    from adapters.trajectory import Array
    from scenarios import Scene


class ChainForces:
    """Force and torque of gravity and all other effects on each bar.

    In a frame that falls with the chain, gravity is the field at a bar less the field at the frame's origin. It is
    computed as a difference from the beginning (Encke's form), so that no digits cancel. Prescribed rotations and
    impulses are no forces, and solar pressure is without shadow.
    """

    def __init__(self, scene: Scene, *, falling: bool = True, surface: bool = True) -> None:
        """Prepare the effects of a scene, for a frame that falls freely or one at rest.

        Parameters
        ----------
        scene : Scene
        falling : bool
            Whether the frame falls freely; False for a frame at rest at the centre of the body.
        surface : bool
            Whether bars at the surface raise. False for trial states of a solver, which may lie below it.
        """
        chain = scene.chain
        gravity = MovingLoads(scene, surface=surface) if falling else AbsoluteLoads(scene, surface=surface)
        self.loads = ChainLoads(scene, gravity, tuple(effects_of(scene, bars_of(chain), free_falling=falling)))
        self.mass_kg, self.inertia_kg_m2 = np.array(chain.mass_kg), np.array(chain.inertia_kg_m2)

    def __call__(
        self, frame: FrameState, position_m: Array, angle_rad: Array, velocity_m_s: Array, rate_rad_s: Array
    ) -> tuple[Array, Array]:
        """Force (N, 2), N, and torque (N,), N m, on each bar, from its place and velocity in the frame.

        Parameters
        ----------
        frame : FrameState
            Origin, velocity and instant of the frame; zeros but for the instant in a frame at rest.
        position_m, velocity_m_s : ndarray, shape (N, 2)
            Bars' centres in the frame, in axes of fixed direction.
        angle_rad, rate_rad_s : ndarray, shape (N,)
            Absolute angles, and their rates.

        Returns
        -------
        force_N : ndarray, shape (N, 2)
            At the bars' centres.
        torque_N_m : ndarray, shape (N,)
            About the bars' centres.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        bars = np.column_stack([position_m, angle_rad]).tolist()
        rates = np.column_stack([velocity_m_s, rate_rad_s]).tolist() if self.loads.of_rates else []
        load = np.array(self.loads(frame, bars, rates))
        return self.mass_kg[:, None] * load[:, :2], self.inertia_kg_m2 * load[:, 2]
