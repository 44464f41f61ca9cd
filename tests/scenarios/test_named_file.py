"""Files that a user names: bounded, ended in time, with or without a byte-order mark."""

import os
import threading
from pathlib import Path

import pytest

from adapters.command.entries import read_entries
from barchain.nightly.running.plan import SHIPPED as PLAN
from barchain.nightly.running.plan import load_plan
from scenarios import load_scene
from scenarios.load import SHIPPED, SceneError
from scenarios.named_file import UnreadableError, read_named

needs_devices = pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs devices of Unix")


@needs_devices
@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom"])
def test_a_device_without_an_end_is_read_up_to_the_bound_alone(device):
    with pytest.raises(UnreadableError, match="more than 10000000 bytes given, allowed"):
        read_named(Path(device), 10_000_000)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_without_a_writer_is_given_up_and_one_that_ends_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr("scenarios.named_file.WAIT_S", 0.2)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(UnreadableError, match="has no end"):
        read_named(pipe, 100)
    monkeypatch.setattr("scenarios.named_file.WAIT_S", 30.0)
    writer = threading.Thread(target=lambda: pipe.write_bytes(b"t,angle_1\n"))
    writer.start()
    assert read_named(pipe, 100) == b"t,angle_1\n"
    writer.join()


@pytest.mark.parametrize("mark", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_changes_no_scene_no_plan_and_no_file_of_engines(tmp_path, mark):
    engines = tmp_path / "mine" / "engines.toml"
    engines.parent.mkdir()
    entry = 'name = "a"\ncommand = "a {request} {samples}"\neffects = ["gravity.point"]\nrtol = [1e-7, 1e-9]\n'
    engines.write_text(f"[[engine]]\n{entry}")
    scene = SHIPPED / "basics" / "two_bars_free.toml"
    for source, load in ((scene, load_scene), (PLAN, load_plan), (engines, read_entries)):
        copy = tmp_path / source.name
        copy.write_text(source.read_text("utf-8"), encoding=mark)
        assert load(copy)


def test_a_damaged_mark_is_one_line(tmp_path):
    (tmp_path / "x.toml").write_bytes(b"\xff\xfea")
    with pytest.raises(SceneError, match=r"can't be read as UTF-16"):
        load_scene(tmp_path / "x.toml")
