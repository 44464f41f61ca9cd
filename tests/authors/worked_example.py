"""Numbers of the worked example in docs/explanation/engine_conventions.md, from the scenes in that page."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.reference.numpy_engines import Reference
from scenarios import parse_scene
from tests.structure.product import ROOT

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

PAGE = ROOT / "docs/explanation/engine_conventions.md"
ZERO = 1e-9
"""Magnitude up to which a number of the example is round-off, shown as 0: its channels begin at 1e-5"""
FREE_HEAD, HELD_HEAD = "| channel | shape | bar or joint 1 | bar 2 |", "| channel | bar or joint 1 | bar 2 |"
HELD = ("rate_rad_s", "reaction_N")


def page() -> str:
    """Text of the page."""
    return PAGE.read_text(encoding="utf-8")


def scenes() -> tuple[Scene, Scene]:
    """The example, and the same with the prescribed rotation."""
    whole, more = re.findall(r"^```toml\n(.*?)^```", page(), re.MULTILINE | re.DOTALL)
    held = whole.replace("[run]", f"{more}[run]")
    free, fixed = (parse_scene(text, name=f"example/{k}", file=PAGE.name) for k, text in enumerate((whole, held)))
    return free, fixed


def at_start(scene: Scene) -> Trajectory:
    """First sample of the reference, with every channel, places included."""
    seen = Reference(condition=True).run(scene).samples(slice(0, 1))
    return seen.replace(position_m=initial_state(scene).position_m[None])


def numbers(values: Array) -> str:
    """A number, or the components of a vector, to eight digits."""
    shown = [f"{0.0 if abs(v) < ZERO else v:.8g}" for v in np.atleast_1d(values)]
    return shown[0] if len(shown) == 1 else f"({', '.join(shown)})"


def cells(name: str, values: Array) -> list[str]:
    """Numbers of a channel's first row, for each bar or joint."""
    row = values[0]
    whole = name.startswith("com") or row.ndim == 0
    return [numbers(row)] if whole else [numbers(each) for each in row]


SHAPES = {
    "t_s": "(n,)", "com_m": "(n, 2)", "com_velocity_m_s": "(n, 2)", "angle_rad": "(n, N)", "rate_rad_s": "(n, N)",
    "position_m": "(n, N, 2)", "reaction_N": "(n, N-1, 2)", "gap_m": "(n, N-1)", "com_residual_m": "(n,)",
    "condition": "(n,)",
}  # fmt: skip


def tables() -> tuple[str, str]:
    """Both tables of the page."""
    free, held = map(at_start, scenes())
    rows = [[f"`{name}`", shape, *cells(name, getattr(free, name)), ""][:4] for name, shape in SHAPES.items()]
    fewer = [[f"`{name}`", *cells(name, getattr(held, name)), ""][:3] for name in HELD]
    fewer.append(["`torque_N_m`", "", *cells("torque_N_m", held.torque_N_m)])  # of the prescribed bar alone
    return table(FREE_HEAD, rows), table(HELD_HEAD, fewer)


def table(head: str, rows: list[list[str]]) -> str:
    """Markdown of a table."""
    return "\n".join([head, "|---" * (head.count("|") - 1) + "|", *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"
