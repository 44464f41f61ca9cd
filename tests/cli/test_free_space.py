"""Chains without an orbital rate, or at rest, pass through the commands with warnings as errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import pytest

from barchain.cli.main import run as command
from tests.support.slow import slow_but

if TYPE_CHECKING:
    from pathlib import Path

AT_REST = """
title = "Two bars in free space, {what}"
source = "test"
[orbit]
altitude_m = 350e3
speed_factor = 0.0
[chain]
bars = 2
mass_kg = [2.0, 1.0]
length_m = 1.0
angle_deg = [0.0, 50.0]
rate_factor = 0.0
[effects]
gravity = "none"
{effects}
[run]
duration_s = 20.0
samples = 21
"""
SCENES = {
    "rest": "",
    "damped": "[effects.joint_spring_damper]\nstiffness_N_m_rad = 0.05\ndamping_N_m_s_rad = 0.02\n",
    "sunlit": "[effects.solar_pressure]\nwidth_m = 1.0\n",
}
COMMANDS = {
    "compare": "compare {scene} --engine reference --workers 1 --out {out}",
    "effects": "effects {scene} --workers 1 --out {out}",
    "cost": "cost {scene} --engine reference --repeats 1 --minutes 0 --out {out}",
    "ensemble": "ensemble {scene} --vary angle_deg=uniform(0,1) --runs 2 --samples 3 --workers 1 --out {out}",
    "export": "export {scene} --out {out}",
}
PAIRS = [(scene, name) for scene in SCENES for name in COMMANDS if (scene, name) != ("sunlit", "ensemble")]
QUICK = [("rest", "ensemble"), ("damped", "export")]


@pytest.fixture(autouse=True)
def warnings_are_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    """In processes of workers, too; in this one pytest's own filter does it."""
    monkeypatch.setenv("PYTHONWARNINGS", "error::RuntimeWarning")


def written(folder: Path, scene: str) -> Path:
    file = folder / f"{scene}.toml"
    file.write_text(AT_REST.format(what=scene, effects=SCENES[scene]), encoding="utf-8")
    return file


@pytest.mark.parametrize("pair", slow_but(PAIRS, QUICK), ids="-".join)
def test_a_chain_at_rest_passes_through_a_command(
    pair: tuple[str, str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    scene, name = pair
    asked = COMMANDS[name].format(scene=written(tmp_path, scene), out=tmp_path / "out")
    assert command(asked.split()) == 0
    assert "Warning" not in capfd.readouterr().err


@pytest.mark.parametrize("factor", slow_but([2.0, -1.0], [2.0]))
def test_wrong_results_of_a_chain_at_rest_are_diagnosed(
    factor: float, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Rates in units of an orbital rate of zero, or a start of another one, are no candidates."""
    scene, result = written(tmp_path, "damped"), tmp_path / "run.csv"
    assert command(["simulate", str(scene), "--out", str(result)]) == 0
    table = pd.read_csv(result)
    table[["rate_1_rad_s", "rate_2_rad_s"]] *= factor
    table.loc[0, ["rate_1_rad_s", "rate_2_rad_s"]] += 1e-3
    table.to_csv(result, index=False)
    assert command(["judge", str(scene), str(result), "--rtol", "1e-9"]) == 1
    assert "Warning" not in capfd.readouterr().err
