"""Digits of a scene over its time in both sets of coordinates, and scenes that the formulations can't carry."""

import dataclasses

import numpy as np
import pytest

from barchain.cli.main import run
from barchain.studies.roundoff import scenes as module
from barchain.studies.roundoff.scenes import digit_rows, need_carried, observed, shortened
from barchain.studies.roundoff.study import scene_study
from barchain.studies.study import run_study
from reference_impl.precision.arithmetic import EXACT, QUADRUPLE
from reports.chapters.roundoff.view import view_roundoff
from reports.results.roundoff import FILES
from scenarios import Gravity, SceneError, load_scene
from tests.support.here import HERE


@pytest.fixture(scope="module")
def short_bars():
    """Two bars of a metre on a tenth of an orbit."""
    scene = load_scene("basics/two_bars_free")
    chain = dataclasses.replace(
        scene.chain, length_m=(1.0, 0.6), inertia_kg_m2=(100.0 / 12.0, 40.0 * 0.36 / 12.0), rate_factor=(1.0, -1.0)
    )
    pulled = dataclasses.replace(scene.effects, gravity=Gravity.GRADIENT)
    return shortened(dataclasses.replace(scene, name="short_bars", chain=chain, effects=pulled), 0.1)


@pytest.fixture(scope="module")
def tables(short_bars, tmp_path_factory):
    folder = tmp_path_factory.mktemp("digits")
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(module, "SAMPLES", 8)
        run_study(scene_study([short_bars], executor=HERE), folder)
    return FILES.contents(folder)


def worst(tables, quantity, arithmetic):
    """Largest median error over the run in relative and in absolute coordinates."""
    own = tables.digits[(tables.digits.quantity == quantity) & (tables.digits.arithmetic == arithmetic)]
    found = own.groupby("coordinates")["median"].max()
    return found["relative"], found["absolute"]


@pytest.mark.parametrize(("arithmetic", "unit"), [("float64", 2.0**-53), ("quadruple", 2.0**-113)])
def test_relative_coordinates_keep_six_more_digits_of_the_reactions_of_short_bars(tables, arithmetic, unit):
    """A metre over the Earth's radius is 1.5e-7: absolute coordinates lose that factor."""
    relative, absolute = worst(tables, "reaction", arithmetic)
    assert relative < 1e3 * unit
    assert absolute > 1e6 * relative


def test_the_track_has_the_digits_of_the_arithmetic_in_either_coordinates(tables):
    for error in worst(tables, "com", "float64"):
        assert 2.0**-55 < error < 1e-13


def test_the_headline_says_the_digits_in_double_precision(tables):
    (found,) = view_roundoff(tables.folder).scene_digits
    relative, absolute = (-np.log10(e) for e in worst(tables, "reaction", "float64"))
    assert f"{relative:.1f} digits in relative and {absolute:.1f} in absolute coordinates" in found.headline
    assert len(found.charts) == 3


def test_truncation_drops_out_of_the_digits(short_bars, monkeypatch):
    """Runs in numbers of 120 digits agree in both coordinates, however long their steps."""
    monkeypatch.setattr(module, "STEPS_PER_RADIAN", 0.5)
    relative, absolute = (list(observed(EXACT, name, short_bars, np.zeros(1)))[-1] for name in module.COORDINATES)
    with EXACT.numbers():
        assert np.abs(relative.angle_rad - absolute.angle_rad).max() < 1e-80


def test_quadruple_precision_has_113_bits():
    with EXACT.numbers():
        third = EXACT.cast(np.ones(1)) / 3
        assert 2.0**-116 < abs(float((QUADRUPLE.cast(third) - third)[0])) < 2.0**-114


def test_a_single_bar_has_digits_of_its_angle_and_its_track():
    alone = load_scene("basics/libration")
    found = {row["quantity"] for row in digit_rows(shortened(alone, 0.01), "float64")}
    assert found == {"attitude", "com"}


def test_effects_that_no_formulation_carries_are_named_in_one_line(tmp_path, capsys):
    assert run(["roundoff", "effects/oblateness", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "effects/oblateness: oblateness given, allowed: gravity.gradient" in said
    assert not (tmp_path / "out").exists()


def test_a_scene_of_too_many_steps_is_refused_with_the_orbits_that_it_may_have():
    scene = load_scene("paper/fig05")
    many = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=100.0 * scene.run.duration_s))
    with pytest.raises(SceneError, match="--orbits") as raised:
        need_carried(many)
    need_carried(shortened(many, float(str(raised.value).split("--orbits ")[1].split()[0])))


@pytest.mark.parametrize(
    ("options", "words"),
    [(["paper/fig15", "--full"], "go without SCENE"), (["--engine", "reference"], "go with SCENE"),
     (["paper/fig15", "--set", "rtol=1e-9"], "no engine has rtol")],
)  # fmt: skip
def test_options_of_another_kind_of_study_are_refused(options, words, tmp_path, capsys):
    assert run(["roundoff", *options, "--out", str(tmp_path / "out")]) == 2
    assert words in capsys.readouterr().err
