"""Instants at which what acts is not smooth: found, never stepped over; a sample on one shows what was just before."""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.integrate.coordinate_sets import MinimalCoordinates
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.integrate.simulate import Simulation
from reference_impl.integrate.stepper import SampledRun
from reference_impl.model.arrays import Array
from reference_impl.model.chain import BarImpulse, BarTurn, ChainModel, Prescription
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import State
from scenarios import load_scene
from tests.effects.effect_runs import placed, ran, started
from tests.support.effect_cases import MU, RADIUS, chain
from tests.support.slow import one_in

EVENTFUL = ["solar_shadow", "thrust_table", "impulse", "everything", "drag"]


@dataclass
class Watch:
    """What a run was seen to do."""

    steps: list[tuple[float, float]] = field(default_factory=list)
    evaluations: list[tuple[float, Any]] = field(default_factory=list)
    marks: list[int] = field(default_factory=list)
    """How many evaluations there had been at the end of each step"""
    falls: list[float] = field(default_factory=list)


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch) -> Watch:
    """Every step, every evaluation with what is held in it, and every event."""
    seen, step, fall = Watch(), SampledRun.step, DiscreteModes.apply_event
    plain = MinimalCoordinates.rhs

    def rhs(self: MinimalCoordinates, t: float, y: Array) -> Array:
        held = None if self.modes is None else tuple(None if m is None else tuple(m.tolist()) for m in self.modes)
        seen.evaluations.append((float(t), held))
        return plain(self, t, y)

    def stepped(self: SampledRun, solver: Any, *more: Any) -> Any:
        found = step(self, solver, *more)
        seen.steps.append((float(solver.t_old), float(solver.t)))
        seen.marks.append(len(seen.evaluations))
        return found

    def fell(self: DiscreteModes, exact: Any, t: float, step: float) -> tuple[float, Array]:
        found = fall(self, exact, t, step)
        seen.falls.append(float(found[0]))
        seen.marks[-1] = len(seen.evaluations)  # what finds the instant still belongs to the step
        return found

    monkeypatch.setattr(MinimalCoordinates, "rhs", rhs)
    monkeypatch.setattr(SampledRun, "step", stepped)
    monkeypatch.setattr(DiscreteModes, "apply_event", fell)
    return seen


def scene_run(name: str, rtol: float = 1e-9) -> tuple[Simulation, ChainModel]:
    scene = load_scene(f"effects/{name}")
    model, s = chain_model(scene), initial_state(scene)
    return started(
        model, consistent_state(model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s), rtol=rtol
    ), model


@pytest.mark.parametrize("name", one_in(3, EVENTFUL))
def test_no_step_sees_two_kinds_of_what_is_held_nor_straddles_an_instant_of_a_table(name: str, watch: Watch) -> None:
    run, model = scene_run(name)
    duration = {"drag": 5400.0, "everything": 1000.0}.get(name, 2000.0)
    run.integrate(np.linspace(0.0, duration, 5))
    before = 1  # the first evaluation of all, before anything is held, is only for whether it is finite
    for (start, end), mark in zip(watch.steps, watch.marks, strict=True):
        within = watch.evaluations[before:mark]
        assert len({held for _, held in within}) <= 1
        reached = [t for t, _ in within]
        assert all(start <= t <= end for t in reached[-12:])  # those before may be of steps that were rejected
        slack = 1e-12 * duration
        assert not any(start + slack < t < end - slack for t in model.breaks_s)
        before = mark
    assert len(watch.falls) == len([t for t in watch.falls if 0.0 < t <= duration])


@pytest.mark.parametrize("name", one_in(3, ["solar_shadow", "thrust_table", "drag"]))
def test_the_error_falls_with_the_tolerance_through_every_event(name: str) -> None:
    """From 1e-6 to 1e-10 by 1e3 of the 1e4 asked for, as without events, or to a tolerance for each step."""
    duration = {"solar_shadow": 3000.0, "thrust_table": 900.0, "drag": 1000.0}[name]
    ends, steps = [], []
    for rtol in (1e-6, 1e-10, 1e-13):
        run, _ = scene_run(name, rtol)
        seen = run.integrate(np.array([0.0, duration]))
        ends.append(seen.y[-1] / run.coordinates.scales(7e6, 1e-3))
        steps.append(seen.steps)
    coarse, fine = (np.abs(y - ends[-1]).max() for y in ends[:2])
    assert fine <= max(1e-3 * coarse, steps[1] * 1e-10)


def test_two_events_in_one_step_are_both_found_in_their_order(watch: Watch) -> None:
    """Two bars that turn their other faces to the Sun within a second, at a tolerance with steps of many."""
    light = SolarPressureEffect(1e-12, 0.0, 0.0, np.ones(2), 0.0, 0.0)
    model = replace(chain(np.random.default_rng(0), 2, 10.0, "none"), effects=(light,))
    rate = 1e-3
    state = placed(model, 1e7, 0.0, np.array([-0.1, -0.1 - 0.5 * rate]), np.full(2, rate))
    run = started(model, state, rtol=1e-3)
    run.integrate(np.array([0.0, 200.0]))
    assert len(watch.falls) == 2
    # turning with hardly a bend: n·s = cos(theta - pi/2), zero at theta = 0
    assert np.abs(np.array(watch.falls) - [100.0, 100.5]).max() <= 1e-3 * 200.0
    both = [s for s in watch.steps if s[0] < 99.9 and s[1] > 100.6]
    assert both, "no step had both of them within"


def free(effects: tuple[Any, ...] = (), impulses: tuple[BarImpulse, ...] = ()) -> tuple[ChainModel, State]:
    random = np.random.default_rng(6)
    model = replace(chain(random, 3, 10.0, "none"), effects=effects, impulses=impulses)
    return model, placed(model, 7e6, 0.0, np.array([0.1, 0.5, 0.2]), np.array([0.01, 0.0, -0.01]))


