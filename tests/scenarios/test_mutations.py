"""Mutated scene files: each is a scene, or is rejected in short lines; no other exception, no hang, no stray file."""

import random
import time
from pathlib import Path

import numpy as np
import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.main import run
from scenarios import SceneError, load_scene
from scenarios.size_limits import MOST_FAULTS, MOST_LINE
from scenarios.text import is_hidden
from tests.scenarios.mutations import SOURCES, mutations

SECONDS = 20.0


def fault_of(content: bytes, folder: Path) -> str:
    """What is wrong with the end of reading a file; empty if nothing is."""
    path = folder / "m.toml"
    path.write_bytes(content)
    begun = time.monotonic()
    try:
        scene = load_scene(path)
    except SceneError as error:
        lines = str(error).split("\n")
        readable = all(line.startswith(str(path)) and len(line) < MOST_LINE + len(str(path)) + 100 for line in lines)
        plain = not any(is_hidden(c) for line in lines for c in line)
        found = "" if readable and plain and len(lines) <= MOST_FAULTS + 1 else f"lines: {lines!r:.300}"
    except BaseException as error:
        found = f"{type(error).__name__}: {error}"
    else:
        numbers = (scene.period_s, scene.radius0_m, scene.speed0_m_s, scene.fastest_rate_rad_s, scene.run.duration_s)
        found = "" if np.isfinite(numbers).all() else f"not finite: {numbers}"
    slow = time.monotonic() - begun > SECONDS
    return f"{content[:300]!r}: {found}{' slow' if slow else ''}" if found or slow else ""


def check(contents: list[bytes], folder: Path) -> None:
    faults = [fault_of(content, folder) for content in contents]
    assert not any(faults), "\n".join(filter(None, faults))
    assert [path.name for path in folder.rglob("*")] == ["m.toml"]


def test_a_sample_of_mutated_scenes_is_read_or_rejected_in_short_lines(tmp_path):
    check(random.Random(3).sample([m for name in SOURCES for m in mutations(name)], 150), tmp_path)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", SOURCES)
def test_every_mutated_scene_is_read_or_rejected_in_short_lines(name, tmp_path):
    check(mutations(name, 400), tmp_path)


def test_mutated_scenes_end_a_command_with_0_or_2(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "m.toml"
    for content in random.Random(5).sample(mutations("effects/thrust"), 40):
        path.write_bytes(content)
        for line in (["validate", str(path)], ["scenes", "show", str(path), "--json"]):
            assert run(line) in {ExitCode.OK, ExitCode.BAD_INPUT}
            assert "Traceback" not in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]
