"""Standard streams that are closed or full cost the output, not the runs; surroundings that allow no run are told."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from barchain.cli.main import run

BARCHAIN = f"{sys.executable} -m barchain"
COMPARE = f"{BARCHAIN} compare basics/kepler_circular --engine reference --workers 1 --out out"
posix = pytest.mark.skipif(os.name != "posix", reason="a shell of POSIX redirects the streams")
needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["sh", "-c", line], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    "streams", ["<&- >&- 2>&-", pytest.param("2>/dev/full", marks=[needs_full, pytest.mark.exhaustive])]
)
def test_closed_streams_and_a_full_standard_error_cost_no_run(streams: str, tmp_path: Path) -> None:
    made = shell(f"{COMPARE} {streams}", tmp_path)
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "out" / "index.html").is_file()


@pytest.mark.exhaustive
@posix
@needs_full
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_standard_output_that_is_full_is_told_after_the_work(unbuffered: str, tmp_path: Path) -> None:
    made = shell(f"PYTHONUNBUFFERED={unbuffered} {COMPARE} >/dev/full", tmp_path)
    assert made.returncode == 2
    assert made.stderr.splitlines()[-1].startswith("barchain: standard output is lost: ")
    assert (tmp_path / "out" / "index.html").is_file()


@posix
def test_a_current_folder_that_is_gone_is_one_line(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    made = shell(f"rmdir {gone}; {BARCHAIN} simulate basics/kepler_circular --out {tmp_path}/x.csv", gone)
    assert (made.returncode, len(made.stderr.splitlines())) == (2, 1)
    assert "the current folder is gone" in made.stderr


@posix
@pytest.mark.timeout(60)
def test_a_scene_that_is_a_device_or_a_pipe_is_rejected_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe.toml")
    for path in ("/dev/zero", "pipe.toml"):
        assert run(["compare", path]) == 2
        said = f"barchain: {path}: a device, a pipe or a socket; a scene is an ordinary file that ends with .toml\n"
        assert capsys.readouterr().err == said
