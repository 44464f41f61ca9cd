"""Parts of planted mistakes: changes of a scene, of a trajectory, and of an engine between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios.effect_types import End, JointSpringDamper

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from scenarios import Gravity, Scene

    SceneChange = Callable[[Scene], Scene]
    ResultChange = Callable[[Any, Scene], Trajectory]
    EngineChange = Callable[[Any, Scene], None]

FAST, PINOCCHIO, MUJOCO, SCIPY = "reference-fast", "pinocchio", "mujoco", "scipy-dop853"


@dataclass(frozen=True)
class Blunder:
    """One mistake, or several in one engine."""

    name: str
    words: str
    """Regular expression that one statement of the report must contain"""
    scene: SceneChange | None = None
    read: ResultChange | None = None
    engine: EngineChange | None = None
    base: str = FAST
    """Right engine"""
    more: str = ""
    """Regular expression of the second mistake of a pair"""

    def apply(self, kind: type[Any]) -> type[Any]:
        """Class of an engine with the mistake."""
        mistake = self

        def build(self: Any, scene: Scene, setting: Any) -> None:
            self.given_scene = scene
            kind.build(self, mistake.scene(scene) if mistake.scene else scene, setting)
            if mistake.engine:
                mistake.engine(self, scene)

        def read(self: Any) -> Trajectory:
            found: Trajectory = kind.read(self)
            return mistake.read(found, self.given_scene) if mistake.read else found

        return type("Wrong", (kind,), {"build": build, "read": read})


def says(*words: str) -> str:
    """Regular expression of a text that contains all of some words, in any order."""
    return "".join(f"(?=.*(?:{w}))" for w in words)


def chain(**values: Callable[[Any], Any]) -> SceneChange:
    """Change of the chain; each new value is a function of the chain."""
    return lambda s: replace(s, chain=replace(s.chain, **{k: v(s.chain) for k, v in values.items()}))


def orbit(**values: Callable[[Scene], Any]) -> SceneChange:
    """Change of the orbit; each new value is a function of the scene."""
    return lambda s: replace(s, orbit=replace(s.orbit, **{k: v(s) for k, v in values.items()}))


def body(**values: Callable[[Any], Any]) -> SceneChange:
    """Change of the central body; each new value is a function of the body."""

    def change(s: Scene) -> Scene:
        return replace(s, central_body=replace(s.central_body, **{k: v(s.central_body) for k, v in values.items()}))

    return change


def gravity(old: Gravity, new: Gravity) -> SceneChange:
    """Another model of gravity in the scenes that have `old`."""
    return lambda s: effects(s, gravity=new) if s.effects.gravity is old else s


def effects(scene: Scene, **values: Any) -> Scene:
    """Scene with other effects."""
    return replace(scene, effects=replace(scene.effects, **values))


def effect(name: str, **values: Callable[[Any], Any]) -> SceneChange:
    """Change of one effect, or of all of its kind; each new value is a function of the effect."""

    def changed(one: Any) -> Any:
        return replace(one, **{k: v(one) for k, v in values.items()})

    def change(scene: Scene) -> Scene:
        now = getattr(scene.effects, name)
        new = tuple(map(changed, now)) if isinstance(now, tuple) else now and changed(now)
        return effects(scene, **{name: new})

    return change


def without(name: str) -> SceneChange:
    """Scene without an effect."""
    return lambda s: effects(s, **{name: () if isinstance(getattr(s.effects, name), tuple) else None})


def both(*changes: SceneChange) -> SceneChange:
    """Changes one after the other."""

    def change(scene: Scene) -> Scene:
        for c in changes:
            scene = c(scene)
        return scene

    return change


def result(**values: Callable[[Any, Any], Any]) -> ResultChange:
    """Change of a trajectory; each new array is a function of the trajectory and the scene."""
    return lambda t, s: t.replace(**{k: v(t, s) for k, v in values.items()})


def times(field: str, factor: float) -> ResultChange:
    """A channel times a number."""
    return lambda t, _: t.replace(**{field: getattr(t, field) * factor})


def turned(vectors: Array, angle: Array) -> Array:
    """Components of vectors (n, ..., 2) in axes turned by `angle` (n, ...)."""
    c, s, x, y = np.cos(angle), np.sin(angle), vectors[..., 0], vectors[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def longitude(t: Trajectory) -> Array:
    """Longitude of the centre of mass, (n,) rad."""
    return np.unwrap(np.arctan2(t.com_m[:, 1], t.com_m[:, 0]))


def late(values: Array, by: int = 1) -> Array:
    """Samples moved by some rows; rows beyond the ends are repeated."""
    rows = np.clip(np.arange(len(values)) - by, 0, len(values) - 1)
    return values[rows]


def weight(s: Scene) -> Array:
    """Shares of the bars in the mass, (N,)."""
    return np.array(s.chain.mass_kg) / s.mass_kg


def centres(t: Any, s: Scene) -> Array:
    """Centres of the bars relative to the chain's centre of mass, (n, N, 2) m."""
    return from_centre_of_mass(np.stack([np.cos(t.angle_rad), np.sin(t.angle_rad)], -1), s)


