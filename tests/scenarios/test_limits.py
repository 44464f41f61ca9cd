"""Scene files within limits: each fault costs one readable line, whatever the size of the file."""

from __future__ import annotations

import itertools
import os
import re
import time
from typing import TYPE_CHECKING

import pytest

from scenarios import SceneError, load_scene, parse_scene, scene_names
from scenarios.size_limits import BARS, FILE_BYTES, MOST_FAULTS, MOST_LINE, MOST_MAGNITUDE, LimitError
from scenarios.text import check_scene_name, is_hidden, is_scene_name

if TYPE_CHECKING:
    from pathlib import Path

GOOD = """
title = "t"
source = "s"
[orbit]
altitude_m = 350e3
[chain]
bars = 3
mass_kg = 100.0
length_m = [10.0, 20.0, 30.0]
[run]
orbits = 1.0
"""
ALTITUDE, TITLE = "altitude_m = 350e3", 'title = "t"'
SECONDS = 20.0  # far above what a rejection takes, and far below the hang that it replaces


def rejected(text: str) -> str:
    begun = time.monotonic()
    with pytest.raises(SceneError) as caught:
        parse_scene(text, name="x", file="x.toml")
    assert time.monotonic() - begun < SECONDS
    return str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("bars = 3", "bars = 1_000_000_000"), ["chain.bars: 1000000000 bars given", "100000", BARS.variable]),
        (("bars = 3", "bars = 0x" + "f" * 9000), ["chain.bars", "given"]),
        (("bars = 3", "bars = " + "9" * 9000), ["not valid TOML", "digits"]),
        (("orbits = 1.0", "orbits = 1.0\nsamples = 9_000_000_000"), ["run.samples", "1000000"]),
        ((TITLE, f'title = "{"a" * 50_000}"'), ["title", "50000 characters given", "at most 200"]),
        ((TITLE, f"title = 't'\n{'k' * 100_000} = 1"), ["kkk...", "unknown key", "allowed here"]),
        ((ALTITUDE, "altitude_m = 1e308"), ["orbit.altitude_m", "1e+308 given", "1e+30"]),
        ((ALTITUDE, f"altitude_m = {'9' * 400}"), ["orbit.altitude_m", "given"]),
        ((ALTITUDE, "altitude_m = 1e-40"), ["orbit.altitude_m", "1e-40 given", "1e-30 to 1e+30"]),
        ((ALTITUDE, "altitude_m = 3e5\nspeed_factor = 1e308"), ["orbit.speed_factor", "1e+308 given", "1e+30"]),
        ((ALTITUDE, "altitude_m = 3e5\n[central_body]\nradius_m = 1e308"), ["central_body.radius_m", "1e+30"]),
        ((TITLE, 'title = "a\\u001b[31m"'), ["title", "character 2 is U+001B", "one line of text"]),
        ((TITLE, 'title = """a\nb"""'), ["title", "character 2 is U+000A", "one line of text"]),
        ((TITLE, 'title = "a\\u202eb"'), ["title", "U+202E RIGHT-TO-LEFT OVERRIDE"]),
        ((TITLE, 'title = "t"\ntags = ["a\\u200bb"]'), ["tags[1]", "U+200B ZERO WIDTH SPACE"]),
        ((TITLE, 'title = "t"\ndescription = "a\\u2028b"'), ["description", "U+2028 LINE SEPARATOR"]),
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


def test_words_in_any_language_are_text() -> None:
    title = "Kétkarú lánc — Ωρίων, 二本の棒, 12\u202f% 🛰"
    assert parse_scene(GOOD.replace(TITLE, f'title = "{title}"'), name="x", file="x.toml").title == title


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(10**12)  # on file systems with holes; reading would end the process
    with pytest.raises(SceneError, match=rf"large\.toml: {10**12} bytes given, allowed: at most {FILE_BYTES.usual}"):
        load_scene(path)


@pytest.mark.parametrize("content", [b"\xff\xfet\x00", b'title = "\xff"', b"\xef\xbb\xbf", b"\x00", b""])
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
    for wrong in ("nan", "-1", "0", "1e9", "²", "9" * 5000):
        monkeypatch.setenv(BARS.variable, wrong)
        assert f"{BARS.variable}=" in rejected(GOOD)
    monkeypatch.setenv(BARS.variable, "3")
    assert parse_scene(GOOD, name="x", file="x.toml").bars == 3


@pytest.mark.parametrize("signs", list(itertools.product((1, -1), repeat=4)))
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
    "x/../../etc", "..", ".", "", "/etc/x", "x//y", "x/", "a\\b", "C:x", "a\nb", "a\u202eb", "a\udcffb", "a\0b",
    "a/ /b", "a" * 201,
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES_OUTSIDE)
def test_a_name_that_leads_out_of_a_folder_is_no_scene_name(name: str) -> None:
    with pytest.raises(LimitError) as caught:
        check_scene_name(name)
    assert "\n" not in str(caught.value)
    with pytest.raises((LimitError, SceneError)):
        parse_scene(GOOD, name=name, file="x.toml")


def test_every_shipped_name_is_a_scene_name() -> None:
    assert all(map(is_scene_name, scene_names()))


@pytest.mark.parametrize("given", ["{0}/mine", "x/../{1}/mine", "{1}/mine"])
def test_a_path_without_its_ending_is_no_name(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.toml").write_text(GOOD)
    shipped = os.path.relpath(tmp_path, load_scene.__globals__["SHIPPED"])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="no such scene"):
        load_scene(given.format(tmp_path, shipped))


def test_a_path_without_its_ending_suggests_the_file_beside_it(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(GOOD)
    with pytest.raises(SceneError, match=rf"did you mean {tmp_path}/mine\.toml\?"):
        load_scene(tmp_path / "mine")


@pytest.mark.parametrize("name", ["..toml", "...toml", "a\u202e.toml", "a\n.toml"])
def test_a_file_whose_name_makes_no_scene_name_is_rejected(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(GOOD)
    with pytest.raises(SceneError, match="scene name") as caught:
        load_scene(tmp_path / name)
    assert not any(map(is_hidden, str(caught.value)))


@pytest.mark.parametrize("name", ["a\0b", "n" * 5000, "a/" * 5000], ids=["nul", "long", "deep"])
def test_a_name_that_the_system_does_not_take_is_no_scene(name: str) -> None:
    with pytest.raises(SceneError, match="no such scene") as caught:
        load_scene(name)
    assert not any(map(is_hidden, str(caught.value)))
