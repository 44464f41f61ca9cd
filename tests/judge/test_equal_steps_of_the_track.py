"""Equal steps that integrate the centre of mass themselves: a right method is inside its bound, a wrong one is not."""

import numpy as np
import pytest

from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, Setting
from adapters.trajectory import Array, Observable, Trajectory
from barchain.conform.scenes import scene_of, solved
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.judge.verdict import Verdict
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from scenarios import Scene

NAME = "conform/one_bar_point"


class OneBar(Engine):
    """Free rotation of one bar, and its centre on an orbit by the midpoint rule."""

    title, coordinates, order = "one bar", Coordinates.RELATIVE, 2.0
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (500, 1000, 2000, 4000), 2000)
    effects = frozenset({"gravity.point"})
    observables = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE})
    gravity = 1.0
    """Of the right one"""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Keep the scene and the steps."""
        self.scene, self.every, self.dt_s = scene, steps_between_samples(scene, setting.value), 0.0
        self.dt_s = step_s(scene, setting.value)

    def slope(self, state: Array) -> Array:
        """Rate of position and velocity."""
        place = state[:2]
        pull = -self.gravity * self.scene.central_body.mu_m3_s2 / np.hypot(*place) ** 3
        return np.concatenate([state[2:], pull * place])

    def simulate(self) -> None:
        """Step from sample to sample."""
        start = initial_state(self.scene)
        state = np.concatenate([start.com_m, start.com_velocity_m_s])
        self.rows = [state]
        for _ in range(self.scene.run.samples - 1):
            for _ in range(self.every):
                state = state + self.dt_s * self.slope(state + 0.5 * self.dt_s * self.slope(state))
            self.rows.append(state)

    def read(self) -> Trajectory:
        """Results at the samples."""
        rows, t_s, start = np.array(self.rows), self.scene.times_s, initial_state(self.scene)
        angle = start.angle_rad + t_s[:, None] * start.rate_rad_s
        return Trajectory(t_s=t_s, com_m=rows[:, :2], com_velocity_m_s=rows[:, 2:], angle_rad=angle,
                          rate_rad_s=np.broadcast_to(start.rate_rad_s, angle.shape).copy())  # fmt: skip


class WeakGravity(OneBar):
    """A gravitational parameter that is wrong by a thousandth."""

    gravity = 0.999


class InMovingFrame(OneBar):
    """Declares a frame whose orbit needs no steps."""

    coordinates = Coordinates.MOVING_FRAME


def verdict(engine: type[Engine], steps: float) -> Verdict:
    settings = [engine.sweep.setting(factor * steps) for factor in (1.0, 2.0, 4.0)]
    runs = (RunResult(Outcome.PASS, trajectory=engine().run(scene_of(NAME), each)) for each in settings)
    return judge("one-bar", engine, settings[0], Evidence(*runs), solved(scene_of(NAME)))


@pytest.mark.parametrize("steps", OneBar.sweep.values)
def test_a_right_method_is_inside_its_bound_and_the_bound_is_not_far_above_it(steps: float) -> None:
    found = verdict(OneBar, steps)
    assert found.outcome is Outcome.PASS, found.rows
    (ratio,) = [row["value"] for row in found.rows if (row["quantity"], row["metric"]) == ("com", "bound_ratio")]
    assert 0.002 < ratio < 1.0


@pytest.mark.parametrize("engine", [WeakGravity, InMovingFrame])
def test_a_wrong_orbit_or_a_wrong_declaration_is_no_pass(engine: type[Engine]) -> None:
    assert verdict(engine, 2000.0).outcome is not Outcome.PASS
