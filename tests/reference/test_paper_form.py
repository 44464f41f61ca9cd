"""The paper's own form: equal to the production form, equal to an independent derivation, misprints as told.

A block (all reactions, all angular accelerations, ...) is compared relative to its scale: the larger of
its own largest magnitude and of what goes into it, tide and centrifugal terms of size (n² + rate²) l. A
reaction may cancel to nothing while the terms it is made of do not, and round-off is of these terms' size.

A joint motor's effect on its bar's angle can pass through zero (it turns the neighbour too, and the joint
pulls back); near there the torque, and all round-off with it, grows like 1/`grip`.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference_impl.model import relative
from reference_impl.model.chain import ChainModel
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import Accelerations
from reference_impl.paper.form import NotSquareError, paper_accelerations, solve
from reference_impl.paper.misprint_effects import generic_model, generic_state, misprint_effects
from reference_impl.paper.misprints import ERRATA, Misprint
from reference_impl.paper.state import units_of
from tests.reference.paper_chains import AGREEMENT, LAWS, MU, RADIUS, chain, disagreement, grip
from tests.support.arbiter import judge
from tests.support.slow import one_in


@pytest.mark.parametrize("laws", LAWS)
@pytest.mark.parametrize("equal", [True, False], ids=["equal", "unequal"])
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), bars=st.integers(1, 12))
def test_paper_form_equals_the_production_form(equal: bool, laws: str, seed: int, bars: int) -> None:
    model, state = chain(seed, bars, equal=equal, laws=laws)
    paper, production = paper_accelerations(model, 25.0, state), relative.accelerations(model, 25.0, state)
    assert disagreement(model, state, paper, production) < AGREEMENT / grip(model, state)


@pytest.mark.parametrize("laws", one_in(2, LAWS))
@pytest.mark.parametrize("bars", [1, 2, 5, 8])
@pytest.mark.parametrize("form", [paper_accelerations, relative.accelerations], ids=["paper", "production"])
def test_both_forms_equal_an_independent_derivation_in_fifty_digits(form, bars: int, laws: str) -> None:
    for equal in (True, False):
        model, state = chain(17 + bars, bars, equal=equal, laws=laws)
        verdict = judge(model, 25.0, state)
        found = form(model, 25.0, state)
        judged = Accelerations(
            model.weight @ verdict.place_m_s2,
            verdict.angle_rad_s2,
            verdict.relative_m_s2,
            verdict.reaction_N,
            verdict.torque_N_m,
        )
        assert disagreement(model, state, found, judged) < AGREEMENT / grip(model, state)


def test_gravity_torque_is_that_of_a_bar_cut_into_pieces() -> None:
    """The sign and size of (17): a short bar's pieces by Gauss's rule, within the O((l/r)²) left out."""
    place, length, mass = np.array([RADIUS * 1.1, RADIUS * 0.3]), 1e4, 100.0
    nodes, weights = np.polynomial.legendre.leggauss(8)
    for angle in np.linspace(0.1, 6.0, 7):
        along = np.array([np.cos(angle), np.sin(angle)])
        pieces = place + 0.5 * length * nodes[:, None] * along
        pull = -MU * pieces / np.linalg.norm(pieces, axis=1)[:, None] ** 3 * (0.5 * mass * weights)[:, None]
        arm = 0.5 * length * nodes[:, None] * along
        torque = np.sum(arm[:, 0] * pull[:, 1] - arm[:, 1] * pull[:, 0])
        model = ChainModel(
            MU, np.array([mass]), np.array([length]), np.array([mass * length**2 / 12]), "gradient", RADIUS
        )
        state = consistent_state(model, place, np.zeros(2), np.array([angle]), np.zeros(1))
        size = 3.0 * MU / np.linalg.norm(place) ** 3 * model.inertia_kg_m2[0]
        found = paper_accelerations(model, 0.0, state).angle_rad_s2[0] * model.inertia_kg_m2[0]
        # the next term of the field's series: at most a few times (l/r)², 2e-6 here
        assert abs(found - torque) < 5.0 * (length / np.linalg.norm(place)) ** 2 * size


def change(misprint: Misprint, model: ChainModel) -> tuple[float, float, float]:
    """Relative change of reactions, phi'' and theta'' of the generic state."""
    state = generic_state(model)
    units = units_of(model, state.com_m)
    right, wrong = (solve(model, 0.0, state, units, s) for s in (frozenset(), frozenset({misprint})))
    return tuple(
        float(np.abs(a - b).max() / np.abs(b).max())
        for a, b in (
            (wrong.reaction, right.reaction),
            (wrong.bars[:, 2], right.bars[:, 2]),
            (wrong.theta_acceleration, right.theta_acceleration),
        )
    )


@pytest.mark.parametrize("row", misprint_effects(), ids=lambda row: row.id)
def test_each_misprint_does_what_the_table_says(row) -> None:
    entry = ERRATA[Misprint(row.id)]
    if entry.expected is None:
        assert row.effect_on_reactions is None
        assert row.effect_on_angular_acceleration is None
    elif entry.expected == 0.0:
        assert row.effect_on_reactions < AGREEMENT
        assert row.effect_on_angular_acceleration > 1e7 * AGREEMENT
    else:  # the same order of magnitude: half a decade either side
        assert abs(np.log10(row.effect_on_reactions / entry.expected)) < 0.5
        assert row.effect_on_angular_acceleration > row.effect_on_reactions / 10.0
    assert row.note.startswith(entry.effect)


def test_beta_changes_the_local_angle_and_not_the_inertial_one() -> None:
    reactions, local, inertial = change(Misprint.BETA_DENOMINATOR, generic_model())
    assert reactions < AGREEMENT
    assert inertial < AGREEMENT
    assert local > 1e-7


def test_w_third_row_is_of_first_order_in_the_size_ratio() -> None:
    large, small = (change(Misprint.W_THIRD_ROW, generic_model((length,) * 5))[0] for length in (1000.0, 100.0))
    assert large / small == pytest.approx(10.0, rel=1e-2)  # next order: l/r = 1e-4 times the chain's length in bars


def test_s2_sign_needs_an_orbit_that_climbs() -> None:
    model = generic_model()
    state = generic_state(model)
    radial = state.com_m / np.linalg.norm(state.com_m)
    level = replace(state, com_velocity_m_s=state.com_velocity_m_s - (state.com_velocity_m_s @ radial) * radial)
    wrong = paper_accelerations(model, 0.0, level, {Misprint.S2_SIGN})
    right = paper_accelerations(model, 0.0, level)
    # gamma is left with the bars' own radial velocities: of the order of the size ratio, 1e-5
    assert disagreement(model, level, wrong, right) < 1e-3


def test_equation_27_as_printed_says_that_it_is_not_square() -> None:
    model, state = chain(5, 5, equal=True, laws="local, external")
    with pytest.raises(NotSquareError, match=r"9 equations .* for 25 unknowns"):
        paper_accelerations(model, 0.0, state, {Misprint.CONTROL_IDENTITY})


def test_other_gravity_is_refused() -> None:
    model, state = chain(6, 3, equal=True, laws="none")
    with pytest.raises(ValueError, match='"gradient" only, not "point"'):
        paper_accelerations(replace(model, gravity="point"), 0.0, state)
