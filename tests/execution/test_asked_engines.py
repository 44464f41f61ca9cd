"""Engines of other packages are asked in processes of their own, as seldom as possible."""

from __future__ import annotations

import pickle
import sys
from typing import TYPE_CHECKING, Any

import pytest

from adapters.engine import Setting
from adapters.reference.numpy_engines import ReferenceNumPy
from adapters.registry import Registration
from barchain.runs import asking, questions
from barchain.runs.asking import ask, ask_about, declarations_of, taken_along
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

SCENES = [load_scene(name) for name in ("basics/two_bars_free", "paper/fig05", "effects/thrust")]
SETTINGS = [Setting("rtol", 1e-8), Setting("rtol", 1e-9)]


class Asked(ReferenceNumPy):
    """Declares noise that depends on the setting, and has a limit of its own."""

    title, coordinates, coordinate_set = "asked", "relative", "minimal"

    @classmethod
    def unsupported(cls, scene):
        return "a thrust is not supported" if scene.effects.thrust else super().unsupported(scene)

    @classmethod
    def noise(cls, scene, setting, t_s):
        return {"attitude": setting.value * t_s}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Callable[..., Any]]:
    """Questions, one for each process."""
    seen: list[Callable[..., Any]] = []

    def counted(question: Callable[..., Any], *given: object, **how: Any) -> asking.Reply:
        seen.append(question)
        return ask(question, *given, **how)

    monkeypatch.setattr(asking, "ask", counted)
    asking.asked_declarations.cache_clear()
    return seen


def test_declarations_reasons_and_noise_take_a_process_each_and_no_second_one(asked: list[Callable[..., Any]]) -> None:
    registration = Registration(f"{__name__}:Asked")
    engine, t_s = declarations_of(registration), SCENES[0].times_s
    assert engine.questions == ("unsupported", "noise")
    ask_about(engine, SCENES)
    assert [engine.unsupported(scene) for scene in SCENES] == [None, None, "a thrust is not supported"]
    taken = taken_along(engine, SCENES[0], SETTINGS, t_s)
    for setting in SETTINGS:
        for each in (engine, taken, pickle.loads(pickle.dumps(taken))):
            assert (each.noise(SCENES[0], setting, t_s)["attitude"] == setting.value * t_s).all()
    assert declarations_of(registration) is engine
    assert asked == [questions.describe] * 3


def test_what_is_taken_along_has_no_other_answers(asked: list[Callable[..., Any]]) -> None:
    engine, t_s = declarations_of(Registration(f"{__name__}:Asked")), SCENES[0].times_s
    first = pickle.dumps(taken_along(engine, SCENES[0], SETTINGS, t_s))
    ask_about(engine, SCENES)
    engine.noise(SCENES[1], SETTINGS[0], t_s)
    assert pickle.dumps(taken_along(engine, SCENES[0], SETTINGS, t_s)) == first
    assert len(asked) == 4


def test_another_python_answers_for_an_engine_that_names_it(tmp_path: Path) -> None:
    marker, python = tmp_path / "started", tmp_path / "python"
    python.write_text(f'#!/bin/sh\ntouch "{marker}"\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    engine = declarations_of(Registration(f"{__name__}:Asked", python=str(python)))
    assert marker.exists()
    assert engine.title == "asked"


def test_a_python_that_is_not_there_makes_its_engine_missing(tmp_path: Path) -> None:
    registration = Registration(f"{__name__}:Asked", python=str(tmp_path / "nowhere"))
    assert "nowhere is not there" in (registration.missing or "")
    with pytest.raises(asking.AdapterLoadError, match="nowhere is not there"):
        declarations_of(registration)
