"""A result folder made of the reference's own motion and of synthetic errors: what a report is tested on."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import Setting
from adapters.reference.numpy_engines import Reference
from barchain.record.scene_description import scene_facts
from reports.results.comparison import FILES, METRIC_COLUMNS, QUANTITY_UNITS
from scenarios import Scene, load_scene
from tests.support.results import MADE, series_folder, write_results

if TYPE_CHECKING:
    from pathlib import Path

    Row = dict[str, Any]

# name: (accuracy parameter, default, error of the attitude after one orbit without growth, has bars)
ENGINES: dict[str, tuple[str, float, float, bool]] = {
    "reference": ("rtol", 1e-10, 1e-10, True),
    "reference-absolute": ("rtol", 1e-10, 4e-9, True),
    "exudyn": ("steps_per_orbit", 10000, 5e-7, True),
    "exudyn-index3": ("steps_per_orbit", 10000, 6e-7, True),
    "exudyn-absolute": ("steps_per_orbit", 10000, 4e-4, True),
    "exudyn-tree": ("steps_per_orbit", 400, 2e-12, True),
    "rebound": ("rtol", 1e-9, 1e-9, False),
    "pymunk": ("steps_per_orbit", 4000, 2e-6, True),
    "pymunk-absolute": ("steps_per_orbit", 4000, 3e-3, True),
}
FAULTS = {
    ("paper/fig13", "pymunk-absolute"): ("not_finite", "angle_3_rad is NaN from sample 212 on"),
    ("paper/fig17", "pymunk-absolute"): ("joints_ignored", "joint 2 opened by 31 m, like free bodies"),
    ("basics/two_bars_free", "pymunk-absolute"): ("nothing_compared", "predictability limit of 0.02 orbits"),
}


def build(folder: Path, names: list[str], *, samples: int, faults: bool = True) -> Path:
    """Write a result folder for some scenes and every engine."""
    rng, metrics, runs, scenes = np.random.default_rng(17), list[Any](), list[Any](), {}
    for name in names:
        whole = load_scene(name)
        scene = dataclasses.replace(whole, run=dataclasses.replace(whole.run, samples=samples))
        write_scene(folder, scene, metrics, runs, rng=rng, faults=FAULTS if faults else {})
        scenes[name] = scene_record(scene)
    return write_results(folder, FILES, {"metrics": metrics}, RECORD | {"runs": runs, "scenes": scenes})


def write_scene(
    folder: Path,
    scene: Scene,
    metrics: list[Row],
    runs: list[Row],
    *,
    rng: np.random.Generator,
    faults: dict[tuple[str, str], tuple[str, str]],
) -> None:
    """Tables of one scene, from a motion of the reference at a tolerance that is cheap."""
    places = [series_folder(folder) / kind / scene.name for kind in ("trajectories", "differences")]
    for place in places:
        place.mkdir(parents=True, exist_ok=True)
    solution = Reference().run(scene, Setting(Reference.sweep.parameter, 1e-7)).to_frame()
    solution.to_parquet(places[0] / "solution.parquet")
    t = solution["t_s"].to_numpy()
    amplification = np.minimum(np.exp(rate(scene) * t), 1e7) * (1 + 0.5 * np.sin(6 * t / t[-1]) ** 2)
    pd.DataFrame({"t_s": t, "amplification": amplification}).to_parquet(places[1] / "amplification.parquet")
    for engine in ENGINES:
        reason = unsupported(scene, engine)
        outcome, why = ("unsupported", reason) if reason else faults.get((scene.name, engine), ("pass", ""))
        runs += run_records(scene, engine, outcome, why)
        if outcome != "pass":
            metrics.append(metric(scene, engine, "run", "outcome", math.nan, outcome=outcome, reason=why))
            continue
        table = differences(scene, engine, solution, amplification, rng)
        table.to_parquet(places[1] / f"{engine}.parquet")
        seen = solution if ENGINES[engine][3] else solution.filter(regex="^(t_|com_)")
        seen.to_parquet(places[0] / f"{engine}.parquet")
        metrics += rows_of(scene, engine, table)


def rate(scene: Scene) -> float:
    """Rate at which errors grow, 1/s."""
    return math.sqrt(3.0) * scene.orbital_rate_rad_s if "chaotic" in scene.tags else 0.4 * scene.orbital_rate_rad_s


def unsupported(scene: Scene, engine: str) -> str:
    """Why an engine is left out; empty if it is not."""
    if engine == "rebound" and scene.effects.gravity == "none":
        return "needs a central body"
    if engine == "pymunk" and scene.effects.prescribed_rotation:
        return "does not support prescribed_rotation.local_horizontal"
    if engine == "exudyn-tree" and "eccentric" in scene.tags:
        return "its circular Hill frame loses its accuracy on an eccentric orbit"
    return ""


def differences(
    scene: Scene, engine: str, solution: pd.DataFrame, amplification: np.ndarray, rng: np.random.Generator
) -> pd.DataFrame:
    """Synthetic differences from the reference solution, tolerances, bounds and drifts."""
    t = solution["t_s"].to_numpy()
    base, bars = ENGINES[engine][2], ENGINES[engine][3]
    curve = base * amplification * (t / t[-1]) * (0.3 + np.abs(np.sin(17 * t / t[-1] + base * 1e9)))
    curve[1:] *= np.exp(0.25 * rng.standard_normal(len(t) - 1))
    size = float(np.mean(scene.chain.length_m))
    scales = {"com": size * 1e-3, "com_velocity": size * 1e-6}
    if bars:
        scales |= {"attitude": 1.0, "rate": 1e-3, "reaction": 0.03}
    if bars and scene.effects.prescribed_rotation:
        scales["torque"] = 10.0
    table = {"t_s": t}
    for quantity, scale in scales.items():
        table[f"{quantity}_difference"] = scale * curve
        table[f"{quantity}_tolerance"] = scale * (2.2 * np.maximum.accumulate(curve) + 1e-13)
        table[f"{quantity}_bound"] = np.full_like(t, scale * 4 * curve.max())
    if bars and scene.bars > 1 and engine != "exudyn-tree":
        table["gap_drift"] = np.where(rng.random(len(t)) < 0.05, 0.0, size * base * (t / t[-1]) ** 2 * 0.1 + 1e-16)
        table["com_residual_drift"] = size * 1e-15 * (1 + rng.random(len(t)))
    if scene.effects.gravity != "gradient":
        table["energy_drift"] = base * 1e-3 * t / t[-1] + 1e-16 * rng.random(len(t))
        table["angular_momentum_drift"] = base * 1e-4 * t / t[-1] + 1e-16 * rng.random(len(t))
    return pd.DataFrame(table)


def rows_of(scene: Scene, engine: str, table: pd.DataFrame) -> list[Row]:
    """Metric rows of one engine that ran."""
    rows = []
    limit_s = scene.run.duration_s * (0.31 if engine.endswith("absolute") and "chaotic" in scene.tags else 1.0)
    seen = table[table["t_s"] <= limit_s]
    for column in table.filter(like="_difference"):
        quantity, values = column.removesuffix("_difference"), seen[column]
        measured = {"rms": float(np.sqrt((values**2).mean())), "final": values.iloc[-1]}
        if scene.period_s < limit_s:
            measured["first_orbit_max"] = table.loc[table["t_s"] <= scene.period_s, column].max()
        judged = {
            "max": (values.max(), float(seen[f"{quantity}_bound"].max())),
            "normalised_error": (float((values / seen[f"{quantity}_tolerance"]).max()), 1.0),
        }
        rows += [metric(scene, engine, quantity, name, value, limit_s=limit_s) for name, value in measured.items()]
        rows += [
            metric(scene, engine, quantity, name, value, tolerance=most, outcome="pass", limit_s=limit_s)
            for name, (value, most) in judged.items()
        ]
        rows[-1]["unit"] = "1"
    for column in table.filter(like="_drift"):
        quantity, drift = column.removesuffix("_drift"), table[column].max()
        rows.append(metric(scene, engine, quantity, "drift", drift, tolerance=3 * drift, outcome="pass"))
    return rows


def metric(scene: Scene, engine: str, quantity: str, name: str, value: float, **more: Any) -> Row:
    """One row of the metrics."""
    parameter, default, *_ = ENGINES[engine]
    row = dict.fromkeys(METRIC_COLUMNS, math.nan) | {"outcome": "reported", "reason": "", "value": value}
    row |= {"scene": scene.name, "engine": engine, "setting": f"{parameter}={default:g}", "metric": name}
    return row | {"quantity": quantity, "unit": QUANTITY_UNITS[quantity]} | more


def run_records(scene: Scene, engine: str, outcome: str, reason: str) -> list[Row]:
    """Entries of the record for one engine's runs."""
    parameter, default, *_ = ENGINES[engine]
    finer = default / 10 if parameter == "rtol" else default * 2
    named = {"scene": scene.name, "engine": engine, "outcome": outcome, "reason": reason, "bits": ""}
    named |= {"seconds": {"build": 0.012, "simulate": 0.0871, "read": 0.0033}, "info": {"steps": 10000}}
    return [
        named | {"role": role, "setting": f"{parameter}={value:g}"}
        for role, value in (("main", default), ("finer", finer))
    ]


