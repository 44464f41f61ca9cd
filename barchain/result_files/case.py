"""Cases to take away: a folder a scene, with its problem, its certified samples, and what an answer can be held to.

A case of a scene that comes with barchain has an identifier (`barchain.solutions.case_versions`).
"""

from __future__ import annotations

import json
from importlib.metadata import distribution
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from adapters.basilisk import chain as basilisk_chain
from adapters.command.entries import unpacked
from adapters.engine import AccuracyParameter, Setting
from adapters.mujoco.mjcf_of_case import model_xml
from adapters.registry import ENGINES, built_in
from adapters.request import run_request
from barchain.metrics.quantities import components
from barchain.record.claim import claim
from barchain.result_files.difficulty import difficulty
from barchain.result_files.tube import Tube, curves, quantities, tube
from barchain.solutions.case_versions import current, values, values_digest
from reports.results.writing import make_folder, write_atomically
from reports.text.words import escape_text
from scenarios import scene_names
from scenarios.channels import CHANNELS, UNITS
from scenarios.effect_equations import MOTION, NOTATION, laws_of
from scenarios.toml.writing import scene_toml

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

ACCURACIES = (1e-6, 1e-8, 1e-10, 1e-12)
"""Requested errors of one step for which a case tells what can be compared"""
REQUESTED = Setting(AccuracyParameter.RTOL, 1e-10)
"""Setting in a case's request"""
FILES = ("README.md", "scene.json", "samples.csv", "settings.json", "picture.svg", "LICENSE")
MODEL, PROGRAM, OWN_SCENE, PAGE = "chain.xml", "basilisk_chain.py", "scene.toml", "compare.html"
"""Further files: of MuJoCo, of Basilisk, of a scene that does not come with barchain, and the page that compares"""
TUBE = "tube_{}_{}.csv"
"""Lower and upper curves at a request"""
BASILISK = "basilisk"
"""Engine whose program is written"""
SAID = {"shipped": "a certified solution: quadruple precision, by equations derived apart from barchain's own"}


def write_case(
    solution: ReferenceSolution, folder: Path, picture: str, page: str = "", *, mjcf: bool, overwrite: bool,
    rtols: Sequence[float] = (), terms: str = "",
) -> list[str]:  # fmt: skip
    """Write the folder of a scene.

    Parameters
    ----------
    solution : ReferenceSolution
        Judging solution of the scene, at its own samples.
    folder : Path
    picture : str
        Drawing of the scene in SVG, of fixed colours.
    page : str
        Page that compares a table, in HTML; empty without one.
    mjcf : bool
        Whether MuJoCo's model of the chain is written too, where MuJoCo carries the scene, and Basilisk's program,
        where Basilisk does.
    overwrite : bool
        Whether files of a case that are there are replaced.
    rtols : sequence of float
        Requested errors for which tubes are written.
    terms : str
        Text of the licence; default: barchain's own.

    Returns
    -------
    list of str
        Names of the files.

    Raises
    ------
    ResultsInPlaceError
        If there are files of a case.
    OSError
        If one can't be written.
    """
    scene = solution.scene
    named = [folder / name for name in (*FILES, MODEL, PROGRAM, OWN_SCENE, PAGE)]
    claim([*named, *folder.glob(TUBE.format("*", "*"))], f"{folder} holds a case", overwrite=overwrite)
    request, facts = run_request(scene, REQUESTED), settings(solution)
    tubes = [tube(solution, rtol) for rtol in rtols]
    lacking = not_carried(scene) if mjcf else (MODEL, PROGRAM)
    model = "" if MODEL in lacking else model_xml(scene)
    program = "" if PROGRAM in lacking else Path(basilisk_chain.__file__).read_text(encoding="utf-8")
    drawn = picture.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    texts = {
        "README.md": problem(scene, request, facts, solution, model=bool(model), program=bool(program), tubes=tubes,
                             page=bool(page)),
        "scene.json": json.dumps(request, indent=1),
        "samples.csv": samples(solution).to_csv(index=False),
        "settings.json": json.dumps(facts, indent=1),
        "picture.svg": drawn,
        "LICENSE": terms or distribution("barchain").read_text("licenses/LICENSE") or "",
    } | {name: text for name, text in ((MODEL, model), (PROGRAM, program), (PAGE, page)) if text}  # fmt: skip
    for each in tubes:
        for side, table in curves(solution, each).items():
            texts[TUBE.format(each.name, side)] = table.to_csv(index=False)
    if scene.name not in scene_names():
        texts[OWN_SCENE] = scene_toml(scene)
    folder.parent.mkdir(parents=True, exist_ok=True)
    make_folder(folder.parent, folder.name)
    for name, text in texts.items():
        write_atomically(folder / name, text)
    return list(texts)


