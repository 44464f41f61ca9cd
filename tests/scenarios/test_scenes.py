"""Scene files: shipped scenes are valid, and a wrong scene is rejected in one readable line."""

import json
import math

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from barchain.cli.main import run
from scenarios import SceneError, SceneFile, check_scene, load_scene, parse_scene, scene_names

GOOD = """
title = "t"
source = "s"
[orbit]
altitude_m = 350e3
[chain]
bars = 3
mass_kg = 100.0
length_m = [10.0, 20.0, 30.0]
[run]
orbits = 1.0
"""


def rejected(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        parse_scene(text, name="x", file="x.toml")
    return str(caught.value)


def test_every_shipped_scene_loads_passes_the_checks_and_closes_its_joints():
    for name in scene_names():
        scene = load_scene(name)
        start, slack = initial_state(scene), 1e-12 * scene.mass_kg * scene.size_m
        assert np.allclose(np.array(scene.chain.mass_kg) @ start.position_m, 0.0, atol=slack), name
        assert [key for key in ("tags", "source", "description") if not getattr(scene, key)] == []
        assert check_scene(scene) is scene


def test_scalars_are_repeated_and_lists_taken_bar_by_bar():
    chain = parse_scene(GOOD, name="x", file="x.toml").chain
    assert chain.mass_kg == (100.0,) * 3
    assert chain.length_m == (10.0, 20.0, 30.0)
    assert chain.inertia_kg_m2 == tuple(100.0 * length**2 / 12 for length in chain.length_m)


def test_orbits_count_periods_of_the_osculating_ellipse():
    scene = parse_scene(
        GOOD.replace("altitude_m = 350e3", "altitude_m = 350e3\nspeed_factor = 1.1"), name="x", file="x"
    )
    semi_major = scene.radius0_m / (2 - 1.1**2)
    period = 2 * math.pi * math.sqrt(semi_major**3 / scene.central_body.mu_m3_s2)
    assert scene.run.duration_s == pytest.approx(period, rel=1e-15)


def test_a_horizontal_bar_is_perpendicular_to_its_own_radius():
    scene = parse_scene(GOOD.replace("[run]", 'angle_from = "bar"\n[run]'), name="x", file="x")
    start = initial_state(scene)
    place = start.com_m + start.position_m
    along = np.stack([np.cos(start.angle_rad), np.sin(start.angle_rad)], axis=-1)
    assert np.abs(np.sum(place * along, axis=-1)).max() < 4 * np.spacing(scene.radius0_m)


def test_a_bar_held_to_its_local_horizontal_starts_at_the_rate_of_its_own_longitude():
    scene = load_scene("paper/fig17")
    start = initial_state(scene)
    place = (start.com_m + start.position_m)[4]
    motion = (start.com_velocity_m_s + start.velocity_m_s)[4]
    longitude_rate = (place[0] * motion[1] - place[1] * motion[0]) / (place @ place)
    assert start.rate_rad_s[4] == pytest.approx(longitude_rate, rel=1e-14)
    assert start.rate_rad_s[4] == pytest.approx(scene.orbital_rate_rad_s, rel=1e-5)  # alpha = 1 to first order
    assert initial_state(load_scene("paper/fig17_inertial")).rate_rad_s[4] == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("bars = 3", "bars = 0"), ["x.toml", "chain.bars", "0 given", "at least 1"]),
        (("mass_kg = 100.0", "mass_kg = [1.0, 2.0]"), ["chain.mass_kg", "one value per bar: 3"]),
        (("mass_kg = 100.0", "mass_kg = [1.0, nan, 1.0]"), ["chain.mass_kg[2]", "nan given", "finite"]),
        (("mass_kg = 100.0", 'mass_kg = "heavy"'), ["chain.mass_kg", "'heavy' given", "a number without quotes"]),
        (("mass_kg = 100.0", "mas_kg = 100.0"), ["chain.mas_kg", "unknown key", "did you mean mass_kg?"]),
        (("altitude_m = 350e3", "altitude_m = 50.0"), ["orbit.altitude_m", "chain of 60 m", "surface"]),
        (("orbits = 1.0", "orbits = 1.0\nduration_s = 5.0"), ["run", "exactly one of orbits, duration_s"]),
        (
            ("altitude_m = 350e3", "altitude_m = 350e3\nspeed_factor = 1.5"),
            ["run.orbits", "not bound", "sqrt(2)"],
        ),
        (
            ("[run]", "[effects]\ndragg = true\n[run]"),
            ["effects.dragg", "unknown key", "did you mean drag?", "allowed here: gravity"],
        ),
        (
            ("altitude_m = 350e3", "altitude_m = 350e3\nperigee_altitude = 300e3"),
            ["orbit.perigee_altitude: unknown key", "periapsis_altitude_m is", "allowed here: altitude_m"],
        ),
        (("orbits = 1.0", "orbits = 1.0\ndt_s = 0.1"), ["run.dt_s: unknown key", "engine's setting"]),
        (("[run]", '[effects]\ngravity = "none"\n[run]'), ["run.orbits", "without gravity"]),
        (('title = "t"', ""), ["title", "missing"]),
        (("bars = 3", "bars ="), ["not valid TOML"]),
    ],
)
def test_a_wrong_scene_is_rejected_with_the_key_what_was_given_and_what_is_allowed(change, words):
    message = rejected(GOOD.replace(*change))
    assert all(word in message for word in words), message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("rotations", "words"),
    [
        (["bar = 4"], ["bar: 4 given, allowed: 1 to 3"]),
        (["bar = 1", "bar = 1"], ["bar 1 is turned by another table from 0 to 60 s", "one turn after the other"]),
        (['bar = 1\nframe = "local"'], ["frame", "'local' given", "local_horizontal"]),
        (['bar = 1\nframe = "previous_bar"'], ["needs a bar before it"]),
        (['bar = 2\nframe = "previous_bar"\nactuator = "external"'], ["angle of a joint", "external"]),
        (['bar = 2\nframe = "previous_bar"', 'bar = 1\nactuator = "joint"'], ["joint 1 would carry two motors"]),
        (
            ['bar = 2\nframe = "previous_bar"', "bar = 2\nstart_s = 60.0"],
            ['a law already, with frame = "previous_bar"'],
        ),
    ],
)
def test_prescriptions_that_conflict_are_rejected(rotations, words):
    tables = "".join(
        f"[[effects.prescribed_rotation]]\namplitude_deg = 10.0\nduration_s = 60.0\n{r}\n" for r in rotations
    )
    message = rejected(GOOD + tables)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ("times_s = [20.0, 70.0]", "give lists as both times_s and angle_deg"),
        ("times_s = [20.0, 70.0]\nangle_deg = [5.0, 40.0]", "5 given first, allowed: 0"),
        ("times_s = [20.0, 70.0]\nangle_deg = [0.0, 40.0]\nstart_s = 3.0", "start_s is given beside a table"),
        ("times_s = [70.0, 20.0]\nangle_deg = [0.0, 40.0]", "times_s must increase"),
        ("duration_s = 50.0", "amplitude_deg is missing"),
    ],
)
def test_a_law_without_its_table_is_rejected(given, fault):
    assert fault in rejected(f"{GOOD}[[effects.prescribed_rotation]]\nbar = 2\n{given}\n")


