"""Synthetic tables of an effect budget."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.results.effects import FILES, TABLE
from tests.support.results import MADE, write_results

if TYPE_CHECKING:
    from pathlib import Path


SCENE: dict[str, Any] = {
    "name": "own/<scene>", "title": "Five bars", "gravity": "gradient", "bound": True, "period_s": 5000.0,
    "duration_s": 25_000.0, "limit_s": 25_000.0, "end_s": 25_000.0, "ended": "", "radius0_m": 7e6,
    "largest_reaction_N": 2.0,
}  # fmt: skip


def row(effect: str, com_m: float = 1.0, attitude: float = 1e-6, reaction: float = 1e-6, **more: Any) -> dict[str, Any]:
    """Row of the table, resolved to 1e-8 of each scale, at twice the time."""
    found: dict[str, Any] = dict.fromkeys(TABLE.columns) | {
        "effect": effect, "title": effect.title(), "kind": "nature", "on": False, "said": "", "reason": "",
        "engine": "reference", "between_start": 1e-3, "torque_start": 0.0, "common_start": 1e-3,
        "between_largest": 2e-3, "torque_largest": 0.0, "common_largest": 1e-3,
        "com_m": com_m, "com_noise_m": 0.07, "attitude_rad": attitude, "attitude_noise_rad": 1e-8,
        "reaction_N": reaction, "reaction_noise_N": 2e-8, "compared_s": 25_000.0, "ended": "",
        "time_ratio": 2.0, "time_ratio_low": 1.9, "time_ratio_high": 2.1, "rounds": 7, "evaluation_ratio": 2.0,
        "evaluation_ratio_low": 1.9, "evaluation_ratio_high": 2.1, "evaluations_ratio": 1.0,
        "seconds": 1.0, "evaluation_s": 1e-6, "evaluations": 1000,
    }  # fmt: skip
    return found | more


def gravity(model: str, attitude: float) -> dict[str, Any]:
    """Row of another model of gravity."""
    return row(
        f"gravity.{model}", attitude=attitude, kind="gravity", said="instead of gradient", title=f"Gravity {model}"
    )


ROWS = [
    gravity("point", 0.1),
    gravity("slender", 1e-7),
    row("oblateness", 612e3, 0.11, 0.0026),
    row("third_body.moon", 0.01, 1e-9, 1e-9, on=True),
    row("drag", 3.0, 4e-7, 6e-8, time_ratio=1.02, time_ratio_low=0.9, time_ratio_high=1.1),
    row("solar_pressure", reason="its process <died>", com_m=None, attitude_rad=None, reaction_N=None, time_ratio=None),
]


def write(folder: Path, rows: list[dict[str, Any]], **changes: Any) -> Path:
    """Write the tables of a budget."""
    record = MADE | {"scene": SCENE | changes, "rtol": 1e-12, "looser": 10.0, "parted_rad": 0.01, "matters": 1e-3}
    return write_results(folder, FILES, {"effects": rows}, record)
