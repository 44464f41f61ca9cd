"""Wrong arguments of the Python functions end in one sentence: the given and the allowed values, the nearest name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import barchain
from barchain import ArgumentError, SceneError, Setting, SettingError, UnknownEngineError, compare, simulate

if TYPE_CHECKING:
    from collections.abc import Callable

FIG05 = "paper/fig05"
ONE = [FIG05], ["reference"]
CALLS: list[tuple[type[Exception], Callable[[], object], tuple[str, ...]]] = [
    (ArgumentError, lambda: compare(FIG05), ("scenes: 'paper/fig05' given", 'did you mean ["paper/fig05"]?')),
    (ArgumentError, lambda: compare([]), ("scenes: [] given", "a list of scenes")),
    (ArgumentError, lambda: compare([FIG05], "exudin"), ("engines: 'exudin' given", 'did you mean ["exudyn"]?')),
    (ArgumentError, lambda: compare([FIG05], 5), ("engines: 5 given", "None for the default engines")),
    (SceneError, lambda: compare(["paper/fig5"]), ("paper/fig5: no such scene", "did you mean paper/fig05?")),
    (UnknownEngineError, lambda: compare([FIG05], [5]), ("5 given as an engine", "allowed: a name")),
    (SettingError, lambda: compare(*ONE, settings="rtol=1e-9"), ("settings: 'rtol=1e-9' given", "a dict of dicts")),
    (SettingError, lambda: compare(*ONE, settings={"exudyn": {}}), ("exudyn given, which is not compared",)),
    (SettingError, lambda: compare(*ONE, settings={"reference": {"rtol": "x"}}), ("rtol='x' given", "1e-15 to 1")),
    (ArgumentError, lambda: compare(*ONE, workers=0), ("workers: 0 given", "a whole number above 0")),
    (ArgumentError, lambda: compare(*ONE, time_limit_s=-1), ("time_limit_s: -1 given", "seconds above 0")),
    (ArgumentError, lambda: compare(*ONE, out=5), ("out: 5 given", "a folder's path")),
    (ArgumentError, lambda: compare(*ONE, dask=5), ("dask: 5 given", "the address of a Dask scheduler")),
    (ArgumentError, lambda: compare(*ONE, resume="x"), ("resume: 'x' given", "True or False")),
    (ArgumentError, lambda: compare(*ONE, progress="yes"), ("progress: 'yes' given", "a function of scene")),
    (SceneError, lambda: simulate(5), ("5 given as a scene", "allowed: a name")),
    (UnknownEngineError, lambda: simulate(FIG05, "exudin"), ("exudin: no such engine", "did you mean exudyn?")),
    (SettingError, lambda: simulate(FIG05, "exudyn", steps_per_orbit="x"), ("steps_per_orbit='x'", "1 to 1e+09")),
    (SettingError, lambda: simulate(FIG05, "exudyn", step_per_orbit=9), ("step_per_orbit", "mean steps_per_orbit?")),
    (SettingError, lambda: simulate(FIG05, rtol=1e-9, steps_per_orbit=9), ("no setting steps_per_orbit", "rtol")),
    (ArgumentError, lambda: simulate(FIG05, condition="x"), ("condition: 'x' given", "True or False")),
    (SettingError, lambda: Setting("rtoll", 1e-9), ("'rtoll' given", "did you mean rtol?", "steps_per_orbit")),
    (ArgumentError, lambda: barchain.scenes(5), ("tag: 5 given", "allowed: a tag")),
    (ArgumentError, lambda: barchain.render(5), ("folder: 5 given", "allowed: a folder's path")),
]


@pytest.mark.parametrize(("kind", "call", "said"), CALLS, ids=[" ".join(said) for _, _, said in CALLS])
def test_a_wrong_argument_ends_in_one_sentence(
    kind: type[Exception], call: Callable[[], object], said: tuple[str, ...]
) -> None:
    with pytest.raises(kind) as found:
        call()
    assert type(found.value) is kind
    assert "\n" not in str(found.value)
    for part in said:
        assert part in str(found.value)


@pytest.mark.slow
def test_a_generator_of_scenes_is_a_list() -> None:
    result = compare((name for name in ["basics/radial_equilibrium"]), (name for name in ["reference"]))
    assert result.passed
