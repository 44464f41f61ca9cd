"""Samples of the motion that a picture shows, from the compiled reference."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import COMPILED, find_engine
from pictures.motion.windows import Window, window_of
from reports.plotting.chain import Geometry, joints
from scenarios.scene import Run

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

FRAMES = 96  # instants of a picture in motion
RTOL = 1e-11
MOST_VERTICES = 41  # of a drawn chain: more are closer than a line is wide


@dataclass(frozen=True)
class Motion:
    """Motion of one scene in the part that is shown; n instants, v vertices."""

    scene: Scene
    window: Window
    t_s: Array
    """(n,)"""
    com_m: Array
    """(n, 2) centre of mass from the body's centre, inertial axes"""
    chain_m: Array
    """(n, v, 2) ends and joints of the bars about the centre of mass, inertial axes"""
    riding_m: Array
    """(n, v, 2) the same in the axes of an observer at the centre of mass"""
    shape_changes: bool
    """Whether the observer sees the chain move"""


def motion_of(scene: Scene) -> Motion:
    """Simulate a scene and take the instants of its picture."""
    window = window_of(scene)
    seen = run_of(scene, window)
    geometry = Geometry(
        np.array(scene.chain.length_m), np.array(scene.chain.mass_kg), scene.central_body.radius_m, scene.period_s,
        closed=True, com_share=scene.chain.com_share,
    )  # fmt: skip
    assert seen.angle_rad is not None
    chain = joints(geometry, seen.angle_rad)
    chain = chain[:, np.unique(np.linspace(0, scene.bars, min(scene.bars + 1, MOST_VERTICES)).astype(int))]
    riding = chain if is_free(scene) else riding_axes(seen.com_m, chain)
    moves = float(np.abs(riding - riding[0]).max()) > 0.02 * scene.size_m
    return Motion(scene, window, seen.t_s, seen.com_m, chain, riding, moves)


def is_free(scene: Scene) -> bool:
    """Whether nothing pulls the chain, so that there is no vertical."""
    return scene.effects.gravity.value == "none"


def run_of(scene: Scene, window: Window) -> Trajectory:
    """Run of the compiled reference, with :data:`FRAMES` samples in the window."""
    before = round((FRAMES - 1) * window.start_s / window.duration_s)
    run = Run(window.end_s, FRAMES + before)
    longer = dataclasses.replace(scene, run=run)
    seen = find_engine(COMPILED).engine().run(longer, Setting(AccuracyParameter.RTOL, RTOL))
    return seen.samples(slice(before, None))


def riding_axes(com_m: Array, chain_m: Array) -> Array:
    """Turn the chain into axes whose second one points away from the body.

    Parameters
    ----------
    com_m : ndarray, shape (n, 2)
    chain_m : ndarray, shape (n, v, 2)

    Returns
    -------
    ndarray, shape (n, v, 2)
        The first axis is opposite to the flight of a counter-clockwise orbit, so that angles keep their sense.
    """
    up = com_m / np.linalg.norm(com_m, axis=1, keepdims=True)
    across = np.stack([up[:, 1], -up[:, 0]], axis=-1)
    turned: Array = np.stack([np.einsum("nk,nvk->nv", across, chain_m), np.einsum("nk,nvk->nv", up, chain_m)], axis=-1)
    return turned
