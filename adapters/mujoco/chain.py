"""A chain as a MuJoCo model in a freely falling frame, and the loads on it.

MuJoCo has no orbital mechanics. Gravity less that at the frame's origin acts on each bar's centre through
`xfrc_applied`; the reactions would omit forces in `qfrc_passive`. The control callback sets the forces at every stage
of RK4. Callbacks belong to the whole process.
"""

from __future__ import annotations

from contextlib import contextmanager
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.bar_loads.forces import impulse_jumps
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.joint_tree import tree_rates
from adapters.common.joint_coordinates import reaction_from_wrench
from adapters.engine import EngineError, UnsupportedMotionError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from adapters.bar_loads.chain_loads import ChainLoads
    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, Load
    from adapters.trajectory import Array
    from scenarios import Impulse
    from scenarios.scene import Chain

SWITCHED_OFF = ("CONSTRAINT", "CONTACT", "EQUALITY", "LIMIT", "FRICTIONLOSS", "SPRING", "DAMPER", "GRAVITY",
                "WARMSTART", "SENSOR", "ISLAND", "AUTORESET")  # fmt: skip
"""Features that would act besides the loads or cost time, and the reset that hides a state that is not finite."""


def model_of(chain: Chain, dt_s: float) -> Any:
    """MuJoCo model: two massless slides, then a hinge at each bar's left end."""
    import mujoco as mj

    spec = mj.MjSpec()
    body, left_m = spec.worldbody, 0.0
    for j, (mass, inertia, half, centre_m) in enumerate(bars_of(chain)):
        # a thin rod's inertia about all axes: MuJoCo rejects 0 along the rod, and plane motion depends on one only
        body = body.add_body(
            pos=[left_m, 0.0, 0.0],
            mass=mass,
            ipos=[centre_m, 0.0, 0.0],
            inertia=[inertia] * 3,
            explicitinertial=True,
        )
        if j == 0:
            body.add_joint(type=mj.mjtJoint.mjJNT_SLIDE, axis=[1.0, 0.0, 0.0])
            body.add_joint(type=mj.mjtJoint.mjJNT_SLIDE, axis=[0.0, 1.0, 0.0])
        body.add_joint(type=mj.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
        left_m = 2.0 * half
    model = spec.compile()
    model.opt.timestep = dt_s
    model.opt.integrator = mj.mjtIntegrator.mjINT_RK4
    for what in SWITCHED_OFF:
        model.opt.disableflags |= getattr(mj.mjtDisableBit, f"mjDSBL_{what}", 0)  # older versions lack some
    return model


class AppliedLoads:
    """Control callback: all loads on each bar, at a stage of a step.

    A step's last stage and the next step's first stage share one instant. At an event the former lies before the event
    and the latter after it. The previous call tells the callback which of the two it evaluates.
    """

    def __init__(self, chain: Chain, data: Any, loads: ChainLoads, track: Array, half_s: float) -> None:
        """Prepare the callback.

        Parameters
        ----------
        chain : Chain
        data : MjData
        loads : ChainLoads
        track : ndarray, shape (n, 4)
            Frame's origin and its velocity every half step from t = 0.
        half_s : float
            Half a step.
        """
        self.loads, self.track, self.half_s, self.bars = loads, track.tolist(), half_s, bars_of(chain)
        # views: making one takes as long as the loads of two bars
        self.position, self.q, self.q_t = data.xipos[1:, :2], data.qpos, data.qvel
        self.joints = data.qpos[2:]
        self.applied = data.xfrc_applied[1:]
        self.pull = loads.pull_alone
        self.last: int | None = None
        self.faces: list[list[bool]] | None = None

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
        index = round(data.time / self.half_s)
        if self.pull:
            self.apply_gravity(self.pull, index)
            return
        ends = index % 2 == 0 and self.last == index - 1
        middle = index if index % 2 else index - 1 if ends else index + 1
        self.last = index
        x, y, vx, vy = self.track[index]
        frame = FrameState(x, y, vx, vy, index * self.half_s, middle * self.half_s)
        q = self.q.tolist()
        positions = [(x, y, angle) for (x, y), angle in zip(self.position.tolist(), accumulate(q[2:]), strict=True)]
        rates = list(tree_rates(q, self.q_t.tolist(), self.bars)) if self.loads.of_rates else []
        if self.loads.faced:
            self.check_faces(frame, positions, rates)
        self.applied[:] = wrenches(self.bars, self.loads(frame, positions, rates))

    def apply_gravity(self, pull: Loads, index: int) -> None:
        """Apply gravity at half step `index`, where nothing else acts."""
        pull.move_to(*self.track[index][:2])
        rows = []
        for (x, y), a, bar in zip(self.position.tolist(), accumulate(self.joints.tolist()), self.bars, strict=True):
            ax, ay, spin = pull.load(x, y, a, bar)
            rows.append((bar.mass_kg * ax, bar.mass_kg * ay, 0.0, 0.0, 0.0, bar.inertia_kg_m2 * spin))
        self.applied[:] = rows

    def check_faces(self, frame: FrameState, positions: list[BarPosition], rates: list[BarRate]) -> None:
        """Reject a motion in which a bar turns its other face: a slope jumps there, which costs RK4 its order."""
        faces = [[x > 0.0 for x in e.incidence(frame, positions, rates)] for e in self.loads.faced]
        if self.faces is not None and faces != self.faces:
            raise UnsupportedMotionError(
                f"a bar turns its other face to the air or the Sun at t = {frame.t_s:.6g} s, within one of the equal "
                "steps; the slope of the load jumps there"
            )
        self.faces = faces


def wrenches(bars: Sequence[BarProperties], loads: Sequence[Load]) -> list[tuple[float, ...]]:
    """Force and torque of each bar's load, in the order of `xfrc_applied`."""
    return [
        (mass * ax, mass * ay, 0.0, 0.0, 0.0, inertia * spin)
        for (mass, inertia, *_), (ax, ay, spin) in zip(bars, loads, strict=True)
    ]


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


def apply_impulses(model: Any, data: Any, chain: Chain, impulses: Sequence[Impulse]) -> Array:
    """Apply `impulses` to the rates in `data`; impulsive reactions on each bar from the next, (N-1, 2), N s.

    With all rates zero, the same joint system gives jumps by impulses as accelerations by forces.
    """
    angle = np.cumsum(data.qpos[2:]).tolist()
    bars, q_t = bars_of(chain), data.qvel.copy()
    data.qvel = 0.0
    data.xfrc_applied[1:] = wrenches(bars, impulse_jumps(bars, impulses, angle))
    with installed(None):
        found = reactions(model, data)
    data.qvel = q_t + data.qacc
    data.xfrc_applied[:] = 0.0
    return found
