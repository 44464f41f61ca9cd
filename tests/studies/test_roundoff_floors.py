"""The floor of an engine that nobody can look into: its precision, a tolerance for each channel, and chaos apart."""

import dataclasses

import numpy as np
import pytest

from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES, Registration
from barchain.runs.executors import LocalProcesses
from barchain.studies.roundoff import floors
from barchain.studies.roundoff.floors import NOT_TOLD, floor_rows, margin, precision_class, two_ulps_away, variants
from barchain.studies.roundoff.scenes import shortened
from barchain.studies.roundoff.study import scene_study
from barchain.studies.study import Reporter, run_study
from reports.chapters.roundoff.view import view_roundoff
from reports.results.roundoff import FILES, TABLES
from scenarios import load_scene
from tests.support.kernel import needs_kernel
from tests.support.single_engine import Single
from tests.support.solutions import solution_of

FEW = floors.FEWEST
CRASHES = Registration("tests.support.faulty_engines:Segfault")


@pytest.fixture(scope="module")
def scene():
    """A regular scene of a tenth of an orbit."""
    return dataclasses.replace(shortened(load_scene("paper/fig15"), 0.1), name="regular")


@pytest.fixture(scope="module")
def few():
    """Fewer variants."""
    with pytest.MonkeyPatch.context() as changed:
        for name, number in {"REPEATS": 1, "SAME_AXES": 4, "TURNED": FEW}.items():
            changed.setattr(floors, name, number)
        yield


@pytest.fixture(scope="module")
def found(scene, few):
    """Rows of the table `floors` of two engines, by engine, run in this process."""

    def rows(engine):
        runs = [(v, engine().run(v.scene)) for v in variants(scene)]
        made = floor_rows(solution_of(scene, dense=False), engine.coordinates, engine().run(scene), runs)
        return TABLES["floors"].framed(row for row in made if row["table"] == "floors").set_index("quantity")

    return {"reference": rows(Reference), "single": rows(Single)}


def test_the_precision_of_engines_is_told(found):
    assert {name: set(rows["class"]) for name, rows in found.items()} == {"reference": {"double"}, "single": {"single"}}
    assert "4 of 4 inputs two ulps of a double away give the same numbers" in found["single"].reason.iloc[0]


def test_the_tolerance_is_the_floor_times_the_margin(found):
    own = found["reference"]
    assert (own["median"] <= own.q95).all()
    assert (own.q95 <= own.floor).all()
    assert own.tolerance.to_numpy() == pytest.approx((margin(FEW) * own.floor).to_numpy())
    assert own.rtol.to_numpy() == pytest.approx((own.tolerance / own.scale).to_numpy())
    assert found["single"]["median"]["attitude"] / own["median"]["attitude"] > 1e6


def test_an_engine_that_crashes_costs_its_own_row_and_the_page_says_the_precision(scene, few, tmp_path):
    ends = []
    study = scene_study([scene], {"reference": ENGINES["reference"], "crashes": CRASHES}, executor=LocalProcesses(1))
    result = run_study(study, tmp_path, reporter=Reporter(lambda *said: ends.append(said)))
    (failure,) = result.failures
    assert failure.startswith("floors: regular, crashes: failed: ")
    assert set(FILES.contents(tmp_path).floors.engine) == {"reference"}
    assert sorted(outcome for *_, outcome in ends) == ["failed", "pass"]
    (floors_there,) = view_roundoff(tmp_path).scene_floors
    assert floors_there.headlines[0].startswith("reference at rtol=1e-10 computes in double precision")
    assert len(floors_there.charts) == 3
    assert {line["title"]: line["unit"] for line in floors_there.lines}["Reactions"] == "N"


def test_an_engine_that_does_not_support_a_scene_is_left_out_with_its_reason():
    study = scene_study(["paper/fig17"], {"pymunk": ENGINES["pymunk"]})
    assert study.tasks == ()
    assert "prescribed rotation is not supported" in study.left_out["pymunk in paper/fig17"]


@needs_kernel
def test_the_spread_of_a_chaotic_scene_is_not_called_round_off():
    """After ten orbits the variants have parted; over what the scene amplifies, they differ by roundings."""
    short = load_scene("paper/fig05")
    run = dataclasses.replace(short.run, duration_s=2.0 * short.run.duration_s)
    chaotic, engine = dataclasses.replace(short, run=run), ReferenceFast
    runs = [(v, engine().run(v.scene)) for v in variants(chaotic)]
    rows = floor_rows(solution_of(chaotic, dense=False), engine.coordinates, engine().run(chaotic), runs)
    floor, *over_time = (row for row in rows if row["quantity"] == "attitude")
    assert over_time[-1]["median"] > 1e-4
    assert floor["floor"] < 1e-12
    assert np.isnan(floor["run_tolerance"])
    assert floor["class"] == "double"


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
    assert len({v.scene.digest for v in variants(scene)}) == len(variants(scene)) - floors.REPEATS + 1