WRONG_EFFECTS = {
    "[effects]\ngravity = \"none\"\n[effects.oblateness]": ["effects.oblateness", "does not pull", "with gravity"],
    "[[effects.third_body]]\nbody = \"other\"": ["effects.third_body[1]", "mu_m3_s2 and distance_m"],
    "[[effects.third_body]]\ndistance_m = 1e6": ["effects.third_body[1].distance_m", "1e+06 given", "more than"],
    "[effects.drag]\naltitude_m = 0.0\nscale_height_m = 5e4\nwidth_m = 1.0": ["effects.drag.density_kg_m3", "missing"],
    "[effects.drag]\ndensity_kg_m3 = 1e-11\naltitude_m = 3e5\nscale_height_m = 5e4\nwidth_m = [1.0]": [
        "effects.drag.width_m", "1 values given", "one value per bar: 3",
    ],
    "[effects.joint_spring_damper]\nstiffness_N_m_rad = [1.0, 2.0, 3.0]": [
        "effects.joint_spring_damper.stiffness_N_m_rad", "3 values given", "one value per joint: 2",
    ],
    "[[effects.thrust]]\nbar = 7\ndirection_deg = 0.0\nforce_N = 1.0": ["effects.thrust[1].bar", "7 given", "1 to 3"],
    "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = [1.0, 2.0]\ntimes_s = [5.0, 5.0]": [
        "effects.thrust[1]", "must increase",
    ],
    "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = [1.0, 2.0]": [
        "effects.thrust[1]", "force_N and times_s",
    ],
    "[[effects.impulse]]\nbar = 1\ndirection_deg = 0.0\nimpulse_N_s = 1.0\nat_s = 1e9": [
        "effects.impulse[1].at_s", "1e+09 given", "before the end of the run",
    ],
    "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = 1.0\nstart_s = 100.0": [
        "effects.thrust[1].start_s", "begins at 100 s", "before the end of the run, 100 s",
    ],
    "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = [1.0, 2.0]\ntimes_s = [200.0, 300.0]": [
        "effects.thrust[1].times_s", "begins at 200 s",
    ],
    "[effects.drag]\ndensity_kg_m3 = 1e-11\naltitude_m = 350.0\nscale_height_m = 50.0\nwidth_m = 0.1": [
        "effects.drag", "altitude_m = 350 m", "starts at 350000 m", "6.99e+03 times", "above it", "at most 30 times",
    ],
    "[effects.drag]\ndensity_kg_m3 = 1e-11\naltitude_m = 3e5\nscale_height_m = 5e4\nwidth_m = 100.0": [
        "effects.drag.width_m", "100 given for bar 1", "at most its length, 10 m",
    ],
    "[effects.solar_pressure]\nwidth_m = [0.1, 30.0, 0.1]": [
        "effects.solar_pressure.width_m", "30 given for bar 2", "at most its length, 20 m",
    ],
    "[effects.joint_spring_damper]\nrest_deg = 3.0": [
        "effects.joint_spring_damper", "give stiffness_N_m_rad, damping_N_m_s_rad, or both",
    ],
    "[[effects.joint_torque]]\njoint = 3\ntorque_N_m = 1.0": ["joint_torque[1].joint: 3 given, allowed: 1 to 2"],
    "[[effects.joint_torque]]\njoint = 1\ntorque_N_m = [1.0]": ["lists as both torque_N_m and times_s"],
    "[effects.joint_spring_damper]\nstiffness_N_m_rad = 1.5" + 2 * (
        "\n[[effects.joint_spring_damper.set_point]]\njoint = 1\ntimes_s = [1.0, 2.0]\nangle_deg = [0.0, 1.0]"
    ): ["1 has a set point already"],
    "[effects]\noblateness = true": ["effects.oblateness: true given", "a table, write [effects.oblateness]"],
    "[effects.third_body]\nbody = \"moon\"": ["effects.third_body: one table given", "write [[effects.third_body]]"],
    "[[effects.drag]]\nwidth_m = 1.0": ["effects.drag", "a table, write [effects.drag]"],
    "[effects]\n\"thrust[1]\" = 1.0": ["effects.thrust[1]: unknown key"],
    "[effects.joint_friction]\ntorque_N_m = 1.0": ["effects.joint_friction: unknown key; joints have no"],
    "[drag]\nwidth_m = 1.0": ["drag: unknown key", "did you mean effects.drag?"],
    "[[thrust]]\nbar = 1": ["thrust: unknown key", "did you mean effects.thrust?"],
    "[effects]\ngravity = \"slender\"": ["chain.inertia_kg_m2", "5 given for bar 1", "833.3", "leave it out"],
}  # fmt: skip


