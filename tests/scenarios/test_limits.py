"""Files within limits: each fault costs one readable line, whatever the file is or holds."""

import os
import re
import threading
from pathlib import Path

import pytest

from adapters.command.entries import read_entries
from barchain.nightly.running.plan import SHIPPED as PLAN
from barchain.nightly.running.plan import load_plan
from scenarios import SceneError, load_scene, parse_scene
from scenarios.load import SHIPPED
from scenarios.named_file import UnreadableError, read_named
from scenarios.size_limits import BARS, FILE_BYTES, MOST_FAULTS, MOST_LINE, MOST_MAGNITUDE, LimitError
from scenarios.text import check_scene_name, is_hidden
from tests.scenarios.test_scenes import GOOD, rejected

ALTITUDE, TITLE = "altitude_m = 350e3", 'title = "t"'


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("bars = 3", "bars = 1_000_000_000"), ["chain.bars: 1000000000 bars given", "100000", BARS.variable]),
        (("bars = 3", "bars = " + "9" * 9000), ["not valid TOML", "digits"]),
        (("orbits = 1.0", "orbits = 1.0\nsamples = 9_000_000_000"), ["run.samples", "1000000"]),
        ((TITLE, f'title = "{"a" * 50_000}"'), ["title", "50000 characters given", "at most 200"]),
        ((TITLE, f"title = 't'\n{'k' * 100_000} = 1"), ["kkk...", "unknown key", "allowed here"]),
        ((ALTITUDE, "altitude_m = 1e308"), ["orbit.altitude_m", "1e+308 given", "1e+30"]),
        ((ALTITUDE, "altitude_m = 1e-40"), ["orbit.altitude_m", "1e-40 given", "1e-30 to 1e+30"]),
        ((TITLE, 'title = "a\\u001b[31m"'), ["title", "character 2 is U+001B", "one line of text"]),
        ((TITLE, 'title = "a\\u202eb"'), ["title", "U+202E RIGHT-TO-LEFT OVERRIDE"]),
        ((TITLE, 'title = "t"\n"a\\u202e\\nb" = 1'), ["a\\u202e\\nb", "unknown key"]),
        ((TITLE, TITLE + "\ntags = [" + "'a'," * 51 + "]"), ["tags", "51", "at most 50"]),
    ],
)  # fmt: skip
def test_a_scene_beyond_a_limit_is_rejected_in_one_short_line(change: tuple[str, str], words: list[str]) -> None:
    message = rejected(GOOD.replace(*change))
    assert "\n" not in message
    assert message.startswith("x.toml: ")
    assert all(word in message for word in words), message
    assert len(message) <= MOST_LINE
    assert message.isascii()


def test_a_description_may_have_lines_and_tabs_and_becomes_one_line() -> None:
    scene = parse_scene(GOOD.replace(TITLE, TITLE + '\ndescription = """a\n\tb"""'), name="x", file="x.toml")
    assert scene.description == "a b"


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(10**12)  # on file systems with holes; reading would end the process
    with pytest.raises(SceneError, match=rf"large\.toml: {10**12} bytes given, allowed: at most {FILE_BYTES.usual}"):
        load_scene(path)


