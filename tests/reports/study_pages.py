"""Every kind of page that barchain writes, from small studies and synthetic tables."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from click.testing import CliRunner

from barchain.cli.main import cli, run
from barchain.nightly.history.nights import open_store
from reports.render import render, render_study
from reports.results import releases
from tests.nightly.history.synthetic import bits, count, error, night, ratio, verdict
from tests.reports import cost_tables, effects_tables, roundoff_tables
from tests.studies import scaling_tables
from tests.support.report_fixture import build
from tests.support.results import MADE, write_results

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def report(folder: Path) -> Path:
    """Report of a comparison with passed, failed and skipped pairs, a short run and an open path, and all chapters."""
    build(folder, ["paper/fig13", "basics/kepler_hyperbolic"], samples=31)
    cost_tables.write(folder, cost_tables.study())
    effects_tables.write(folder, effects_tables.ROWS)
    roundoff_tables.write(folder)
    scaling_tables.write(folder)
    return render(folder)[0]


def studied(name: str, *arguments: str) -> Callable[[Path], Path]:
    """Page of a study that a command runs."""

    def made(folder: Path) -> Path:
        assert run([*arguments, "--workers", "1", "--out", str(folder)]) == 0
        return folder / f"{name}.html"

    return made


def releases_page(folder: Path) -> Path:
    """Page of two releases of an engine, of which one does not run."""
    named: dict[str, Any] = {"engine": "box", "version": "1.0", "scene": "s"}
    size = {"wheel_B": 1e6, "installed_B": 3e6, "import_s": 0.1, "import_low": 0.09, "import_high": 0.12}
    rows = {
        "releases": [
            named | size | {"released": "2026-01-05", "state": "runs"},
            named | {"version": "1.1", "released": "2026-02-05", "state": "does not run", "reason": "no name"},
        ],
        "errors": [named | {"quantity": "attitude", "unit": "rad", "value": 1e-6, "verdict": "pass"}],
        "runs": [named | {"trajectory": "aa", "steps": 100}],
        "times": [
            named | {"setting": "attitude<=1e-06", "relative_to": "other", "ratio": 3.0, "low": 2.5, "high": 3.5}
        ],
    }
    record = MADE | {"engine": "box", "distribution": "box", "scenes": {"s": {}}, "anchor": "other"}
    record |= {"versions": ["1.0", "1.1"]}
    write_results(folder, releases.FILES, rows, record)
    return render_study("releases", folder).page


def nightly_page(folder: Path) -> Path:
    """Page of a night on which an error grew, after nights of which one was worse."""
    history = str(folder / "history")
    store = open_store(history, create=True)
    for k, factor in enumerate((1.0, 1.0, 1.0, 2.0, 3.0)):
        digits = bits("00" if factor == 1.0 else "11")
        store.add(night(error(1e-5 * factor), count(), verdict(), digits, ratio(factor), number=k))
    CliRunner().invoke(cli, ["history", "report", "--history", history, "--out", str(folder)])
    return folder / "nightly.html"


def results_page(folder: Path) -> Path:
    """Results page of nights of which an engine is worse on the last, and another supports nothing."""
    nightly_page(folder)
    store = open_store(str(folder / "history"))
    other = verdict("unsupported", reason="no <b>gravity</b> of points")
    refused = replace(other, identity=replace(other.identity, engine="box"))
    store.add(night(error(3e-5), verdict("inconsistent"), ratio(3.0), refused, number=5))
    CliRunner().invoke(cli, ["history", "site", "--history", store.place.url, "--out", str(folder / "site")])
    return folder / "site" / "index.html"


PAGES: dict[str, Callable[[Path], Path]] = {
    "report": report,
    "short report": lambda folder: render(build(folder, ["basics/kepler_hyperbolic"], samples=31))[0],
    "ensemble": studied(
        "ensemble", "ensemble", "paper/fig05", "--vary", "angle_deg=normal(0, 1)", "--runs", "20", "--orbits", "0.1",
        "--samples", "3",
    ),
    "sweep": studied(
        "sweep", "sweep", "basics/two_bars_free", "--vary", "chain.rate_factor[1]=1:5:5", "--vary",
        "chain.rate_factor[2]=1:5:5", "--vary", "run.samples=5",
    ),
    "stability": studied("stability", "stability", "hard/vertical_fall", "--engine", "reference"),
    "selftest": studied(
        "selftest", "selftest", "basics/libration", "--fault", "nan-com", "--fault", "scale-rate", "--smallest"
    ),
    "releases": releases_page,
    "nightly": nightly_page,
    "results": results_page,
}  # fmt: skip
"""Function that makes each page in an empty folder"""
