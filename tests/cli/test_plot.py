"""`barchain plot`: runs as charts and animations, by the ending of the file."""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from barchain.cli.main import run
from reports.motion.charts import TIME_UNITS, Chosen, Run, charts_of
from tests.support.page_policy import check_policy

if TYPE_CHECKING:
    from pathlib import Path

SCENE = "basics/two_bars_free"
JOINED = "paper/fig13"
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run as `simulate` writes it."""
    out = tmp_path_factory.mktemp("runs") / "run.csv"
    assert run(["-q", "simulate", SCENE, "--set", "rtol=1e-6", "--out", str(out)]) == 0
    return out


def drawn(*words: object) -> int:
    """Exit code of `plot`."""
    return run(["-q", "plot", *map(str, words)])


def texts(svg: Path) -> list[str]:
    """Texts of a chart."""
    return ["".join(element.itertext()) for element in ET.parse(svg).iter(f"{SVG}text")]


def test_a_file_of_a_run_is_a_chart_with_units_and_a_description(table: Path, tmp_path: Path) -> None:
    out, again = tmp_path / "run.svg", tmp_path / "again.svg"
    again.write_text("mine")
    assert drawn(table, "--out", out) == drawn(table, "--out", again, "--overwrite") == 0
    assert out.read_bytes() == again.read_bytes()
    shown = texts(out)
    assert {"attitude, rad", "magnitude of reactions, N", "change of the CM's radius, m"} <= set(shown)
    assert {"bar 1", "bar 2"} <= set(shown)
    assert [text for text in shown if text.startswith("time, ")] != []
    root = ET.parse(out).getroot()
    assert root.get("role") == "img"
    assert "attitude, rad" in str(root.get("aria-label"))


def test_angles_and_rates_are_in_degrees_where_these_are_asked_for(table: Path) -> None:
    kept = Run("run", pd.read_csv(table))
    radians, degrees = (charts_of([kept], ["attitude", "rate"], Chosen(degrees=given)) for given in (False, True))
    assert list(degrees) == ["attitude, °", "rate, °/s"]
    for before, after in zip(radians.values(), degrees.values(), strict=True):
        np.testing.assert_allclose(after[0].values, before[0].values * 180.0 / math.pi, rtol=1e-15)


def test_a_png_is_a_picture(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.png"
    assert drawn(table, "--channel", "rate", "--out", out) == 0
    with Image.open(out) as picture:
        assert min(picture.size) > 300


def test_a_derived_channel_of_a_file_needs_its_scene(table: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "run.svg"
    assert drawn(table, "--channel", "joint_angle", "--out", out) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert "--of" in said
    assert not out.exists()
    assert drawn(table, "--channel", "joint_angle", "--of", SCENE, "--out", out) == 0
    assert "joint angle, rad" in texts(out)


def test_columns_that_a_file_holds_are_drawn_without_a_scene(table: Path, tmp_path: Path) -> None:
    given, out = tmp_path / "mine.csv", tmp_path / "mine.svg"
    pd.DataFrame({"t_s": [0.0, 7200.0], "tension_1_left_N": [0.0, 1.0], "gravity_force_1_x_N": [1.0, 2.0]}).to_csv(
        given, index=False
    )
    assert drawn(given, "--channel", "tension", "--channel", "effect_force", "--out", out) == 0
    assert {"tension left, N", "gravity force x, N", "time, minutes"} <= set(texts(out))


def test_a_run_of_a_comparison_knows_its_scene(table: Path, tmp_path: Path) -> None:
    file = tmp_path / "series" / "comparison" / "trajectories" / SCENE / "mine.parquet"
    file.parent.mkdir(parents=True)
    pd.read_csv(table).to_parquet(file)
    out = tmp_path / "run.svg"
    assert drawn(file, "--channel", "joint_angle", "--out", out) == 0


def test_several_engines_lie_over_each_other_and_one_that_lacks_a_channel_is_told(tmp_path: Path, capsys) -> None:
    out = tmp_path / "run.svg"
    words = [JOINED, "--engine", "reference-fast", "--engine", "rebound", "--channel", "attitude,altitude"]
    assert run(["plot", *words, "--out", str(out)]) == 0
    assert {"reference-fast", "rebound", "attitude, rad", "altitude, m"} <= set(texts(out))
    assert "rebound: no column of attitude" in capsys.readouterr().err


def test_a_file_and_a_scene_lie_over_each_other_in_common_minutes(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.svg"
    assert drawn(table, SCENE, "--set", "rtol=1e-6", "--time", "min", "--bar", "2", "--out", out) == 0
    shown = texts(out)
    assert {"run.csv", "time, minutes", "attitude, rad, bar 2"} <= set(shown)


@pytest.mark.slow
def test_an_animation_has_frames_that_differ(table: Path, tmp_path: Path) -> None:
    few, out = tmp_path / "few.csv", tmp_path / "run.gif"
    pd.read_csv(table).iloc[:30].to_csv(few, index=False)
    assert drawn(few, "--of", SCENE, "--out", out) == 0
    with Image.open(out) as film:
        assert film.n_frames > 30
        first = np.asarray(film.convert("L"), int)
        film.seek(film.n_frames // 2)
        assert np.abs(np.asarray(film.convert("L"), int) - first).max() > 100


def test_a_page_moves_without_a_script_and_loads_nothing(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.html"
    assert drawn(table, "--of", SCENE, "--channel", "attitude", "--out", out) == 0
    text = out.read_text()
    assert "@keyframes" in text
    assert "attitude, rad" in text
    check_policy(out)


def test_a_film_without_ffmpeg_says_so_before_anything_runs(table: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    out = tmp_path / "run.mp4"
    assert drawn(table, "--of", SCENE, "--out", out) == 2
    assert "ffmpeg" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "x.pdf"], [".pdf", ".svg, .png, .gif, .mp4, .html"]),
        (["--channel", "attitud", "--out", "x.svg"], ["no such channel", "did you mean attitude?"]),
        (["--bar", "7", "--out", "x.svg"], ["bar 7", "allowed: 1, 2"]),
        (["--channel", "torque", "--out", "x.svg"], ["torque"]),
        (["--time", "orbits", "--out", "x.svg"], ["orbit"]),
        (["--out", "x.gif"], ["scene"]),
        (["--of", "paper/fig05", "--out", "x.gif"], ["angles of 2 bars", "5"]),
        (["--engine", "exudyn", "--out", "x.svg"], ["--engine", "SCENE"]),
        (["--of", SCENE, "--channel", "attitude", "--out", "x.gif"], ["--channel", "charts"]),
        (["--frame", "inertial", "--out", "x.svg"], ["--frame", "animation"]),
    ],
)
def test_what_cant_be_drawn_is_one_line(table: Path, words, said, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert drawn(table, *words) == 2
    shown = capsys.readouterr().err
    assert len(shown.splitlines()) == 1
    assert all(word in shown for word in said), shown
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("t_s,angle_1_rad\n0,0\n1,x\n", "line 3"),
        ("time,angle_1_rad\n0,0\n1,1\n", "t_s"),
        ("t_s,speed\n0,0\n1,1\n", "speed"),
        ("t_s,angle_1_rad\n1,0\n0,1\n", "rise"),
        ("", "no rows"),
    ],
)
def test_a_file_that_is_no_run_is_one_line(content: str, said: str, tmp_path: Path, capsys) -> None:
    file = tmp_path / "run.csv"
    file.write_text(content)
    assert drawn(file, "--out", tmp_path / "x.svg") == 2
    shown = capsys.readouterr().err
    assert len(shown.splitlines()) == 1
    assert said in shown


def test_bars_that_turn_too_often_for_an_animation_are_told(tmp_path: Path, capsys) -> None:
    file, t = tmp_path / "run.csv", np.linspace(0.0, 1000.0, 2001)
    spun = {f"angle_{j}_rad": 5.0 * t for j in (1, 2)}
    pd.DataFrame({"t_s": t, "com_x_m": 7e6, "com_y_m": 0.0} | spun).to_csv(file, index=False)
    assert drawn(file, "--of", SCENE, "--out", tmp_path / "x.gif") == 2
    assert "turns" in capsys.readouterr().err


def test_a_trajectory_draws_named_channels_and_moves(tmp_path: Path) -> None:
    import matplotlib as mpl

    import barchain

    motion = barchain.simulate(SCENE, "reference-fast", rtol=1e-6)
    with mpl.rc_context({"backend": "agg"}):
        figure, axes = motion.plot(["joint_angle", "reaction"], joints=[1])
    assert [ax.get_title(loc="left") for ax in axes] == ["joint angle, rad", "reaction x, N", "reaction y, N"]
    joint = motion.angle_rad[:, 1] - motion.angle_rad[:, 0]
    np.testing.assert_allclose(axes[0].lines[0].get_ydata(), joint)
    content = io.BytesIO()
    figure.savefig(content)
    mpl.pyplot.close(figure)
    film = motion.animate(tmp_path / "run.html")
    assert film.read_text().startswith("<!doctype html>")
    for wrong in (
        lambda: motion.plot(["joint_angel"]),
        lambda: motion.animate("run.avi"),
        lambda: motion.plot(bars=[9]),
    ):
        with pytest.raises(ValueError, match="allowed"):
            wrong()
    assert mpl.pyplot.get_fignums() == []


def test_units_of_time_are_known_to_the_command_line():
    from barchain.cli.plot import TIME_UNITS as OFFERED

    assert OFFERED == TIME_UNITS
