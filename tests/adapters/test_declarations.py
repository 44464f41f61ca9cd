"""What an engine declares decides which scenes it is given, whatever its code answers."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import pickle
import subprocess
import sys

import pytest

from adapters.engine import Setting, StatedAnswers
from adapters.reference.numpy_engines import Reference, ReferenceAbsolute, ReferenceNumPy
from adapters.registry import ENGINES
from scenarios import load_scene
from scenarios.effect_types import all_effect_names
from tests.support.slow import one_in

DIGEST = """
import hashlib, pickle
from adapters.registry import ENGINES
found = [pickle.dumps(ENGINES[name].declarations()) for name in ("reference", "pymunk", "rebound", "exudyn")]
print(hashlib.sha256(b"".join(found)).hexdigest())
"""


class Forgetful(ReferenceNumPy):
    """Answers for all effects, and declares a few."""

    title, coordinates, coordinate_set = "forgetful", Reference.coordinates, "minimal"
    effects = frozenset({"gravity.point", "solar_pressure"})

    @classmethod
    def unsupported(cls, scene):
        return "a hyperbola is not supported" if scene.name == "basics/kepler_hyperbolic" else None


@pytest.mark.parametrize("name", ["effects/joint_springs", "effects/solar_shadow"])
def test_an_effect_or_a_variant_that_is_not_declared_by_name_is_not_supported(name: str) -> None:
    scene, declared = load_scene(name), Forgetful.declarations()
    lacking = scene.effects.names - Forgetful.effects
    reason = declared.unsupported(scene)
    assert Forgetful.unsupported(scene) is None
    assert reason is not None
    assert all(effect in reason for effect in lacking)


def test_a_variant_is_declared_beside_its_effect() -> None:
    shadow = load_scene("effects/solar_shadow")
    effect = dataclasses.replace(Reference.declarations(), effects=tuple(sorted(shadow.effects.names)))
    assert effect.unsupported(shadow) is None
    without = tuple(name for name in effect.effects if name != "solar_pressure.shadow")
    assert "solar_pressure.shadow" in (dataclasses.replace(effect, effects=without).unsupported(shadow) or "")


def test_an_engine_that_answers_itself_is_asked_first() -> None:
    assert (
        Forgetful.declarations().unsupported(load_scene("basics/kepler_hyperbolic")) == "a hyperbola is not supported"
    )


@pytest.mark.parametrize("name", one_in(3, [name for name, r in ENGINES.items() if not r.missing]))
def test_declarations_are_those_of_the_class(name: str) -> None:
    declared, engine = ENGINES[name].declarations(), ENGINES[name].load()
    assert set(declared.effects) == engine.effects <= all_effect_names()
    assert set(declared.observables) == engine.observables
    assert (declared.order, declared.sweep, declared.coordinates) == (engine.order, engine.sweep, engine.coordinates)
    scene = load_scene("paper/fig05")
    setting = engine.sweep.setting()
    assert declared.unsupported(scene) == engine.unsupported(scene)
    assert declared.noise(scene, setting, scene.times_s).keys() == engine.noise(scene, setting, scene.times_s).keys()


def test_replaced_declarations_answer_for_themselves() -> None:
    scene, declared = load_scene("paper/fig05"), ReferenceAbsolute.declarations()
    setting = declared.sweep.setting()
    quiet = dataclasses.replace(declared, questions=())
    stated = dataclasses.replace(declared, questions=("noise",), answers=StatedAnswers({"attitude": 1.0}))
    assert declared.declares_noise
    assert not quiet.declares_noise
    assert quiet.noise(scene, setting, scene.times_s) == {}
    assert stated.noise(scene, Setting("rtol", 1e-3), scene.times_s) == {"attitude": 1.0}
    assert declared.noise(scene, setting, scene.times_s).keys() > {"attitude"}


def test_the_bytes_of_declarations_are_the_same_in_every_process() -> None:
    """Here and in a process whose hashes have another seed."""
    here = [pickle.dumps(ENGINES[name].declarations()) for name in ("reference", "pymunk", "rebound", "exudyn")]
    there = subprocess.check_output([sys.executable, "-c", DIGEST], env=os.environ | {"PYTHONHASHSEED": "1"}, text=True)
    assert there.strip() == hashlib.sha256(b"".join(here)).hexdigest()