def error_bars(solution: ReferenceSolution) -> dict[str, Array]:
    """Bar of each quantity's error that a case states, (n,): a proven radius would take its place here."""
    n = len(solution.amplification)
    return {name: bar[:n] for name, bar in solution.error.items()}


def samples(solution: ReferenceSolution) -> pd.DataFrame:
    """Samples of a solution, with the error bar of each quantity."""
    bars = {f"error_{CHANNELS[name].column_of()}": bar for name, bar in error_bars(solution).items()}
    return values(solution).assign(**bars)


def identifier(solution: ReferenceSolution) -> str:
    """Identifier of a case with these values; empty of other values, as those of a scene file of the same name."""
    row = current().get(solution.scene.name)
    return row.identifier if row and row.digest == values_digest(solution) else ""


def settings(solution: ReferenceSolution) -> dict[str, Any]:
    """Duration, limits and tolerances for several accuracies, ready for JSON."""
    scene, tubes = solution.scene, [tube(solution, rtol) for rtol in ACCURACIES]
    return {
        "identifier": identifier(solution),
        "scene": scene.name,
        "duration_s": scene.run.duration_s,
        "period_s": scene.period_s,
        "samples": scene.run.samples,
        "solution": SAID.get(str(solution.source), "barchain's reference"),
        "solution_limit_s": solution.limit_s,
        "amplification": float(solution.amplification[-1]),
        "difficulty": difficulty(solution, tubes),
        "units": {name: UNITS[name] for name in solution.error},
        "accuracies": [
            {
                "rtol": each.rtol,
                "predictability_limit_s": each.until_s,
                "largest_difference": {name: float(np.nanmax(width)) for name, width in each.width.items()},
            }
            for each in tubes
        ],
    }


def page_data(solution: ReferenceSolution, rtols: Sequence[float]) -> dict[str, Any]:
    """Case for a page that compares a table with it, ready for JSON: certified samples, error bars and tubes."""
    scene, frame, bars = solution.scene, values(solution), error_bars(solution)
    of, counted = quantities(scene), components(solution.trajectory)
    parts: dict[str, list[list[str]]] = {name: [] for name in bars}
    for column in (name for name in map(str, frame) if name in of):
        name = of[column]
        size = counted[name].shape[-1]
        if parts[name] and len(parts[name][-1]) < size:
            parts[name][-1].append(column)
        else:
            parts[name].append([column])
    return {
        "identifier": identifier(solution),
        "scene": scene.name,
        "title": scene.title,
        "columns": {name: frame[name].tolist() for name in map(str, frame)},
        "quantities": {
            name: {
                "unit": UNITS[name], "label": CHANNELS[name].shown_title, "parts": parts[name], "error": shortened(bar),
            }
            for name, bar in bars.items()
        },
        "tubes": [
            {"name": each.name, "until_s": each.until_s, "width": {n: shortened(w) for n, w in each.width.items()}}
            for each in (tube(solution, rtol) for rtol in rtols)
        ],
    }  # fmt: skip


def shortened(bounds: Array) -> list[float | None]:
    """Bounds to six digits; None for not-a-number."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in bounds]


def problem(
    scene: Scene, request: dict[str, Any], facts: dict[str, Any], solution: ReferenceSolution, *, model: bool,
    program: bool, tubes: Sequence[Tube], page: bool,
) -> str:  # fmt: skip
    """Problem of a scene in words and equations."""
    chain = scene.chain
    effects = {name: json.dumps(table) for name, table in request["scene"]["effects"].items() if name != "gravity"}
    made = plain_templates()
    made.filters["md"] = escape_text
    return made.get_template("problem.md.j2").render(
        scene=scene,
        judged=scene.name if scene.name in scene_names() else OWN_SCENE,
        start=request["start"],
        notation=NOTATION,
        motion=MOTION,
        laws=laws_of(scene),
        facts=facts,
        bars=list(zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)),
        effects=effects,
        columns=list(samples(solution).columns),
        end=solution.trajectory.ended,
        every_s=scene.run.duration_s / (scene.run.samples - 1),
        model=model,
        tubes=tubes,
        page=PAGE if page else "",
        noise=unpacked(built_in()[BASILISK].entry)[1].noise if program else {},
    )


def plain_templates(**options: Any) -> Environment:
    """Templates of plain text, with options of Jinja."""
    loader = PackageLoader("barchain.result_files", "template")
    return Environment(loader=loader, undefined=StrictUndefined, autoescape=False, **options)


def not_carried(scene: Scene) -> dict[str, str]:
    """Files for other engines that a case has not, each with the reason why its engine does not carry the scene."""
    rounding = basilisk_chain.why_left_out(run_request(scene, REQUESTED))
    reasons = {
        MODEL: ENGINES["mujoco"].declarations().unsupported(scene),
        PROGRAM: built_in()[BASILISK].declarations().unsupported(scene) or rounding,
    }
    return {name: reason for name, reason in reasons.items() if reason}
