"""What one engine at one setting may be off by in one scene: computed once for each verdict.

Everything here follows from the scene, the reference solution, and what the engine's method promises at its setting.
Nothing follows from what the engine's run gave, but for a count of steps, which is bounded
(`barchain.judge.declared_noise`).
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.judge import declared_noise as declared
from barchain.judge.local_errors import (
    ROUNDINGS,
    UNIT_ROUNDOFF,
    kepler_growth,
    kinks,
    local_errors,
    orbit_rate_bound,
    orbit_scale,
    step_constant,
)
from barchain.judge.tolerances import NORM_SLACK, rounded, roundoff_unit, step_unit
from barchain.solutions.reference import PARTED_RAD, RICHARDSON

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.local_errors import LocalErrors
    from barchain.solutions.reference import ReferenceSolution


class ErrorModel:
    """Floors, expected-error bounds and the predictability limit of one engine at one setting in one scene."""

    start_rad: float = 0.0
    """Error of the initial state, in what growth is counted in, rad: none but for a restart from an engine's samples"""

    def __init__(self, engine: type[Engine], setting: Setting, solution: ReferenceSolution, run: Trajectory) -> None:
        """Prepare.

        Parameters
        ----------
        engine : type
        setting : Setting
        truth : Truth
        run : Trajectory
            Of the engine: its number of samples, and its count of steps as far as that is believed.
        """
        self.engine, self.setting, self.solution, self.scene = engine, setting, solution, solution.scene
        self.n = min(len(run.t_s), len(solution.amplification))
        self.t_s = solution.trajectory.t_s[: self.n]
        self.amplification = solution.amplification[: self.n]
        said = run.info.get("steps", 0.0)
        counted = float(said) if isinstance(said, int | float) and np.isfinite(said) else 0.0
        self.steps = (
            declared.believed_steps(setting, solution, counted)
            if setting.parameter is AccuracyParameter.RTOL
            else counted
        )

    @cached_property
    def declared_noise(self) -> dict[str, Array]:
        """Noise that the engine declares, (n,) for each quantity, unbounded."""
        return declared.noise(self.engine, self.setting, self.solution, self.t_s)

    @cached_property
    def noise(self) -> dict[str, Array]:
        """Noise that the engine declares, (n,) for each quantity, as far as it counts in floors."""
        return declared.bounded(self.declared_noise, self.solution)

    @cached_property
    def local(self) -> LocalErrors:
        """Errors made on the way, before the motion carries them on."""
        return local_errors(self.engine, self.scene, self.setting, self.solution, self.steps)

    def steps_taken(self, t_s: Array) -> Array:
        """Steps taken up to each instant, (n,)."""
        return declared.steps_taken(self.scene, self.setting, self.steps, t_s)

    @cached_property
    def floor_rad(self) -> Array:
        """What round-off and declared noise alone may make of the attitude, (n,) rad."""
        return self.amplified_rad(self.noise)

    def amplified_rad(self, noise: dict[str, Array]) -> Array:
        """Round-off and noise in the attitude, as the scene amplifies them, (n,) rad."""
        walk = ROUNDINGS * np.sqrt(self.steps_taken(self.t_s))
        found: Array = (
            roundoff_unit(self.engine, self.solution) * walk + noise.get("attitude", 0.0)
        ) * self.amplification
        return found

    @cached_property
    def attitude_rad(self) -> Array:
        """Expected-error bound of the attitude, (n,) rad, before it is cut off where two runs have parted.

        Carried on are the error of the start (half a step aside), and all errors that are made on the way.
        """
        made = self.amplification * self.local.immediate["attitude"][0] + self.local.attitude(
            self.t_s, self.amplification
        )
        found: Array = NORM_SLACK * made + self.started_rad
        return found

    @property
    def started_rad(self) -> Array:
        """What round-off and the given initial state are off by, (n,) rad."""
        return self.floor_rad + self.amplification * self.start_rad

    @cached_property
    def limit_s(self) -> float:
        """Predictability limit, s: until then two correct runs at this setting agree to :data:`PARTED_RAD`.

        Growth of a perturbation, measured on the reference solution, times the errors that the method promises. The
        engine's own run has no say in it. No later than the limit of the reference solution itself.
        """
        parted = np.nonzero(np.maximum.accumulate(self.attitude_rad) > PARTED_RAD)[0]
        last = int(parted[0]) - 1 if len(parted) else self.n - 1
        return min(float(self.t_s[max(last, 0)]), self.solution.limit_s)

    @cached_property
    def floor(self) -> dict[str, Array]:
        """What round-off alone may contribute to each quantity, (n,): a random walk of the steps' roundings, amplified.

        On top comes what the engine declares of itself (`Engine.noise`), bounded: the tolerance of its iterations, and
        the noise of multipliers that are differences over a step.
        """
        parted = RICHARDSON * PARTED_RAD  # up to the limit no attitude is off by more
        return self.floor_of(np.minimum(self.floor_rad, parted), self.noise)

    @cached_property
    def unbounded_floor(self) -> dict[str, Array]:
        """The same with noise as it is declared: an error that it explains is no other physics, and no accuracy."""
        return self.floor_of(self.amplified_rad(self.declared_noise), self.declared_noise)

    def floor_of(self, angle_rad: Array, noise: dict[str, Array]) -> dict[str, Array]:
        """Floor of each quantity, (n,), from that of the attitude, (n,) rad, and noise of its own."""
        solution, seen, n = self.solution, self.solution.trajectory, self.n
        found = {
            name: angle_rad * solution.response[name][:n] + rounded(seen, name)[:n] + noise.get(name, 0.0)
            for name in solution.response
        }
        if "rate" in found:  # a place rounded once in a radian of the orbit
            found["rate"] += roundoff_unit(self.engine, solution) * ROUNDINGS * orbit_scale(self.scene)
        walk = ROUNDINGS * np.sqrt(self.steps_taken(self.t_s))
        carried = UNIT_ROUNDOFF * walk * kepler_growth(self.scene, self.t_s - self.t_s[0])
        for name, values in (("com", seen.com_m), ("com_velocity", seen.com_velocity_m_s)):
            found[name] += np.maximum.accumulate(np.linalg.norm(values[:n], axis=1)) * carried
        return found

    @cached_property
    def bound(self) -> dict[str, Array]:
        """Expected-error bound: what the method promises at this setting, (n,) for each quantity, floors included.

        Errors of attitude made at s are carried to t by G(t)/G(s), and into the other quantities by the perturbed
        run's measured response; the track of the centre of mass has its own local errors besides.
        """
        parted = RICHARDSON * PARTED_RAD  # up to the limit no attitude is off by more
        attitude = (self.attitude_rad - self.floor_rad) / NORM_SLACK  # with the error of the start in it
        found = {}
        for name, response in self.solution.response.items():
            direct = self.local.immediate[name][: self.n] if name in self.local.immediate else 0.0
            carried = np.minimum(NORM_SLACK * attitude, parted)
            if name != "attitude":  # the perturbed run parts in one direction; others may answer more strongly
                carried = NORM_SLACK * np.minimum(attitude, parted)
            found[name] = carried * response[: self.n] + NORM_SLACK * direct + self.floor[name]
        track = NORM_SLACK * self.local.track(self.scene, self.t_s)
        found["com"] += track
        found["com_velocity"] += track * orbit_rate_bound(self.scene, self.solution.trajectory)
        return found

    @cached_property
    def missed(self) -> dict[str, Array]:
        """What fixed steps may miss where a manoeuvre starts or ends inside one, (n,) for each quantity."""
        return kinks(self.engine, self.scene, self.setting, self.solution)

    def explained(self, own: dict[str, Array]) -> dict[str, Array]:
        """What may stand between the engine and the reference if both are right, (n,) for each quantity.

        Both error estimates, `own` of the engine and that of the reference, floors, and what a manoeuvre's ends leave
        inside a step. For a method that chooses its steps also a few steps' requests: its errors are a sum of what
        single steps leave, of any sign, so that two of its runs may meet where both are off. The slack is that of the
        band, NORM_SLACK; for a track asked for in radii, far above what is made, one step.
        """
        missed = self.missed
        found = {}
        for name in own.keys() & self.solution.error.keys():
            n = min(self.n, len(own[name]))  # an engine may run on where the reference has ended
            both = np.maximum.accumulate(own[name][:n]) + self.solution.error[name][:n]
            found[name] = RICHARDSON * both + self.floor[name][:n] + (missed[name][:n] if name in missed else 0.0)
            if self.setting.parameter is AccuracyParameter.RTOL:
                unit = step_unit(self.engine, name, self.scene, self.setting)
                requested = np.maximum(NORM_SLACK * self.solution.response[name][:n], unit)
                found[name] = found[name] + step_constant(self.engine) * self.setting.value * requested
        return found
