"""The documentation's site as files: its pages, their anchors and links."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

LOADS = {"script": "src", "img": "src", "iframe": "src", "source": "srcset"}
STYLES = {"stylesheet", "preload", "icon", "modulepreload"}


class Page(HTMLParser):
    """Anchors, links and loaded files of one page."""

    def __init__(self) -> None:
        super().__init__()
        self.ids, self.links, self.loads = set[str](), list[str](), list[str]()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take an element."""
        given = {name: value or "" for name, value in attrs}
        self.ids.update(value for name, value in given.items() if name in {"id", "name"})
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in LOADS and LOADS[tag] in given:
            self.loads.append(given[LOADS[tag]])
        if tag == "link" and STYLES & set(given.get("rel", "").split()):
            self.loads.append(given.get("href", ""))


def read_site(folder: Path) -> dict[Path, Page]:
    """All pages of a built site."""
    found = {}
    for path in sorted(folder.rglob("*.html")):
        found[path.resolve()] = page = Page()
        page.feed(path.read_text("utf-8"))
    return found


def dead_links(site: dict[Path, Page]) -> Iterator[str]:
    """Links to pages, files and anchors of the site that are not there."""
    for path, page in site.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                yield f"{path.name}: {link}"
            elif parts.fragment and target in site and unquote(parts.fragment) not in site[target].ids:
                yield f"{path.name}: {link} (no such anchor)"


def loads_from_elsewhere(site: dict[Path, Page]) -> Iterator[str]:
    """Scripts, styles and pictures that a page would load from another place."""
    for path, page in site.items():
        for target in page.loads:
            if urlsplit(target).netloc:
                yield f"{path.name}: {target}"
