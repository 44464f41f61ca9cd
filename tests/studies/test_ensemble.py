"""Ensembles: copies drawn as asked, run as the engine runs them, on threads or on a cluster that loses workers."""

import dataclasses

import numpy as np
import pytest

from adapters.engine import Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.cli.main import run as barchain
from barchain.runs.call import CallFailedError
from barchain.runs.cluster.connection import ClusterError
from barchain.runs.executors import DaskCluster, LocalProcesses
from barchain.studies.distributions import VariationError
from barchain.studies.ensemble.chunks import Chunk, chunk_bytes, need_sound, run_chunk
from barchain.studies.ensemble.population import populate
from barchain.studies.ensemble.study import ensemble
from barchain.studies.ensemble.variation import parse
from scenarios import load_scene
from tests.support.kernel import needs_kernel
from tests.support.page_policy import check_policy
from tests.support.results import read_table

pytestmark = needs_kernel
RTOL = 1e-8
EVERYTHING = (
    "angle_deg[*]=normal(5, 3)", "rate_factor=uniform(0.9, 1.1)", "mass_kg[2]=lognormal(100, 0.2)",
    "length_m=triangular(80, 100, 130)", "altitude_m=normal(4e5, 1e3)", "speed_factor=uniform(0.99, 1.05)",
    "longitude_deg=uniform(-180, 180)",
)  # fmt: skip


def short(name, share=0.1, samples=6):
    scene = load_scene(name)
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=share * scene.run.duration_s, samples=samples)
    )


@pytest.mark.parametrize(
    "name",
    ["paper/fig05", "paper/fig05_bar_horizontal", "paper/fig17", "basics/two_bars_free", "conform/com_share_alone"],
)
def test_every_copy_moves_as_the_engine_moves_it_bit_for_bit(name):
    scene = short(name)
    vary = [v for v in EVERYTHING if not v.startswith("speed_factor") or scene.bound]
    population = populate(scene, tuple(parse(v, scene.bars) for v in vary), 5, seed=3)
    seen, _ = run_chunk(Chunk(population, RTOL))
    for run in range(5):
        alone = ReferenceFast().run(population.copy(run), Setting(ReferenceFast.sweep.parameter, RTOL))
        # starts made for all copies at once are the engine's own to a rounding; what follows amplifies it by the orbit
        np.testing.assert_allclose(seen.angle_rad[run], alone.angle_rad, rtol=0, atol=1e-10)
        sizes = np.linalg.norm(alone.reaction_N, axis=2)
        np.testing.assert_allclose(seen.reaction_N[run], sizes, rtol=0, atol=1e-9 * sizes.max())
        assert seen.steps[run] == alone.info["steps"]


def test_quantiles_of_free_turning_are_those_of_the_rates_drawn():
    scene = short("basics/free_rotation", share=1.0)
    found = ensemble(scene, ["rate_factor=uniform(0.5, 2)"], runs=400, samples=3, rtol=1e-12)
    end = scene.run.duration_s
    start = found.angle_rad[0, 0, 0]
    turned = found.runs["rate_factor"].to_numpy() * scene.orbital_rate_rad_s * end
    last = found.quantiles.query("quantity == 'attitude' and item == 1 and t_s == @end")
    for _, row in last.iterrows():
        assert row["value"] == pytest.approx(start + np.quantile(turned, row["quantile"]), rel=1e-9)
        assert row["runs"] == 400


def test_draws_of_one_quantity_depend_neither_on_what_else_varies_nor_on_the_number_of_workers():
    scene = short("paper/fig13")
    alone = ensemble(scene, EVERYTHING[:1], runs=300, samples=3, executor=LocalProcesses(1))
    together = ensemble(scene, EVERYTHING, runs=300, samples=3, executor=LocalProcesses(2))
    np.testing.assert_array_equal(alone.runs["angle_deg[4]"], together.runs["angle_deg[4]"])
    again = ensemble(scene, EVERYTHING, runs=300, samples=3, executor=LocalProcesses(1))
    np.testing.assert_array_equal(again.angle_rad, together.angle_rad)
    np.testing.assert_array_equal(again.reaction_size_N, together.reaction_size_N)
    other = ensemble(scene, EVERYTHING, runs=300, samples=3, seed=2)
    assert not np.array_equal(other.angle_rad, together.angle_rad)


