"""The chain of :mod:`adapters.mujoco.chain` in MuJoCo's XML, a file of `barchain export`; the engine does not read it.

It has every digit: MuJoCo itself writes six.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from adapters.bar_loads.interface import bars_of
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import to_joint_coordinates

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenarios import Scene

STEPS_A_SAMPLE = 20


def model_xml(scene: Scene) -> str:
    """Model without gravity, and the start about the centre of mass as its keyframe ``start``."""
    root = ElementTree.Element("mujoco", model="chain")
    step_s = scene.run.duration_s / (scene.run.samples - 1) / STEPS_A_SAMPLE
    option = {"timestep": numbers([step_s]), "gravity": "0 0 0", "integrator": "RK4"}
    option_element = ElementTree.SubElement(root, "option", option)
    ElementTree.SubElement(option_element, "flag", contact="disable", constraint="disable")
    body, left_m = ElementTree.SubElement(root, "worldbody"), 0.0
    chain = scene.chain
    for j, (mass, inertia, half, centre_m) in enumerate(bars_of(chain)):
        body = ElementTree.SubElement(body, "body", name=f"bar_{j + 1}", pos=numbers([left_m, 0.0, 0.0]))
        about = {"pos": numbers([centre_m, 0.0, 0.0]), "diaginertia": numbers([inertia] * 3)}
        ElementTree.SubElement(body, "inertial", {"mass": numbers([mass])} | about)
        for axis in ("1 0 0", "0 1 0") if j == 0 else ():
            ElementTree.SubElement(body, "joint", type="slide", axis=axis)
        ElementTree.SubElement(body, "joint", type="hinge", axis="0 0 1")
        left_m = 2.0 * half
    q, q_t = to_joint_coordinates(np.array(chain.length_m), initial_state(scene), np.array(chain.left_m))
    frames = ElementTree.SubElement(root, "keyframe")
    ElementTree.SubElement(frames, "key", name="start", qpos=numbers(q), qvel=numbers(q_t))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def numbers(values: Iterable[float]) -> str:
    """Numbers in every digit."""
    return " ".join(repr(float(value)) for value in values)
