"""Enclosures: closed forms inside their balls, mistakes outside, and the proofs beside certified solutions."""

from __future__ import annotations

import dataclasses

import mpmath
import numpy as np
import pytest

from adapters.trajectory import to_frame
from barchain.metrics.quantities import TRACK, components
from barchain.result_files.judging import judge_files
from barchain.solutions.certified_file import columns_of, head_of, motion_of, read_file, shipped_path, write_frame
from barchain.solutions.proof import (
    DIGITS,
    UNKNOWNS,
    ExcludedError,
    at_most,
    attach,
    balls_of,
    by_quantity,
    check_proof,
    exactly,
    proof_of,
    prove,
    state_of,
)
from scenarios import load_scene, make_scene, scene_names

flint = pytest.importorskip("flint", reason="python-flint is not installed: nothing can be enclosed")

from barchain.solutions.enclosure.forces import number  # noqa: E402
from barchain.solutions.enclosure.run import Effort, NotEnclosedError, enclose, order_for  # noqa: E402
from barchain.solutions.enclosure.start import start_balls  # noqa: E402

QUICK = "conform/one_bar_gradient"
BITS = 160
PROVEN = [name for name in scene_names() if (path := shipped_path(name)).is_file() and "proof" in head_of(path)]


def enclosed(scene, times_s, start, bits=BITS, **options):
    """Balls of a scene at some instants."""
    flint.ctx.prec = bits
    return list(enclose(scene, times_s, start, Effort(bits, order_for(bits)), **options))


def narrow(ball, size):
    """Whether a ball is so narrow that a test of what it contains means something."""
    return ball.rad() < 1e-30 * size


def test_a_circular_orbit_of_rational_rate_stays_inside():
    """mu = r v² in numbers that double precision holds."""
    scene = make_scene(
        {
            "title": "circle", "source": "closed form", "central_body": {"mu_m3_s2": 4e14, "radius_m": 6e6},
            "orbit": {"altitude_m": 250e3}, "effects": {"gravity": "point"},
            "run": {"duration_s": 3000.0, "samples": 3},
            "chain": {"bars": 1, "mass_kg": 100.0, "length_m": 1.0, "angle_deg": 0.0},
        }
    )  # fmt: skip
    radius, speed = 6.25e6, 8000.0
    start = [number(x) for x in (radius, 0.0, 0.0, speed, 0.5, 0.25)]
    for found in enclosed(scene, [0.0, 1500.0, 3000.0], start):
        turned = number(found.t_s) * number(speed) / number(radius)
        x, y, angle = found.state[0], found.state[1], found.state[4]
        assert x.contains((turned.cos() * number(radius)).mid())
        assert y.contains((turned.sin() * number(radius)).mid())
        assert angle.contains((number(0.5) + number(0.25) * number(found.t_s)).mid())
        assert narrow(x, radius)


def test_a_straight_chain_that_spins_freely_has_its_centrifugal_tension():
    scene = load_scene("basics/free_rotation")
    flint.ctx.prec = BITS
    start = start_balls(scene)
    angle, rate = start[4].mid(), start[9].mid()
    start[4:9], start[9:14] = [angle] * 5, [rate] * 5
    (found,) = enclosed(scene, [2000.0], start)
    turned = angle + rate * 2000
    for j, moment in enumerate((200, 300, 300, 200)):  # sum of the places beyond the joint, in lengths of 100 m
        tension = rate * rate * 100 * moment
        assert found.reaction[2 * j].contains((tension * turned.cos()).mid())
        assert found.reaction[2 * j + 1].contains((tension * turned.sin()).mid())
    assert narrow(found.reaction[0], 1.0)


