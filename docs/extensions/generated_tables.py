"""Directive ``generated``: tables of the reference, made from the code when the site is built."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from reference_tables import TABLES
from sphinx.util.docutils import SphinxDirective

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.application import Sphinx


class Generated(SphinxDirective):
    """A table by its name in :data:`reference_tables.TABLES`."""

    required_arguments: ClassVar[int] = 1

    def run(self) -> list[nodes.Node]:
        """Parse the table's Markdown as part of the page."""
        return self.parse_text_to_nodes(TABLES[self.arguments[0]](), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("generated", Generated)
    return {"parallel_read_safe": True}
