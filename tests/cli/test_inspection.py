"""What barchain tells of scenes, engines, files and the installation, and what the shell completes."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from click.shell_completion import ShellComplete

from adapters.registry import ENGINES, Registration
from barchain.cli.common.options import SETTING, settings_by_engine, shipped_scene_names
from barchain.cli.common.progress import choose_verbosity, counted, verdicts_shown
from barchain.cli.main import cli, run
from barchain.solutions import certified_file
from scenarios import change_scene, load_scene, scene_names
from scenarios.toml.writing import scene_toml

if TYPE_CHECKING:
    from pathlib import Path

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
    good.write_text(BAD_SCENE.replace("altitude_km = 500.0", "altitude_m = 5e5").replace("-5.0", "5.0"))
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


def test_labels_of_scenes_are_words_with_units(capsys):
    for name in ("effects/everything", "effects/thrust_table", "paper/fig17"):
        assert run(["scenes", "show", name]) == 0
        labels = [re.split(r" {2,}", line)[0] for line in capsys.readouterr().out.splitlines()]
        assert not [label for label in labels if "_" in label or "{" in label]
        assert not [label for label in labels if re.search(r" (m|s|kg|rad|N)$", label) and ", " not in label]


@pytest.mark.parametrize(("orbit", "said", "warned"), [
    ("altitude_m = 5e5", "period 5676.81 s (1 h 34 min 37 s), lowest height 500 km", ""),
    ("altitude_m = 7e4", "lowest height 70 km", "below 80 km; was another"),
    ("altitude_m = 5e5\nspeed_factor = 0.5", "lowest height -5395.43 km", "meets the surface, where a run ends; was"),
    ("altitude_m = 7e4\nspeed_factor = 1.5", "open orbit of the centre of mass: no period, lowest height 70 km", "80"),
])  # fmt: skip
def test_validate_tells_period_and_lowest_height_and_warns_of_a_low_orbit(orbit, said, warned, tmp_path, capsys):
    file = tmp_path / "mine.toml"
    text = BAD_SCENE.replace("altitude_km = 500.0", orbit).replace("-5.0", "5.0")
    file.write_text(text.replace("orbits = 1.0", "duration_s = 6000.0"))
    assert run(["validate", str(file)]) == 0
    shown = capsys.readouterr()
    assert said in shown.out.splitlines()[1]
    assert bool(shown.err) == bool(warned)
    assert warned in shown.err


@pytest.mark.parametrize(("pressure_Pa", "noted"), [(4.56e-6, False), (3e-5, False), (4.56, True), (4.56e-12, True)])
def test_validate_tells_sunlight_that_no_planet_has(pressure_Pa, noted, tmp_path, capsys):
    file = tmp_path / "mine.toml"
    text = BAD_SCENE.replace("altitude_km = 500.0", "altitude_m = 5e5").replace("-5.0", "5.0")
    file.write_text(f"{text}[effects.solar_pressure]\nwidth_m = 1.0\npressure_Pa = {pressure_Pa}\n")
    assert run(["validate", str(file)]) == 0
    assert ("times the Sun's at the Earth's distance" in capsys.readouterr().out) is noted


def test_validate_tells_a_low_point_after_the_end_of_the_run(tmp_path, capsys):
    file = tmp_path / "mine.toml"
    orbit = "altitude_m = 5e5\nspeed_factor = 0.9"
    text = BAD_SCENE.replace("altitude_km = 500.0", orbit).replace("-5.0", "5.0")
    file.write_text(text.replace("orbits = 1.0", "duration_s = 60.0"))
    assert run(["validate", str(file)]) == 0
    assert "meets the surface, where a run ends, after the end of this run;" in capsys.readouterr().err


def test_validate_proposes_a_run_that_engines_of_equal_steps_support(tmp_path, capsys):
    file = tmp_path / "mine.toml"
    text = BAD_SCENE.replace("altitude_km", "altitude_m").replace("-5.0", "5.0").replace("500.0", "5e5")
    thrust = "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = 0.5\nstart_s = 100.0\nduration_s = 300.0\n"
    file.write_text(text.replace("[run]", f"{thrust}[run]"))
    assert run(["validate", str(file)]) == 0
    proposed = re.search(r"with duration_s = (\S+) and samples = (\d+) in \[run\]", capsys.readouterr().out)
    assert proposed
    file.write_text(file.read_text().replace("orbits = 1.0", f"duration_s = {proposed[1]}\nsamples = {proposed[2]}"))
    assert run(["validate", str(file)]) == 0
    assert "equal steps" not in capsys.readouterr().out


def test_doctor_tells_versions_engines_kernel_machine_and_tables(capsys, monkeypatch):
    monkeypatch.setitem(ENGINES, "nothing", Registration("nowhere:Nothing", "nowhere", install="pip install nowhere"))
    assert run(["doctor"]) == 0
    text = capsys.readouterr().out
    for word in ("barchain ", "Python ", "cores", "GB", "kernel", "solutions", "exudyn", "pip install nowhere"):
        assert word in text
    found = printed_json(capsys, "doctor --json")
    assert found["faults"] == []
    assert found["machine"]["cores"] >= 1
    assert found["certified_solutions"]["tables"] >= 50


def test_doctor_exits_with_1_where_a_table_is_damaged_or_an_adapter_does_not_load(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(certified_file, "CERTIFIED_SOLUTIONS", tmp_path)
    monkeypatch.setitem(ENGINES, "broken", Registration("nowhere:Nothing"))
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "fig05.parquet").write_text("nothing")
    assert run(["doctor"]) == 1
    text = capsys.readouterr().out
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


def test_the_shells_script_is_printed():
    env = os.environ | {"_BARCHAIN_COMPLETE": "zsh_source"}
    code = "import sys; sys.argv = ['barchain']; from barchain.cli.main import main; main()"
    made = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert "#compdef barchain" in made.stdout


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


THRUST = """
[[effects.thrust]]
bar = 1
direction_deg = 90.0
force_N = 0.01
start_s = 100.0
duration_s = 700.0
"""
SLEW = """
[[effects.prescribed_rotation]]
bar = 1
amplitude_deg = 30.0
duration_s = 300.0
start_s = 100.0
"""


@pytest.mark.parametrize(("tables", "proposed"), [(THRUST, True), (THRUST + SLEW, False)])
def test_validate_proposes_another_run_only_where_an_engine_then_supports_the_scene(tables, proposed, tmp_path, capsys):
    file = tmp_path / "mine.toml"
    text = BAD_SCENE.replace("altitude_km = 500.0", "altitude_m = 5e5").replace("-5.0", "5.0")
    file.write_text(text.replace("orbits = 1.0", "duration_s = 5130.0") + tables)
    assert run(["validate", str(file)]) == 0
    assert ("instants alone stop" in capsys.readouterr().out) is proposed


@pytest.mark.parametrize(
    ("frame", "rate_factor", "noted"),
    [
        ("inertial", 5.0, True),
        ("inertial", 0.0, False),
        ("local_horizontal", 1.0, False),
        ("local_horizontal", 2.0, True),
    ],
)
def test_a_prescribed_bar_that_starts_at_another_rate_than_its_law_is_noted(
    frame: str, rate_factor: float, noted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slew.toml"
    file.write_text(
        'title = "A slew"\nsource = "test"\n[orbit]\naltitude_m = 500e3\n'
        f"[chain]\nbars = 2\nmass_kg = 100.0\nlength_m = 20.0\nangle_deg = 10.0\nrate_factor = [1.0, {rate_factor}]\n"
        f'[[effects.prescribed_rotation]]\nbar = 2\namplitude_deg = 45.0\nduration_s = 60.0\nframe = "{frame}"\n'
        "[run]\norbits = 0.1\nsamples = 11\n"
    )
    assert run(["validate", str(file)]) == 0
    assert ("bar 2 is prescribed: it starts at the rate of its law" in capsys.readouterr().out) is noted


@pytest.mark.parametrize(("joint", "noted"), [(1, True), (3, False)])
def test_a_torque_in_a_joint_that_a_law_drives_is_noted(
    joint: int, noted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slew.toml"
    slew = scene_toml(load_scene("effects/joint_slew"))
    file.write_text(f"{slew}\n[[effects.joint_torque]]\njoint = {joint}\ntorque_N_m = 0.1\n")
    assert run(["validate", str(file)]) == 0
    assert (f"note: a prescribed rotation drives joint {joint}: " in capsys.readouterr().out) is noted


@pytest.mark.parametrize(("start_s", "noted"), [(20.0, True), (0.0, False)])
def test_a_law_of_no_amplitude_that_begins_late_is_noted_as_holding_from_the_start(
    start_s: float, noted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "lock.toml"
    lock = {"bar": 2, "frame": "previous_bar", "amplitude_deg": 0.0, "duration_s": 30.0, "start_s": start_s}
    scene = change_scene(
        load_scene("basics/two_bars_free"),
        {"chain": {"rate_factor": 1.0}, "effects": {"prescribed_rotation": [lock]}},
    )
    file.write_text(scene_toml(scene))
    assert run(["validate", str(file)]) == 0
    assert ("held from the start to the end of the run" in capsys.readouterr().out) is noted


def test_the_length_of_a_scene_without_an_orbit_is_told_in_seconds(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["validate", "basics/two_bars_free"]) == 0
    assert "2 bars, 2000 s, " in capsys.readouterr().out
