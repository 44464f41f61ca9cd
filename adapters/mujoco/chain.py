"""A chain as a MuJoCo model in a freely falling frame, and the loads on it.

MuJoCo has no orbital mechanics. Gravity less that at the frame's origin acts on each bar's centre through
`xfrc_applied`; the reactions would omit forces in `qfrc_passive`. The control callback sets the forces at every stage
of RK4. Callbacks belong to the whole process.
"""

from __future__ import annotations

from contextlib import contextmanager
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from adapters.common.joint_forces import reaction_from_wrench
from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.bar_loads.gravity import Loads
    from adapters.trajectory import Array
    from scenarios.scene import Chain

SWITCHED_OFF = ("CONSTRAINT", "CONTACT", "EQUALITY", "LIMIT", "FRICTIONLOSS", "SPRING", "DAMPER", "GRAVITY",
                "WARMSTART", "SENSOR", "ISLAND", "AUTORESET")  # fmt: skip
"""Features that would act besides the loads or cost time, and the reset that hides a state that is not finite."""


def model_of(chain: Chain, dt_s: float) -> Any:
    """MuJoCo model: two massless slides, then a hinge at each bar's left end."""
    import mujoco as mj

    spec = mj.MjSpec()
    body, left_m = spec.worldbody, 0.0
    for j, (mass, length, inertia) in enumerate(zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)):
        # a thin rod's inertia about all axes: MuJoCo rejects 0 along the rod, and plane motion depends on one only
        body = body.add_body(
            pos=[left_m, 0.0, 0.0],
            mass=mass,
            ipos=[0.5 * length, 0.0, 0.0],
            inertia=[inertia] * 3,
            explicitinertial=True,
        )
        if j == 0:
            body.add_joint(type=mj.mjtJoint.mjJNT_SLIDE, axis=[1.0, 0.0, 0.0])
            body.add_joint(type=mj.mjtJoint.mjJNT_SLIDE, axis=[0.0, 1.0, 0.0])
        body.add_joint(type=mj.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
        left_m = length
    model = spec.compile()
    model.opt.timestep = dt_s
    model.opt.integrator = mj.mjtIntegrator.mjINT_RK4
    for what in SWITCHED_OFF:
        model.opt.disableflags |= getattr(mj.mjtDisableBit, f"mjDSBL_{what}", 0)  # older versions lack some
    return model


class AppliedLoads:
    """Control callback: gravity on each bar at its current position."""

    def __init__(self, chain: Chain, data: Any, loads: Loads, origin_m: Array, every_s: float) -> None:
        """Prepare the callback.

        Parameters
        ----------
        chain : Chain
        data : MjData
        loads : Loads
        origin_m : ndarray, shape (n, 2)
            Frame's origin every `every_s` from t = 0.
        every_s : float
        """
        self.loads, self.origin, self.every_s = loads, origin_m.tolist(), every_s
        self.bars = [
            (m, J, 0.5 * length)
            for m, J, length in zip(chain.mass_kg, chain.inertia_kg_m2, chain.length_m, strict=True)
        ]
        self.position, self.joints = data.xipos[1:, :2], data.qpos[2:]
        self.applied = data.xfrc_applied[1:]
        self.evaluations = 0

    def move_frame(self, index: int) -> None:
        """No change: gravity has no events."""

    def __call__(self, model: Any, data: Any) -> None:
        """Apply forces and torques.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        del model
        self.evaluations += 1
        self.loads.move_to(*self.origin[round(data.time / self.every_s)])
        load = self.loads.load
        rows = []
        for (x, y), angle, (mass, inertia, half) in zip(
            self.position.tolist(), accumulate(self.joints.tolist()), self.bars, strict=True
        ):
            ax, ay, spin = load(x, y, angle, half)
            rows.append((mass * ax, mass * ay, 0.0, 0.0, 0.0, inertia * spin))
        self.applied[:] = rows


def data_at(model: Any, q: Array, q_t: Array) -> Any:
    """MuJoCo data at coordinates and rates, each (N + 2,)."""
    import mujoco as mj

    data = mj.MjData(model)
    data.qpos, data.qvel = q, q_t
    return data


def reactions(model: Any, data: Any) -> Array:
    """Force on each bar from the next, (N-1, 2), N, at the state in `data`; the loads must be installed."""
    import mujoco as mj

    mj.mj_forward(model, data)
    mj.mj_rnePostConstraint(model, data)
    return reaction_from_wrench(data.cfrc_int[2:, 3:5], on_next_bar=True)  # of the parent on the child


@contextmanager
def installed(control: Callable[[Any, Any], None] | None) -> Iterator[None]:
    """Install `control`, and turn MuJoCo's warnings into errors.

    Raises
    ------
    EngineError
        At the end, if MuJoCo issued a warning.
    """
    import mujoco as mj

    said: list[str] = []
    before = mj.get_mjcb_control(), mj.get_mju_user_warning()
    mj.set_mjcb_control(control)
    mj.set_mju_user_warning(said.append)
    try:
        yield
    finally:
        mj.set_mjcb_control(before[0])
        mj.set_mju_user_warning(before[1])
    if said:
        raise EngineError(f"MuJoCo: {said[0]}")
