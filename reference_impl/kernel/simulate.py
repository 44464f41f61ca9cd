"""One run of the compiled reference, with the observables of :mod:`reference_impl.integrate.simulate`."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853

from reference_impl.integrate import stiffness
from reference_impl.integrate.coordinate_sets import MinimalCoordinates
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.integrate.simulate import History, Simulation
from reference_impl.integrate.stepper import Integration, smooth_segments
from reference_impl.integrate.surface_contact import contact_instant
from reference_impl.kernel import layout
from reference_impl.kernel.library import Evaluation, Integrator, Observer, library
from reference_impl.kernel.packing import DOUBLE, WIDE
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.effect import EffectState
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE
from reference_impl.model.kinematics import gap_vectors, relative_positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.coordinate_sets import StateCoordinates
    from reference_impl.kernel.layout import CompiledChain, Workspace
    from reference_impl.kernel.packing import Number
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import Modes

EXACT_RTOL = 1e-14  # below it, rounding of states and coefficients is compensated
LEAST_RTOL = {DOUBLE: 1e-15, WIDE: 1e-18}  # below it the error estimate is round-off, and steps would collapse


def has_wide_type() -> bool:
    """Whether the wide type has more digits than double here: C's long double, of which NumPy's is the same."""
    return bool(np.finfo(WIDE).eps < np.finfo(DOUBLE).eps)


class KernelSimulation:
    """One run: set-up, integration, observables; arguments and meaning as in :class:`Simulation`."""

    most_events: float = math.inf
    """State events after which the run gives up"""

    def __init__(
        self,
        model: ChainModel,
        com_m: Array,
        com_velocity_m_s: Array,
        angle_rad: Array,
        rate_rad_s: Array,
        *,
        rtol: float,
        number: Number = DOUBLE,
        shift_rad: float = 0.0,
    ) -> None:
        """Set up a run.

        Parameters beyond those of :class:`Simulation`:

        number : type
            Type of the numbers. The wide type keeps its digits between impulses; samples are rounded to double.
        shift_rad : float
            Shift of the initial angles, and of the rates relative to the fastest, which may be below double precision;
            its sign differs by bar.

        Raises
        ------
        KernelMissingError
            If the kernel can't be used here.
        """
        library()
        self.model = model
        start = (com_m, com_velocity_m_s, angle_rad, rate_rad_s)
        self.reference = Simulation(model, *start, rtol=max(rtol, LEAST_RTOL[number]))
        self.order = reference_order(model.bars)
        self.y0 = layout.pack(*start).astype(number)
        bar = np.arange(model.bars)
        fastest = max(np.sqrt(model.mu_m3_s2 / np.linalg.norm(com_m) ** 3), np.abs(rate_rad_s).max())
        self.y0[bar] += number(shift_rad) * (-1.0) ** bar
        self.y0[model.bars + 2 + bar] += number(shift_rad * fastest) * (-1.0) ** (bar // 2)
        self.atol = np.ones_like(self.y0)
        self.atol[self.order] = self.reference.atol
        self.exact = rtol <= EXACT_RTOL or number is WIDE
        self.chain = layout.compiled_chain(model, number)
        self.work = layout.workspace_of(self.chain)
        self.reference.coordinates = CompiledRates(self.chain, self.work, self.y0, self.order, model)
        self.stepper = layout.new_stepper(self.y0, exact=self.exact)
        ground = layout.SurfaceBounds(
            self.reference.contact_free_radius_m,
            self.reference.contact_free_perigee_m,
            self.reference.largest_pull_m_s2,
        )
        self.integrator = Integrator(self.stepper, self.atol, ground, self.chain, self.work)
        self.events: DiscreteModes | None = None
        self.detects_events = any(effect.has_state_events for effect in model.effects)

    def reset(self, t_s: Array) -> None:
        """Reset to the start, with the sample instants `t_s`."""
        self.t_s, self.rows = t_s.astype(self.y0.dtype), np.empty((len(t_s), len(self.y0)), self.y0.dtype)
        self.rows[0] = self.stepper.y[:] = self.y0
        clock = self.stepper.clock
        clock[:] = 0.0
        clock[layout.NOW], clock[layout.SAMPLED], clock[layout.EXACT] = t_s[0], 1, self.exact
        self.integrator.sample_into(self.t_s, self.rows)

    def integrate(self, t_s: Array) -> Integration:
        """Integrate over the sample instants, from ``t_s[0]``; stop at contact of a bar with the surface.

        Raises
        ------
        ArithmeticError
            If the step size collapses, or the state or its rate is not finite.
        numpy.linalg.LinAlgError
            If the joint system is not positive definite in double precision.
        """
        if (
            stiffness.choose_method(self.reference.coordinates, self.reference.y0, t_s, self.reference.atol)
            is not DOP853
        ):
            return self.integrate_implicitly(t_s)
        self.reset(t_s)
        if self.model.effects or self.model.impulses:
            end_s = float(t_s[-1])
            self.events = DiscreteModes(self.reference.coordinates, end_s, most_events=self.most_events)
        stopped_s = None
        for start, end in smooth_segments(t_s, self.model.breaks_s):
            stopped_s = self.integrate_segment(start, end)
            if stopped_s is not None:
                break
        clock = self.stepper.clock
        count = int(clock[layout.SAMPLED])
        return Integration(
            t_s[:count], self.rows[:count], int(clock[layout.STEPS]), int(clock[layout.EVALUATIONS]), stopped_s
        )

    def integrate_implicitly(self, t_s: Array) -> Integration:
        """Integrate with the NumPy reference's implicit solver and compiled rates."""
        self.reset(t_s)
        result = self.reference.integrate(t_s)
        self.events = self.reference.events
        rows = np.zeros((len(result.y), len(self.y0)))
        rows[:, self.order] = result.y
        return dataclasses.replace(result, y=rows)

    def integrate_segment(self, start_s: float, end_s: float) -> float | None:
        """Integrate from break to break; return the instant of contact with the surface, or None."""
        if self.events:
            before = self.in_double(self.stepper.y)
            beyond_double = self.stepper.y[self.order] - before
            after = self.events.begin_segment(start_s, end_s, before)
            self.set_state(start_s, after + beyond_double)
        here: float = start_s
        code, stopped_s = self.integrator.advance_to(here, end_s), None
        while code in (layout.CHECK_SURFACE, layout.MODE_ENDED) and stopped_s is None:
            stopped_s, event_s = self.examine_step()
            here = start_s if event_s is None else event_s
            code = layout.ARRIVED if stopped_s is not None else self.integrator.advance_to(here, end_s)
        self.raise_failure(code)
        return stopped_s

    def in_double(self, y: Array) -> Array:
        """State in the NumPy reference's order and in double precision, as the effects' events take it."""
        state: Array = y[self.order].astype(float)
        return state

    def set_state(self, t_s: float, y: Array) -> None:
        """Set time, state (in the NumPy reference's order) and modes at the start of a smooth segment."""
        self.stepper.clock[layout.NOW] = t_s
        self.stepper.y[self.order] = y
        set_modes(self.chain, self.reference.coordinates.modes)

    def examine_step(self) -> tuple[float | None, float | None]:
        """Instants of contact and of a mode's end in the last step; takes its samples up to the first of them."""
        carry = self.stepper
        if not self.detects_events:  # otherwise already computed
            self.integrator.make_interpolant()
        end, step = float(carry.clock[layout.NOW]), float(carry.clock[layout.TAKEN])
        found = np.empty_like(carry.y)

        def at(t: float) -> Array:
            self.integrator.interpolate(float((t - (end - step)) / step), found)
            return self.in_double(found)

        event_s = self.events.find_event(at, end - step, end) if self.events and self.detects_events else None
        stopped_s = self.contact_instant(at, event_s)
        until = next(t for t in (stopped_s, event_s, end) if t is not None)
        self.integrator.take_samples(until)
        if event_s is not None and stopped_s is None and self.events:
            event_s, state = self.events.apply_event(self.partial_step, event_s, (end - step, end))
            if self.chain.number is not DOUBLE:
                self.partial_step(event_s)
                state = carry.end[self.order]
            self.set_state(event_s, state)
        else:
            self.integrator.begin_next_step()
        return stopped_s, event_s

    def partial_step(self, until_s: float) -> Array:
        """State in the NumPy reference's order at an instant inside the last step, by a shorter step."""
        carry = self.stepper
        begin = carry.clock[layout.NOW] - carry.clock[layout.TAKEN]
        self.integrator.take_partial_step(float(begin), float(until_s - begin))
        return self.in_double(carry.end)

    def contact_instant(self, at: Callable[[float], Array], event_s: float | None) -> float | None:
        """Instant of contact with the surface in the last step, if before the end of a mode."""
        end, step = float(self.stepper.clock[layout.NOW]), float(self.stepper.clock[layout.TAKEN])
        before, after = self.in_double(self.stepper.before), self.in_double(self.stepper.y)
        if not self.reference.contact_free_radius_m or self.reference.clears_surface(before, after, step):
            return None
        stopped_s = contact_instant(at, self.reference.height, end - step, end, self.reference.height(before))
        later = stopped_s is not None and event_s is not None and stopped_s > event_s
        return None if later else stopped_s

    def raise_failure(self, code: int) -> None:
        """Raise the same error as the NumPy reference."""
        if code == layout.LOST_JOINT:
            raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
        now = self.stepper.clock[layout.NOW]
        if code == layout.NOT_FINITE and now == self.t_s[0]:
            raise ArithmeticError(f"the initial state or its rate is not finite{self.reference.failure_hint}")
        words = {
            layout.COLLAPSED: "Required step size is less than spacing between numbers.",
            layout.NOT_FINITE: "state not finite",
        }
        if code in words:
            raise ArithmeticError(f"DOP853 failed at t = {now:.6g} s: {words[code]}{self.reference.failure_hint}")

    def history(self, result: Integration, *, condition: bool = False) -> History:
        """Observables at the samples of an integration."""
        n, samples = self.model.bars, len(result.t_s)
        reaction = np.zeros((samples, n - 1, 2), self.y0.dtype)
        torque = np.zeros((samples, len(self.chain.laws)), self.y0.dtype)
        self.observe(result, reaction, torque)
        reaction, torque, seen = (each.astype(float) for each in (reaction, torque, result.y))
        angle, com, rate, velocity = np.split(seen[:, : 2 * n + 4], [n, n + 2, 2 * n + 2], axis=1)
        position = relative_positions(self.model, angle)
        gap = np.linalg.norm(gap_vectors(self.model, position, angle), axis=-1)
        numbers = (
            [self.reference.condition(self.reference.coordinates.unpack(y[self.order])) for y in result.y]
            if condition
            else None
        )
        return History(
            result.t_s,
            com,
            velocity,
            angle,
            rate,
            reaction,
            gap,
            np.linalg.norm(np.einsum("j,tjk->tk", self.model.weight, position), axis=1),
            torque,
            None if numbers is None else np.array(numbers),
            result.steps,
            result.evaluations,
            result.stopped_s,
            self.events.impulse_sums(result.t_s) if self.events else None,
            stiffness.METHOD_NAMES[self.reference.method],
        )

    def observe(self, result: Integration, reaction_N: Array, torque_N_m: Array) -> None:
        """Reactions (n, N-1, 2) and torques (n, P) at the samples; modes follow from each state."""
        chain = layout.refined(self.chain)
        observe = Observer(chain, self.work)
        moded = has_modes(chain)
        for one in [slice(k, k + 1) for k in range(len(result.t_s))] if moded else [slice(None)]:
            t, y = result.t_s[one].astype(self.y0.dtype), result.y[one]
            if moded:
                set_modes(chain, modes_at(self.reference.coordinates, float(t[0]), self.in_double(y[0])))
            if not observe(t, y, reaction_N[one], torque_N_m[one]):
                raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)


