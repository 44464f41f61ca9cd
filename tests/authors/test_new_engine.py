"""`barchain new-engine`: a whole package with a right engine, or one line and nothing written."""

from __future__ import annotations

import ast
import importlib
import os
import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from adapters.reference.numpy_engines import Reference
from adapters.registry import RESERVED, Registration, third_party
from barchain.cli.main import run
from barchain.engine import AccuracyParameter, Engine, Setting
from barchain.engine.new_package import package_names
from barchain.runs.trajectory_checks import fault
from barchain.studies.comparison.run import run_comparison
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.structure.product import ROOT
from tests.support.changed import lasting
from tests.support.generic_scenes import worst
from tests.support.slow import one_in

if TYPE_CHECKING:
    from collections.abc import Iterator

NAME = "my-Engine_2"
SCENE = "basics/two_bars_free"
QUICK = (SCENE, "basics/radial_equilibrium", "paper/fig13", "effects/thrust", "effects/joint_springs")
SUPPORTED_OF_THE_CORE = 13  # all but the two with prescribed rotations


def core_scenes() -> list[str]:
    files = (p for folder in ("basics", "paper") for p in (ROOT / "scenarios" / folder).glob("*.toml"))
    return sorted(f"{p.parent.name}/{p.stem}" for p in files)


