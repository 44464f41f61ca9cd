"""The page of conventions stays true: its picture is its script's, its numbers are the reference's."""

from __future__ import annotations

import dataclasses
import math
import re
import runpy

import numpy as np
import pytest

from adapters.common.landing import landing_text
from adapters.engine import Coordinates
from adapters.reference.numpy_engines import Reference
from barchain.engine import ChainForces, FrameState
from tests.authors.worked_example import SHAPES, at_start, page, scenes, tables
from tests.structure.product import ROOT

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
SEEN = 2e-7  # of eight digits
PICTURE = ROOT / "docs/images/engine_conventions.svg"


def numbers_and_words(text: str) -> tuple[list[float], str]:
    return [float(n) for n in NUMBER.findall(text)], NUMBER.sub("#", text)


@pytest.mark.parametrize("which", [0, 1], ids=["free", "prescribed"])
def test_the_worked_example_holds_every_channels_number_at_the_start(which: int) -> None:
    made = tables()[which]
    head = made.partition("\n")[0]
    assert head in page(), f"insert\n{made}"
    shown = page()[page().index(head) :].partition("\n\n")[0] + "\n"
    (mine, words), (theirs, said) = numbers_and_words(shown), numbers_and_words(made)
    assert words == said, f"insert\n{made}"
    assert mine == pytest.approx(theirs, rel=SEEN), f"insert\n{made}"


def test_the_worked_example_names_every_channel_of_a_trajectory() -> None:
    seen = at_start(scenes()[0])
    arrays = {name for name, value in vars(seen).items() if isinstance(value, np.ndarray)}
    assert arrays - {"torque_N_m"} == set(SHAPES)


def test_the_example_follows_from_the_pages_formulas_by_hand() -> None:
    seen, (scene, _) = at_start(scenes()[0]), scenes()
    r0, longitude = 6_878_000.0, math.radians(60.0)
    v0 = 1.1 * math.sqrt(scene.central_body.mu_m3_s2 / r0)
    theta = np.radians([10.0, -45.0])
    apart = 10.0 * np.array([math.cos(theta[0]), math.sin(theta[0])])
    apart += 20.0 * np.array([math.cos(theta[1]), math.sin(theta[1])])
    assert seen.com_m[0] == pytest.approx(r0 * np.array([math.cos(longitude), math.sin(longitude)]))
    assert seen.com_velocity_m_s[0] == pytest.approx(v0 * np.array([-math.sin(longitude), math.cos(longitude)]))
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    assert seen.position_m is not None
    assert seen.angle_rad[0] == pytest.approx(theta)
    assert seen.rate_rad_s[0] == pytest.approx([2.0 * v0 / r0, -v0 / r0])
    assert seen.position_m[0] == pytest.approx(np.array([-0.75 * apart, 0.25 * apart]))


def test_the_reaction_is_the_force_that_bar_1_lacks_in_newtons_law() -> None:
    scene, dt = scenes()[0], 0.5
    short = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=2.0 * dt, samples=3))
    motion = Reference().run(short, Reference.sweep.setting(1e-13))
    assert motion.angle_rad is not None
    assert motion.reaction_N is not None
    ends = np.stack([np.cos(motion.angle_rad), np.sin(motion.angle_rad)], axis=-1)
    apart = 10.0 * ends[:, 0] + 20.0 * ends[:, 1]
    place = np.stack([-0.75 * apart, 0.25 * apart], axis=1)
    acceleration = (place[2] - 2.0 * place[1] + place[0]) / dt**2
    still = np.zeros((2, 2))
    tide, _ = ChainForces(scene)(FrameState(*motion.com_m[1].tolist()), place[1], motion.angle_rad[1], still, still[0])
    common = tide.sum(axis=0) / scene.mass_kg  # the tides accelerate the centre of mass too
    lacking = 100.0 * (acceleration[0] + common) - tide[0]
    assert motion.reaction_N[1, 0] == pytest.approx(lacking, abs=1e-6)


def test_the_picture_is_the_one_that_its_script_makes() -> None:
    made = runpy.run_path(str(PICTURE.with_suffix(".py")))["picture"]()
    assert PICTURE.read_text(encoding="utf-8") == made, "run python docs/images/engine_conventions.py"


def test_the_page_has_the_text_of_a_landing_and_a_row_for_every_kind_of_coordinates() -> None:
    assert landing_text(812.345678) in page()
    assert all(f"| `{kind.name}` |" in page() for kind in Coordinates)
