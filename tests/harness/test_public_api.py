"""The package's own names: complete, quick to import, and what they say they are."""

import inspect
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import barchain
from pictures.paths import DOCS
from tests.support.report_fixture import build

STUDIES = ("ensemble", "cost", "effects", "sweep", "measure", "asked_run")
HEAVY = ("numpy", "pandas", "scipy", "matplotlib", "pydantic", "exudyn")
SCRIPT = """
from barchain import load_scene, simulate

print("once")
simulate(load_scene("basics/two_bars_free"), "exudyn")
"""


def test_importing_barchain_imports_nothing_heavy() -> None:
    code = f"import sys, barchain; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there_and_another_is_an_attribute_error() -> None:
    assert not [name for name in barchain.__all__ if getattr(barchain, name) is None or name not in dir(barchain)]
    assert {*barchain.MODULES, "__version__"} == set(barchain.__all__)
    assert barchain.__version__ == version("barchain")
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        barchain.nonsense  # noqa: B018


def test_scenes_are_chosen_by_tag_and_engines_say_what_is_missing() -> None:
    assert "paper/fig05" in barchain.scenes()
    assert set(barchain.scenes("basics")) < set(barchain.scenes())
    assert barchain.scenes("no such tag") == []
    assert barchain.engines()["reference"].missing is None
    assert barchain.engines()["reference"].by_default


def test_a_folder_is_rendered_again(tmp_path: Path) -> None:
    build(tmp_path, ["basics/radial_equilibrium"], faults=False, samples=11)
    assert tmp_path / "index.html" in barchain.render(str(tmp_path))


def test_public_functions_document_every_parameter_and_result() -> None:
    for name in ("scenes", "engines", "simulate", "compare", "render", *STUDIES):
        function = getattr(barchain, name)
        text = inspect.getdoc(function) or ""
        for parameter in inspect.signature(function).parameters:
            assert f"\n{parameter} :" in text or f"\n**{parameter} :" in text, name
        assert "Returns\n" in text, name


def test_the_reference_pages_have_every_public_name() -> None:
    page = (DOCS / "reference" / "python.md").read_text("utf-8")
    engines = (DOCS / "reference" / "engine_interface.md").read_text("utf-8")
    shown = {*re.findall(r"auto(?:class|function):: (\w+)$", page, re.MULTILINE), *re.findall(r"## `(\w+)`", engines)}
    assert {name for name in barchain.__all__ if not name.startswith("_")} <= shown


def test_an_ensemble_names_magnitudes_and_a_trajectory_vectors() -> None:
    found = barchain.ensemble("paper/fig09", ["angle_deg=normal(80, 0.1)"], runs=250, orbits=0.01, samples=3)
    assert found.reaction_size_N.shape == (250, 3, 4)
    assert np.all(found.reaction_size_N > 0.0)
    assert not hasattr(found, "reaction_N")


@pytest.mark.slow
def test_the_studies_of_cost_and_effects_return_their_tables() -> None:
    priced = barchain.cost(["basics/two_bars_free"], ["reference-fast"], orbits=0.01, repeats=1, minutes=0.01)
    assert set(priced.points.engine) == {"reference-fast"}
    budget = barchain.effects("basics/two_bars_free", rtol=1e-5, repeats=1, minutes=0.001, engine="reference-fast")
    assert len(budget.effects) > 1


@pytest.mark.slow
def test_a_script_needs_no_guard_and_runs_once(tmp_path: Path) -> None:
    """Processes do not import the script that starts them."""
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr
