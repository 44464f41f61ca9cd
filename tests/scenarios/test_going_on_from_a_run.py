"""A run goes on where another one ended: from its file, or from its state in Python."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.trajectory import Trajectory
from barchain import latched
from barchain.cli.simulate import in_degrees
from barchain.drawing import with_channel
from barchain.metrics.derived import DerivedError, chosen_columns
from barchain.result_files.drawn_runs import read_run_table
from reference_impl.model.invariants import relative_angular_momentum, relative_kinetic_energy
from reports.motion.charts import Run
from scenarios import Scene, SceneError, change_scene, go_on, load_scene, make_scene
from scenarios.toml.start_table import OWN
from scenarios.toml.writing import scene_data, toml
from tests.support import solutions

EPS = float(np.finfo(float).eps)
RTOL = 1e-12
HALF_S = 1500.0
SCENE = make_scene({
    "title": "t", "source": "s", "orbit": {"altitude_m": 600e3, "speed_factor": 1.1, "longitude_deg": 20.0},
    "chain": {"bars": 3, "mass_kg": [80.0, 60.0, 40.0], "length_m": 50.0, "angle_deg": [80.0, 82.0, 79.0]},
    "effects": {
        "third_body": [{"body": "moon", "longitude_deg": 10.0}],
        "solar_pressure": {"width_m": 1.0, "sun_longitude_deg": -60.0, "sun_rate_rad_s": 1e-5, "shadow": False},
        "thrust": [
            {"bar": 1, "direction_deg": 90.0, "force_N": 0.01, "start_s": 1000.0, "duration_s": 900.0},
            {"bar": 2, "direction_deg": 0.0, "axes": "inertial", "force_N": [0.0, 0.02, 0.0],
             "times_s": [500.0, 1600.0, 2500.0]},
        ],
        "impulse": [{"bar": 3, "direction_deg": 90.0, "impulse_N_s": 0.05, "at_s": 700.0},
                    {"bar": 1, "direction_deg": 0.0, "impulse_N_s": 0.05, "at_s": 2100.0}],
    },
    "run": {"duration_s": 2.0 * HALF_S, "samples": 61},
})  # fmt: skip
REST = {"run": {"duration_s": HALF_S, "samples": 31}}


def run(scene: Scene) -> Trajectory:
    """Run of the reference."""
    return solutions.run(scene, RTOL).of_run(scene)


HELD: dict[str, Any] = {"bar": 2, "amplitude_deg": 0.0, "duration_s": 2.0 * HALF_S, "frame": "previous_bar"}


def test_a_joint_that_moves_is_not_caught_by_a_law_and_one_at_rest_is_held() -> None:
    """Rates of 0.1 mrad/s and 0 against the bar before; an impact would change the momentum of the other bars."""
    state = run(SCENE).state(HALF_S)
    with pytest.raises(SceneError, match=r"bar 2 turns against bar 1 at .* rad/s in the state"):
        go_on(SCENE, state, REST | {"effects": {"prescribed_rotation": [HELD]}})
    still = {**state, "chain": {**state["chain"], "rate_rad_s": [state["chain"]["rate_rad_s"][0]] * 3}}
    locked = go_on(SCENE, still, REST | {"effects": {"prescribed_rotation": [HELD]}})
    (law,) = go_on(locked, run(locked).state(HALF_S), REST).effects.prescribed_rotation
    assert law.amplitude_rad == 0.0


FREE = make_scene({
    "title": "t", "source": "s", "orbit": {"altitude_m": 600e3},
    "chain": {"bars": 4, "mass_kg": [80.0, 60.0, 40.0, 10.0], "length_m": [5.0, 3.0, 2.0, 4.0],
              "angle_from": "inertial", "angle_deg": [10.0, 80.0, -30.0, 150.0],
              "rate_rad_s": [0.02, -0.05, 0.04, 0.01]},
    "effects": {"gravity": "none"}, "run": {"duration_s": 20.0, "samples": 21},
})  # fmt: skip


@pytest.mark.parametrize("joints", [[1, 3], [1, 2, 3]])
def test_a_latch_keeps_the_angular_momentum_and_takes_the_energy_of_the_relative_rates(joints: list[int]) -> None:
    """What an impact without rebound takes is the energy of the rates that it takes (Carnot); all caught, L/I stays."""
    state, model = run(FREE).state(10.0), chain_model(FREE)
    after = latched(FREE, state, joints)
    angle = np.array([state["chain"]["angle_rad"]])
    rates = [np.array([each["chain"]["rate_rad_s"]]) for each in (state, after)]
    momenta = [relative_angular_momentum(model, angle, rate)[0] for rate in rates]
    energies = [relative_kinetic_energy(model, angle, rate)[0] for rate in (*rates, rates[0] - rates[1])]
    assert momenta[1] == pytest.approx(momenta[0], rel=1e-13)
    assert energies[0] - energies[1] == pytest.approx(energies[2], rel=1e-12)
    for joint in joints:
        assert rates[1][0, joint] == pytest.approx(rates[1][0, joint - 1], abs=1e-16)
    if len(joints) == FREE.bars - 1:
        ones = np.ones_like(angle)
        assert rates[1][0] == pytest.approx(momenta[0] / (2.0 * relative_kinetic_energy(model, angle, ones)[0]))
    locks = [HELD | {"bar": joint + 1} for joint in joints]
    held = run(go_on(FREE, after, REST | {"effects": {"prescribed_rotation": locks}}))
    for joint in joints:
        apart = held.angle_rad[:, joint] - held.angle_rad[:, joint - 1]
        assert apart == pytest.approx(apart[0], abs=1e-12)


def test_a_latch_beside_a_lock_keeps_it_and_what_it_can_not_do_is_one_line() -> None:
    locked = change_scene(FREE, {"effects": {"prescribed_rotation": [HELD | {"bar": 4}]}})
    state = run(locked).state(10.0)
    rates = latched(locked, state, [1])["chain"]["rate_rad_s"]
    assert rates[3] == pytest.approx(rates[2], rel=1e-12)
    assert rates[1] == pytest.approx(rates[0], rel=1e-12)
    for scene, joints in ((locked, [3]), (FREE, [4]), (FREE, [0]), (FREE, 2), (FREE, "2"), (FREE, [1.5])):
        with pytest.raises(SceneError, match="given, allowed"):
            latched(scene, state, joints)  # type: ignore[arg-type]


def test_two_halves_are_the_whole_to_the_accuracy_of_the_runs() -> None:
    """The second half starts off by roundings of the state, and both runs have errors of their tolerance.

    Within an orbit a stable chain's errors grow less than a hundred times; the track's by 3 n t.
    """
    whole = run(SCENE)
    half = run(go_on(SCENE, whole.state(HALF_S), REST))
    grown = 100.0 * (10.0 * EPS + RTOL)
    rows = slice(30, None)
    assert np.abs(half.com_m - whole.com_m[rows]).max() <= grown * SCENE.radius0_m
    assert np.abs(half.com_velocity_m_s - whole.com_velocity_m_s[rows]).max() <= grown * SCENE.speed0_m_s
    assert np.abs(half.angle_rad - whole.angle_rad[rows]).max() <= grown
    scale = np.abs(whole.reaction_N).max()
    assert np.abs(half.reaction_N[1:] - whole.reaction_N[rows][1:]).max() <= 10.0 * grown * scale
    joined = whole.samples(slice(30)).continued(half)
    np.testing.assert_allclose(joined.t_s, whole.t_s)
    np.testing.assert_allclose(joined.impulse_N_s, whole.impulse_N_s, atol=100.0 * RTOL)


def started_in(folder: Path, file: str, row: dict[str, Any]) -> Scene:
    """Scene of a file that starts in a row of a run."""
    tables = scene_data(SCENE)
    del tables["orbit"]
    tables["chain"] = {key: value for key, value in tables["chain"].items() if key not in OWN}
    text = "\n".join(toml(tables | REST | {"start": {"from": file} | row}))
    (folder / "started.toml").write_text(text, encoding="utf-8")
    return load_scene(folder / "started.toml")


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_a_file_starts_a_scene_as_python_does(tmp_path: Path, ending: str) -> None:
    """By an instant, a row, or the last row by default."""
    whole = run(SCENE)
    frame = whole.samples(slice(31)).to_frame()
    (tmp_path / "runs").mkdir()
    path = tmp_path / "runs" / f"run{ending}"
    if ending == ".csv":
        frame.to_csv(path, index=False)
    else:
        frame.to_parquet(path, index=False)
    for start in ({"time_s": HALF_S}, {"row": 31}, {}):
        second = started_in(tmp_path, f"runs/run{ending}", start)
        assert second.digest == go_on(SCENE, whole.state(HALF_S), REST).digest


def test_a_file_in_degrees_starts_a_scene_to_rounding(tmp_path: Path) -> None:
    frame = run(SCENE).to_frame()
    frame.to_csv(tmp_path / "radians.csv", index=False)
    in_degrees(frame).to_csv(tmp_path / "degrees.csv", index=False)
    scenes = [started_in(tmp_path, file, {"time_s": HALF_S}) for file in ("radians.csv", "degrees.csv")]
    states = [initial_state(scene) for scene in scenes]
    np.testing.assert_allclose(states[1].angle_rad, states[0].angle_rad, rtol=8.0 * EPS)
    np.testing.assert_allclose(states[1].rate_rad_s, states[0].rate_rad_s, rtol=8.0 * EPS)


def test_effects_go_on_where_they_were() -> None:
    second = go_on(SCENE, run(SCENE).state(HALF_S), REST).effects
    first = SCENE.effects
    moon = first.third_body[0]
    assert second.third_body[0].longitude_rad == pytest.approx(moon.longitude_rad + moon.rate_rad_s * HALF_S, rel=1e-14)
    assert second.solar_pressure.sun_longitude_rad == pytest.approx(math.radians(-60.0) + 1e-5 * HALF_S, rel=1e-14)
    assert [p.at_s for p in second.impulse] == [600.0]
    assert second.thrust[0].times_s == (0.0, 400.0)
    assert second.thrust[1].times_s == (0.0, 100.0, 1000.0)
    assert second.thrust[1].force_N[0] == pytest.approx(0.02 * 1000.0 / 1100.0)


def test_a_run_that_goes_on_twice_keeps_its_clock(tmp_path: Path) -> None:
    """From either scene, and from a table: the third starts 1500 s after the first."""
    whole = run(SCENE)
    second = go_on(SCENE, whole.state(1000.0), {"run": {"duration_s": 2000.0, "samples": 41}})
    motion = run(second)
    motion.to_frame().to_csv(tmp_path / "second.csv", index=False)
    thirds = [go_on(scene, motion.state(500.0), REST) for scene in (SCENE, second)]
    for third in (*thirds, started_in(tmp_path, "second.csv", {"time_s": 500.0})):
        assert third.effects.impulse[0].at_s == pytest.approx(600.0)
        assert third.effects.third_body[0].longitude_rad == pytest.approx(
            go_on(SCENE, whole.state(HALF_S), REST).effects.third_body[0].longitude_rad, rel=1e-13
        )


def test_a_rotation_holds_its_bar_once_it_is_over_and_can_not_start_halfway() -> None:
    slewed = load_scene("paper/fig17")
    law = slewed.effects.prescribed_rotation[0]
    over = change_scene(slewed, {"run": {"start_s": law.start_s + law.duration_s}}).effects.prescribed_rotation[0]
    assert (over.start_s, over.amplitude_rad) == (0.0, 0.0)
    with pytest.raises(SceneError, match=r"prescribed_rotation\[1\]: bar 5 is being turned at the start"):
        change_scene(slewed, {"run": {"start_s": law.start_s + 0.5 * law.duration_s}})


def test_a_state_is_that_of_a_sample() -> None:
    short = run(
        change_scene(SCENE, {"run": {"duration_s": 60.0, "samples": 3}, "effects": {"thrust": None, "impulse": None}})
    )
    assert short.state()["run"]["start_s"] == 60.0
    with pytest.raises(ValueError, match=r"^31 s given, allowed: the instant of a sample; the nearest is 30.0 s$"):
        short.state(31.0)
    with pytest.raises(ValueError, match="no angles or no rates"):
        short.replace(angle_rad=None).state()


HEAD = "t_s,com_x_m,com_y_m,com_vx_m_s,com_vy_m_s,angle_1_rad,rate_1_rad_s"
TABLE = f"{HEAD}\n0.0,7e6,0.0,0.0,7e3,1.0,0.001\n10.0,7e6,7e4,-80.0,7e3,1.01,0.001\n"
FILE = {"title": "t", "source": "s", "chain": {"bars": 1, "mass_kg": 1.0, "length_m": 10.0}, "run": {"duration_s": 9.0}}
FAULTS: list[tuple[str, dict[str, Any], dict[str, Any], str]] = [
    (TABLE, {"row": 3}, {}, "start.row: 3 given, allowed: 1 to 2"),
    (TABLE, {"time_s": 4.0}, {}, "start.time_s: 4 given, allowed: the instant of a row; the nearest is 0.0 s"),
    (TABLE, {"row": 1, "time_s": 0.0}, {}, "allowed: one of them"),
    (TABLE, {}, {"orbit": {"altitude_m": 5e5}}, "orbit: given beside [start]"),
    (TABLE, {}, {"chain": FILE["chain"] | {"angle_deg": 3.0}}, "chain.angle_deg: given beside [start]"),
    (TABLE, {}, {"chain": FILE["chain"] | {"bars": 2}}, "has no column angle_2_rad"),
    (TABLE.replace("com_vy_m_s", "com_vy"), {}, {}, "has no column com_vy_m_s (did you mean"),
    (TABLE.replace("-80.0", "fast"), {}, {}, "'fast' in the column com_vx_m_s"),
    (f"{HEAD},angle_2_rad\n0.0,7e6,0.0,0.0,7e3,1.0,0.001,1.0\n", {}, {}, "chain.bars: 1 given"),
    (HEAD, {}, {}, "has no rows"),
    (TABLE.replace("rate_1_rad_s", "rate_1_deg_s").replace(",0.001", ",slow"), {}, {}, "in the column rate_1_deg_s"),
    (TABLE, {"from": "run.txt"}, {}, "ends with .csv or .parquet"),
    (TABLE, {"from": "other.csv"}, {}, "no such file"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "start", "others", "words"), FAULTS, ids=[words for *_, words in FAULTS])
def test_a_start_that_can_not_be_read_is_one_line(
    table: str,
    start: dict[str, Any],
    others: dict[str, Any],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.csv").write_text(table, encoding="utf-8")
    with pytest.raises(SceneError) as error:
        make_scene(FILE | {"start": {"from": "run.csv"} | start} | others)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_run_that_goes_on_is_drawn_after_the_first_and_its_channels_are_those_of_its_own_times(
    tmp_path: Path,
) -> None:
    """The motor's table goes on inside: at the clock's times the second scene has another torque."""
    scene = load_scene("conform/joint_torque_alone")
    half_s = float(run(scene).t_s[20])
    second = go_on(scene, run(scene).state(half_s), {"run": {"duration_s": 300.0, "samples": 11}})
    motion = run(second)
    motion.to_frame().to_csv(tmp_path / "second.csv", index=False)
    drawn = with_channel(Run("second", read_run_table(tmp_path / "second.csv"), second), "joint_torque")
    np.testing.assert_allclose(drawn.t_s, half_s + motion.t_s)
    right = chosen_columns(motion, ["joint_torque"])
    np.testing.assert_array_equal(drawn.table["joint_torque_1_N_m"], right["joint_torque_1_N_m"])
    assert list(right)[:2] == ["t_s", "clock_s"]
    assert np.ptp(right["joint_torque_1_N_m"]) > 0.0


def test_a_lock_between_two_instants_has_no_torque_before_and_after_it_and_impulses_add_up() -> None:
    """Three runs after each other; the second one alone has a law, and the last one alone no impulse."""
    struck = {"bar": 1, "direction_deg": 90.0, "impulse_N_s": 2.0}
    pushes = {"impulse": [struck | {"at_s": 5.0}, struck | {"at_s": 25.0}]}
    free = change_scene(FREE, {"effects": pushes, "run": {"duration_s": 30.0, "samples": 31}})
    first = run(free).samples(slice(21))
    law = {"run": {"duration_s": 10.0, "samples": 11}, "effects": {"prescribed_rotation": [HELD]}}
    held = run(go_on(free, latched(free, first.state(), [1]), law))
    last = run(go_on(free, held.state(), {"run": {"duration_s": 10.0, "samples": 11}}))
    whole = first.continued(held).continued(last)
    assert last.impulse_N_s is None
    assert whole.torque_bars == (2,)
    np.testing.assert_array_equal(whole.t_s[[0, 20, 21, 31, 32, 42]], [0.0, 20.0, 20.0, 30.0, 30.0, 40.0])
    np.testing.assert_array_equal(whole.torque_N_m[21:32], held.torque_N_m)
    assert not whole.torque_N_m[:21].any()
    assert not whole.torque_N_m[32:].any()
    np.testing.assert_array_equal(whole.impulse_N_s[31:], [first.impulse_N_s[-1] + held.impulse_N_s[-1]] * 12)
    assert np.abs(held.impulse_N_s[-1]).max() > 0.0
    for without in (whole, first):
        with pytest.raises(DerivedError, match="torque_power needs a law for each torque, which mine lacks"):
            chosen_columns(without, ["torque_power"])
