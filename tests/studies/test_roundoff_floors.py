"""The floor of an engine that nobody can look into: its precision, a tolerance for each channel, and chaos apart."""

import dataclasses

import numpy as np
import pytest

from adapters.registry import ENGINES, Registration
from barchain.runs.executors import LocalProcesses
from barchain.studies.roundoff import floors
from barchain.studies.roundoff.floors import NOT_TOLD, margin, precision_class, two_ulps_away, variants
from barchain.studies.roundoff.scenes import shortened
from barchain.studies.roundoff.study import scene_study
from barchain.studies.study import Reporter, run_study
from reports.chapters.roundoff.view import view_roundoff
from reports.results.roundoff import FILES
from scenarios import load_scene
from tests.support.kernel import needs_kernel

SINGLE = Registration("tests.support.single_engine:Single")
FEW = floors.FEWEST
CRASHES = Registration("tests.support.faulty_engines:Segfault")


def measured(folder, scene, orbits, **engines):
    """Tables of a study of engines by name."""
    ends = []
    study = scene_study([scene], engines, orbits=orbits, executor=LocalProcesses(2))
    result = run_study(study, folder, reporter=Reporter(lambda *said: ends.append(said)))
    return FILES.contents(folder), result, ends


@pytest.fixture(scope="module")
def regular(tmp_path_factory):
    """A regular scene in an engine of single precision, one of double precision, and one that crashes."""
    folder = tmp_path_factory.mktemp("floors")
    scene = dataclasses.replace(shortened(load_scene("paper/fig15"), 0.1), name="regular")
    engines = {"reference": ENGINES["reference"], "single": SINGLE, "crashes": CRASHES}
    with pytest.MonkeyPatch.context() as changed:
        for name, number in {"REPEATS": 1, "SAME_AXES": 4, "TURNED": FEW}.items():
            changed.setattr(floors, name, number)
        return measured(folder, scene, None, **engines)


def told(tables):
    """Class and reason of each engine."""
    found = tables.floors.drop_duplicates("engine").set_index("engine")
    return dict(found["class"]), dict(found.reason)


def test_the_precision_of_engines_is_told(regular):
    kinds, reasons = told(regular[0])
    assert kinds == {"reference": "double", "single": "single"}
    assert "roundings of a double" in reasons["reference"]


def test_an_engine_of_single_precision_gives_the_same_numbers_for_inputs_two_ulps_away(regular):
    _, reasons = told(regular[0])
    assert "4 of 4 inputs two ulps of a double away give the same numbers" in reasons["single"]


def test_the_tolerance_is_the_floor_times_the_margin_in_the_unit_of_the_channel(regular):
    tables, *_ = regular
    own = tables.floors[tables.floors.engine == "reference"].set_index("quantity")
    assert (own["median"] <= own.q95).all()
    assert (own.q95 <= own.floor).all()
    assert own.tolerance.to_numpy() == pytest.approx((margin(FEW) * own.floor).to_numpy())
    assert own.rtol.to_numpy() == pytest.approx((own.tolerance / own.scale).to_numpy())
    single = tables.floors[tables.floors.engine == "single"].set_index("quantity")
    assert single["median"]["attitude"] / own["median"]["attitude"] > 1e6


def test_an_engine_that_crashes_costs_its_own_row(regular):
    tables, result, ends = regular
    assert not result.passed
    (failure,) = result.failures
    assert failure.startswith("floors: regular, crashes: failed: ")
    assert set(tables.floors.engine) == {"reference", "single"}
    assert sorted(outcome for *_, outcome in ends) == ["failed", "pass", "pass"]


def test_an_engine_that_does_not_support_a_scene_is_left_out_with_its_reason():
    study = scene_study(["paper/fig17"], {"pymunk": ENGINES["pymunk"]})
    assert study.tasks == ()
    assert "prescribed rotation is not supported" in study.left_out["pymunk in paper/fig17"]


def test_the_page_says_the_precision_and_has_a_chart_of_each_channel(regular):
    shown = view_roundoff(regular[0].folder)
    (found,) = shown.scene_floors
    assert any(line.startswith("reference at rtol=1e-10 computes in double precision") for line in found.headlines)
    assert len(found.charts) == 3
    assert {line["title"]: line["unit"] for line in found.lines}["Reactions"] == "N"
    assert not shown.general


@needs_kernel
def test_the_spread_of_a_chaotic_scene_is_not_called_round_off(tmp_path):
    """After ten orbits the variants have parted; over what the scene amplifies, they differ by roundings."""
    scene = load_scene("paper/fig05")
    twice = dataclasses.replace(scene.run, duration_s=2.0 * scene.run.duration_s)
    scene = dataclasses.replace(scene, name="longer", run=twice)
    tables, *_ = measured(tmp_path, scene, None, fast=ENGINES["reference-fast"])
    own = tables.spread[tables.spread.quantity == "attitude"].sort_values("orbits")
    assert own["median"].iloc[-1] > 1e-4
    floor = tables.floors.set_index("quantity").loc["attitude"]
    assert floor.floor < 1e-12
    assert np.isnan(floor.run_tolerance)
    assert told(tables)[0] == {"fast": "double"}


@pytest.mark.parametrize(
    ("share", "silent", "kind"),
    [(3e-15, 0, "double"), (3e-7, 8, "single"), (3e-7, 0, NOT_TOLD), (1e-10, 0, NOT_TOLD), (0.1, 8, NOT_TOLD)],
)
def test_a_spread_of_the_size_of_single_precision_needs_a_sign_of_it(share, silent, kind):
    """An iteration that stops at 1e-7 spreads as much, and tells inputs two ulps apart from each other."""
    assert precision_class(share, silent, 8)[0] == kind


def test_a_further_error_exceeds_the_margin_as_rarely_as_is_said():
    """At a chance of 1e-2, which drawn numbers can show."""
    random = np.random.default_rng(3)
    errors = np.abs(random.standard_normal((200_000, 25)))
    beyond = (errors[:, -1] > margin(24, 1e-2) * errors[:, :-1].max(axis=1)).mean()
    assert beyond == pytest.approx(1e-2, rel=0.1)
    assert margin(24) > margin(32) > 1.0


def test_variants_lie_two_ulps_away_and_are_the_same_in_every_study():
    scene = load_scene("paper/fig13")
    other = two_ulps_away(scene, np.random.default_rng(1))
    moved = np.abs(np.subtract(other.chain.mass_kg, scene.chain.mass_kg)) / np.spacing(100.0)
    assert (moved == 2.0).all()
    assert np.abs(np.subtract(other.chain.rate_factor, scene.chain.rate_factor)) == pytest.approx(2.0**-51)  # of 1
    assert variants(scene) == variants(scene)
    assert len({v.scene.digest for v in variants(scene)}) == len(variants(scene)) - 1  # two are the scene again
