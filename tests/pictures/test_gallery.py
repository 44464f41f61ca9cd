"""The gallery shows every scene by a picture that needs nothing else and moves only for those who want it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from adapters.registry import COMPILED, find_engine
from pictures.motion.geometry import chain_panel, orbit_panel, round_length
from pictures.motion.picture import scene_picture
from pictures.motion.samples import motion_of, riding_axes
from pictures.motion.windows import window_of
from pictures.paths import IMAGES, ROOT
from pictures.write import TOP, gallery_scenes, picture_file, site_files
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from scenarios import Scene

SVG = "{http://www.w3.org/2000/svg}"
LEFT_OUT = "conform/"
"""Scenes for examinations of new engines, which the index names in one line"""
MOST_BYTES = 7_000_000  # 72 scenes, and charts of the documents

needs_compiler = pytest.mark.skipif(bool(find_engine(COMPILED).missing), reason="pictures need the compiled reference")
drawn = cache(site_files)
every_scene = pytest.mark.parametrize("scene", gallery_scenes(), ids=lambda s: s.name)


def test_the_gallery_has_every_scene_but_those_of_conform() -> None:
    assert {s.name for s in gallery_scenes()} == {n for n in scene_names() if not n.startswith(LEFT_OUT)}


@pytest.mark.slow
@needs_compiler
@every_scene
def test_every_scene_has_a_picture_and_a_thumbnail_with_a_title_which_move_only_for_those_who_want_it(
    scene: Scene,
) -> None:
    for small in (False, True):
        text = drawn()[picture_file(scene.name, small=small)]
        root = ET.fromstring(text)
        assert root.findtext(f"{SVG}title")
        assert root.get("aria-label") == root.findtext(f"{SVG}title")
        assert root.get("role") == "img"
        assert "prefers-color-scheme:dark" in text
        assert not re.search("href=|<script", text)
        moving = [group for group in root.iter(f"{SVG}g") if group.get("class") == "m"]
        inside = sum(len(list(group.iter(f"{SVG}animate"))) for group in moving)
        assert inside == len(list(root.iter(f"{SVG}animate")))
        assert "@media (prefers-reduced-motion:reduce){.m{display:none}" in (root.findtext(f"{SVG}style") or "")


@pytest.mark.slow
@needs_compiler
def test_pictures_stay_small_and_nothing_that_is_generated_names_a_folder_of_the_machine() -> None:
    files = [path for path in IMAGES.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) + sum(map(len, drawn().values())) < MOST_BYTES
    assert not [path for path, text in drawn().items() if str(ROOT) in text]


@needs_compiler
def test_two_drawings_of_a_scene_have_the_same_bytes() -> None:
    scene = load_scene("paper/fig09")
    assert scene_picture(motion_of(scene)) == scene_picture(motion_of(scene))


@needs_compiler
def test_a_drawn_chain_keeps_the_lengths_of_its_bars_in_both_panels() -> None:
    motion = motion_of(load_scene("effects/tip_masses"))
    length = np.array(motion.scene.chain.length_m)
    for chains in (orbit_panel(motion, body=True).chains_px, chain_panel(motion).chains_px):
        drawn = np.linalg.norm(np.diff(chains, axis=1), axis=-1)
        np.testing.assert_allclose(drawn / drawn[:, :1], np.broadcast_to(length / length[0], drawn.shape), rtol=1e-9)


@needs_compiler
def test_a_chain_at_rest_along_the_radius_stands_upright_and_does_not_move() -> None:
    motion = motion_of(load_scene("basics/radial_equilibrium"))
    assert not motion.shape_changes
    assert np.abs(motion.riding_m[..., 0]).max() < 1e-6 * motion.scene.size_m


def test_the_riding_observer_sees_the_outward_direction_upwards_and_angles_keep_their_sense() -> None:
    place = np.array([[0.0, 7.0e6], [-7.0e6, 0.0]])
    outward = place[:, None, :] / 7.0e6
    turned = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
    np.testing.assert_allclose(riding_axes(place, outward), np.broadcast_to([0.0, 1.0], (2, 1, 2)), atol=1e-15)
    np.testing.assert_allclose(riding_axes(place, turned), np.broadcast_to([-1.0, 0.0], (2, 1, 2)), atol=1e-15)


@every_scene
def test_the_shown_part_lies_inside_the_run(scene: Scene) -> None:
    window = window_of(scene)
    assert 0.0 <= window.start_s < window.end_s <= scene.run.duration_s


@pytest.mark.parametrize(("most", "found"), [(99.0, 50.0), (100.0, 100.0), (0.0041, 0.002), (7.2, 5.0)])
def test_a_scale_bar_has_a_round_length(most: float, found: float) -> None:
    assert round_length(most) == pytest.approx(found, rel=1e-12)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_picture_at_the_top_of_the_readme_has_one_theme_in_each_file(theme: str) -> None:
    text = (IMAGES / f"chain-{theme}.svg").read_text(encoding="utf-8")
    ET.fromstring(text)
    papers = set(re.findall(r"--paper:(#\w+)", text))
    assert len(papers) == 1
    assert load_scene(TOP).title in text
