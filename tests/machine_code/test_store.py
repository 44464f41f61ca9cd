"""Machine code on disk: kept once, by source, compiler and processor, and never trusted when damaged."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("llvmlite", reason="compiled code needs it")

from reference_impl.machine_code import store, target
from tests.machine_code.small_library import fresh

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(store.PLACE, str(tmp_path))
    return tmp_path


def test_machine_code_is_kept_once(folder: Path) -> None:
    first = fresh()
    assert not first.is_kept
    assert first.code == fresh().code
    assert [path.name for path in folder.iterdir()] == [f"{first.key}{store.SUFFIX}"]


@pytest.mark.parametrize("damage", [b"", b"text", None])
def test_a_damaged_file_is_compiled_anew(folder: Path, damage: bytes | None) -> None:
    made = fresh()
    code = made.code
    path = folder / f"{made.key}{store.SUFFIX}"
    content = path.read_bytes()
    path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]) if damage is None else damage)
    assert not fresh().is_kept
    assert fresh().code == code
    assert path.read_bytes() == content


def test_code_for_another_processor_or_compiler_is_not_taken(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {fresh().key}
    monkeypatch.setattr(target, "processor", lambda: ("haswell", ""))
    keys.add(fresh().key)
    monkeypatch.setattr("llvmlite.__version__", "0.0")
    keys.add(fresh().key)
    assert len(keys) == 3


def test_a_folder_that_can_not_be_made_costs_the_compilation_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(store.PLACE, str(tmp_path / "file" / "compiled"))
    assert fresh().code
    assert not fresh().is_kept


def test_two_processes_at_once_keep_one_whole_file(folder: Path) -> None:
    script = "from tests.machine_code.small_library import fresh; print(len(fresh().code))"
    running = [subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    sizes = {p.communicate()[0] for p in running}
    assert all(p.returncode == 0 for p in running)
    assert len(sizes) == 1
    assert fresh().is_kept
    assert len(list(folder.iterdir())) == 1