def scene_record(scene: Scene) -> Row:
    """Entry of the record for one scene."""
    return scene_facts(scene) | {
        "solution_setting": "reference, rtol=1e-13",
        "solution_error_rad": 7.1e-12,
        "solution_limit_s": scene.run.duration_s,
        "amplification_per_orbit": math.exp(rate(scene) * scene.period_s),
        "amplification_total": math.exp(min(rate(scene) * scene.run.duration_s, 40.0)),
        "model_difference": {"com_m": 0.056, "note": "12π r (l/r)² per orbit against a point's orbit"},
    }


RECORD: dict[str, Any] = MADE | {
    "barchain": "0.1.0",
    "engines": {
        name: {"title": f"{name}, as the tests make it up", "coordinates": "moving frame", "parameter": parameter}
        | {"default": default, "version": "1.2.3", "order": 2 if parameter != "rtol" else None, "missing": None}
        | {"external": not name.startswith("reference")}
        for name, (parameter, default, *_) in ENGINES.items()
    },
    "misprints": [
        {"id": "gravity_torque_sign", "place": "(17), (B.7)", "printed": "−3 sin φ cos φ/ρ³",
         "right": "+3 sin φ cos φ/ρ³", "effect_on_reactions": 0.113, "effect_on_angular_acceleration": 1.7,
         "note": "φ from the horizontal; else the horizontal bar would be the stable one"},
        {"id": "stable_multiples", "place": "section 6", "printed": "even multiples of π/2 stable",
         "right": "odd multiples (radial) stable", "effect_on_reactions": 0.0, "effect_on_angular_acceleration": None,
         "note": "text only; the figures agree with this"},
    ],
    "tolerances": [
        {"quantity": "attitude", "what": "round-off floor of the reference", "value": 4.4e-13,
         "derivation": "2 000 steps of half an ulp of 2π each, added at random: √2000 · 2⁻⁵² · 2π"},
    ],
    "limitations": ["Planar motion only; bars are rigid and joints are without friction."],
}  # fmt: skip
