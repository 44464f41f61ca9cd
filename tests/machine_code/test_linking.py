"""Machine code works wherever the system finds memory for it."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("llvmlite", reason="compiled code needs it")

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from scenarios import load_scene
from tests.machine_code import crowded_process


@pytest.mark.skipif(sys.platform != "linux", reason="the layout of memory is Linux's")
def test_code_and_its_constants_lie_together_in_a_process_with_little_free_address_space() -> None:
    made = subprocess.run([sys.executable, crowded_process.__file__], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr[-500:]
    here = ENGINES["reference-fast"].load()().run(load_scene("paper/fig05"), Setting(AccuracyParameter.RTOL, 1e-8))
    assert here.angle_rad is not None
    assert float.fromhex(made.stdout) == here.angle_rad[-1, 0]
