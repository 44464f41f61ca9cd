"""Fresh environments and mixtures of sources: what is asked for is what is there, or one line says why not."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from adapters.command.own_python import VARIABLE, environments_folder
from barchain.nightly.attribution import environments
from barchain.nightly.attribution.environments import (
    PinnedEnvironment,
    commit_tree,
    constraints,
    installed_tree,
    loosened,
    pinned_environment,
    replace_packages,
    requirements,
    run_in,
)
from barchain.nightly.errors import PinnedEnvironmentError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environments"))


def test_a_pin_takes_the_place_of_the_installed_version_and_leaves_all_others() -> None:
    wanted = requirements(["numpy==1.26.4"], ["pymunk"])
    assert "numpy==1.26.4" in wanted
    assert sum(one.startswith("numpy") for one in wanted) == 1
    assert any(one.startswith("pymunk==") for one in wanted)
    held = constraints(["numpy==1.26.4"])
    assert not any(one.startswith(("numpy==", "barchain==")) for one in held)
    assert any(one.startswith("scipy==") for one in held)
    free = loosened(wanted)
    assert free[-1] == "numpy==1.26.4"
    assert "scipy" in free


def test_one_part_of_the_sources_is_exchanged_and_nothing_else(tmp_path: Path) -> None:
    tree, other = installed_tree(tmp_path / "tree"), installed_tree(tmp_path / "other")
    (other / "adapters/mujoco/new.py").write_text("", "utf-8")
    (other / "adapters/mujoco/chain.py").unlink()
    (other / "adapters/engine.py").write_text("changed", "utf-8")
    (other / "barchain/api.py").write_text("changed", "utf-8")
    replace_packages(tree, other, ("adapters.mujoco", "adapters.engine"))
    assert (tree / "adapters/mujoco/new.py").is_file()
    assert not (tree / "adapters/mujoco/chain.py").exists()
    assert (tree / "adapters/engine.py").read_text("utf-8") == "changed"
    assert (tree / "barchain/api.py").read_text("utf-8") != "changed"


def repository(folder: Path) -> Path:
    folder.mkdir()

    def git(*words: str) -> None:
        subprocess.run(["git", "-C", str(folder), *words], check=True, capture_output=True)

    git("init", "-q")
    git("config", "user.name", "Ada")
    git("config", "user.email", "ada@example.org")
    for name in ("barchain", "adapters", "reference_impl", "scenarios", "reports"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(name, "utf-8")
    git("add", ".")
    git("commit", "-qm", "first")
    return folder


def test_the_sources_of_a_commit_are_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = repository(tmp_path / "repository")
    monkeypatch.setattr(environments, "__file__", str(own / "module.py"))
    (own / "adapters" / "__init__.py").write_text("later", "utf-8")
    tree = commit_tree("HEAD", tmp_path / "tree")
    assert (tree / "adapters" / "__init__.py").read_text("utf-8") == "adapters"


@pytest.mark.parametrize(
    ("commit", "said"), [("0123456789+", "differed from the commit"), ("no-such-commit", "no-such-commit")]
)
def test_sources_that_can_not_be_made_again_are_told_in_one_line(
    tmp_path: Path, commit: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(environments, "__file__", str(repository(tmp_path / "repository") / "module.py"))
    with pytest.raises(PinnedEnvironmentError, match=said) as told:
        commit_tree(commit, tmp_path / "tree")
    assert "\n" not in str(told.value)


@pytest.mark.exhaustive
def test_an_older_release_runs_todays_barchain_and_a_version_that_does_not_exist_is_told(tmp_path: Path) -> None:
    made = pinned_environment(["pymunk==7.3.0"])
    tree = installed_tree(tmp_path / "tree")
    code = "import pymunk, barchain; print(pymunk.version, barchain.__file__)"
    done = run_in(made.python, tree, ("-c", code), limit_s=60.0, folder=tmp_path)
    assert done.output.split() == ["7.3.0", str(tree / "barchain" / "__init__.py")]
    assert pinned_environment(["pymunk==7.3.0"]).folder == made.folder
    with pytest.raises(PinnedEnvironmentError, match="99"):
        pinned_environment(["pymunk==99"])
    assert [p.name for p in environments_folder().iterdir() if p.is_dir()] == [made.folder.name]


def test_a_command_that_does_not_end_is_killed(tmp_path: Path) -> None:
    here = PinnedEnvironment(tmp_path, ())
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(sys.executable)
    done = run_in(here.python, tmp_path, ("-c", "import time; time.sleep(60)"), limit_s=1.0, folder=tmp_path)
    assert done.reason == "did not end within 1 s"
    done = run_in(here.python, tmp_path, ("-c", "raise ValueError('no')"), limit_s=30.0, folder=tmp_path)
    assert done.reason == "ValueError: no"