@pytest.mark.parametrize("effects", WRONG_EFFECTS)
def test_a_wrong_effect_is_rejected_in_one_readable_line(effects):
    text = GOOD.replace("[run]", "inertia_kg_m2 = 5.0\n[run]") if "slender" in effects else GOOD
    text = text.replace("orbits = 1.0", "duration_s = 100.0")
    message = rejected(text + effects)
    assert all(word in message for word in WRONG_EFFECTS[effects]), message
    assert "\n" not in message


def test_a_misspelt_scene_name_suggests_the_nearest():
    with pytest.raises(SceneError, match=r"did you mean paper/fig05\?"):
        load_scene("paper/fig5")
    for given, said in (("drag", r"mean effects/drag\?"), ("effects/foo", "`barchain scenes` lists all scenes")):
        with pytest.raises(SceneError, match=said):
            load_scene(given)


def test_the_command_line_rejects_a_wrong_scene_in_one_line_with_exit_code_2(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD.replace("mass_kg = 100.0", "mass_kg = -1.0"))
    assert run(["simulate", str(path), "--out", str(tmp_path / "x.csv")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "mine.toml" in error
    assert "-1.0" in error


def test_the_schema_is_a_json_schema_that_describes_every_key(capsys):
    assert run(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema == SceneFile.model_json_schema()
    tables = [schema, *schema["$defs"].values()]
    keys = [(name, key) for table in tables for name, key in table["properties"].items() if "$ref" not in key]
    undescribed = [name for name, key in keys if "description" not in key and "default" not in key]
    assert undescribed == []


def test_all_faults_between_tables_are_told_at_once_and_one_of_several_bars_stands_for_all():
    wide = "[effects.drag]\ndensity_kg_m3 = 1e-11\naltitude_m = 3e5\nscale_height_m = 5e4\nwidth_m = 100.0\n"
    push = "[[effects.thrust]]\nbar = 4\nforce_N = 1.0\ndirection_deg = 0.0\nstart_s = 0.0\nduration_s = 1.0\n"
    lines = rejected(GOOD.replace("350e3", "50.0") + push + wide).split("\n")
    assert [line.split(": ")[:2] for line in lines] == [
        ["x.toml", "orbit.altitude_m"],
        ["x.toml", "effects.thrust[1].bar"],
        ["x.toml", "effects.drag.width_m"],
    ]
