"""The formulations in any arithmetic: exact numbers are exact, and doubles agree with the reference's own code."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from barchain.studies.roundoff.formulations import FORMULATIONS, EvaluationCase, StateKind, exact_case
from reference_impl.model import absolute as plain_absolute
from reference_impl.model import relative as plain_relative
from reference_impl.precision import steppers
from reference_impl.precision.arithmetic import EXACT, FLOAT32, FLOAT64, LONG, exact_numbers
from reference_impl.precision.chain import ChainParameters, RelativeState
from reference_impl.precision.formulations import absolute, relative
from tests.support.joint_roundoff import case, forward, joint_bound

TINY = 1e-12


def gap_between(found, answer):
    """Largest difference over the largest value."""
    return float(abs(found - answer).max() / abs(answer).max())


@pytest.mark.parametrize("kind", StateKind)
@pytest.mark.parametrize("bars", [2, 50])
def test_exact_answers_have_50_digits_where_absolute_coordinates_lose_most(kind, bars):
    """Two formulas, one of which loses 36 digits on the horizontal chain of this size, agree to 50."""
    with exact_numbers():
        exact = exact_case(EvaluationCase(kind, bars, TINY, 1))
        by_relative = relative(EXACT, exact.bars, exact.state)
        by_absolute = absolute(EXACT, exact.bars, exact.state.absolute)
        assert gap_between(by_absolute.reaction_N, by_relative.reaction_N) < 1e-50
        assert gap_between(by_absolute.angle_rad_s2, by_relative.angle_rad_s2) < 1e-50
        assert gap_between(by_absolute.com_m_s2, by_relative.com_m_s2) < 1e-100


def columns(c):
    """Chain and state of a random case, as one column."""
    m, s = c.model, c.state
    one = lambda v: np.asarray(v, float)[..., None]  # noqa: E731
    bars = ChainParameters(np.array([m.mu_m3_s2]), one(m.mass_kg), one(m.length_m), one(m.inertia_kg_m2))
    return bars, RelativeState(one(s.com_m), one(s.position_m.T), one(s.angle_rad), one(s.rate_rad_s))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), bars=st.integers(2, 9), decades=st.floats(0.0, 3.0))
def test_in_doubles_the_relative_formulation_is_the_references(seed, bars, decades):
    """Both are backward stable solutions of the same system: apart by twice what round-off opens a joint."""
    c = case(seed, bars, "gradient", decades)
    found, plain = relative(FLOAT64, *columns(c)), plain_relative.accelerations(c.model, 0.0, c.state)
    apart = np.linalg.norm(found.reaction_N[..., 0].T - plain.reaction_N, axis=1)
    assert (apart <= forward(c, 2.0 * joint_bound(c, plain))).all()


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), bars=st.integers(2, 9))
def test_in_doubles_the_absolute_formulation_is_the_references_absolute_one(seed, bars):
    """The same within the round-off of a place, u r times n², that both have."""
    c = case(seed, bars, "gradient", 1.0)
    chain, state = columns(c)
    found = absolute(FLOAT64, chain, state.absolute).reaction_N[..., 0].T
    s = c.state
    plain = plain_absolute.accelerations(
        c.model, 0.0, s.com_m + s.position_m, s.com_velocity_m_s + s.velocity_m_s, s.angle_rad, s.rate_rad_s
    )
    radius = np.linalg.norm(s.com_m)
    floor = 32.0 * 2.0**-53 * c.model.mu_m3_s2 / radius**2 * np.ones(bars - 1)
    assert (np.linalg.norm(found - plain.reaction_N, axis=1) <= forward(c, floor + joint_bound(c, plain))).all()


def test_every_arithmetic_stays_itself_from_input_to_answer():
    with exact_numbers():
        exact = exact_case(EvaluationCase(StateKind.GENERIC, 4, 1e-5, 2))
        for a in (FLOAT32, FLOAT64, LONG):
            for formulation in FORMULATIONS.values():
                answer = formulation.reactions(a, formulation.given(exact, a).cast(a))
                assert answer.dtype == a.dtype, (a.name, formulation.name)


def test_long_doubles_survive_the_way_through_exact_numbers():
    value = np.array([1.0, -3.0, 1e30], np.longdouble) / 3
    with exact_numbers():
        assert (LONG.cast(EXACT.cast(value)) == value).all()


def oscillator(y):
    """y'' = -y in the arithmetic of `y`."""
    return np.concatenate([y[1:], -y[:1]])


@pytest.mark.parametrize(
    ("step", "order", "counts"),
    [
        (steppers.rk4, 4, (20, 40, 80)),
        (steppers.DormandPrince(LONG), 8, (6, 12, 24)),
        (lambda f, y, h: steppers.extrapolated(f, y, h, (2, 4, 6)), 6, (8, 16, 32)),
    ],
)
def test_steppers_have_their_order(step, order, counts):
    def error(steps):
        y = np.array([[1.0], [0.0]], np.longdouble)
        for _ in range(steps):
            y = step(oscillator, y, np.longdouble(3.0) / steps)
        return float(np.hypot(y[0, 0] - np.cos(np.longdouble(3.0)), y[1, 0] + np.sin(np.longdouble(3.0))))

    errors = [error(n) for n in counts]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[-1] == pytest.approx(order, abs=0.15)


def test_own_steps_are_scipys():
    """Column for column what SciPy's DOP853 takes: errors of the same size, at about the same evaluations."""
    start, stretch = np.array([[1.0, 1.0], [0.0, 0.5]]), np.array([20.0, 20.0])
    allowed = np.array([[1e-9, 1e-6], [1e-9, 1e-6]])
    zero = np.zeros(2, int)
    at = steppers.advance_adaptively(
        FLOAT64, oscillator, steppers.AdaptiveRuns(start, 0.1 * np.ones(2), zero, zero > 0), stretch, allowed
    )
    for k, tolerance in enumerate((1e-9, 1e-6)):
        theirs = solve_ivp(lambda _, y: oscillator(y), (0.0, 20.0), start[:, k], "DOP853", rtol=3e-14, atol=tolerance)
        exact = start[0, k] * np.cos(20.0) + start[1, k] * np.sin(20.0)
        ours = abs(at.y[0, k] - exact)
        assert 0.1 < ours / abs(theirs.y[0, -1] - exact) < 10.0
        assert at.evaluations[k] == pytest.approx(theirs.nfev, rel=0.3)


def test_a_run_that_never_ends_is_given_up_and_the_others_go_on(monkeypatch):
    monkeypatch.setattr(steppers, "LARGEST_STEP_COUNT", 50)
    start, zero = np.ones((2, 2)), np.zeros(2, int)
    allowed = np.array([[1e-3, 1e-30], [1e-3, 1e-30]])
    runs = steppers.AdaptiveRuns(start, 0.1 * np.ones(2), zero, zero > 0)
    at = steppers.advance_adaptively(FLOAT64, oscillator, runs, np.ones(2), allowed)
    assert at.abandoned.tolist() == [False, True]
    assert np.isfinite(at.y[:, 0]).all()
    assert np.isnan(at.y[:, 1]).all()
