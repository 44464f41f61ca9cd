"""Content-Security-Policy of a page, and whether the page obeys it."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
LOADING = {"script", "img", "image", "link", "iframe", "object", "embed", "form", "base", "audio", "video", "font"}


class Page(HTMLParser):
    """What a page would load, and its policies in the order of its elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.before: list[str] = []
        self.policies: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policies.append(given["content"])
        elif not self.policies:
            self.before.append(tag)
        handlers = [name for name in given if name.startswith("on")]
        outside = [v for k, v in given.items() if k in {"src", "href", "action"} and not v.startswith("#")]
        styles = [v for k, v in given.items() if k == "style" and ("url(" in v and "url(#" not in v)]
        self.loads += [f"{tag}: {found}" for found in (*handlers, *outside, *styles)]
        self.loads += [tag] if tag in LOADING else []


def check_policy(page: Path) -> None:
    """Assert that a page has the policy before everything that could load, and loads nothing."""
    found = Page(page.read_text(encoding="utf-8"))
    assert found.policies == [POLICY]
    assert set(found.before) <= {"html", "head", "meta"}
    assert found.loads == []