def drifts(t: Any, s: Scene) -> Array:
    """Velocities of the bars' centres relative to the chain's centre of mass, (n, N, 2) m/s."""
    return from_centre_of_mass(t.rate_rad_s[..., None] * np.stack([-np.sin(t.angle_rad), np.cos(t.angle_rad)], -1), s)


def from_centre_of_mass(ways: Array, s: Scene) -> Array:
    """Sums of vectors along the bars (n, N, 2), each times its bar's length, to the bars' centres."""
    along = ways * np.array(s.chain.length_m)[:, None]
    from_left = np.cumsum(along, axis=1) - 0.5 * along
    found: Array = from_left - np.einsum("j,njk->nk", weight(s), from_left)[:, None]
    return found


def left_end(t: Any, s: Scene) -> Array:
    """Left end of bar 1 relative to the centre of mass, (n, 2) m."""
    half = 0.5 * s.chain.length_m[0]
    found: Array = centres(t, s)[:, 0] - half * np.stack([np.cos(t.angle_rad[:, 0]), np.sin(t.angle_rad[:, 0])], -1)
    return found


def relative(values: Array) -> Array:
    """Values of each bar less those of the bar before."""
    return np.diff(values, axis=1, prepend=0.0)


def one_more(s: Scene) -> Scene:
    """One sample more at the end."""
    n = s.run.samples
    return replace(s, run=replace(s.run, duration_s=s.run.duration_s * n / (n - 1), samples=n + 1))


def halved(s: Scene) -> Scene:
    """A further sample in each interval."""
    return replace(s, run=replace(s.run, samples=2 * s.run.samples - 1))


def lost_time(s: Scene) -> Scene:
    """Samples at k T/n instead of k T/(n - 1)."""
    return replace(s, run=replace(s.run, duration_s=s.run.duration_s * (s.run.samples - 1) / s.run.samples))


def impulses_apart(t: Trajectory, _: Scene) -> Trajectory:
    """Impulsive reactions of each event alone, not their sum so far."""
    return t if t.impulse_N_s is None else t.replace(impulse_N_s=np.diff(t.impulse_N_s, axis=0, prepend=0.0))


def half_central(s: Scene) -> Scene:
    """Each thrust on both ends at half its size: a force on the bar's centre."""
    halves = [replace(p, end=end, force_N=tuple(0.5 * f for f in p.force_N)) for p in s.effects.thrust for end in End]
    return effects(s, thrust=tuple(halves))


def stray(stiffness: float, damping: float) -> SceneChange:
    """Springs and dampers in joints that are free."""

    def change(s: Scene) -> Scene:
        n = s.bars - 1
        if s.effects.joint_spring_damper or not n:
            return s
        return effects(s, joint_spring_damper=JointSpringDamper((stiffness,) * n, (damping,) * n, (0.0,) * n))

    return change


