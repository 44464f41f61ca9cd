"""Pictures of the report, taken from its pages by a browser without a window."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pictures.paths import IMAGES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path
    from typing import Literal

    from playwright.sync_api import FloatRect, Page

    Theme = Literal["light", "dark"]

WIDTH_PX = 1200
CHART_PX = 820
"""Window of pictures of charts: in a column of text of 740 px, their words stay near their own size"""
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
INDEX = "report/index.html"
SCENE = "section.scene >> nth=3"
THEMES: tuple[Theme, ...] = ("light", "dark")


BADGE = """(element, number) => {
  const cell = element.closest("td"), badge = document.createElement("span");
  const box = (cell ?? element).getBoundingClientRect();
  const left = cell ? box.right - 15 : box.left - 26, top = box.top + (cell ? 3 : 0);
  badge.textContent = number;
  badge.style.cssText = `position:absolute;left:${left + scrollX}px;top:${top + scrollY}px;` +
    "width:22px;height:22px;border-radius:11px;background:#a3195b;color:#fff;font:bold 14px/22px sans-serif;" +
    "text-align:center;z-index:9;box-shadow:0 0 0 2px #fff";
  document.body.append(badge);
}"""
"""Script that puts a numbered disc to the left of an element, or into the corner of a table's cell"""
ROOM = "body { padding-left: 30px !important }"
"""Room for the numbers at the left edge"""


@dataclass(frozen=True)
class Shot:
    """Part of a page."""

    name: str
    """Of the picture: ``report-<name>-<theme>.png``"""
    page: str
    """In the work folder"""
    selector: str
    """First element that matches"""
    height_px: int = 700
    """Most that is shown of it"""
    marks: tuple[str, ...] = ()
    """Elements that get the numbers 1, 2, ..., which the text below the picture explains"""
    width_px: int = WIDTH_PX
    """Of the window"""


SHOTS = (
    Shot(
        "reading-opening",
        INDEX,
        "main",
        740,
        ("#verdict", ".judge", ".scale", ".folds input >> nth=0", ".matrix thead a >> nth=0", "details >> nth=0"),
    ),
    Shot(
        "reading-matrix",
        INDEX,
        ".folds",
        760,
        (
            ".matrix tbody tr >> nth=0 >> th .h",
            ".matrix tbody tr >> nth=3 >> td.pass >> nth=0",
            ".matrix tbody td:has-text('CM') >> nth=3",
            ".matrix tbody td .part >> nth=0",
            ".matrix tbody td.aside >> nth=0",
        ),
    ),
    Shot(
        "reading-scene",
        INDEX,
        SCENE,
        1500,
        (
            f"{SCENE} >> h3",
            f"{SCENE} >> .facts",
            f"{SCENE} >> .grid >> nth=0 >> figure >> nth=0",
            f"{SCENE} >> h4 >> nth=0",
            f"{SCENE} >> h4 >> nth=1",
            f"{SCENE} >> summary >> nth=0",
        ),
    ),
    Shot("matrix", INDEX, ".folds", 900),
    Shot("scene", INDEX, SCENE, 1400),
    Shot("cost", "report/cost.html", "section.scene .grid", 700, width_px=CHART_PX),
    Shot("effects", INDEX, "#effects ~ .scene .grid, #effects ~ .grid", 700, width_px=CHART_PX),
    Shot("roundoff", INDEX, "#roundoff ~ .grid", 700, width_px=CHART_PX),
    Shot("releases", "releases-mujoco/releases.html", ".grid", 700, width_px=CHART_PX),
    Shot("stability", "stability/stability.html", ".matrix", 900),
)


def report_pictures(work: Path) -> Iterator[Path]:
    """Take all pictures whose pages are there, light and dark; yield their files."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415  # for this stage alone

    browser_path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        for shot in SHOTS:
            if (work / shot.page).is_file():
                for theme in THEMES:
                    page = browser.new_page(
                        viewport={"width": shot.width_px, "height": 900},
                        device_scale_factor=1 if shot.width_px == WIDTH_PX else 2,
                        color_scheme=theme,
                        reduced_motion="reduce",
                        bypass_csp=bool(shot.marks),
                    )
                    page.goto((work / shot.page).as_uri())
                    number(page, shot.marks)
                    yield take(page, shot, theme)
                    page.close()
        browser.close()


def number(page: Page, marks: Sequence[str]) -> None:
    """Put numbers beside elements."""
    if marks:
        page.add_style_tag(content=ROOM)
    for k, selector in enumerate(marks, start=1):
        page.locator(selector).first.evaluate(BADGE, k)


def take(page: Page, shot: Shot, theme: Theme) -> Path:
    """Picture of one element, cut at its height."""
    element = page.locator(shot.selector).first
    element.scroll_into_view_if_needed()
    box = element.bounding_box()
    if box is None:
        raise ValueError(f"{shot.page}: {shot.selector} is not shown")
    top = box["y"] + float(page.evaluate("scrollY"))
    path = IMAGES / f"report-{shot.name}{'-dark' if theme == 'dark' else ''}.png"
    clip: FloatRect = {"x": 0, "y": top, "width": shot.width_px, "height": min(box["height"], shot.height_px)}
    page.screenshot(path=path, clip=clip, full_page=True)
    return path
