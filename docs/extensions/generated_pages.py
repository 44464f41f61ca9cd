"""Gallery and pages of engines, written into ``docs/generated/`` before Sphinx looks for pages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pictures.paths import DOCS
from pictures.write import write_site_files

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def write(app: Sphinx) -> None:
    """Write the files that differ.

    Raises
    ------
    RuntimeError
        If the imported code is not that of the folder whose documentation is built.
    """
    if Path(app.srcdir) != DOCS:
        raise RuntimeError(f"{DOCS.parent} has other documentation than {app.srcdir}: pip install -e '.[docs]' there")
    write_site_files()


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the beginning of a build."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