def test_a_law_that_is_far_quicker_than_the_orbit_turns_its_bar_by_its_amplitude():
    """Sines of the law grow exponentially on wide circles, where they bound nothing."""
    scene = load_scene("conform/one_bar_law")
    (turn,) = scene.effects.prescribed_rotation[0].turns
    head, frame = read_file(shipped_path(scene.name))
    row = frame[head["dense"] :].query("t_s < @turn.start_s").tail(1)
    start = state_of(exactly(components(motion_of(row, head), UNKNOWNS)), 0)
    times = [turn.start_s, turn.end_s]
    before, after = (found.state for found in enclosed(scene, times, start, start_s=float(row["t_s"].iloc[0])))
    x, y, vx, vy, angle, rate = before
    gained = (rate - (x * vy - y * vx) / (x * x + y * y)) * number(turn.duration_s)  # on the local horizontal
    longitude = flint.arb.atan2(after[1], after[0]) - flint.arb.atan2(y, x)
    assert (after[4] - angle).overlaps(longitude + gained + number(turn.amplitude_rad))
    assert narrow(after[4], 1.0)


def test_a_wrong_sign_of_gravitys_torque_is_excluded_at_once():
    scene = load_scene("conform/three_bars_gradient")
    head, frame = read_file(shipped_path(scene.name))
    first = frame[head["dense"] :][:2]
    right, wrong = (prove(scene, motion_of(first, head), gradient_sign=sign) for sign in (1, -1))
    for quantity, error in columns_of(first, "error_").items():
        assert np.all(right.proven[quantity] <= error)
        if quantity not in TRACK:
            assert wrong.proven[quantity][1] > 1e6 * error[1]
    assert wrong.proven["reaction"][0] > 1e6 * columns_of(first, "error_")["reaction"][0]


@pytest.mark.parametrize("relative", [0.0, 1e-25])
def test_an_error_of_1e_25_in_a_certified_value_is_excluded(relative):
    """A fresh enclosure, with other bits, against the digits in the file."""
    scene = load_scene(QUICK)
    values, proof = proof_of(shipped_path(QUICK))
    flint.ctx.prec = 300
    stored = balls_of(values, proof)
    (found,) = enclosed(scene, [float(values.t_s[1])], state_of(stored, 0), bits=300)
    for quantity, fresh in by_quantity(found, scene.bars).items():
        planted = stored[quantity][1] * (1 + flint.arb(relative)) if quantity in stored else []
        assert [x.overlaps(y) for x, y in zip(np.ravel(planted), fresh.ravel(), strict=True)] == [
            not relative
        ] * fresh.size


@pytest.mark.parametrize(
    ("column", "row", "factor"),
    [
        ("low_angle_1_rad", -1, None),
        ("radius_attitude", -6, 1e12),
        ("proven_attitude", -3, 0.01),
        ("proven_rate", 3, 1e3),
        ("relative", 0, 1e-20),
    ],
)
def test_a_bound_that_was_changed_in_a_file_and_an_error_of_1e_25_are_told(column, row, factor, tmp_path):
    head, frame = read_file(shipped_path(QUICK))
    assert check_proof(load_scene(QUICK), shipped_path(QUICK)) == ""
    at = frame.index[row]
    if column == "relative":
        head["proof"]["relative"] *= factor
    elif factor is None:
        frame.loc[at, column] += 1e-25 * frame.loc[at, "angle_1_rad"]
    else:
        frame.loc[at, column] *= factor
    write_frame(tmp_path / "planted.parquet", head, frame)
    assert check_proof(load_scene(QUICK), tmp_path / "planted.parquet")


def test_a_chain_at_rest_is_exact_at_the_start():
    scene = load_scene("published/pendulum")
    start = start_balls(scene)
    flint.ctx.prec = BITS
    rows = enclose(scene, [0.0, 0.0, 1.0], start, Effort(BITS, order_for(BITS)))
    for row in (next(rows), next(rows)):
        assert [x.mid() for x in row.state] == [x.mid() for x in start]
        assert all(x.rad() == 0 for x in row.state[2:4])


def test_a_bound_is_rounded_up():
    assert at_most(1.37e-28) == "2e-28"


def test_an_error_of_ten_roundings_in_a_certified_value_is_excluded(tmp_path):
    head, frame = read_file(shipped_path(QUICK))
    frame.loc[3, "rate_1_rad_s"] *= 1.0 + 10.0 * 2.0**-53
    path = tmp_path / "planted.parquet"
    write_frame(path, head, frame)
    with pytest.raises(ExcludedError, match="the rate at"):
        attach(path, load_scene(QUICK), tmp_path)


