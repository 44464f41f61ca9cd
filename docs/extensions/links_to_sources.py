"""Links that leave the documentation for a file of the project become code: the site has no copy of it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

LINK = re.compile(r"(?<!!)\[([^\]\n]+(?:\n[^\]\n]+)?)\]\((?!https?:|mailto:|#)([^)\s#]+)(?:#[^)]*)?\)")
PAGES = {".md", ".ipynb"}


def replace_links(app: Sphinx, name: str, source: list[str]) -> None:
    """Replace links in the text of a page; `source` holds it and is changed in place."""
    page = Path(app.env.doc2path(name))
    root = Path(app.srcdir)
    source[0] = LINK.sub(lambda found: found.group() if inside(page, root, found.group(2)) else words(found), source[0])


def inside(page: Path, root: Path, target: str) -> bool:
    """Whether a link leads to a page or a picture of the documentation."""
    path = (page.parent / target).resolve()
    return path.is_relative_to(root) and not path.is_dir() and "recipes" not in path.parts


def words(found: re.Match[str]) -> str:
    """Words of a link, as code with the file's path from the project's folder."""
    text = found.group(1)
    path = re.sub(r"^(\.\./)+", "", found.group(2))
    return f"{text} (`{path}`)" if path.strip("/") not in text else text


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the reading of pages."""
    app.connect("source-read", replace_links)
    return {"parallel_read_safe": True}
