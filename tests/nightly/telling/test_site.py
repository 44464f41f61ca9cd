"""The results page of a history: what it has of each pair, what was not measured, and a folder that stands alone."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from click.testing import CliRunner

from barchain.cli.main import cli
from barchain.nightly.figures.figure import Figure, FigureKind, NightPart
from barchain.nightly.history.nights import open_store
from tests.nightly.history.synthetic import PARTS, error, identity, night, ratio, verdict

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.figures.figure import Night

ERROR = "attitude.first_orbit_max"
PROGRAM = "program:mine (mine.m)"


def written(url: str, out: Path, *more: str) -> tuple[str, list[dict[str, str]]]:
    """Page and rows of the table of a site."""
    ended = CliRunner().invoke(cli, ["history", "site", "--history", url, "--out", str(out), *more])
    assert ended.exit_code == 0, ended.output
    with (out / "results.csv").open(encoding="utf-8", newline="") as file:
        return (out / "index.html").read_text("utf-8"), list(csv.DictReader(file))


def add(url: str, *nights: Night) -> None:
    store = open_store(url, create=True)
    for one in nights:
        store.add(one)


def judged(word: str = "pass", **more: Any) -> Figure:
    found = verdict(word, **{key: more[key] for key in more.keys() & {"reason", "depends"}})
    place = {key: more[key] for key in more.keys() & {"engine", "scene"}}
    return replace(found, identity=replace(found.identity, setting="", **place))


def timed(target: str, value: float) -> Figure:
    found = ratio(value, "cost.time_ratio", low=0.9 * value, high=1.1 * value)
    return replace(found, identity=replace(found.identity, setting=f"attitude<={target}"))


def reach(word: str, reason: str = "") -> Figure:
    return Figure(identity("cost.reach", FigureKind.VERDICT, setting="attitude<=1e-06"), word=word, reason=reason)


def test_a_pair_has_its_latest_results_with_intervals_and_its_engine_the_nights_of_its_releases(
    url: str, tmp_path: Path
) -> None:
    newer = (NightPart("engine:mujoco", "4.0.0", "ee"), *PARTS[1:])
    for k, parts in enumerate((PARTS, PARTS, newer)):
        word = "inconsistent" if k == 0 else "pass"
        own = error(1e-5 * (k + 1), ERROR, tolerance=1e-7)
        add(url, night(judged(word), own, timed("1e-06", 2.0 + k), timed("1e-08", 9.0), number=k, parts=parts))
    page, (row,) = written(url, tmp_path / "site")
    assert (row["verdict"], row["verdict_since"][:10], row["version"]) == ("pass", "2026-01-02", "mujoco 4.0.0")
    assert [float(row[f"error{end}"]) for end in ("", "_low", "_high")] == pytest.approx([3e-5, 2.99e-5, 3.01e-5])
    assert [float(row[f"time_{end}"]) for end in ("ratio", "low", "high")] == pytest.approx([4.0, 3.6, 4.4])
    assert (row["at_error"], row["relative_to"]) == ("attitude<=1e-06", "reference-fast")
    assert re.search(r"mujoco 4.0.0 since .*2026-01-03.*; mujoco 3.3.0 since .*2026-01-01", page)
    assert page.count('class="spark"') == 2


def test_a_larger_error_that_nobody_accepted_stands_with_its_night(url: str, tmp_path: Path) -> None:
    add(url, *(night(judged(), error(1e-5 * factor, ERROR), number=k) for k, factor in enumerate((1.0, 2.0, 2.0))))
    page, (row,) = written(url, tmp_path / "site")
    assert row["worse_since"].startswith("2026-01-02")
    assert "worse than accepted since" in page


def test_an_engine_that_is_a_program_has_the_version_that_its_entry_states(url: str, tmp_path: Path) -> None:
    own = judged(engine="mine", depends=(PROGRAM,))
    add(url, night(own, number=0, parts=(NightPart(PROGRAM, "1.2 (3f2a91c)", "aa"),)))
    assert written(url, tmp_path / "site")[1][0]["version"] == "mine 1.2 (3f2a91c)"
    add(url, night(own, number=1, parts=(NightPart(PROGRAM, "", "bb"),)))
    assert written(url, tmp_path / "site")[1][0]["version"] == "version not stated"


def test_what_was_not_measured_has_its_reason(url: str, tmp_path: Path) -> None:
    hard = judged(scene="paper/fig13")
    add(url, night(hard, number=0))
    unsupported = judged("unsupported", engine="box", reason="no <gravity> of points")
    add(url, night(judged(), reach("not reached", "timed out"), unsupported, number=1))
    page, rows = written(url, tmp_path / "site")
    lacking = re.sub(r"<[^>]*>", "|", page[page.index('id="unmeasured"') :])
    assert "no &lt;gravity&gt; of points" in lacking
    assert "not reached: timed out" in lacking
    assert "not on the latest night; last 2026-01-01" in lacking
    assert {row["scene"]: row["time_ratio"] for row in rows} == {"paper/fig05": "", "paper/fig13": ""}


def test_the_folder_stands_alone_and_a_later_site_adds_pages_and_keeps_earlier_ones(url: str, tmp_path: Path) -> None:
    site = tmp_path / "site"
    add(url, *(night(judged(), error(1e-5, ERROR), number=k) for k in range(4)))
    page, _ = written(url, site, "--days", "2")
    assert sorted(one.name[:10] for one in site.iterdir() if one.is_dir()) == ["2026-01-03", "2026-01-04"]
    early = next(site.glob("2026-01-03*")) / "nightly.html"
    early.write_text("kept", "utf-8")
    add(url, night(judged(), error(1e-5, ERROR), number=4))
    page, _ = written(url, site, "--days", "3")
    linked = set(re.findall(r'href="([^"#]+)"', page))
    assert {link[:10] for link in linked} == {"2026-01-03", "2026-01-04", "2026-01-05", "results.cs"}
    assert all((site / link).is_file() for link in linked)
    assert early.read_text("utf-8") == "kept"


def test_a_history_without_results_is_one_line(url: str, tmp_path: Path) -> None:
    open_store(url, create=True).place.need_writable()
    ended = CliRunner().invoke(cli, ["history", "site", "--history", url, "--out", str(tmp_path / "site")])
    assert "the history holds no nights" in str(ended.exception)