@pytest.fixture(name="package", scope="module")
def _package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("new") / "package"
    assert run(["-q", "new-engine", NAME, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(name="made", scope="module")
def _made(package: Path) -> Iterator[type[Engine]]:
    """The new engine's class, imported from its source folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(package / "src")
        module, _, name = target_of(package).partition(":")
        yield getattr(importlib.import_module(module), name)


def target_of(package: Path) -> str:
    table = tomllib.loads((package / "pyproject.toml").read_text(encoding="utf-8"))
    found: str = table["project"]["entry-points"]["barchain.engines"][NAME]
    return found


def test_the_package_has_metadata_source_a_test_and_a_readme(package: Path) -> None:
    files = {p.relative_to(package).as_posix() for p in package.rglob("*") if p.is_file()}
    source = {f"src/barchain_my_engine_2/{n}" for n in ("__init__.py", "adapter.py", "chain.py", "py.typed")}
    assert files == source | {"README.md", "pyproject.toml", "tests/test_conformity.py"}


def test_the_entry_point_is_one_that_the_registry_takes(package: Path) -> None:
    point = EntryPoint(NAME, target_of(package), "barchain.engines")
    assert third_party([point])[NAME].rejected == ""


def test_the_packages_own_test_is_one_line_that_calls_conform_and_skips_nothing(package: Path) -> None:
    text = (package / "tests/test_conformity.py").read_text(encoding="utf-8")
    (test,) = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    assert len(test.body) == 1
    assert f'assert_conforms("{NAME}")' in text
    assert "skip" not in text


def test_nothing_in_the_package_is_left_to_fill_in(package: Path) -> None:
    texts = [p.read_text(encoding="utf-8") for p in package.rglob("*") if p.is_file()]
    assert not any(mark in text for text in texts for mark in ("{{", "{%", "TODO", "None.", str(ROOT)))


def test_the_source_has_the_style_of_barchains_own(package: Path) -> None:
    pytest.importorskip("ruff")
    for command in (["check"], ["format", "--check"]):
        options = ["--no-cache", "-q", "--config", str(ROOT / "pyproject.toml"), "src"]
        line = [sys.executable, "-m", "ruff", *command, *options]
        done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=package)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", one_in(4, QUICK))
def test_the_engine_returns_what_it_declares_and_agrees_with_the_reference(name: str, made: type[Engine]) -> None:
    whole = load_scene(name)
    scene = lasting(whole, 19.0 * whole.times_s[1], 20)
    seen, expected = made().run(scene), Reference().run(scene)
    assert fault(scene, made, seen) is None
    assert worst(seen.angle_rad, expected.angle_rad) < 1e-6
    assert expected.reaction_N is not None
    scale = max(np.abs(expected.reaction_N).max(initial=0.0), 1e-12)
    assert worst(seen.reaction_N, expected.reaction_N) < 1e-5 * scale


def test_the_engine_converges_with_its_declared_order(made: type[Engine]) -> None:
    whole, ends = load_scene("paper/fig05"), []
    scene = lasting(whole, 0.3 * whole.period_s, 3)
    for steps in (100, 200, 400):
        seen = made().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, steps))
        assert seen.angle_rad is not None
        ends.append(seen.angle_rad[-1])
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert np.log2(ratio) == pytest.approx(made.order, abs=0.5)


def test_the_engine_supports_all_core_scenes_but_prescribed_rotations(made: type[Engine]) -> None:
    reasons = {name: made.unsupported(load_scene(name)) for name in core_scenes()}
    assert sum(r is None for r in reasons.values()) == SUPPORTED_OF_THE_CORE
    assert all("prescribed rotation" in r for r in reasons.values() if r)


def test_a_bar_at_the_surface_ends_the_run_with_a_reason(made: type[Engine]) -> None:
    scene = load_scene("hard/vertical_fall")
    seen, expected = made().run(scene), Reference().run(scene)
    assert expected.ended
    assert seen.ended.startswith("a bar reached the surface at t = ")
    assert abs(len(seen.t_s) - len(expected.t_s)) <= 1


@pytest.mark.exhaustive
def test_a_comparison_passes_the_engine_on_every_scene_that_it_supports(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    above = [str(package / "src"), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, above)))
    monkeypatch.syspath_prepend(package / "src")
    names = core_scenes()
    result = run_comparison(names, out=tmp_path / "out", registered={NAME: Registration(target_of(package))})
    found = {name: result.outcomes[name, NAME] for name in names}
    assert set(found.values()) <= {Outcome.PASS, Outcome.UNSUPPORTED}, found
    assert list(found.values()).count(Outcome.PASS) == SUPPORTED_OF_THE_CORE


@pytest.mark.exhaustive
def test_the_package_installs_with_pip_and_takes_part_in_a_comparison(package: Path, tmp_path: Path) -> None:
    python = tmp_path / "venv/bin/python"
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    subprocess.run([python, "-m", "pip", "install", "-q", str(ROOT)], check=True, timeout=600)
    subprocess.run([python, "-m", "pip", "install", "-q", str(package)], check=True, timeout=300)
    words = ["compare", SCENE, "--engine", "reference", "--engine", NAME, "--out", "out"]
    subprocess.run([python, "-m", "barchain", *words], check=True, cwd=tmp_path, timeout=300)


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["a b"], "'a b' given, allowed: 1 to 40 letters"),
        (["x" * 41], "allowed: 1 to 40 letters"),
        (["x_"], "a letter or digit at both ends"),
        ([""], "no text given"),
        (["Reference"], "barchain registers an engine of that name"),
        ([sorted(RESERVED)[0]], "names barchain's own files"),
        (["Reference-Impl"], "which names a package of barchain"),
        (["json"], "json given, which names a package of Python's library"),
        (["trial", "--out", "nowhere/trial"], "there is no folder nowhere"),
        (["trial", "--out", "."], "is there already"),
        (["trial", "--out", ""], "no text given"),
        ([], "Missing argument 'NAME'"),
    ],
)
def test_a_bad_name_or_folder_gives_one_line_and_writes_nothing(
    typed: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["new-engine", *typed]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    assert words in error
    assert list(tmp_path.iterdir()) == []


def test_an_engine_that_another_package_registers_keeps_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    others = {"theirs": Registration("their_package:Engine", distribution="their-package")}
    monkeypatch.setattr("barchain.engine.new_package.engines", lambda: others)
    assert run(["new-engine", "Theirs"]) == 2
    assert "their-package registers an engine of that name" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["folder", "dangling link"])
def test_what_is_there_is_kept(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    place = tmp_path / "trial"
    if kind == "dangling link":
        place.symlink_to(tmp_path / "gone")
    else:
        place.mkdir()
        (place / "mine").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    assert run(["new-engine", "trial"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "trial is there already" in error
    assert sorted(tmp_path.rglob("*")) == before


def test_a_disk_that_fails_midway_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write = Path.write_text

    def until_full(path: Path, *given: Any, **options: Any) -> int:
        if path.name == "chain.py":
            raise OSError(28, "No space left on device", "chain.py")
        return write(path, *given, **options)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Path, "write_text", until_full)
    assert run(["new-engine", "trial"]) == 2
    assert capsys.readouterr().err == "barchain: chain.py: No space left on device\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "class_name"),
    [("odin", "OdinEngine"), ("my-engine_2", "MyEngine2Engine"), ("3d", "N3dEngine"), ("error", "ErrorEngine")],
)
def test_names_are_identifiers_that_hide_no_library(name: str, class_name: str) -> None:
    names = package_names(name)
    assert names.class_name == class_name
    assert names.class_name.isidentifier()
    assert names.module.isidentifier()
    assert names.module != name
