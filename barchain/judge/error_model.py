"""Error model of one engine at one setting in one scene, for the main run of a verdict.

The finer run and each restart have an error model of their own; in each, every member is computed once.
Everything here follows from the scene, the judging solution, and the promise of the engine's method at its setting.
Nothing follows from the engine's own run, except a count of steps, which is bounded
(`barchain.judge.scales`).

Two questions are asked of a difference from the judging solution, at every sample up to the predictability limit.

*Is the difference explained?* The two error estimates, round-off and the declared model difference explain it:
``explained = 2 (E_engine + E_reference) + floor + model``. The 2 is Richardson's, see
`barchain.solutions.reference.RICHARDSON`.

*Is the difference small enough?* It is inside the expected-error bound of the engine's method and setting, ``bound``.

Both use the error amplification G(t), measured with a perturbed run: an error made at s is G(t)/G(s) times as large
at t. `barchain.judge.tolerances` lists all tolerances with their derivations.
"""

from __future__ import annotations

from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter, Coordinates
from barchain.judge.discontinuities import kink_errors
from barchain.judge.local_errors import departure, requested_errors, step_constant, track_unit, truncation_errors
from barchain.judge.scales import (
    MACHINE_EPSILON,
    NORM_SLACK,
    ROUNDINGS,
    believed_noise,
    believed_steps,
    declared_noise,
    kepler_growth,
    orbit_rate_bound,
    orbit_scale,
    rounded_sum,
    scales,
)
from barchain.metrics.quantities import own_rate, rate_scale
from barchain.solutions.reference import RICHARDSON
from reports.results.comparison import PARTED_RAD
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.local_errors import LocalErrors
    from barchain.solutions.reference import ReferenceSolution


MAX_STEPS = 1e8
"""Largest number of steps of a run that would end"""
DAMPED_SUM = 10.0
"""Sum of errors of multipliers that each step damps by a tenth, in units of one step's error"""