def test_a_bar_that_is_heavier_or_longer_keeps_the_shape_of_its_mass_unless_its_inertia_is_its_own():
    scene, slender = load_scene("paper/fig13"), lambda made: made.mass_kg * made.length_m**2 / 12.0
    made = populate(scene, (parse("mass_kg=uniform(50, 90)", 5), parse("length_m[3]=uniform(10, 20)", 5)), 20, seed=1)
    np.testing.assert_allclose(made.inertia_kg_m2, slender(made), rtol=1e-12)
    vary = (parse("mass_kg=uniform(500, 900)", 5), parse("inertia_kg_m2[1]=uniform(7, 7)", 5))
    made = populate(scene, vary, 3, seed=1)
    assert (made.inertia_kg_m2[:, 0] == 7.0).all()
    np.testing.assert_allclose(made.inertia_kg_m2[:, 1:], slender(made)[:, 1:], rtol=1e-12)


def test_copies_that_reach_the_surface_end_there_and_are_counted():
    found = ensemble(load_scene("paper/fig09"), ["speed_factor=uniform(0.2, 1.0)"], runs=60, orbits=0.5, samples=21)
    ended = found.runs[found.runs["outcome"] == "ended"]
    assert 10 < len(ended) < 60
    assert ended["reason"].str.contains("a bar reached the surface at t = ").all()
    last = found.quantiles[found.quantiles["t_s"] == found.quantiles["t_s"].max()]
    assert (last["runs"] == 60 - len(ended)).all()
    assert np.isfinite(last["value"]).all()


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("angle=normal(0, 1)", "did you mean angle_deg"),
        ("angle_deg=norml(0, 1)", "did you mean normal"),
        ("angle_deg=normal(0)", "normal(mean, deviation)"),
        ("angle_deg=normal(0, -1)", "normal(mean, deviation)"),
        ("angle_deg=normal(0, nan)", "normal(mean, deviation)"),
        ("angle_deg=normal(0, x)", "numbers in normal(mean, deviation)"),
        ("angle_deg[6]=normal(0, 1)", "allowed: 1 to 5"),
        ("altitude_m[1]=normal(4e5, 1)", "altitude_m is not a bar's"),
        ("angle_deg", "KEY=DISTRIBUTION"),
        ("mass_kg=normal(1, 3)", "greater than 0"),
        ("speed_factor=uniform(-1, -0.5)", "0 or more"),
        ("altitude_m=uniform(100, 200)", "higher than the chain is long"),
        ("angle_deg[1]=normal(20, 1);angle_deg=normal(80, 0)", "given twice"),
    ],
)
def test_what_cant_be_drawn_is_said_in_one_line(vary, words):
    with pytest.raises(VariationError) as caught:
        ensemble(short("paper/fig05"), vary.split(";"), runs=50)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_command_writes_tables_and_a_page(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["--runs", "40", "--orbits", "0.2", "--samples", "5", "--out", str(out)]
    assert barchain(["ensemble", "paper/fig05", "--vary", "angle_deg=normal(0, 1)", *arguments]) == 0
    assert "40 finished" in capsys.readouterr().out
    check_policy(out / "ensemble.html")
    assert (out / "ensemble.html").read_text(encoding="utf-8").count("<svg") == 9
    assert len(read_table(out, "ensemble", "quantiles")) == 5 * 5 * 9
    assert barchain(["ensemble", "paper/fig05", "--vary", "angle=normal(0, 1)", *arguments]) == 2


def test_an_address_where_nothing_answers_is_said_in_one_line():
    pytest.importorskip("distributed")
    with pytest.raises(ClusterError, match="no Dask scheduler answers there"):
        ensemble(short("paper/fig05"), ["angle_deg=normal(0, 1)"], runs=2, executor=DaskCluster("tcp://127.0.0.1:1"))


@pytest.mark.parametrize("damage", ["runs", "words", "bytes"])
def test_a_chunk_that_comes_back_damaged_is_no_result_and_is_not_kept(damage, tmp_path):
    chunk = Chunk(populate(short("paper/fig05"), (), 4, seed=1), RTOL)
    sound, file = chunk_bytes(chunk), tmp_path / "answer"
    content = {
        "runs": chunk_bytes(Chunk(populate(short("paper/fig05"), (), 3, seed=1), RTOL)),
        "words": sound.replace(b'"failed": ["", "", "", ""]', b'"failed": ["", "", ""]'),
        "bytes": sound[:-30],
    }
    file.write_bytes(b"kept")
    need_sound(chunk, sound, file)
    assert file.exists()
    with pytest.raises(CallFailedError, match="came back damaged"):
        need_sound(chunk, content[damage], file)
    assert not file.exists()