def modes_at(coordinates: StateCoordinates, t_s: float, y: Array) -> Modes:
    """Modes of the effects at a state in the NumPy reference's order."""
    state = coordinates.unpack(y)
    at = EffectState(coordinates.model, t_s, state, unit_along(state.angle_rad))
    return tuple(effect.mode(at) for effect in coordinates.model.effects)


def has_modes(chain: CompiledChain) -> bool:
    """Whether an effect of compiled code has a mode, such as a face or light."""
    return any(effect.mode.size for effect in chain.effects)


def set_modes(chain: CompiledChain, modes: Modes | None) -> None:
    """Set the modes in compiled code."""
    for effect, mode in zip(chain.effects, modes or (), strict=True):
        if mode is not None:
            effect.mode[:] = mode


class CompiledRates(MinimalCoordinates):
    """Minimal coordinates in the NumPy reference's order, with compiled rates."""

    def __init__(self, chain: CompiledChain, work: Workspace, y0: Array, order: Array, model: ChainModel) -> None:
        """Prepare rates of `chain`, with vectors like `y0`; `order` maps the NumPy reference's order to them."""
        super().__init__(model)
        self.chain, self.work, self.order = chain, work, order
        self.y, self.slopes = np.zeros_like(y0), np.zeros_like(y0)
        self.evaluation = Evaluation(self.y, self.slopes, chain, work)
        self.moded = has_modes(chain)

    def rhs(self, t_s: float, y: Array) -> Array:
        """Time derivative of a vector in the NumPy reference's order.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the joint system is not positive definite in double precision.
        """
        self.y[self.order] = y
        if self.moded:
            set_modes(self.chain, self.modes or modes_at(self, t_s, y))
        if not self.evaluation(t_s):
            raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
        rates: Array = self.slopes[self.order]
        return rates


def reference_order(bars: int) -> Array:
    """Indices of the NumPy reference's [Z0, Z0', theta, theta'] in [theta, Z0, theta', Z0'], shape (2N+4,) of int."""
    n = bars
    order: Array = np.concatenate([[n, n + 1, 2 * n + 2, 2 * n + 3], np.arange(n), np.arange(n + 2, 2 * n + 2)]).astype(
        int
    )
    return order
