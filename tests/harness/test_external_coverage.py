"""Engines of independent physics that support a scene: unsupported effects are told from unsupported instants."""

from __future__ import annotations

import dataclasses

import pandas as pd
import pytest

from adapters.registry import ENGINES, Registration
from barchain.cli.compare import show_advice
from barchain.metrics.quantities import conserved
from barchain.record.scene_description import invariant_words, losses
from barchain.solutions.judging import WORDS
from barchain.solutions.reference import SolutionSource
from barchain.studies.comparison.external_coverage import (
    MAX_SUGGESTED_SAMPLES,
    external_coverage,
    fitting_run,
    unchecked_attitudes,
    with_run,
)
from reports.results.outcome import Outcome
from scenarios import Scene, load_scene, scene_names
from scenarios.load import parse_scene

ASKED = {name: ENGINES[name] for name in ("reference", "exudyn", "pymunk", "rebound")}
HERE = {name: r for name, r in ASKED.items() if not r.missing}
FRAME = """title = "t"
source = "s"
[orbit]
altitude_m = 350e3
[chain]
bars = 3
mass_kg = 100.0
length_m = 20.0
angle_deg = 80.0
[run]
{run}
samples = 101
"""
THRUST = "[[effects.thrust]]\nbar = 1\ndirection_deg = 0.0\nforce_N = 1.0\n"


def scene(effects: str, run: str = "orbits = 1.0") -> Scene:
    return parse_scene(FRAME.format(run=run) + effects, name="x", file="x.toml")


@pytest.mark.parametrize(
    ("effects", "run"),
    [
        (THRUST + "start_s = 100.0\nduration_s = 700.0", "orbits = 1.0"),
        ("[[effects.impulse]]\nbar = 1\ndirection_deg = 0.0\nimpulse_N_s = 1.0\nat_s = 333.125", "orbits = 1.0"),
    ],
)
def test_a_run_that_is_proposed_is_carried(effects: str, run: str) -> None:
    own = scene(effects, run)
    found = external_coverage(own, HERE)["instants"]
    assert found["engines"]
    assert set(found["at_s"]) <= set(own.effects.breaks_s)
    wanted = fitting_run(own)
    assert wanted
    assert found["run"] == dataclasses.asdict(wanted)
    assert wanted.samples <= MAX_SUGGESTED_SAMPLES
    assert 0.0 <= wanted.duration_s - own.run.duration_s < 0.1 * own.run.duration_s
    again = external_coverage(with_run(own, wanted), HERE)
    assert again["instants"] == {}
    for name in found["engines"]:
        assert HERE[name].load().unsupported(own)
        assert HERE[name].load().unsupported(with_run(own, wanted)) is None


def test_a_run_keeps_its_duration_where_samples_alone_will_do() -> None:
    own = scene(THRUST + "start_s = 100.0\nduration_s = 700.0", "duration_s = 5130.0")
    wanted = fitting_run(own)
    assert wanted
    assert wanted.duration_s == 5130.0
    assert wanted.samples == 514  # every 10 s, and midway between two


def test_the_run_is_proposed_on_the_terminal_to_engines_that_lack_no_effect(capsys: pytest.CaptureFixture[str]) -> None:
    turned = "[[effects.prescribed_rotation]]\nbar = 1\namplitude_deg = 30.0\nstart_s = 100.0\nduration_s = 300.0\n"
    show_advice([scene(THRUST + "start_s = 100.0\nduration_s = 700.0"), scene(turned)], {"pymunk": HERE["pymunk"]})
    shown = capsys.readouterr().out.splitlines()
    assert len(shown) == 1
    assert shown[0].startswith("  x: instants alone stop pymunk: engines of equal steps")
    assert "in [run] each instant is one" in shown[0]


def test_instants_that_share_nothing_have_no_run_proposed() -> None:
    own = scene(THRUST + "start_s = 100.000017\nduration_s = 700.1")
    found = external_coverage(own, HERE)["instants"]
    assert found["run"] is None
    assert found["engines"]


def test_what_lacks_an_effect_is_told_and_no_instant_blamed() -> None:
    found = external_coverage(load_scene("effects/everything"), HERE)
    assert set(found["lack"]) == {name for name, r in HERE.items() if r.external}
    assert found["instants"] == {}
    assert "heyoka" in found["not_requested"]
    assert found["solution"].startswith("real128")
    assert external_coverage(scene(""), HERE)["solution"] == ""


def test_an_engine_that_was_not_chosen_is_asked_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(HERE["pymunk"].load(), "unsupported", classmethod(lambda cls, _: asked.append(cls.__name__)))
    found = external_coverage(load_scene("paper/fig05"), {"rebound": HERE["rebound"]})
    assert not asked
    assert "pymunk" in found["not_requested"]


def test_every_invariant_that_is_none_has_its_reasons() -> None:
    for name in scene_names():
        own = load_scene(name)
        keeps, lost = conserved(own), losses(own)
        assert keeps.energy == (not any(loss.energy for loss in lost)), name
        assert keeps.angular_momentum == (not any(loss.angular_momentum for loss in lost)), name


def test_all_reasons_are_given_effects_first() -> None:
    assert invariant_words(load_scene("effects/drag")) == (
        "neither energy nor angular momentum: drag has no potential; "
        "the gravity-gradient torque has no counterpart in the force"
    )
    words = invariant_words(load_scene("effects/joint_springs"))
    assert words == "angular momentum; not energy: dampers dissipate energy"
    assert invariant_words(load_scene("effects/slender")) == "energy and angular momentum"


def test_an_adapter_that_does_not_load_is_named_with_its_message() -> None:
    broken = Registration("tests.support.faulty_engines:NoSuchEngine")
    found = external_coverage(scene(""), {"broken": broken})
    assert "NoSuchEngine" in found["not_loaded"]["broken"]
    assert "broken" not in found["lack"]


@pytest.mark.parametrize(
    ("judged", "source", "unchecked"),
    [
        ({"scipy-dop853": "attitude"}, SolutionSource.REFERENCE, ["scipy-dop853"]),
        ({"reference": "attitude", "exudyn": "attitude"}, SolutionSource.REFERENCE, None),
        ({"reference": "attitude"}, SolutionSource.HEYOKA, None),
        ({"reference": "attitude", "rebound": "com"}, SolutionSource.REFERENCE, ["reference"]),
    ],
    ids=["own equations alone", "an independent engine", "a certified solution judges", "a track is no attitude"],
)
def test_a_scene_that_nothing_independent_checks_is_told(
    judged: dict[str, str], source: SolutionSource, unchecked: list[str] | None
) -> None:
    rows = [("x", engine, quantity, "normalised_error") for engine, quantity in judged.items()]
    metrics = pd.DataFrame(rows, columns=["scene", "engine", "quantity", "metric"])
    outcomes = {("x", engine): Outcome.PASS for engine in judged}
    record = {"scenes": {"x": {"solution_source": WORDS[source]}}}
    found = unchecked_attitudes(metrics, outcomes, {"exudyn", "rebound"}, record)
    assert found == ({"x": unchecked} if unchecked else {})
