"""The page of a case in a browser: it compares a table that is dropped on it, without a network."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from barchain.cli.main import cli
from tests.support.accessibility import HEIGHT, OVERFLOW, SCHEMES, checked
from tests.support.browser import chromium, in_browser
from tests.support.page_policy import check_policy

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser, Page

SCENE = "basics/two_bars_free"


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a case with its page, whose requests are the default ones."""
    out = tmp_path_factory.mktemp("cases")
    found = CliRunner().invoke(cli, ["export", SCENE, "--out", str(out), "--page"])
    assert found.exit_code == 0, found.output
    return out / SCENE


@pytest.fixture(scope="module")
def browser() -> Browser:
    with chromium() as opened:
        yield opened


def new_tab(browser: Browser, **view: Any) -> Page:
    """Tab without a network; an error of its page, or of the page's policy, fails."""
    tab = browser.new_context(offline=True, **view).new_page()
    tab.on("pageerror", lambda error: pytest.fail(str(error)))
    tab.on("console", lambda said: pytest.fail(said.text))
    return tab


shared_tab = cache(new_tab)
"""Tab of the usual view, in which each test loads the page anew: a tab's process takes longer to start than a test"""


def opened(browser: Browser, case: Path, table: str, **view: Any) -> Page:
    """Page, loaded anew, after a table was given to it."""
    tab = new_tab(browser, **view) if view else shared_tab(browser)
    tab.goto((case / "compare.html").as_uri())
    tab.set_input_files("#file", {"name": "run.csv", "mimeType": "text/csv", "buffer": table.encode()})
    tab.wait_for_function("document.getElementById('verdict').textContent !== 'No table yet.'")
    return tab


def departures(tab: Page) -> list[str]:
    return tab.locator("tbody td:nth-child(2)").all_inner_texts()


def test_a_page_allows_its_own_script_alone(case: Path) -> None:
    check_policy(case / "compare.html", scripts=1)


@in_browser
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_page_with_its_result_is_accessible_on_a_phone(case: Path, browser: Browser, scheme: str) -> None:
    view = {"color_scheme": scheme, "viewport": {"width": 390, "height": HEIGHT}, "bypass_csp": True}
    tab = opened(browser, case, (case / "samples.csv").read_text(), **view)
    assert checked(tab) == []
    assert tab.evaluate(OVERFLOW) <= 0


@in_browser
def test_the_samples_of_a_case_stay_inside_every_tube(case: Path, browser: Browser) -> None:
    tab = opened(browser, case, (case / "samples.csv").read_text())
    for request in ("1e-6", "1e-9"):
        tab.select_option("#rtol", label=request)
        assert tab.inner_text("#verdict").startswith(f"Inside the tube of {request} in CM track")
        assert departures(tab) == ["✓ none"] * 5


@in_browser
def test_an_error_is_shown_with_its_size_and_from_where_it_leaves_the_tube(case: Path, browser: Browser) -> None:
    """The first departure is the earliest in any order of rows."""
    table = pd.read_csv(case / "samples.csv", usecols=["t_s", "angle_1_rad", "angle_2_rad"])
    table.loc[150:, "angle_2_rad"] += 1e-4
    tab = opened(browser, case, table[::-1].to_csv(index=False, sep=";"))
    assert "Inside" in tab.inner_text("#verdict")
    tab.select_option("#rtol", label="1e-9")
    when = f"{table.t_s[150]:.6g} s"
    assert tab.inner_text("#verdict") == f"Outside the tube of 1e-9: Attitude from {when}."
    assert departures(tab) == [f"✗ {when}, angle_2_rad"]
    assert "1.00e−4 rad" in tab.inner_text("tbody")
    assert tab.locator("#result svg").count() == 1


@in_browser
@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("", "The file is empty."),
        ("time,angle_1_rad\n0,0\n", "names no column t_s"),
        ("t_s,phi\n0,0\n", "No column is named as"),
        ("t_s,angle_1_rad\n0.5,0\n", "No row is at an instant"),
        ("t_s;angle_1_rad\n0,0;0,5\n", "Row 1: t_s is no number, but “0,0”. Write numbers with a decimal point."),
    ],
)
def test_a_table_that_can_not_be_compared_is_told_why(case: Path, browser: Browser, table: str, said: str) -> None:
    assert said in opened(browser, case, table).inner_text("#verdict")


@in_browser
@pytest.mark.parametrize("cell", [",nan", ",1.2d0", ""])
def test_a_value_that_is_no_number_leaves_the_tube(case: Path, browser: Browser, cell: str) -> None:
    start = float(pd.read_csv(case / "samples.csv").angle_1_rad[0])
    tab = opened(browser, case, f"t_s,angle_1_rad,angle_2_rad\n0,{start!r}{cell}\n")
    assert departures(tab) == ["✗ 0 s (no number), angle_2_rad"]
    assert "angle_2_rad: no number in 1 row, the first at 0 s" in tab.inner_text("#notes")


@in_browser
def test_a_run_that_blew_up_is_outside_from_its_first_empty_cells(case: Path, browser: Browser) -> None:
    table = pd.read_csv(case / "samples.csv", usecols=["t_s", "com_x_m", "com_y_m", "angle_1_rad", "angle_2_rad"])
    table.loc[51:, ["angle_1_rad", "angle_2_rad"]] = np.nan
    tab = opened(browser, case, table.to_csv(index=False))
    assert tab.inner_text("#verdict") == "Outside the tube of 1e-6: Attitude from 510 s (no number)."
    assert departures(tab) == ["✓ none", "✗ 510 s (no number), angle_1_rad"]
    assert "angle_1_rad, angle_2_rad: no number in 150 rows, the first at 510 s: empty." in tab.inner_text("#notes")


@in_browser
def test_a_part_of_a_table_is_inside_only_where_it_has_rows(case: Path, browser: Browser) -> None:
    table = pd.read_csv(case / "samples.csv", usecols=["t_s", "angle_1_rad", "angle_2_rad"])
    tab = opened(browser, case, table[:100].to_csv(index=False))
    held = "Inside the tube of 1e-6 up to 990 s in Attitude; the table has 100 of 201 instants."
    assert tab.inner_text("#verdict") == held
    tab = opened(browser, case, table[100:150].to_csv(index=False))
    assert "1e-6 from 1000 s up to 1490 s in" in tab.inner_text("#verdict")


@in_browser
def test_a_channel_without_a_tube_at_any_row_is_not_inside_it(case: Path, browser: Browser) -> None:
    tab = opened(browser, case, "t_s,com_x_m,angle_1_rad\n0,6728000,7\n")
    tab.evaluate("data.tubes[1].width.attitude.fill(null)")  # as after a predictability limit
    tab.select_option("#rtol", label="1e-9")
    assert tab.inner_text("#verdict").startswith("Inside the tube of 1e-9 up to 0 s in CM track;")
    assert departures(tab) == ["✓ none", "not compared"]
