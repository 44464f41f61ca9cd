"""What barchain tells of scenes, engines, files and the installation, and what the shell completes."""

from __future__ import annotations

import dataclasses
import json
import re
import sys

import pytest
from click.shell_completion import ShellComplete

from adapters.registry import ENGINES, Registration
from barchain.cli.common.options import SETTING, settings_by_engine, shipped_scene_names
from barchain.cli.common.progress import choose_verbosity, counted, verdicts_shown
from barchain.cli.main import cli, main, run
from barchain.solutions import certified_file
from scenarios import load_scene, scene_names
from scenarios.toml.writing import scene_toml

BAD_SCENE = """
title = "t"
source = "s"
[orbit]
altitude_km = 500.0
[chain]
bars = 2
mass_kg = [100.0, -5.0]
length_m = 20.0
angle_deg = 80.0
[run]
orbits = 1.0
"""


GOOD_SCENE = BAD_SCENE.replace("altitude_km = 500.0", "altitude_m = 5e5").replace("-5.0", "5.0")


def printed_json(capsys, command):
    assert run(command.split()) == 0
    return json.loads(capsys.readouterr().out)


def test_scenes_are_filtered_by_tag_folder_and_effect(capsys):
    found = printed_json(capsys, "scenes --folder effects --effect drag --json")
    assert found
    assert all(s["name"].startswith("effects/") and "drag" in s["effects"] for s in found)
    assert {s["name"] for s in printed_json(capsys, "scenes --tag chaotic --json")} >= {"paper/fig05"}