@pytest.mark.parametrize(("samples", "at"), [(11, 3), (11, 7), (1001, 3)])
def test_a_sample_on_an_instant_shows_what_was_just_before(samples: int, at: int) -> None:
    """Also where the sample, a multiple of a step, is a rounding off the instant: 3 x 0.1 is not 0.3."""
    t = np.linspace(0.0, 1.0, samples)
    instant = float(f"{at / (samples - 1):.6g}")
    blow = BarImpulse(0, -1.0, False, 1.0, 5.0, instant)
    push = ThrustEffect(np.array([instant, 2.0]), np.array([5.0, 5.0]), 2, 1.0, False, 1.2)
    model, state = free((push,), (blow,))
    quiet, _ = free()
    h, before = ran(model, state, t, rtol=1e-9), ran(quiet, state, t, rtol=1e-9)
    i = at
    still = {"atol": 1e-9, "rtol": 1e-9}  # the tolerance asked for
    np.testing.assert_allclose(h.rate_rad_s[: i + 1], before.rate_rad_s[: i + 1], **still)
    np.testing.assert_allclose(h.reaction_N[: i + 1], before.reaction_N[: i + 1], **still)
    np.testing.assert_allclose(h.com_velocity_m_s[: i + 1], before.com_velocity_m_s[: i + 1], **still)
    assert not h.impulse_N_s[: i + 1].any()
    assert np.abs(h.com_velocity_m_s[i + 1]).max() > 1e-3
    assert h.impulse_N_s[i + 1].any()
    assert np.abs(h.reaction_N[i + 1] - before.reaction_N[i + 1]).max() > 1e-3


@pytest.mark.parametrize(("samples", "at"), [(11, 3), (1001, 3)])
def test_a_sample_on_the_end_of_a_thrust_still_shows_it(samples: int, at: int) -> None:
    t = np.linspace(0.0, 1.0, samples)
    instant = float(f"{at / (samples - 1):.6g}")
    model, state = free((ThrustEffect(np.array([0.0, instant]), np.array([5.0, 5.0]), 2, 1.0, False, 1.2),))
    longer, _ = free((ThrustEffect(np.array([0.0, 2.0]), np.array([5.0, 5.0]), 2, 1.0, False, 1.2),))
    h, through = ran(model, state, t, rtol=1e-9), ran(longer, state, t, rtol=1e-9)
    np.testing.assert_allclose(h.reaction_N[: at + 1], through.reaction_N[: at + 1], atol=1e-9, rtol=1e-9)
    assert np.abs(h.reaction_N[at + 1] - through.reaction_N[at + 1]).max() > 1e-3
    assert h.reaction_N[0].any()  # at t = 0, just after


def test_impulses_at_one_instant_are_struck_together_and_each_instant_adds_its_reactions() -> None:
    """Impulsive reactions are linear in the impulses."""
    one, two = BarImpulse(0, -1.0, False, 1.0, 5.0, 0.25), BarImpulse(2, 1.0, True, 2.0, 3.0, 0.25)
    t = np.linspace(0.0, 1.0, 3)

    def reactions(*blows: BarImpulse) -> Array:
        model, state = free((), blows)
        found = ran(model, state, t, rtol=1e-11).impulse_N_s
        assert found is not None
        return found

    both = reactions(one, two)
    alone = reactions(one) + reactions(two)
    assert np.abs(both - alone).max() <= 1e-11 * 100.0 * np.abs(alone).max()
    later = reactions(one, replace(two, at_s=0.75))
    assert np.array_equal(later[1], reactions(one)[1])
    assert not np.array_equal(later[2], later[1])


# at the edge of a mode

HELD = Prescription(0, (BarTurn(0.0, 60.0, 0.0),), frame="local_horizontal", reacts_on=None)


@pytest.mark.parametrize("law", [(HELD,), (replace(HELD, frame="inertial"),), ()])
def test_a_bar_that_lies_edge_on_to_the_wind_gets_through_and_does_not_chatter(
    law: tuple[Prescription, ...], watch: Watch
) -> None:
    """Along a circular orbit the face's sign is a matter of rounding, in which nothing may be searched."""
    r = RADIUS + 250e3
    v = math.sqrt(MU / r)
    one = np.ones(1)
    air = DragEffect(6e-11, r, 45e3, 0.0, one, 2.2, 1.8)
    model = ChainModel(MU, 100.0 * one, 10.0 * one, 1e4 / 12.0 * one, "gradient", prescriptions=law, effects=(air,))
    rate = 0.0 if law and law[0].frame == "inertial" else v / r
    state = placed(model, r, v, np.array([np.pi / 2.0]), np.array([rate]))
    seen, fine = (started(model, state, rtol=rtol).integrate(np.array([0.0, 1000.0])) for rtol in (1e-8, 1e-13))
    assert seen.t_s[-1] == 1000.0
    assert seen.steps < 100
    assert all(start <= end for start, end in watch.steps)
    assert np.abs(seen.y[-1, :2] - fine.y[-1, :2]).max() < 7e6 * 1e-8 * seen.steps


def test_a_bar_that_points_at_the_sun_gets_through() -> None:
    one = np.ones(1)
    light = SolarPressureEffect(1e-3, 0.3, 0.0, one, 0.5, 0.0)
    model = ChainModel(MU, 100.0 * one, 100.0 * one, 1e6 / 12.0 * one, "none", effects=(light,))
    h = ran(model, placed(model, 7e6, 0.0, np.array([0.3]), np.zeros(1)), np.linspace(0.0, 1000.0, 3))
    assert h.steps < 100
