"""Files that the command writes: what is in them, by path."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from pictures.chart import chart_file, cost_chart
from pictures.motion.picture import scene_picture, thumbnail
from pictures.motion.samples import motion_of
from pictures.pages.cost_page import COST_PAGE, cost_page
from pictures.pages.engine_page import engine_page, page_file
from pictures.pages.index_pages import ENGINES_INDEX, FAMILIES, engines_index, gallery_index
from pictures.pages.libraries import LIBRARIES
from pictures.pages.marked import marked_pages
from pictures.pages.record import MeasuredRecord
from pictures.pages.releases import RELEASES_PAGE, releases_page
from pictures.pages.scene_page import page_of, scene_page
from pictures.paths import GALLERY, IMAGES
from reports.tables.writing import write_atomically
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from scenarios import Scene

TOP = "paper/fig09"
"""Scene at the top of the README"""
ALT = 'aria-label="'


def gallery_scenes() -> list[Scene]:
    """Scenes of the gallery, family by family."""
    names = [n for family in FAMILIES for n in scene_names() if n.startswith(f"{family.folder}/")]
    return [load_scene(name) for name in names]


def picture_file(scene: str, *, small: bool = False) -> Path:
    """File of a scene's picture or thumbnail."""
    return GALLERY / f"{scene}{'-small' * small}.svg"


def pictures_of(scene: Scene) -> Iterator[tuple[Path, str]]:
    """Pictures of a scene."""
    motion = motion_of(scene)
    yield picture_file(scene.name), scene_picture(motion)
    yield picture_file(scene.name, small=True), thumbnail(motion)
    if scene.name == TOP:
        for theme in ("light", "dark"):
            yield IMAGES / f"chain-{theme}.svg", scene_picture(motion, theme)


def alt_of(path: Path) -> str:
    """Alternative text of a picture that was written."""
    text = path.read_text(encoding="utf-8")
    return html.unescape(text.partition(ALT)[2].partition('"')[0])


def pages() -> dict[Path, str]:
    """All pages, rendered from the scenes, the engines' code, the pictures and the record."""
    measured, scenes = MeasuredRecord(), gallery_scenes()
    found = {page_of(s.name): scene_page(s, alt_of(picture_file(s.name)), measured) for s in scenes}
    found |= {page_file(library): engine_page(library, measured) for library in LIBRARIES}
    found |= {GALLERY / "index.md": gallery_index(scenes, measured), ENGINES_INDEX: engines_index()}
    found[COST_PAGE] = cost_page(COST_PAGE.read_text(encoding="utf-8"), measured)
    found[RELEASES_PAGE] = releases_page(RELEASES_PAGE.read_text(encoding="utf-8"), measured)
    return found | marked_pages()


def charts() -> dict[Path, str]:
    """Charts of the pages of the engines, from the record."""
    measured = MeasuredRecord()
    return {chart_file(lib): chart for lib in LIBRARIES if (chart := cost_chart(lib, measured))}


def write_all(files: Mapping[Path, str]) -> int:
    """Write the files that differ from those in place; return their number."""
    changed = {p: t for p, t in files.items() if not p.exists() or p.read_text(encoding="utf-8") != t}
    for path, text in changed.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, text)
    return len(changed)
