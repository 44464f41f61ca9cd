"""The table of channels: its columns are those of tables that exist, and each row stands for an array."""

import dataclasses
import re

import numpy as np

from adapters.trajectory import Trajectory, from_frame, to_frame
from pictures.paths import DOCS
from scenarios import load_scene
from scenarios.channels import CHANNELS, COMPARED, STORED, numbered_part

SCENE = load_scene("effects/slews")


def filled(samples: int = 3) -> Trajectory:
    random = np.random.default_rng(1)
    arrays = {channel.array: random.normal(size=channel.shape(samples, SCENE)) for channel in STORED}
    return Trajectory(np.arange(float(samples)), **arrays)


def test_every_array_of_a_trajectory_is_a_channel() -> None:
    arrays = {f.name for f in dataclasses.fields(Trajectory) if str(f.type).startswith("Array")}
    assert arrays == {"t_s", *(channel.array for channel in STORED)}


def test_every_channel_comes_back_from_its_columns() -> None:
    made = filled().of_run(SCENE)
    back = from_frame(to_frame(made))
    for channel in STORED:
        assert np.array_equal(getattr(back, channel.array), getattr(made, channel.array)), channel.name
    assert back.torque_bars == made.torque_bars


def test_columns_have_the_order_that_files_have() -> None:
    """Programs of users read these files by position too."""
    firsts = [name for name in to_frame(filled()) if numbered_part(name) is None or "_1_" in name]
    assert firsts == [
        "t_s", "com_x_m", "com_y_m", "com_vx_m_s", "com_vy_m_s", "angle_1_rad", "rate_1_rad_s", "position_1_x_m",
        "position_1_y_m", "reaction_1_x_N", "reaction_1_y_N", "impulse_1_x_N_s", "impulse_1_y_N_s", "gap_1_m",
        "torque_law_1_N_m", "com_residual_m", "condition",
    ]  # fmt: skip


def test_a_scene_without_an_effect_lacks_its_channels() -> None:
    quiet = load_scene("paper/fig05")
    assert CHANNELS["torque"].names(SCENE)
    assert not [name for name in ("torque", "impulse") if CHANNELS[name].names(quiet)]
    assert len(CHANNELS["reaction"].names(quiet)) == 2 * (quiet.bars - 1)
    assert CHANNELS["com"].names(quiet) == ["com_x", "com_y"]


def test_every_compared_channel_has_its_section_of_the_conventions() -> None:
    page = (DOCS / "explanation" / "engine_conventions.md").read_text(encoding="utf-8")
    headings = {
        re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in re.findall(r"^#+ (.*)$", page, re.MULTILINE)
    }
    assert not {channel.section for channel in COMPARED} - headings