class ErrorModel:
    """Floors, expected-error bounds and the predictability limit of one engine at one setting in one scene.

    Frozen by convention: members are computed when first asked for, kept, and never changed. A restart sets `start_rad`
    and `declared_noise` before (`barchain.judge.checks.restart`).
    """

    start_rad = 0.0
    """Error of the initial state as an angle, rad: zero, except for a restart from an engine's samples"""

    written: Mapping[str, Array] = MappingProxyType({})
    """Error of values that were written with few digits, (n,) for each quantity in its unit; nothing amplifies it"""
    absent: Mapping[str, NDArray[np.bool_]] = MappingProxyType({})
    """Parts of arrays that a file lacks, of the shape of a sample; its run has the judging solution's there"""
    noise_is_bounded = True
    """Whether declared noise counts up to a bound: more of it is a limit of the engine, and makes no pass"""

    def __init__(self, engine: Declarations, setting: Setting, solution: ReferenceSolution, run: Trajectory) -> None:
        """Keep the arguments; nothing expensive is computed yet.

        Parameters
        ----------
        engine : Declarations
        setting : Setting
        solution : ReferenceSolution
        run : Trajectory
            Of the engine. Only its number of samples is used, and its count of steps as far as that is believed.
        """
        self.engine, self.setting, self.solution, self.scene = engine, setting, solution, solution.scene
        self.n = min(len(run.t_s), len(solution.amplification))
        self.t_s = solution.trajectory.t_s[: self.n]
        self.amplification = solution.amplification[: self.n]
        self.run = run

    @property
    def by_change_alone(self) -> bool:
        """Whether nothing but the change between two results tells the error."""
        return False

    @cached_property
    def steps(self) -> float:
        """Count of steps that the run reports, as far as it is believed; 0 without one."""
        said = self.run.info.get("steps", 0.0)
        counted = float(said) if isinstance(said, int | float) and np.isfinite(said) else 0.0
        if self.setting.parameter is not AccuracyParameter.RTOL:
            return counted
        return believed_steps(self.setting, self.solution, counted)

    @cached_property
    def scale(self) -> dict[str, float]:
        """Size of each quantity in the scene, SI units (`barchain.judge.scales`)."""
        return scales(self.solution)

    @cached_property
    def place_m(self) -> float:
        """Largest number that a bar's place is made of in the engine's coordinates, m.

        Absolute coordinates count from the central body's centre, relative ones along the chain. In a frame on an orbit
        of its own, the chain's departure from that orbit is added to the chain's size.
        """
        if self.engine.coordinates.absolute:
            return self.scene.radius0_m
        if self.engine.coordinates is Coordinates.RELATIVE:
            return self.scene.size_m
        place, _ = departure(self.engine, self.scene, self.solution.trajectory)
        return self.scene.size_m + float(np.linalg.norm(place, axis=1).max())

    @property
    def rounding_m(self) -> float:
        """Error of a place by the roundings of one step, m."""
        return ROUNDINGS * MACHINE_EPSILON * self.place_m

    @property
    def rounding_rad(self) -> float:
        """The same as an angle, rad: in units of u for lengths of a bar, of u r/l for distances."""
        return self.rounding_m / min(self.scene.chain.length_m)

    @cached_property
    def steps_taken(self) -> Array:
        """Steps taken up to each sample, (n,): by the setting, or as the run counts them."""
        run = self.scene.run
        whole = self.steps or run.samples
        if self.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
            whole = run.duration_s / step_s(self.scene, self.setting.value)
        taken: Array = 1.0 + (self.t_s - self.t_s[0]) / run.duration_s * min(whole, MAX_STEPS)
        return taken

    @cached_property
    def walk(self) -> Array:
        """Random walk up to each sample of an error of 1 in each step, (n,)."""
        return np.sqrt(self.steps_taken)

    @cached_property
    def track_growth(self) -> Array:
        """Growth up to each sample of a small error of the centre of mass at the start, (n,)."""
        return kepler_growth(self.scene, self.t_s - self.t_s[0])

    @cached_property
    def declared_noise(self) -> dict[str, Array]:
        """Noise that the engine declares, (n,) for each quantity, unbounded."""
        return declared_noise(self.engine, self.setting, self.solution, self.t_s)

    @cached_property
    def noise(self) -> dict[str, Array]:
        """Noise that the engine declares, (n,) for each quantity, as far as it counts in floors."""
        return believed_noise(self.declared_noise, self.scale)

    @cached_property
    def local(self) -> LocalErrors:
        """Errors that the method makes in its steps, before the motion amplifies them."""
        if self.setting.parameter is AccuracyParameter.RTOL:
            return requested_errors(self.engine, self.setting, self.solution, self.steps)
        return truncation_errors(self.engine, self.setting, self.solution)

    @cached_property
    def floor_rad(self) -> Array:
        """Error of the attitude that round-off and declared noise alone may cause, (n,) rad."""
        return self.amplified_rad(self.noise)

    def amplified_rad(self, noise: dict[str, Array]) -> Array:
        """Round-off and noise in the attitude, as the scene amplifies them, (n,) rad."""
        found: Array = (self.rounding_rad * self.walk + noise.get("attitude", 0.0)) * self.amplification
        return found

    @cached_property
    def attitude_rad(self) -> Array:
        """Expected-error bound of the attitude, (n,) rad, before it is cut off where two runs have parted.

        Two kinds of error are amplified: that of the start (half a step aside), and all errors of later steps.
        """
        made = self.amplification * self.local.immediate["attitude"][0] + self.local.attitude(
            self.t_s, self.amplification
        )
        found: Array = NORM_SLACK * made + (self.floor_rad + self.amplification * self.start_rad)
        return found

    @cached_property
    def kept_request(self) -> dict[str, Array]:
        """Error that a method leaves that keeps its request, (n,): ``attitude``, rad, and ``com``, m. No bound.

        One local error as large as the request, of any sign, is made in each radian of the fastest motion, of the chain
        or the orbit. They add up as a random walk, and grow as one that is made at the start. Rounding and noise are
        added.
        """
        scene, elapsed_s = self.scene, self.t_s - self.t_s[0]
        rates = rate_scale(scene, self.solution.trajectory), orbit_rate_bound(scene, self.solution.trajectory)
        request = self.setting.value * step_constant(self.engine)
        turned, travelled = (request * np.sqrt(1.0 + rate * elapsed_s) for rate in rates)
        unit_m = track_unit(self.engine, scene, request)
        return {
            "attitude": turned * self.amplification + self.floor["attitude"],
            "com": travelled * unit_m * self.track_growth + self.floor["com"],
        }

    @cached_property
    def limit_s(self) -> float:
        """Predictability limit, s: until then two correct runs at this setting agree to :data:`PARTED_RAD`.

        The limit follows from the error amplification, measured on the judging solution, times the errors that the
        method promises. The engine's own run does not enter. The limit is no later than the judging solution's own.
        """
        parted = np.nonzero(np.maximum.accumulate(self.attitude_rad) > PARTED_RAD)[0]
        last = int(parted[0]) - 1 if len(parted) else self.n - 1
        return min(float(self.t_s[max(last, 0)]), self.solution.limit_s)

    @cached_property
    def floor(self) -> dict[str, Array]:
        """Round-off floor of each quantity, (n,): a random walk of the steps' roundings, amplified.

        The engine's declared noise (`Engine.noise`) is added, bounded: the tolerance of its iterations, and the noise
        of multipliers that are differences over a step.
        """
        parted = RICHARDSON * PARTED_RAD  # up to the limit no attitude is off by more
        return self.floor_of(np.minimum(self.floor_rad, parted), self.noise)

    @cached_property
    def unbounded_floor(self) -> dict[str, Array]:
        """Floor with noise as it is declared, (n,) each: an error inside it is neither other physics nor accuracy."""
        return self.floor_of(self.amplified_rad(self.declared_noise), self.declared_noise)

    def floor_of(self, angle_rad: Array, noise: dict[str, Array]) -> dict[str, Array]:
        """Floor of each quantity, (n,), from that of the attitude, (n,) rad, and noise of its own."""
        solution, seen, n = self.solution, self.solution.trajectory, self.n
        found = {
            name: angle_rad * solution.response[name][:n] + rounded_sum(seen, name)[:n] + noise.get(name, 0.0)
            for name in solution.response
        }
        if "rate" in found:  # a place rounded once in a radian of the orbit
            found["rate"] += self.rounding_rad * orbit_scale(self.scene)
        carried = ROUNDINGS * MACHINE_EPSILON * self.walk * self.track_growth
        for name, values in (("com", seen.com_m), ("com_velocity", seen.com_velocity_m_s)):
            found[name] += np.maximum.accumulate(np.linalg.norm(values[:n], axis=1)) * carried
        return {name: values + self.written.get(name, 0.0) for name, values in found.items()}

    @cached_property
    def bound(self) -> dict[str, Array]:
        """Expected-error bound: the promise of the method at this setting, (n,) for each quantity, floors included.

        Errors of attitude made at s are amplified by G(t)/G(s) until t. The perturbed run's measured response carries
        them into the other quantities. The track of the centre of mass has local errors of its own besides.
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
        if self.scene.effects.gravity is Gravity.NONE and self.setting.parameter is AccuracyParameter.RTOL:
            track = np.minimum(track, self.straight_track_m)
        found["com"] += track
        found["com_velocity"] += track * orbit_rate_bound(self.scene, self.solution.trajectory)
        return found

    @property
    def straight_track_m(self) -> Array:
        """Largest error of a track without gravity by any weights that a method gives to the forces, (n,) m.

        Accelerations a that a step weighs lie between those of the motion, so that no mean is off by more than their
        range: t²/2 of it from the start. A constant force leaves no error, however large a request is. Attitudes that
        are off by an angle turn the force, and the share of a bar that it meets: 2 |a| times that angle. Where the
        centre of mass is computed from bars, their own speeds enter, by that angle times their size, for t.
        """
        fine = self.solution.fine
        if len(fine.t_s) < 2:
            return np.full(self.n, np.inf)
        acceleration = np.gradient(fine.com_velocity_m_s, fine.t_s, axis=0)
        lowest, highest = (f.accumulate(acceleration, axis=0) for f in (np.minimum, np.maximum))
        size = np.maximum.accumulate(np.linalg.norm(acceleration, axis=1))
        varied, most = (np.interp(self.t_s, fine.t_s, x) for x in (np.linalg.norm(highest - lowest, axis=1), size))
        elapsed_s = self.t_s - self.t_s[0]
        drift_m_s = self.scene.size_m * rate_scale(self.scene, self.solution.trajectory) * self.attitude_rad
        found: Array = 0.5 * elapsed_s**2 * (varied + 2.0 * most * self.attitude_rad) + elapsed_s * drift_m_s
        return found

    @cached_property
    def missed(self) -> dict[str, Array]:
        """Error of fixed steps where something jumps inside one, (n,) for each quantity.

        A law's fourth derivative jumps where a manoeuvre starts or ends, a force's slope where a bar turns its other
        face. The error depends on where in the step the jump falls, and does not shrink from one setting to the next:
        one step's own error is allowed for a manoeuvre, and the largest one for each face
        (`barchain.judge.discontinuities`).
        """
        if self.setting.parameter is AccuracyParameter.RTOL:
            return {}
        end_s, laws = self.scene.run.duration_s, self.scene.effects.prescribed_rotation
        inside = any(0.0 < t < end_s for law in laws for t in law.breaks_s)
        step = step_s(self.scene, self.setting.value)
        parts = [self.local.immediate if inside else {}, kink_errors(self.solution, step, self.t_s, self.amplification)]
        return {name: sum((p[name] for p in parts if name in p), np.zeros(self.n)) for name in {*parts[0], *parts[1]}}

    def explained(self, own: dict[str, Array]) -> dict[str, Array]:
        """Largest difference of two correct results, the engine's and the reference's, (n,) for each quantity.

        Its parts are both error estimates (`own` is the engine's, (n,) each), floors, and the errors that a
        manoeuvre's ends leave inside a step. For a method that chooses its steps a few steps' requests are added. The
        errors of such a method are a sum over steps of any sign, so that two of its runs may meet where both are off.
        The slack is NORM_SLACK, as in the bound. A track is requested in radii, far above the errors made: there one
        step's request is added.
        """
        missed, scene, chosen = self.missed, self.scene, self.setting.parameter is AccuracyParameter.RTOL
        requested = {}
        if chosen:
            track = track_unit(self.engine, scene, self.setting.value)
            track *= NORM_SLACK if self.engine.track_by_length else 1.0
            requested = {"com": track, "com_velocity": track * orbit_scale(scene), "rate": own_rate(scene)}
        found = {}
        for name in own.keys() & self.solution.error.keys():
            n = min(self.n, len(own[name]))  # an engine may run on where the reference has ended
            both = np.maximum.accumulate(own[name][:n]) + self.solution.error[name][:n]
            found[name] = RICHARDSON * both + self.floor[name][:n] + (missed[name][:n] if name in missed else 0.0)
            if chosen:
                unit = np.maximum(NORM_SLACK * self.solution.response[name][:n], requested.get(name, 0.0))
                found[name] = found[name] + step_constant(self.engine) * self.setting.value * unit
        return found

    def max_roundoff(self, amplification: Array) -> dict[str, Array]:
        """Largest round-off that the engine's coordinates can cause, (n,) for each quantity, in its unit.

        A place of the size r is known to u r: r is the orbit's radius in absolute coordinates and the chain's size in
        others. Each step leaves a rounding of that size, and of velocities known to u r over the step. Over a bar's
        length these are angles and rates. They add up as a random walk, and the scene amplifies them. Forces that an
        engine gets as differences over a step are known to m u r / h².

        Parameters
        ----------
        amplification : ndarray, shape (n,)
            Error amplification of the scene since the start, or since the instant from which a comparison started anew.
        """
        scene, size, t = self.scene, self.scale, self.t_s - self.t_s[0]
        shortest, longest, heaviest = min(scene.chain.length_m), max(scene.chain.length_m), max(scene.chain.mass_kg)
        fixed_step = self.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
        place = self.rounding_m
        step = step_s(scene, self.setting.value) if fixed_step else 1.0 / orbit_scale(scene)
        turn = self.rounding_rad * self.walk * (1.0 + t * orbit_scale(scene)) * amplification
        if fixed_step:  # velocities are differences of places a step apart
            turn = turn + place / (shortest * step) * t * amplification
        track = place * self.walk * self.track_growth
        force = DAMPED_SUM * heaviest * place / step**2
        found = {
            "com": track,
            "com_velocity": track * orbit_scale(scene),
            "attitude": turn,
            "rate": turn * size["rate"] + place / (shortest * step),
            "reaction": turn * size["reaction"] + force,
            "torque": turn * size["torque"] + force * longest,
            "impulse": turn * size["impulse"] + heaviest * place / step,
        }
        return {name: NORM_SLACK * values for name, values in found.items()}
