"""Accessibility of pages: axe-core in headless Chromium, in both colour schemes and at several widths.

``python -m tests.support.accessibility FILE_OR_FOLDER ...`` prints every violation, and ends with 1 if there is any.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.support.browser import chromium

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from playwright.sync_api import Browser
    from playwright.sync_api import Page as Tab

SCHEMES = ("light", "dark")
WIDTHS = (390, 1200, 1600)
"""A phone, a laptop, a large screen; CSS pixels"""
HEIGHT = 900
RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
"""Tags of axe-core's rules that a page has to obey"""
TOO_WIDE = "page-wider-than-window"
"""Own rule: the page scrolls sideways as a whole (WCAG 1.4.10); wide tables scroll in boxes of their own"""

OUTSIDE = "loads-from-outside"
"""Own rule: the page asks for something that is not in its file"""

OPENED = "for (const d of document.querySelectorAll('details')) d.open = true"
RUN = "tags => axe.run(document, {runOnly: tags, resultTypes: ['violations']})"
OVERFLOW = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"


@dataclass(frozen=True)
class Violation:
    """One element that breaks one rule, in one scheme at one width."""

    page: str
    scheme: str
    width: int
    rule: str
    impact: str
    target: str
    """Selector of the element"""
    remedy: str

    def __str__(self) -> str:
        """One line."""
        view = f"{self.page} ({self.scheme}, {self.width} px)"
        return f"{view}: {self.rule} ({self.impact}): {self.target}: {self.remedy}"


def violations(
    pages: Sequence[Path], schemes: Sequence[str] = SCHEMES, widths: Sequence[int] = WIDTHS
) -> list[Violation]:
    """Violations on HTML files, all their folded parts unfolded.

    Raises
    ------
    RuntimeError
        If no Chromium is installed.
    """
    if not pages:
        return []  # no browser is needed to find that there is nothing
    with chromium() as browser:
        views = [(s, w) for s in schemes for w in widths]
        return [v for page in pages for s, w in views for v in on_page(browser, page, s, w)]


def on_page(browser: Browser, page: Path, scheme: Any, width: int) -> Iterator[Violation]:
    """Violations on one page in one view; its policy is bypassed, because it allows no script, not even axe's."""
    with browser.new_context(
        color_scheme=scheme, viewport={"width": width, "height": HEIGHT}, bypass_csp=True, offline=True
    ) as context:
        tab, asked = context.new_page(), []
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(page.resolve().as_uri())
        tab.evaluate(OPENED)
        for found in checked(tab):
            for node in found["nodes"]:
                target = " ".join(str(t) for t in node["target"])
                remedy = " ".join(node["failureSummary"].split())
                yield Violation(page.name, scheme, width, found["id"], found["impact"], target, remedy)
        wide = tab.evaluate(OVERFLOW)
        if wide > 0:
            yield Violation(page.name, scheme, width, TOO_WIDE, "serious", "html", f"{wide} px too wide")
        outside = [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]
        yield from (Violation(page.name, scheme, width, OUTSIDE, "serious", "html", url) for url in outside)


def checked(tab: Tab) -> list[dict[str, Any]]:
    """Rules that a page breaks, as axe-core reports them."""
    tab.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = tab.evaluate(RUN, list(RULES))["violations"]
    return found


def html_files(places: Iterable[Path]) -> list[Path]:
    """HTML files among some files and in some folders."""
    return [f for place in places for f in (sorted(place.rglob("*.html")) if place.is_dir() else [place])]


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the files and folders of a command line."""
    parser = argparse.ArgumentParser(description="Check HTML files with axe-core.")
    parser.add_argument("places", nargs="+", type=Path, metavar="FILE_OR_FOLDER")
    parser.add_argument("--widths", type=int, nargs="+", default=WIDTHS, help="widths of the window, CSS pixels")
    given = parser.parse_args(arguments)
    pages = html_files(given.places)
    found = violations(pages, widths=given.widths)
    print("\n".join(str(v) for v in found))
    print(f"{len(pages)} pages, {len(SCHEMES)} schemes, {len(given.widths)} widths: {len(found)} violations")
    return 1 if found or not pages else 0


if __name__ == "__main__":
    sys.exit(main())
