"""Parts of this installation, and which figure depends on which."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING

import pytest

from barchain.nightly.figures.dependencies import (
    DECIDING,
    capture,
    depends_on,
    environment_parts,
    installed_parts,
    recorded_environment,
    variables_part,
)
from barchain.nightly.figures.figure import FigureKind
from barchain.record.environment import environment, machine
from barchain.record.sources import contents_digest, installed_commit, made_by_wheel

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.figures.figure import NightPart


def named(*engines: str) -> dict[str, NightPart]:
    return {part.name: part for part in installed_parts(engines, ["paper/fig05"], capture())}


def test_the_environment_names_the_machine_and_its_libraries() -> None:
    here = capture()
    assert here.cpu
    assert here.cores >= 1
    assert here.python.startswith("3.")
    assert "openblas" in here.blas or "mkl" in here.blas or here.blas
    assert recorded_environment({"environment": environment(), "machine": machine()}) == here


def test_a_blas_that_a_wheel_brings_along_is_part_of_the_wheel() -> None:
    def blas(text: str) -> str:
        return environment_parts(dataclasses.replace(capture(), blas=text))[1].digest

    assert blas("openblas 0.3.27 Haswell (numpy)") == blas("openblas 0.3.30 Haswell (numpy)")
    assert blas("openblas 0.3.27 Haswell (numpy)") != blas("openblas 0.3.27 SkylakeX (numpy)")
    assert blas("openblas 0.3.27 Haswell") != blas("openblas 0.3.30 Haswell")
    assert "(numpy)" in capture().blas or "numpy" not in capture().blas


def test_an_earlier_record_tells_kernel_and_c_library_by_the_platforms_name() -> None:
    own = {"platform": "Linux-6.1.0-x86_64-with-glibc2.36", "cpu": "Example", "cores": 2, "python": "3.11.9"}
    found = recorded_environment({"environment": own})
    assert (found.libc, found.kernel, found.blas) == ("glibc 2.36", "Linux-6.1.0-x86_64", "")


def test_every_part_of_an_installation_has_a_digest() -> None:
    parts = named("reference", "rebound", "pymunk")
    assert all(part.digest for part in parts.values())
    assert {"engine:rebound", "adapter:rebound", "scene:paper/fig05", "solution:paper/fig05"} <= set(parts)
    assert parts["adapter:rebound"].digest != parts["adapter:pymunk"].digest


def test_a_figure_depends_on_its_own_engine_and_a_ratio_on_its_anchor_too() -> None:
    own = set(depends_on("paper/fig05", "rebound", FigureKind.BITS))
    assert "engine:rebound" in own
    assert not any(part in own for part in ("engine:pymunk", "adapter:pymunk", "judge", "solution:paper/fig05"))
    assert {"judge", "solution:paper/fig05"} <= set(depends_on("paper/fig05", "rebound", FigureKind.ERROR))
    assert "engine:pymunk" in depends_on("paper/fig05", "rebound", FigureKind.RATIO, "pymunk")


def installed_editable(folder: Path, *, editable: bool) -> Path:
    """Distribution `toy-engine` in a folder, with the only source of its module, which its list of files lacks."""
    about = folder / "toy_engine-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-engine\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[barchain.engines]\ntoy = toymotion.chain:Toy\n")
    (about / "direct_url.json").write_text(json.dumps({"url": folder.as_uri(), "dir_info": {"editable": editable}}))
    (about / "RECORD").write_text("toy_engine-1.0.dist-info/METADATA,,\n")
    source = folder / "toymotion" / "chain.py"
    source.parent.mkdir()
    (source.parent / "__init__.py").touch()
    source.write_text("step = 1.0")
    return source


def test_pip_notes_the_commit_of_an_installation_from_a_repository(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed_editable(tmp_path, editable=False)
    monkeypatch.syspath_prepend(tmp_path)
    assert installed_commit("toy-engine") is None
    place = {"url": "https://example.org/toy", "vcs_info": {"vcs": "git", "commit_id": "0123456789abcdef"}}
    (tmp_path / "toy_engine-1.0.dist-info" / "direct_url.json").write_text(json.dumps(place))
    assert installed_commit("toy-engine") == "0123456789abcdef"


@pytest.mark.parametrize("editable", [True, False])
def test_sources_of_an_editable_distribution_count(
    editable: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = installed_editable(tmp_path, editable=editable)
    monkeypatch.syspath_prepend(tmp_path)
    before = contents_digest("toy-engine")
    assert before == contents_digest("toy-engine")
    source.write_text("step = 2.0")
    assert (contents_digest("toy-engine") != before) is editable


def test_the_digest_of_a_distribution_is_that_of_its_contents() -> None:
    assert contents_digest("rebound") == contents_digest("rebound")
    assert contents_digest("rebound") != contents_digest("pymunk")
    assert contents_digest("no-such-distribution") == ""
    made_here = ("x-1.0.dist-info/RECORD", "x/__pycache__/y.cpython-311.pyc", "x-1.0.dist-info/uv_cache.json")
    assert not any(map(made_by_wheel, made_here))
    assert all(map(made_by_wheel, ("x/y.py", "x-1.0.dist-info/METADATA")))


def test_a_variable_that_chooses_the_code_which_computes_is_a_part(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in DECIDING:
        monkeypatch.delenv(name, raising=False)
    before = variables_part()
    monkeypatch.setenv("BARCHAIN_KERNEL", "other.so")
    after = variables_part()
    assert before.differs(after)
    assert after.version == "BARCHAIN_KERNEL=other.so"
    assert "variables" in depends_on("paper/fig05", "reference", FigureKind.BITS)
