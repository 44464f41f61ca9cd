"""Pictures of the report, taken from its pages by a browser without a window."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pictures.paths import IMAGES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from typing import Literal

    from playwright.sync_api import FloatRect, Page

    Theme = Literal["light", "dark"]

WIDTH_PX = 1200
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
THEMES: tuple[Theme, ...] = ("light", "dark")


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


SHOTS = (
    Shot("matrix", "report/index.html", "#matrix ~ .matrix", 900),
    Shot("scene", "report/index.html", "section.scene >> nth=8", 1100),
    Shot("cost", "report/cost.html", "section.scene .grid", 700),
    Shot("effects", "report/effects.html", "section.scene, .grid", 700),
    Shot("roundoff", "report/roundoff.html", ".grid", 700),
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
                    page = browser.new_page(viewport={"width": WIDTH_PX, "height": 900}, color_scheme=theme)
                    page.goto((work / shot.page).as_uri())
                    yield take(page, shot, theme)
                    page.close()
        browser.close()


def take(page: Page, shot: Shot, theme: Theme) -> Path:
    """Picture of one element, cut at its height."""
    element = page.locator(shot.selector).first
    element.scroll_into_view_if_needed()
    box = element.bounding_box()
    if box is None:
        raise ValueError(f"{shot.page}: {shot.selector} is not shown")
    path = IMAGES / f"report-{shot.name}{'-dark' if theme == 'dark' else ''}.png"
    clip: FloatRect = {"x": 0, "y": box["y"], "width": WIDTH_PX, "height": min(box["height"], shot.height_px)}
    page.screenshot(path=path, clip=clip, full_page=True)
    return path
