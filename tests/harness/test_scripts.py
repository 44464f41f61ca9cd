"""A plain script may call barchain: processes do not import the script that starts them."""

import subprocess
import sys

import pytest

SCRIPT = """
from barchain import load_scene, simulate

print("once")
simulate(load_scene("basics/two_bars_free"), "reference")
simulate(load_scene("basics/two_bars_free"), "exudyn")
"""


@pytest.mark.slow
def test_a_script_needs_no_guard_and_runs_once(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr
