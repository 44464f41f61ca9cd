"""Exported folders: a stranger solves the problem from the folder alone, and `judge` passes the answer."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest
from click.testing import CliRunner

from adapters.command.entries import python_path, unpacked
from adapters.mujoco.chain import model_of
from adapters.registry import built_in
from barchain.cli.main import cli
from barchain.judge.written import Declared
from barchain.result_files.judging import judge_files
from reports.text.words import escape_text
from scenarios import load, load_scene
from tests.support.slow import exhaustive_but

STRANGER = Path(__file__).with_name("stranger.py")
SCENES = ("basics/two_bars_free", "paper/fig05")
BASILISK = built_in()["basilisk"]


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    out = tmp_path_factory.mktemp("cases")
    found = CliRunner().invoke(cli, ["export", *SCENES, "effects/drag", "--out", str(out), "--mjcf", "--rtol", "1e-6"])
    assert found.exit_code == 0, found.output
    return out


@pytest.mark.parametrize("scene", exhaustive_but(SCENES, SCENES[:1]))
def test_a_stranger_solves_a_case_and_judge_and_the_test_in_its_readme_pass_the_table_and_fail_a_wrong_one(
    cases, tmp_path, scene
):
    folder = shutil.copytree(cases / scene, tmp_path / "case")

    def python(*words):
        line = [sys.executable, "-I", *words]
        return subprocess.run(line, cwd=folder, text=True, capture_output=True, check=False).stderr

    assert not python(str(STRANGER), ".", "run.csv", "1e-10")
    found = judge_files(scene, folder / "run.csv", declared=Declared(rtol=1e-10), time_limit_s=60.0)
    assert found.passed, found.reasons
    assert {quantity for quantity, *_ in found.sizes} == {"com", "com_velocity", "attitude", "rate", "reaction"}
    (code,) = re.findall(r"```python\n(.*?)```", (folder / "README.md").read_text(), re.DOTALL)
    assert not python("-c", code)
    run = pd.read_csv(folder / "run.csv")
    run.assign(angle_2_rad=run.angle_2_rad + 0.1).to_csv(folder / "run.csv", index=False)
    assert "AssertionError" in python("-c", code)


def test_the_samples_of_a_case_pass_by_their_digits_alone(cases):
    found = judge_files(SCENES[1], cases / SCENES[1] / "samples.csv", time_limit_s=60.0)
    assert found.passed, found.reasons


def test_a_case_states_its_problem_and_what_can_be_compared(cases):
    folder = cases / "paper/fig05"
    text, facts = (folder / "README.md").read_text(), json.loads((folder / "settings.json").read_text())
    scene = load_scene("paper/fig05")
    for number in (scene.central_body.mu_m3_s2, scene.run.duration_s, *scene.chain.mass_kg, *scene.chain.inertia_kg_m2):
        assert str(number) in text
    assert "K = 3 mu J (u.Z)(n.Z)/r^5" in text
    assert "exp(-(r - R - altitude_m)/H)" in (cases / "effects/drag/README.md").read_text()
    limits = [each["predictability_limit_s"] for each in facts["accuracies"]]
    assert limits == sorted(limits)
    assert limits[0] < limits[-1] <= facts["duration_s"]
    errors = pd.read_csv(folder / "samples.csv").filter(like="error_")
    assert len(errors.columns) == 5
    assert (errors >= 0.0).all(axis=None)
    assert "MIT License" in (folder / "LICENSE").read_text()
    ElementTree.parse(folder / "picture.svg")


def test_the_model_for_mujoco_is_the_chain_at_its_start(cases):
    mujoco = pytest.importorskip("mujoco")
    scene = load_scene("paper/fig05")
    model = mujoco.MjModel.from_xml_path(str(cases / "paper/fig05/chain.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    adapted = model_of(scene.chain, 1.0)
    for part in ("body_mass", "body_inertia", "body_ipos", "body_pos", "jnt_type", "jnt_axis", "jnt_bodyid"):
        assert (getattr(model, part) == getattr(adapted, part)).all(), part
    assert model.body_mass[1:] @ data.xipos[1:, :2] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert (model.opt.gravity == 0.0).all()


def test_the_program_for_basilisk_is_there_where_basilisk_carries_the_scene(cases):
    folder = cases / SCENES[0]
    assert (folder / "basilisk_chain.py").read_text() == (unpacked(BASILISK.entry)[0] / "chain.py").read_text()
    assert "basilisk_chain.py" in (folder / "README.md").read_text()
    assert not (cases / SCENES[1] / "basilisk_chain.py").exists()
    assert "basilisk_chain.py" not in (cases / SCENES[1] / "README.md").read_text()


@pytest.mark.exhaustive
@pytest.mark.skipif(bool(BASILISK.missing), reason=BASILISK.missing or "it is there")
@pytest.mark.parametrize("scene", [SCENES[0], "basics/point_chain"])
def test_the_program_for_basilisk_passes_from_the_folder_alone(tmp_path, scene):
    found = CliRunner().invoke(cli, ["export", scene, "--out", str(tmp_path), "--mjcf"])
    assert found.exit_code == 0, found.output
    folder, python = tmp_path / scene, python_path(*unpacked(BASILISK.entry))
    for table, times in (("run.csv", []), ("finer.csv", ["2"])):
        words = ["basilisk_chain.py", "scene.json", table, "result.json", *times]
        subprocess.run([python, *words], check=True, cwd=folder, env={})
    declared = Declared(order=4.0, absolute=True, noise=unpacked(BASILISK.entry)[1].noise)
    judged = judge_files(scene, folder / "run.csv", folder / "finer.csv", declared=declared, time_limit_s=60.0)
    assert judged.passed, judged.reasons
    assert {quantity for quantity, *_ in judged.sizes} == {"com", "com_velocity", "attitude", "rate"}


def test_a_case_is_not_overwritten_unasked(cases):
    words = ["export", SCENES[0], "--out", str(cases)]
    assert "holds a case" in str(CliRunner().invoke(cli, words).exception)
    assert CliRunner().invoke(cli, [*words, "--overwrite"]).exit_code == 0


def test_a_title_with_markup_is_text_in_a_case(tmp_path):
    scene = (Path(load.__file__).parent / "basics" / "two_bars_free.toml").read_text()
    title = "*Two* <b>bars</b> [here](https://example.org)"
    path = tmp_path / "own.toml"
    path.write_text(re.sub(r"^title = .*$", f'title = "{title}"', scene, count=1, flags=re.MULTILINE))
    found = CliRunner().invoke(cli, ["export", str(path), "--out", str(tmp_path / "cases")])
    assert found.exit_code == 0, found.output
    (page,) = (tmp_path / "cases").rglob("README.md")
    first = page.read_text().splitlines()[0]
    assert first == f"# {escape_text(title)}"
    assert "<b>" not in first
    assert "[here](" not in first
