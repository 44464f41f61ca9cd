"""Each effect's push against fifty digits, from its potential or its elements along a bar: at round-off at any size.

Bounds are derived in `effect_sizes`. All but drag's, sunlight's and a thrust's differences between bars shrink with
the bars, so that a bound met by bars of a millimetre says that no digit is lost with size.
"""

import inspect
import sys
from dataclasses import fields, replace
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference_impl.effects import oblateness, quadrupole, second_moment, slender, third_body
from reference_impl.model.chain import ChainModel
from reference_impl.model.effect import ChainEffect, EffectAccelerations
from reference_impl.model.state import State
from tests.effects.effect_judge import EffectVerdict, energy, judge
from tests.effects.effect_sizes import EffectSizes, sizes
from tests.support.effect_cases import (
    KINDS,
    T_S,
    chain,
    distance_m,
    motion,
    reach_m,
    seen,
    seen_whole,
    springs,
)
from tests.support.joint_roundoff import C, Case, U

LENGTHS_M = [1e-3, 1e-1, 1e1, 1e3, 1e5]
SEEDS = st.integers(0, 2**32 - 1)
CENTRAL = ["slender", "quadrupole", "oblateness", "oblateness, turning", "oblateness, second moment"]
FIELDS = [*CENTRAL, "third body", "third body, turning", "third body, second moment"]


def looked_at(kind: str, seed: int, length_m: float, bars: int = 3):
    """A chain, an effect and a state."""
    random = np.random.default_rng(seed)
    model = chain(random, bars, length_m)
    return model, KINDS[kind](random, model), motion(random, model)


def sizes_of(effect: ChainEffect, model: ChainModel, state: State) -> EffectSizes:
    return sizes(Case(replace(model, effects=(effect,)), state), T_S)


def excess(push: EffectAccelerations, right: EffectVerdict, size: EffectSizes, weight: np.ndarray) -> dict[str, float]:
    """Errors in units of what round-off allows; no mean is taken of the whole, which saves its four roundings."""
    apart = push.difference - push.difference @ weight
    errors = {
        "whole": (push.common + push.difference - right.whole, (C - 4.0) * whole(size)),
        "apart": (apart - right.apart, C * size.acceleration.max()),
        "spin": (push.angular - right.spin, C * size.spin.max()),
    }
    return {k: float(np.abs(e).max()) / (U * s) if s else float(np.abs(e).max()) for k, (e, s) in errors.items()}


def whole(size: EffectSizes) -> float:
    """Of one bar's acceleration."""
    return size.common + float(size.acceleration.max())


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=8, deadline=None)
@given(seed=SEEDS, length_m=st.sampled_from(LENGTHS_M))
def test_an_effect_is_right_to_round_off_at_any_size(kind: str, seed: int, length_m: float) -> None:
    """The whole acceleration, the differences between bars and the turning, each to its own size's round-off.

    Absolute coordinates give the same to the round-off of the whole: of differences between bars they lose u r/l.
    """
    model, effect, state = looked_at(kind, seed, length_m)
    right, size = judge(effect, model, state, T_S), sizes_of(effect, model, state)
    found = excess(effect.accelerations(seen(model, state), None), right, size, model.weight)
    assert max(found.values()) <= 1.0, found
    push = effect.accelerations(seen_whole(model, state), None)
    assert push.common == 0.0
    twice = 2.0 * (C - 4.0) / C  # a mean beside the whole: both rounded
    coarse = EffectSizes(np.full(model.bars, twice * whole(size)), 2.0 * size.spin, 0.0)
    assert max(excess(push, right, coarse, model.weight).values()) <= 1.0


@pytest.mark.parametrize("kind", FIELDS)
def test_differences_have_the_same_digits_at_every_length(kind: str) -> None:
    """One attitude, bars from a millimetre to a hundred kilometres: the relative error stays at its few u."""
    for length in LENGTHS_M[::2]:
        model, effect, state = looked_at(kind, 0, length)
        right = judge(effect, model, state, T_S)
        push = effect.accelerations(seen(model, state), None)
        error = np.abs(push.difference - push.difference @ model.weight - right.apart).max()
        assert error <= (C + 16.0) * U * np.abs(right.apart).max(), length


def test_the_slender_bar_tends_to_the_quadrupole_as_the_square_of_its_size() -> None:
    """Force: next order e = (l/2r)² of it; torque as well: the exact one less the gradient's."""
    off = []
    for length in (1e4, 1e5):
        model, exact, state = looked_at("slender", 3, length)
        at, e = seen(model, state), float((model.half_m / distance_m(state)).max()) ** 2
        full, first = exact.accelerations(at, None), quadrupole.QuadrupoleEffect().accelerations(at, None)
        spin = second_moment.angular_accelerations(model.mu_m3_s2, at.position_from_body, at.unit)
        off.append(
            [
                np.abs(full.difference - first.difference).max() / np.abs(first.difference).max() / e,
                np.abs(full.angular - spin).max() / np.abs(spin).max() / e,
            ]
        )
    assert np.all(np.array(off) < 10.0)  # the next multipole's coefficients: 35/3 at most of the last one's
    np.testing.assert_allclose(off[0], off[1], rtol=0.1)