def test_a_scene_is_shown_with_its_values_and_the_engines_that_support_it(capsys):
    assert run(["scenes", "show", "paper/fig17"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^chain: lengths, m +10\.0 \(5 times\)$", text, re.MULTILINE)
    assert re.search(r"^chain: angles, degrees +60\.0, 65\.0, 70\.0, 75\.0, 80\.0$", text, re.MULTILINE)
    assert re.search(r"^engine reference +supports the scene$", text, re.MULTILINE)
    shown = printed_json(capsys, "scenes show paper/fig17 --json")
    assert shown["chain"]["mass_kg"] == list(load_scene("paper/fig17").chain.mass_kg)
    assert shown["engines"]["reference"] == "supports the scene"
    assert "supports" not in shown["engines"]["pymunk"]


def test_an_engine_that_is_not_installed_tells_what_it_would_support(capsys, monkeypatch):
    monkeypatch.setitem(ENGINES, "mujoco", dataclasses.replace(ENGINES["mujoco"], module="nowhere"))
    reason = printed_json(capsys, "scenes show paper/fig17 --json")["engines"]["mujoco"]
    assert re.match("prescribed rotation is not supported.*; .*not installed; try: pip install", reason)
    supported = printed_json(capsys, "scenes show paper/fig05 --json")["engines"]["mujoco"]
    assert re.match("supports the scene; .*not installed; try: pip install", supported)


def test_engines_are_listed_as_json_and_missing_ones_by_themselves(capsys, monkeypatch):
    monkeypatch.setitem(ENGINES, "nothing", Registration("nowhere:Nothing", "nowhere", install="pip install nowhere"))
    monkeypatch.setitem(ENGINES, "broken", Registration("nowhere:Nothing"))
    known = {e["name"]: e for e in printed_json(capsys, "engines --json")}
    assert known["reference"]["default"]
    assert not known["reference"]["independent_physics"]
    assert known["exudyn"]["setting"] == "steps_per_orbit=5000"
    assert "does not load" in known["broken"]["fault"]
    missing = {e["name"]: e for e in printed_json(capsys, "engines --missing --json")}
    assert missing["nothing"]["install"] == "pip install nowhere"
    assert "reference" not in missing


def test_validate_prints_one_line_for_each_fault_of_each_file_and_exits_with_2(tmp_path, capsys):
    bad, good = tmp_path / "bad.toml", tmp_path / "good.toml"
    bad.write_text(BAD_SCENE)
    good.write_text(GOOD_SCENE)
    assert run(["validate", str(bad), str(good), str(tmp_path / "none.toml")]) == 2
    shown = capsys.readouterr()
    assert shown.out.startswith(
        f"{good}: valid: 2 bars, 1 orbits, {load_scene(good).run.samples} samples\n"
        f"{good}: orbit of the centre of mass: period 5676.81 s (1 h 34 min 37 s), lowest height 500 km\n"
        f"{good}: start: 500 km high at longitude 0°, 7612.68399 m/s, 0° above the horizontal; "
    )
    lines = shown.err.splitlines()
    assert len(lines) == 3
    assert f"{bad}: orbit.altitude_km: unknown key (did you mean altitude_m?); allowed here: altitude_m" in shown.err
    assert f"{bad}: chain.mass_kg[2]: -5.0 given, allowed: greater than 0" in shown.err
    assert run(["validate", "paper/fig05"]) == 0


@pytest.mark.parametrize(("orbit", "duration_s", "said", "warned"), [
    ("altitude_m = 5e5", 6000.0, "period 5676.81 s (1 h 34 min 37 s), lowest height 500 km", ""),
    ("altitude_m = 7e4", 6000.0, "lowest height 70 km", "below 80 km; was another"),
    ("altitude_m = 5e5\nspeed_factor = 0.5", 6000.0, "lowest height -5395.43 km", "surface, where a run ends; was"),
    ("altitude_m = 5e5\nspeed_factor = 0.9", 60.0, "lowest height", "where a run ends, after the end of this run;"),
    ("altitude_m = 7e4\nspeed_factor = 1.5", 6000.0, "open orbit of the centre of mass: no period, lowest", "80"),
])  # fmt: skip
def test_validate_tells_period_and_lowest_height_and_warns_of_a_low_orbit(
    orbit, duration_s, said, warned, tmp_path, capsys
):
    shown = validated(GOOD_SCENE.replace("altitude_m = 5e5", orbit), duration_s, tmp_path, capsys)
    assert said in shown.out.splitlines()[1]
    assert bool(shown.err) == bool(warned)
    assert warned in shown.err


def validated(text, duration_s, folder, capsys):
    """What `validate` prints of a scene that is valid."""
    file = folder / "mine.toml"
    file.write_text(text.replace("orbits = 1.0", f"duration_s = {duration_s}"))
    assert run(["validate", str(file)]) == 0
    return capsys.readouterr()


def test_validate_proposes_a_run_that_engines_of_equal_steps_support(tmp_path, capsys):
    text = GOOD_SCENE.replace("[run]", THRUST.format(0.5, 300.0) + "[run]")
    shown = validated(text, 5676.81, tmp_path, capsys)
    proposed = re.search(r"with duration_s = (\S+) and samples = (\d+) in \[run\]", shown.out)
    assert proposed
    shown = validated(f"{text}samples = {proposed[2]}\n", proposed[1], tmp_path, capsys)
    assert "equal steps" not in shown.out


THRUST = "[[effects.thrust]]\nbar = 1\ndirection_deg = 90.0\nforce_N = {}\nstart_s = 100.0\nduration_s = {}\n"
SLEW = "[[effects.prescribed_rotation]]\nbar = {}\namplitude_deg = {}\nduration_s = 300.0\n"
SUNLIGHT = "[effects.solar_pressure]\nwidth_m = 1.0\npressure_Pa = {}\n"
RATES = "rate_factor = [1.0, {}]\n[run]"


@pytest.mark.parametrize(("tables", "rate", "said", "noted"), [
    (SUNLIGHT.format(3e-5), 1.0, "times the Sun's at the Earth's distance", False),
    (SUNLIGHT.format(4.56), 1.0, "times the Sun's at the Earth's distance", True),
    (SUNLIGHT.format(4.56e-12), 1.0, "times the Sun's at the Earth's distance", True),
    (THRUST.format(0.01, 700.0), 1.0, "instants alone stop", True),
    (THRUST.format(0.01, 700.0) + SLEW.format(1, 30.0), 1.0, "instants alone stop", False),
    (SLEW.format(2, 45.0) + 'frame = "inertial"\n', 5.0, "it starts at the rate of its law", True),
    (SLEW.format(2, 45.0) + 'frame = "inertial"\n', 0.0, "it starts at the rate of its law", False),
    (SLEW.format(2, 45.0) + 'frame = "local_horizontal"\n', 2.0, "it starts at the rate of its law", True),
    (SLEW.format(2, 45.0) + 'frame = "local_horizontal"\n', 1.0, "it starts at the rate of its law", False),
    (SLEW.format(2, 0.0) + 'frame = "previous_bar"\nstart_s = 20.0\n', 1.0, "held from the start to the end", True),
    (SLEW.format(2, 0.0) + 'frame = "previous_bar"\nstart_s = 0.0\n', 1.0, "held from the start to the end", False),
])  # fmt: skip
def test_validate_notes_what_a_person_may_not_mean(tables, rate, said, noted, tmp_path, capsys):
    """Another sunlight than the Earth's, instants that stop engines of equal steps, rates and holds of a law."""
    text = GOOD_SCENE.replace("[run]", RATES.format(rate))
    assert (said in validated(text + tables, 5130.0, tmp_path, capsys).out) is noted


@pytest.mark.parametrize(("joint", "noted"), [(1, True), (3, False)])
def test_a_torque_in_a_joint_that_a_law_drives_is_noted(joint, noted, tmp_path, capsys):
    slew = scene_toml(load_scene("effects/joint_slew"))
    torque = f"\n[[effects.joint_torque]]\njoint = {joint}\ntorque_N_m = 0.1\n"
    shown = validated(slew + torque, 0.0, tmp_path, capsys)
    assert (f"note: a prescribed rotation drives joint {joint}: " in shown.out) is noted


def test_doctor_tells_versions_engines_machine_and_tables(capsys, monkeypatch):
    monkeypatch.setitem(ENGINES, "nothing", Registration("nowhere:Nothing", "nowhere", install="pip install nowhere"))
    found = printed_json(capsys, "doctor --json")
    assert found["faults"] == []
    assert found["machine"]["cores"] >= 1
    assert found["certified_solutions"]["tables"] >= 50
    assert "pip install nowhere" in json.dumps(found)


def test_doctor_exits_with_1_where_a_table_is_damaged_or_an_adapter_does_not_load(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(certified_file, "CERTIFIED_SOLUTIONS", tmp_path)
    monkeypatch.setitem(ENGINES, "broken", Registration("nowhere:Nothing"))
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "fig05.parquet").write_text("nothing")
    assert run(["doctor"]) == 1
    text = capsys.readouterr().out
    assert all(word in text for word in ("barchain ", "Python ", "cores", "GB", "kernel", "solutions", "exudyn"))
    assert "fault: table of paper/fig05" in text
    assert "fault: broken: the adapter nowhere:Nothing does not load" in text


def completions(*arguments):
    *before, incomplete = arguments
    return {c.value for c in ShellComplete(cli, {}, "barchain", "_X").get_completions(list(before), incomplete)}


def test_the_shell_completes_commands_scenes_and_engines():
    assert completions("cross") == {"crossval"}
    assert completions("compare", "paper/fig17") == {"paper/fig17", "paper/fig17_inertial"}
    assert completions("simulate", "paper/fig05", "--engine", "heyoka-") == {"heyoka-long", "heyoka-quad"}
    assert shipped_scene_names() == scene_names()


def test_the_shells_script_is_printed(monkeypatch, capsys):
    monkeypatch.setenv("_BARCHAIN_COMPLETE", "zsh_source")
    monkeypatch.setattr(sys, "argv", ["barchain"])
    with pytest.raises(SystemExit):
        main()
    assert "#compdef barchain" in capsys.readouterr().out


@pytest.mark.parametrize(("given", "chosen", "found"), [
    (["rtol=1e-8"], ["reference", "exudyn", "rebound"], {"reference": {"rtol": 1e-8}, "rebound": {"rtol": 1e-8}}),
    (["exudyn:steps_per_orbit=100"], ["reference", "exudyn"], {"exudyn": {"steps_per_orbit": 100.0}}),
    (["rtol=1e-8", "reference:rtol=1e-6"], ["reference"], {"reference": {"rtol": 1e-6}}),
    ([], ["reference"], {}),
])  # fmt: skip
def test_a_setting_goes_to_the_engine_named_or_to_all_that_have_it(given, chosen, found):
    registered = {name: ENGINES[name] for name in chosen}
    assert settings_by_engine([SETTING.convert(text, None, None) for text in given], registered) == found


@pytest.mark.parametrize(("quiet", "lines"), [(True, 0), (False, 3)])
def test_quiet_commands_print_no_progress(quiet, lines, capsys):
    choose_verbosity(-int(quiet))
    try:
        with verdicts_shown(1) as show, counted("runs", 1) as done:
            show.step("scene", "engine", "pass")
            show.note("a note")
            done(1)
    finally:
        choose_verbosity(0)
    assert len(capsys.readouterr().err.splitlines()) == lines
