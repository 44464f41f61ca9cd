"""Runs of altered scenes in the reference, and their cost."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model, initial_state
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from barchain.judge.scales import NORM_SLACK
from barchain.solutions.judging import NUMPY, solution_engine

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ModelChange, SceneMistake
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

ALTERED = Setting(AccuracyParameter.RTOL, 1e-13)
"""Accuracy of runs of altered scenes: that of reference solutions"""
COMPILED_S, COMPILED_BAR_S = 3e-7, 6e-8
"""Time of an evaluation of the compiled reference, and of each bar in it, s; order of magnitude"""
NUMPY_S, NUMPY_BAR_S = 1.2e-4, 4e-7
"""The same for the NumPy reference, s"""
PROBED = 2
"""Samples of the run that measures the number of evaluations"""

MOST_FASTER = 60.0
"""Largest ratio of the fastest rates of an altered scene and the right one; degrees for radians make 57"""
KEPT_RUNS = 128
"""Runs that are kept for further results on the same scene"""


@dataclass(frozen=True)
class AlteredRuns:
    """Runs of altered forms of one scene.

    A run that is expected to take too long is not made. The estimate follows from the scene alone: the evaluations up
    to the second sample, times the intervals. The same scene therefore gets the same diagnosis on every machine.
    """

    scene: Scene
    scene_run_s: float
    """Longest expected time of one run of an altered scene, s; 0: no runs"""
    equation_run_s: float
    """Longest expected time of one run with altered equations, s; 0: no runs"""

    @cached_property
    def evaluations(self) -> float:
        """Expected evaluations of the equations of motion in a run."""
        probed = simulated(sampled_until(self.scene, PROBED))
        if probed is None:
            return np.inf
        return float(probed.info["evaluations"]) * (self.scene.run.samples - 1) / (PROBED - 1)

    def expected_s(self, *, compiled: bool) -> float:
        """Expected time of a run, s."""
        each, bar = (COMPILED_S, COMPILED_BAR_S) if compiled else (NUMPY_S, NUMPY_BAR_S)
        return self.evaluations * (each + bar * self.scene.bars)

    def run(self, mistake: SceneMistake, samples: int | None = None) -> Trajectory | None:
        """Run with a mistake over the first `samples` or all samples.

        None if it would take too long, if the reference fails, or if the mistake changes nothing in the scene.
        """
        scene = self.scene if mistake.scene is None else mistake.scene(self.scene)
        if mistake.model is None and scene == self.scene:
            return None
        if mistake.model is not None and mistake.model(right := chain_model(scene)) is right:
            return None
        share = 1.0 if samples is None else samples / self.scene.run.samples
        if scene.fastest_rate_rad_s > MOST_FASTER * self.scene.fastest_rate_rad_s:
            return None
        if not self.affordable(share, equations=mistake.model is not None):
            return None
        if samples is None:
            motion = simulated(scene, mistake.model)
        else:
            motion = simulated.__wrapped__(sampled_until(scene, samples), mistake.model)
        return None if motion is None else completed(motion, scene, self.scene)

    def affordable(self, share: float = 1.0, *, equations: bool = False) -> bool:
        """Whether a share of a run is expected to be short enough; of a run with altered equations or another one."""
        longest_s = self.equation_run_s if equations else self.scene_run_s
        return self.affordable_in(longest_s, share, equations=equations)

    def affordable_in(self, longest_s: float, runs: float, *, equations: bool = False) -> bool:
        """Whether a number of runs is expected to end within a time, s; 0: no runs."""
        compiled = not equations and solution_engine() != NUMPY
        return longest_s > 0.0 and runs * self.expected_s(compiled=compiled) <= longest_s

    @cached_property
    def halves(self) -> Trajectory | None:
        """The right motion at its samples and half way between them; None if its run would take too long."""
        run = self.scene.run
        dense = dataclasses.replace(self.scene, run=dataclasses.replace(run, samples=2 * run.samples - 1))
        return simulated(dense) if self.affordable() else None


def completed(motion: Trajectory, altered: Scene, right: Scene) -> Trajectory:
    """Motion of an altered scene, with zeros for impulses and prescribed torques that only the right scene has."""
    effects = right.effects
    if effects.impulse and motion.impulse_N_s is None:
        motion = motion.replace(impulse_N_s=np.zeros_like(motion.reaction_N))
    if effects.prescribed_rotation != altered.effects.prescribed_rotation and effects.prescribed_rotation:
        columns = {p.bar: column for column, p in enumerate(altered.effects.prescribed_rotation)}
        torque = np.zeros((len(motion.t_s), len(effects.prescribed_rotation)))
        for column, prescribed in enumerate(effects.prescribed_rotation):
            if prescribed.bar in columns and motion.torque_N_m is not None:
                torque[:, column] = motion.torque_N_m[:, columns[prescribed.bar]]
        motion = motion.replace(torque_N_m=torque)
    return motion


def run_errors(judging: ReferenceSolution) -> dict[str, Array]:
    """Error of a run of an altered scene, (n,) for each quantity, SI units.

    The error of the attitude is the requested one, amplified as in the right scene, and responses carry it into other
    quantities. The track has the requested error of a radius and of the initial speed. All have the slack of bounds.
    """
    scene, requested = judging.scene, NORM_SLACK * ALTERED.value
    found = {q: requested * judging.amplification * r for q, r in judging.response.items()}
    found["com"] = found["com"] + requested * scene.radius0_m
    found["com_velocity"] = found["com_velocity"] + requested * scene.speed0_m_s
    return found


def sampled_until(scene: Scene, samples: int) -> Scene:
    """Scene that ends at one of its first samples."""
    run, last = scene.run, min(samples, scene.run.samples)
    duration = run.duration_s * (last - 1) / (run.samples - 1)
    return dataclasses.replace(scene, run=dataclasses.replace(run, duration_s=duration, samples=last))


@lru_cache(KEPT_RUNS)
def simulated(scene: Scene, model: ModelChange | None = None) -> Trajectory | None:
    """Run of the reference; None if it fails.

    Parameters
    ----------
    scene : Scene
    model : callable, optional
        Change of the equations, which needs the NumPy form.
    """
    try:
        if model is None:
            return ENGINES[solution_engine()].load()().run(scene, ALTERED)
        engine = Reference()
        engine.build(scene, ALTERED)
        engine.prepared = engine.prepare(model(chain_model(scene)), initial_state(scene), ALTERED.value)
        engine.simulate()
        return engine.read()
    except (EngineError, ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None
