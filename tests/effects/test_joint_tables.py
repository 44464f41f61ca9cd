"""Angles of bars and joints that follow tables."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from adapters.registry import ENGINES
from scenarios import SceneError, change_scene, load_scene
from tests.effects.joint_runs import forms, moved

FORMS = forms("reference", "reference-fast", "heyoka")
REST = [(1, 0.0), (2, 0.0)]


@pytest.mark.parametrize("engine", FORMS)
def test_joints_follow_the_quintic_splines_through_their_tables(engine: str) -> None:
    """SciPy's spline through the same points, and the integrator's error of some hundred steps of 1e-13."""
    seen = moved(load_scene("effects/joint_table"), engine)
    assert seen.angle_rad is not None
    joints = np.degrees(np.diff(seen.angle_rad, axis=1))
    for joint, times, angles in (
        (0, [20.0, 60.0, 110.0, 150.0, 220.0], [0.0, 35.0, 80.0, 60.0, 0.0]),
        (1, [20.0, 80.0, 140.0, 220.0], [0.0, -50.0, 15.0, 0.0]),
    ):
        spline = make_interp_spline(times, angles, k=5, bc_type=(REST, REST))
        wanted = spline(np.clip(seen.t_s, times[0], times[-1]))
        np.testing.assert_allclose(joints[:, joint] - joints[0, joint], wanted, atol=1e-8)


def test_the_two_forms_of_the_reference_and_an_independent_derivation_need_the_same_torques() -> None:
    scene = load_scene("conform/prescribed_table")
    names = [name for name in ("reference", "reference-fast", "heyoka") if not ENGINES[name].missing]
    first, *others = (moved(scene, name) for name in names)
    assert first.torque_N_m is not None
    for other in others:
        assert other.torque_N_m is not None
        largest = np.abs(first.torque_N_m).max(axis=0)
        np.testing.assert_allclose(other.torque_N_m / largest, first.torque_N_m / largest, atol=1e-10)


def test_a_table_of_two_points_is_the_quintic() -> None:
    """A quintic that begins and ends without rate and acceleration is 10 s^3 - 15 s^4 + 6 s^5."""
    table = load_scene("effects/joint_table").effects.prescribed_rotation[0]
    law = {"bar": 2, "frame": "previous_bar"}
    turns = [law | {"amplitude_deg": 40.0, "duration_s": 50.0, "start_s": 20.0, "course": "quintic"}]
    points = [law | {"times_s": [20.0, 70.0], "angle_deg": [0.0, 40.0]}]
    one, other = (
        change_scene(load_scene("effects/joint_table"), {"effects": {"prescribed_rotation": laws}}).effects
        for laws in (turns, points)
    )
    assert len(table.turns) == 4
    for t_s in (0.0, 20.0, 33.0, 69.9, 70.0, 100.0):
        np.testing.assert_allclose(
            other.prescribed_rotation[0].law(t_s), one.prescribed_rotation[0].law(t_s), rtol=1e-12, atol=1e-15
        )


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"times_s": [20.0, 70.0]}, "give lists as both times_s and angle_deg"),
        ({"times_s": [20.0, 70.0], "angle_deg": [5.0, 40.0]}, "5 given first, allowed: 0"),
        ({"times_s": [20.0, 70.0], "angle_deg": [0.0, 40.0], "start_s": 3.0}, "start_s is given beside a table"),
        ({"times_s": [70.0, 20.0], "angle_deg": [0.0, 40.0]}, "times_s must increase"),
        ({"duration_s": 50.0}, "amplitude_deg is missing"),
    ],
    ids=["half a table", "not from zero", "both", "backwards", "neither"],
)
def test_a_law_without_its_table_is_told(given: dict[str, object], fault: str) -> None:
    law = {"bar": 2, "frame": "previous_bar"} | given
    with pytest.raises(SceneError, match=fault):
        change_scene(load_scene("effects/joint_table"), {"effects": {"prescribed_rotation": [law]}})


def test_a_scene_with_tables_is_written_and_read_back(tmp_path: Path) -> None:
    scene = load_scene("effects/joint_table")
    scene.to_toml(tmp_path / "again.toml")
    assert load_scene(str(tmp_path / "again.toml")).effects == scene.effects
    assert "prescribed_rotation.spline" in scene.effects.names
