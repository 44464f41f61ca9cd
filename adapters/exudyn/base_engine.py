"""Common part of every Exudyn engine: build, run without output, and check Exudyn's results."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.common import face_reversal
from adapters.common.step_alignment import straddled_words
from adapters.engine import Engine, EngineError, Setting, UnsupportedMotionError
from adapters.exudyn.loads.thrust import off_step_s
from adapters.exudyn.readout import SensorReadings, gaps, landing, positions, trajectory
from adapters.exudyn.solve.restart_segments import run_segments, segments_of
from adapters.exudyn.solve.solver import method_for, settings_of, solver_of, steps_of
from adapters.trajectory import Observable, Trajectory

if TYPE_CHECKING:
    from adapters.exudyn.models.model import Model
    from adapters.exudyn.timetable import Steps
    from scenarios import Scene

OBSERVED = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})
START_TOLERANCE = 1e-12  # rad, and relative to the largest coordinate, between the first sample and the initial state


class ExudynEngine(Engine):
    """Common part: settings, run, and checks that Exudyn does not make."""

    observables = OBSERVED
    options = frozenset({"repeated_load"})
    absolute: ClassVar[bool] = False
    index3: ClassVar[bool] = False
    explicit: ClassVar[bool] = False

    def __init__(self, *, repeated_load: bool = False) -> None:
        """Prepare a run; `repeated_load` applies each load twice at half strength, to time the loads."""
        self.load_copies = 2 if repeated_load else 1

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`: corners of a thrust's table inside a step included."""
        off = off_step_s(scene)
        return super().unsupported(scene) or (None if off is None else straddled_words(scene, off))

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why equal steps do not support a motion: a bar turns its other face to the wind or the Sun."""
        return face_reversal.unsupported_motion(scene, motion)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Assemble the model and the solver."""
        self.scene = scene
        self.steps = steps_of(scene, setting.value)
        self.method = method_for(scene, explicit=self.explicit, index3=self.index3, absolute=self.absolute)
        self.model = self.make(self.steps)
        self.settings = settings_of(self.steps, scene.run.samples, self.method)
        self.solver = solver_of(self.method)
        self.segments = segments_of(scene, self.steps, self.method)

    @abstractmethod
    def make(self, steps: Steps) -> Model:
        """Model of the scene."""

    def simulate(self) -> None:
        """Run the solver; :meth:`read` checks whether it reached the end."""
        try:
            self.finished = self._solve()
        except Exception as error:
            raise EngineError(f"Exudyn: {str(error).strip().splitlines()[0]}") from error

    def _solve(self) -> bool:
        if len(self.segments.boundaries) > 2:
            return run_segments(self.model, self.segments, self.settings, self.method)
        return bool(self.solver.SolveSystem(self.model.mbs, self.settings))

    def read(self) -> Trajectory:
        """Return the samples above the surface, in inertial axes."""
        try:
            return self._read()
        finally:
            self.model.close()

    @abstractmethod
    def readings(self) -> tuple[SensorReadings, dict[str, float | str]]:
        """Sensor readings, and further entries of `info`."""

    def _read(self) -> Trajectory:
        readings, info = self.readings()
        stored = len(readings.angle_rad)
        axes = self.model.frame.at(self.scene.times_s[:stored])
        landed = landing(self.scene, axes, readings)
        self._check(readings, stored if landed is None else landed, whole=landed is None)
        ended = ""
        if landed is not None:
            ended = f"a bar was below the surface at t = {self.scene.times_s[landed]:.6g} s, the next sample"
            readings, axes = readings.first(landed), self.model.frame.at(self.scene.times_s[:landed])
        found = trajectory(self.scene, axes, readings, ended=ended, info=info | {"steps": self.steps.count})
        turns = face_reversal.first_reversal(self.scene, found)
        if turns:
            raise UnsupportedMotionError(f"Exudyn: {turns}")
        loose = Observable.GAP in self.observables  # the bars' positions are coordinates, so that joints may have gaps
        return found.replace(
            gap_m=gaps(self.scene, readings) if loose else None,
            position_m=positions(self.scene, axes, readings) if loose else None,
            torque_N_m=readings.torque_N_m if Observable.TORQUE in self.observables else None,
        )

    def _check(self, readings: SensorReadings, used: int, *, whole: bool) -> None:
        """Reject results that Exudyn reports without an error."""
        t = self.scene.times_s
        good = readings.finite[:used]
        if not good.all():
            raise EngineError(f"Exudyn: the state is not finite at t = {t[int(np.argmin(good))]:.6g} s")
        if whole and (not self.finished or used != self.scene.run.samples):
            raise EngineError(f"Exudyn: the solver stopped after t = {t[used - 1]:.6g} s of {t[-1]:.6g} s")
        start = self.model.start
        off = np.abs(readings.position_m[0] - start.position_m).max() / (
            np.abs(start.position_m).max() + self.scene.size_m
        )
        if max(off, np.abs(readings.angle_rad[0] - start.angle_rad).max()) > START_TOLERANCE:
            raise EngineError("Exudyn: the first sample is not the initial state")
