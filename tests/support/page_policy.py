"""Content-Security-Policy of a page, and whether the page obeys it."""

from __future__ import annotations

import base64
import hashlib
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
        self.runs = False
        self.loads: list[str] = []
        self.before: list[str] = []
        self.scripts: list[str] = []
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
        own_script = tag == "script" and not given.keys() - {"type", "id"}
        self.runs = own_script and given.get("type") != "application/json"  # whose text is data
        self.loads += [tag] if tag in LOADING and not own_script else []

    def handle_data(self, data: str) -> None:
        if self.runs:
            self.scripts.append(data)

    def handle_endtag(self, tag: str) -> None:
        self.runs = False


def check_policy(page: Path, *, scripts: int = 0) -> None:
    """Assert that a page has the policy before everything that could load, loads nothing, and has so many scripts.

    Its scripts are allowed by their hashes.
    """
    found = Page(page.read_text(encoding="utf-8"))
    assert len(found.scripts) == scripts
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in found.scripts]
    allowed = "".join(f" 'sha256-{digest}'" for digest in digests)
    assert found.policies == [f"{POLICY}; script-src{allowed}" if allowed else POLICY]
    assert set(found.before) <= {"html", "head", "meta"}
    assert found.loads == []
