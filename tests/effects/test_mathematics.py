"""Formulas in the report read as people write them."""

import pytest

from reports.text.words import AS_NONE, effect, written


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("-3 sin(phi) cos(phi)/rho^3", "−3 sin(φ) cos(φ)/ρ³"),
        ("|theta^(p+1)| G(t)/G(s)", "|θ⁽ᵖ⁺¹⁾| G(t)/G(s)"),
        ("some 5e4 times, 1e8 times", "some 5×10⁴ times, 10⁸ times"),
        ("phi'' + omega'', beta_j", "φ″ + ω″, β_j"),
        ("sqrt(3) n, 12 pi r (l/r)^2", "√3 n, 12 π r (l/r)²"),
        ("generalized-alpha, rtol = 1e-13, Figs. 5-8, mean", "generalized-alpha, rtol = 1e-13, Figs. 5-8, mean"),
    ],
)
def test_ascii_formulas_are_set_and_words_are_left(typed, shown):
    assert written(typed) == shown


def test_an_effect_that_is_none_but_for_rounding_is_said_to_be_none():
    assert effect(2.8e-16) == effect(0.0) == AS_NONE
    assert effect(9e-6) == "9.00×10⁻⁶"
    assert effect(None) == ""