@pytest.mark.parametrize("content", [b"\xff\xfet\x00", b'title = "\xff"', b""])
def test_a_file_of_other_bytes_is_rejected_in_one_line(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bytes.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert all(line.startswith(str(path)) for line in str(caught.value).split("\n"))


def test_a_file_of_many_faults_tells_the_first_and_counts_the_rest() -> None:
    message = rejected("\n".join(f"key_{k} = 1" for k in range(100_000)) + GOOD)
    lines = message.split("\n")
    assert len(lines) == MOST_FAULTS + 1
    assert lines[-1].endswith(f"{100_000 - MOST_FAULTS} more faults")


def test_too_many_tables_of_an_effect_are_counted() -> None:
    impulse = "[[effects.impulse]]\nbar = 1\ndirection_deg = 0.0\nimpulse_N_s = 1.0\nat_s = 5.0\n"
    assert "effects.impulse: 1001 tables or values given, allowed: at most 1000" in rejected(GOOD + impulse * 1001)


def test_bars_times_samples_fit_into_memory() -> None:
    text = GOOD.replace("bars = 3", "bars = 50_000").replace("length_m = [10.0, 20.0, 30.0]", "length_m = 0.1")
    message = rejected(text)
    assert "run.samples: 50000 bars at 501 samples: 25050000 values" in message
    assert "BARCHAIN_MOST_VALUES" in message


def test_a_variable_allows_more_and_a_wrong_one_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(BARS.variable, "2")
    assert "3 bars given, allowed: at most 2" in rejected(GOOD)
    for wrong in ("nan", "0", "9" * 5000):
        monkeypatch.setenv(BARS.variable, wrong)
        assert f"{BARS.variable}=" in rejected(GOOD)
    monkeypatch.setenv(BARS.variable, "3")
    assert parse_scene(GOOD, name="x", file="x.toml").bars == 3


@pytest.mark.parametrize("signs", [(1, 1, 1, 1), (-1, -1, -1, -1), (1, -1, 1, -1), (-1, 1, 1, -1)])
def test_all_derived_quantities_of_the_largest_and_smallest_numbers_are_finite(signs: tuple[int, ...]) -> None:
    numbers = [f"{MOST_MAGNITUDE**sign!r}" for sign in signs]
    text = re.sub(r"\[run\]\norbits = 1.0", "[run]\nduration_s = {2}\n[central_body]\nmu_m3_s2 = {3}", GOOD)
    text = text.replace(ALTITUDE, "altitude_m = 1e30\nspeed_factor = {0}").replace("mass_kg = 100.0", "mass_kg = {1}")
    scene = parse_scene(text.format(*numbers), name="x", file="x.toml")
    found = (
        scene.period_s,
        scene.step_period_s,
        scene.speed0_m_s,
        scene.fastest_rate_rad_s,
        *scene.chain.inertia_kg_m2,
    )
    assert all(0.0 < value < float("inf") for value in found)


NAMES_OUTSIDE = (
    "x/../../etc", ".", "", "/etc/x", "x//y", "a\\b", "C:x", "a\u202eb", "a\udcffb", "a\0b", "a/ /b", "a" * 201,
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES_OUTSIDE)
def test_a_name_that_leads_out_of_a_folder_is_no_scene_name(name: str) -> None:
    with pytest.raises(LimitError) as caught:
        check_scene_name(name)
    assert "\n" not in str(caught.value)
    with pytest.raises((LimitError, SceneError)):
        parse_scene(GOOD, name=name, file="x.toml")


@pytest.mark.parametrize("given", ["{0}/mine", "x/../{1}/mine", "{1}/mine"])
def test_a_path_without_its_ending_is_no_name(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.toml").write_text(GOOD)
    shipped = os.path.relpath(tmp_path, load_scene.__globals__["SHIPPED"])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="no such scene"):
        load_scene(given.format(tmp_path, shipped))


def test_what_is_no_scene_file_suggests_the_nearest_beside_it(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(GOOD)
    for given in ("mine", "mien.toml"):
        with pytest.raises(SceneError, match=rf"did you mean {tmp_path}/mine\.toml\?"):
            load_scene(tmp_path / given)
    with pytest.raises(SceneError, match="no such scene"):
        load_scene("n" * 5000)  # a name that the system does not take


@pytest.mark.parametrize("name", ["..toml", "...toml", "a\u202e.toml", "a\n.toml"])
def test_a_file_whose_name_makes_no_scene_name_is_rejected(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(GOOD)
    with pytest.raises(SceneError, match="scene name") as caught:
        load_scene(tmp_path / name)
    assert not any(map(is_hidden, str(caught.value)))


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs devices of Unix")
def test_a_device_without_an_end_is_read_up_to_the_bound_alone():
    with pytest.raises(UnreadableError, match="more than 10000000 bytes given, allowed"):
        read_named(Path("/dev/zero"), 10_000_000)


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
