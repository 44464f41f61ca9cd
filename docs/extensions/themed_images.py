"""Pictures of a page: the variant of the reader's theme, and a link to the picture in its full size.

A page names one picture, as a code host shows it: ``X.png``, or ``X-light.svg``. In the dark theme the site shows
``X-dark.png`` instead, if that file lies beside it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from docutils import nodes
from sphinx.transforms import SphinxTransform
from sphinx.util.osutil import relative_uri

if TYPE_CHECKING:
    from sphinx.application import Sphinx

LIGHT, DARK = "only-light", "only-dark"
"""Classes that the theme furo hides in the other theme"""


def dark_variant(uri: str) -> str:
    """Address of the dark variant of a picture: ``X-dark.png`` of ``X.png`` and of ``X-light.png``."""
    path = Path(uri)
    return path.with_name(f"{path.stem.removesuffix('-light')}-dark{path.suffix}").as_posix()


class DarkVariants(SphinxTransform):
    """Put the dark variant of a picture, if there is one, after the picture."""

    default_priority: ClassVar[int] = 400
    """Before Sphinx collects the files of all pictures"""

    def apply(self, **_: Any) -> None:
        """Change the pictures of one page."""
        for image in [*self.document.findall(nodes.image)]:
            uri = image["uri"]
            if "://" in uri or Path(uri).stem.endswith("-dark"):
                continue
            dark = dark_variant(uri)
            if not Path(self.env.relfn2path(dark, self.env.docname)[1]).is_file():
                continue
            other = image.deepcopy()
            other["uri"] = dark
            image["classes"].append(LIGHT)
            other["classes"].append(DARK)
            image.parent.insert(image.parent.index(image) + 1, other)


def in_link(image: nodes.Element) -> bool:
    """Whether a picture is part of a link, at any depth: Sphinx puts an inline node into links to other pages."""
    above = image.parent
    while above is not None and not isinstance(above, nodes.reference):
        above = above.parent
    return above is not None


def link_to_full_size(app: Sphinx, doctree: nodes.document, name: str) -> None:
    """Make each picture that leads nowhere a link to its own file."""
    folder = relative_uri(app.builder.get_target_uri(name), "_images")
    for image in [*doctree.findall(nodes.image)]:
        if in_link(image) or image["uri"] not in app.env.images:
            continue
        theme = [c for c in image["classes"] if c in (LIGHT, DARK)]
        link = nodes.reference("", "", internal=True, refuri=f"{folder}/{app.env.images[image['uri']][1]}")
        link["classes"] += ["full-size", *theme]
        image.replace_self(link)
        link += image


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the transform, and connect to the finished pages."""
    app.add_transform(DarkVariants)
    app.connect("doctree-resolved", link_to_full_size)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