# potentials


@pytest.mark.parametrize("kind", [k for k in CENTRAL if k != "oblateness, turning"])
@settings(max_examples=8, deadline=None)
@given(seed=SEEDS, length_m=st.sampled_from(LENGTHS_M))
def test_the_energy_is_that_of_the_potential_whose_gradient_the_push_is(kind: str, seed: int, length_m: float) -> None:
    """The judge differences the same potential for the forces and torques above."""
    model, effect, state = looked_at(kind, seed, length_m)
    found = effect.energy(model, state.com_m[None], state.angle_rad[None])[0]
    lowest = distance_m(state) - reach_m(state)
    if kind.startswith("oblateness"):
        size = abs(effect.strength_m5_s2) / lowest**3 * model.mass_kg.sum()
    else:
        size = 2.0 * model.mu_m3_s2 / lowest**3 * model.inertia_kg_m2.sum()
    assert abs(found - energy(effect, model, state)) <= C * U * size


def test_springs_turn_down_the_slope_of_their_energy() -> None:
    """A parabola's central difference is its slope: rounding over the step is all that is left."""
    random = np.random.default_rng(2)
    model = chain(random, 4, 10.0)
    effect, state = springs(random, model, damped=False), motion(random, model)
    turn, step = effect.accelerations(seen(model, state), None).angular * model.inertia_kg_m2, 0.5
    for j in range(model.bars):
        moved = np.repeat(state.angle_rad[None], 2, axis=0)
        moved[:, j] += [step, -step]
        up, down = effect.energy(model, np.zeros((2, 2)), moved)
        assert abs((up - down) / (2.0 * step) + turn[j]) <= C * U * (up + down) / step


# faults


FAULTS = {
    "slender: the closed form less a point mass's pull": (
        slender,
        "        pull = strength * (seen.real * radial + 1j * (seen.imag * across)) * at.unit\n",
        "        place = at.position_from_body\n"
        "        one, two = np.abs(place - m.half_m * at.unit), np.abs(place + m.half_m * at.unit)\n"
        "        both = one + two\n"
        "        bar = seen.real / both + 1j * seen.imag * both / (both**2 - m.length_m**2)\n"
        "        pull = strength * place - 2.0 * m.mu_m3_s2 / (one * two) * bar * at.unit\n",
    ),
    "slender: a root less one": (slender, "delta = x / (1.0 + np.sqrt(1.0 + x))", "delta = np.sqrt(1.0 + x) - 1.0"),
    "oblateness: two places' fields": (
        oblateness,
        "return strength * z, strength * (d * (1.0 + change) + z * change)",
        "place = at.position_from_body\n"
        "        return strength * z, -3.0 * self.strength_m5_s2 * place / abs(place) ** 5 - strength * z",
    ),
    "third body: two places' tides": (
        third_body,
        "difference = complex_field_differences(self.mu_m3_s2, np.asarray(at.com - body), at.position)",
        "difference = self.tide(body, at.position_from_body) - common",
    ),
}
"""Subtractions of nearly equal numbers, put back where the effects avoid them"""


@pytest.mark.parametrize("what", FAULTS)
def test_a_cancelling_subtraction_put_back_into_an_effect_is_seen(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    module, old, new = FAULTS[what]
    kind = what.split(":", maxsplit=1)[0]
    model, effect, state = looked_at(kind, 1, 1e-1)
    right, size = judge(effect, model, state, T_S), sizes_of(effect, model, state)
    sound = excess(effect.accelerations(seen(model, state), None), right, size, model.weight)
    wrong = faulty(module, effect, old, new, monkeypatch)
    found = excess(wrong.accelerations(seen(model, state), None), right, size, model.weight)
    assert max(sound.values()) <= 1.0
    assert max(found.values()) > 10.0, found


def faulty(module: ModuleType, effect: ChainEffect, old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> ChainEffect:
    """The effect, by its module's text with a change in it."""
    source = inspect.getsource(module)
    assert source.count(old) == 1, "the line that this fault replaces is not there any more"
    changed = ModuleType("faulty_effect")
    monkeypatch.setitem(sys.modules, changed.__name__, changed)
    exec(compile(source.replace(old, new), "faulty_effect.py", "exec"), changed.__dict__)
    made: ChainEffect = getattr(changed, type(effect).__name__)(
        **{f.name: getattr(effect, f.name) for f in fields(effect)}
    )
    return made
