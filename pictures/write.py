"""Files that the command writes: what is in them, by path."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from pictures.chart import chart_file, cost_chart
from pictures.motion.picture import scene_picture, thumbnail
from pictures.motion.samples import motion_of
from pictures.pages.engine_page import engine_page, page_file
from pictures.pages.generated_tables import pages_with_tables
from pictures.pages.index_pages import ENGINES_INDEX, FAMILIES, engines_index, gallery_index
from pictures.pages.libraries import LIBRARIES
from pictures.pages.record import MeasuredRecord
from pictures.pages.scene_page import page_of, scene_page
from pictures.paths import GALLERY, GENERATED, IMAGES
from reports.results.writing import write_atomically
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from pictures.pages.libraries import EngineLibrary
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


def top_pictures() -> dict[Path, str]:
    """Picture at the top of the README, in each theme."""
    motion = motion_of(load_scene(TOP))
    return {IMAGES / f"chain-{theme}.svg": scene_picture(motion, theme) for theme in ("light", "dark")}


def scene_files(scene: Scene, measured: MeasuredRecord) -> dict[Path, str]:
    """Picture, thumbnail and page of a scene."""
    motion = motion_of(scene)
    picture = scene_picture(motion)
    return {
        picture_file(scene.name): picture,
        picture_file(scene.name, small=True): thumbnail(motion),
        page_of(scene.name): scene_page(scene, alt_of(picture), measured),
    }


def alt_of(picture: str) -> str:
    """Alternative text of a picture."""
    return html.unescape(picture.partition(ALT)[2].partition('"')[0])


def library_files(library: EngineLibrary, measured: MeasuredRecord) -> dict[Path, str]:
    """Page of a library, and its chart where the record has points."""
    chart = cost_chart(library, measured)
    page = {page_file(library): engine_page(library, measured)}
    return page | {chart_file(library): chart} if chart else page


def site_files() -> dict[Path, str]:
    """All files below :data:`GENERATED`: the gallery, and the pages of engines."""
    measured, scenes = MeasuredRecord(), gallery_scenes()
    found = {GALLERY / "index.md": gallery_index(scenes, measured), ENGINES_INDEX: engines_index()}
    for scene in scenes:
        found |= scene_files(scene, measured)
    for library in LIBRARIES:
        found |= library_files(library, measured)
    return found


def write_site_files() -> int:
    """Write the files below :data:`GENERATED` that differ, and remove those of scenes and engines that are gone."""
    files = site_files()
    for path in GENERATED.rglob("*"):
        if path.is_file() and path not in files:
            path.unlink()
    return write_all(files)


def write_tables() -> int:
    """Write the committed pages whose generated tables differ."""
    return write_all(pages_with_tables())


def write_all(files: Mapping[Path, str]) -> int:
    """Write the files that differ from those in place; return their number."""
    changed = {p: t for p, t in files.items() if not p.exists() or p.read_text(encoding="utf-8") != t}
    for path, text in changed.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, text)
    return len(changed)
