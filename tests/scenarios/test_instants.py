"""Instants next to a sample are on it, bit for bit; no shipped scene is another one for that."""

import numpy as np
import pytest

from scenarios import Scene, load_scene
from scenarios.load import SceneError, parse_scene
from scenarios.toml import alignment as instants
from tests.support.scene_lists import ALL
from tests.support.slow import one_in

CHAIN = """title = "t"
source = "s"
[orbit]
altitude_m = 350e3
[chain]
bars = 2
mass_kg = [100.0, 60.0]
length_m = 50.0
angle_deg = [80.0, 75.0]
[run]
duration_s = 1000.0
samples = 8
"""
THRUST = "[[effects.thrust]]\nbar = 1\ndirection_deg = 90.0\n"
IMPULSE = "[[effects.impulse]]\nbar = 1\ndirection_deg = 90.0\nimpulse_N_s = 1.0\n"
TURN = "[[effects.prescribed_rotation]]\nbar = 1\namplitude_deg = 30.0\n"


def scene_of(effects: str) -> Scene:
    """Run of 1000 s, sampled every 142.857... s, with some effects."""
    return parse_scene(CHAIN + effects, name="t", file="t.toml")


def on_samples(scene: Scene) -> list[bool]:
    """Of each instant, whether it is a sample bit for bit."""
    return [t in scene.times_s.tolist() for t in scene.effects.breaks_s]


@pytest.mark.parametrize("name", one_in(4, ALL))
def test_no_shipped_scene_is_moved(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Certified solutions are kept by digest: none of their instants may move."""
    digest = load_scene(name).digest
    monkeypatch.setattr(instants, "NEAR", -1.0)
    assert load_scene(name).digest == digest


@pytest.mark.parametrize(
    "effects",
    [
        THRUST + "force_N = 1.0\nstart_s = 285.714285714\nduration_s = 285.714285714",
        THRUST + "force_N = [1.0, 2.0, 0.5]\ntimes_s = [1e-8, 428.5714285, 999.9999999]",
        IMPULSE + "at_s = 428.5714285",
        TURN + "start_s = 142.8571428\nduration_s = 571.42857150",
    ],
)
def test_instants_next_to_a_sample_are_on_it(effects: str) -> None:
    assert all(on_samples(scene_of(effects)))


def test_only_what_is_next_to_a_sample_moves() -> None:
    scene = scene_of(THRUST + "force_N = 1.0\nstart_s = 285.714283\nduration_s = 100.0\n" + IMPULSE + "at_s = 999.99")
    assert scene.effects.breaks_s == (285.714283, 285.714283 + 100.0, 999.99)
    turn = scene_of(TURN + "start_s = 100.0\nduration_s = 185.714285714").effects.prescribed_rotation[0]
    assert turn.start_s == 100.0
    assert turn.breaks_s[1] in scene.times_s


def test_ends_of_a_rotation_that_rounding_alone_keeps_off_stay() -> None:
    sample = float(scene_of("").times_s[2])
    start = float(np.nextafter(sample, 0.0))
    turn = scene_of(TURN + f"start_s = {start!r}\nduration_s = 60.0").effects.prescribed_rotation[0]
    assert (turn.start_s, turn.duration_s) == (start, 60.0)
    thrust = scene_of(THRUST + f"force_N = 1.0\nstart_s = {start!r}").effects.thrust[0]
    assert thrust.times_s == (sample, 1000.0)


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        (IMPULSE + "at_s = 1e-7", ["effects.impulse[1].at_s: 1e-07 given", "after the start", "1e-09 of it"]),
        (IMPULSE + "at_s = 999.9999999", ["effects.impulse[1].at_s", "before the end of the run, 1000 s"]),
        (THRUST + "force_N = 1.0\nstart_s = 999.9999999", ["effects.thrust[1].start_s", "before the end of the run"]),
        (
            THRUST + "force_N = [1.0, 2.0, 3.0]\ntimes_s = [1.0, 285.7142857, 285.7142858]",
            ["effects.thrust[1]: two instants at the sample at 285.714 s", "(1e-06 s)"],
        ),
        (TURN + "start_s = 285.7142855\nduration_s = 5e-7", ["effects.prescribed_rotation[1]: two instants"]),
    ],
)
def test_two_instants_next_to_one_sample_are_rejected_in_one_line(effects: str, words: list[str]) -> None:
    with pytest.raises(SceneError) as rejected:
        scene_of(effects)
    message = str(rejected.value)
    assert len(message.splitlines()) == 1
    assert all(word in message for word in words), message
