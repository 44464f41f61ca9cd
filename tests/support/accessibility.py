"""Accessibility of pages: axe-core in headless Chromium, in both colour schemes and at several widths."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING, Any

from tests.support.browser import chromium

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from playwright.sync_api import Browser
    from playwright.sync_api import Page as Tab

SCHEMES = ("light", "dark")
WIDTHS = (390, 1200, 1600)
"""A phone, a laptop, a large screen; CSS pixels"""
HEIGHT = 900
RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
"""Tags of axe-core's rules that a page has to obey"""
OPENED = "for (const d of document.querySelectorAll('details')) d.open = true"
RUN = "tags => axe.run(document, {runOnly: tags, resultTypes: ['violations']})"
OVERFLOW = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"
"""Whether the page scrolls sideways as a whole (WCAG 1.4.10); wide tables scroll in boxes of their own"""


def violations(page: Path) -> list[str]:
    """Violations on an HTML file in every view, all its folded parts unfolded.

    Raises
    ------
    RuntimeError
        If no Chromium is installed.
    """
    with chromium() as browser:
        return [v for scheme in SCHEMES for width in WIDTHS for v in in_view(browser, page, scheme, width)]


def in_view(browser: Browser, page: Path, scheme: Any, width: int) -> Iterator[str]:
    """Violations on one page in one view; its policy is bypassed, because it allows no script, not even axe's."""
    view, asked = f"{page.name} ({scheme}, {width} px)", []
    with browser.new_context(
        color_scheme=scheme, viewport={"width": width, "height": HEIGHT}, bypass_csp=True, offline=True
    ) as context:
        tab = context.new_page()
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(page.resolve().as_uri())
        tab.evaluate(OPENED)
        for found in checked(tab):
            for node in found["nodes"]:
                yield f"{view}: {found['id']}: {node['target']}: {' '.join(node['failureSummary'].split())}"
        wide = tab.evaluate(OVERFLOW)
        if wide > 0:
            yield f"{view}: {wide} px too wide"
        outside = [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]
        yield from (f"{view}: loads {url} from outside" for url in outside)


def checked(tab: Tab) -> list[dict[str, Any]]:
    """Rules that a page breaks, as axe-core reports them."""
    tab.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = tab.evaluate(RUN, list(RULES))["violations"]
    return found