def test_every_certified_value_is_nearer_the_exact_one_than_its_error_bar():
    for name in PROVEN:
        head, frame = read_file(shipped_path(name))
        proven, error = columns_of(frame, "proven_"), columns_of(frame, "error_")
        assert proven.keys() == error.keys(), name
        for quantity, allowed in error.items():
            seen = ~np.isnan(allowed)
            assert np.array_equal(seen, ~np.isnan(proven[quantity])), name
            assert np.all(proven[quantity][seen] <= allowed[seen]), name
        assert head["proof"]["relative"] < DIGITS, name


def test_another_method_of_another_order_finds_the_same_digits():
    """Newton's and Euler's laws with the joint's force, by extrapolated midpoint steps in 40 digits of mpmath."""
    scene = load_scene("conform/two_bars_free")
    values, proof = proof_of(shipped_path(scene.name))
    with mpmath.workdps(40):
        chain = scene.chain
        mass, half, inertia = (
            np.array([mpmath.mpf(x) for x in each]) for each in (chain.mass_kg, chain.length_m, chain.inertia_kg_m2)
        )
        half = half / 2

        def slopes(y):
            u = [np.array([mpmath.cos(a), mpmath.sin(a)]) for a in y[:2]]
            n = [np.array([-s, c]) for c, s in u]
            gap = sum(h * w * w * a for h, w, a in zip(half, y[2:], u, strict=True))
            matrix = sum(h * h / j * np.outer(a, a) for h, j, a in zip(half, inertia, n, strict=True))
            matrix = matrix + np.eye(2, dtype=int) * sum(1 / mass)
            force = np.array(list(mpmath.lu_solve(mpmath.matrix(matrix.tolist()), mpmath.matrix(gap.tolist()))))
            return np.array([*y[2:], *(h / j * (a @ force) for h, j, a in zip(half, inertia, n, strict=True))])

        y = np.array([mpmath.mpf(float(x)) for x in [*values.angle_rad[0], *values.rate_rad_s[0]]])
        for _ in range(STEPS):
            y = extrapolated(slopes, y, mpmath.mpf(float(values.t_s[1])) / STEPS)
        for name, part in (("angle_rad", y[:2]), ("rate_rad_s", y[2:])):
            high, low = (getattr(x, name)[1] for x in (values, proof.low))
            for found, a, b in zip(part, high, low, strict=True):
                assert abs(found - mpmath.mpf(float(a)) - mpmath.mpf(float(b))) < 1e-29 * abs(found)


STEPS, LEVELS = 4, 15


def extrapolated(slopes, y, step):
    """A step of order 30: midpoint rules of 2, 4, ... 30 parts (Gragg, Bulirsch, Stoer)."""
    rows = []
    for k in range(1, LEVELS + 1):
        before, h = y, step / (2 * k)
        now = y + h * slopes(y)
        for _ in range(2 * k - 1):
            before, now = now, before + 2 * h * slopes(now)
        row = [(before + now + h * slopes(now)) / 2]
        for j, last in enumerate(rows[-1] if rows else [], start=1):
            ratio = mpmath.mpf(k) / (k - j)
            row.append(row[-1] + (row[-1] - last) / (ratio * ratio - 1))
        rows.append(row)
    return rows[-1][-1]


def test_a_start_that_is_not_the_scenes_is_rejected():
    scene = load_scene(QUICK)
    values, _ = proof_of(shipped_path(QUICK))
    other = dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, speed_factor=1.0 + 1e-14))
    prove(scene, values.samples(slice(0, 2)))
    with pytest.raises(ExcludedError, match="com_velocity at the start"):
        prove(other, values.samples(slice(0, 2)))


def test_a_motion_with_events_is_left_out_with_the_reason():
    scene = load_scene("effects/solar_shadow")
    with pytest.raises(NotEnclosedError, match="shadow"):
        enclosed(scene, [10.0], start_balls(scene))


def test_judging_a_file_says_how_far_the_solution_is_proven(tmp_path):
    head, frame = read_file(shipped_path(QUICK))
    path = tmp_path / "run.csv"
    to_frame(motion_of(frame[: head["samples"]], head)).to_csv(path, index=False)
    found = judge_files(QUICK, path, time_limit_s=60.0)
    assert [note for note in found.notes if "proven to" in note]