def gravity_as(change: Callable[[tuple[float, float, float]], tuple[float, float, float]]) -> EngineChange:
    """Another load of gravity on each bar (m/s^2, m/s^2, rad/s^2), from the right one."""

    def planted(engine: Any, _: Scene) -> None:
        gravity = engine.chain.loads.gravity
        if gravity is not None:
            right = gravity.load
            gravity.load = lambda *given: change(right(*given))

    return planted


def spin_times(factor: float) -> EngineChange:
    """Torque of the gravity gradient times a number, in Pinocchio's loads."""
    return gravity_as(lambda load: (load[0], load[1], factor * load[2]))


no_tides = gravity_as(lambda load: (0.0, 0.0, load[2]))
"""The same gravity on all bars, that at the frame's origin"""


def no_velocity_terms(engine: Any, _: Scene) -> None:
    """Neither centrifugal nor Coriolis' terms."""
    pin = engine.chain.pin
    engine.chain.pin = SimpleNamespace(**vars(pin) | {
        "aba": lambda model, data, q, q_t, *more: pin.aba(model, data, q, 0.0 * q_t, *more),
        "rnea": lambda model, data, q, q_t, *more: pin.rnea(model, data, q, 0.0 * q_t, *more),
    })  # fmt: skip


def loads_on_joints(engine: Any, _: Scene) -> None:
    """Loads on the bars' left ends instead of their centres."""
    right = engine.chain.put

    def put(angle: Any, loads: Any) -> None:
        bars = engine.chain.bars
        engine.chain.bars = [bar._replace(half_length_m=0.0) for bar in bars]
        right(angle, loads)
        engine.chain.bars = bars

    engine.chain.put = put


def middle_joints(engine: Any, s: Scene) -> None:
    """Joints in the middle of the bar before."""
    for j in range(1, s.bars):
        engine.chain.model.jointPlacements[3 + j].translation = np.array([0.5 * s.chain.length_m[j - 1], 0.0, 0.0])


def euler(engine: Any, _: Scene) -> None:
    """MuJoCo's default integrator."""
    import mujoco  # noqa: PLC0415

    engine.model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER


def fixed_tolerance(engine: Any, s: Scene) -> None:
    """The same coarse tolerance whatever is requested."""
    from adapters.common.initial_state import initial_state  # noqa: PLC0415
    from adapters.common.reference_model import chain_model  # noqa: PLC0415

    engine.prepared = engine.prepare(chain_model(s), initial_state(s), 1e-5)


def single_times(engine: Any, _: Scene) -> None:
    """Instants in single precision wherever the right-hand side is evaluated."""
    problem = engine.prepared.problem
    right = problem.rhs
    problem.rhs = lambda t, y: right(float(np.float32(t)), y)


def leaves_file(engine: Any, _: Scene) -> None:
    """A log in the working folder."""
    del engine
    Path("engine.log").write_text("built")


def interpolated(values: Array) -> Array:
    """Every other sample, with straight lines between."""
    rows = np.arange(len(values))
    flat = values.reshape(len(values), -1)
    return np.stack([np.interp(rows, rows[::2], c) for c in flat[::2].T], -1).reshape(values.shape)


def inertia_times(factor: float) -> SceneChange:
    """Inertias times a number."""
    return chain(inertia_kg_m2=lambda c: tuple(factor * j for j in c.inertia_kg_m2))


def pair(first: Blunder, second: Blunder) -> Blunder:
    """Two mistakes in one engine, in the order of the list."""

    def scene(s: Scene) -> Scene:
        for m in (first, second):
            s = m.scene(s) if m.scene else s
        return s

    def read(t: Trajectory, s: Scene) -> Trajectory:
        for m in (first, second):
            t = m.read(t, s) if m.read else t
        return t

    def engine(e: Any, s: Scene) -> None:
        for m in (first, second):
            if m.engine:
                m.engine(e, s)

    base = first.base if first.engine else second.base
    return Blunder(f"{first.name}; {second.name}", first.words, scene, read, engine, base, second.words)
