"""Cases to take away: a folder a scene, with its problem, its certified samples, and what an answer can be held to."""

from __future__ import annotations

import json
from importlib.metadata import distribution
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from adapters.basilisk import chain as basilisk_chain
from adapters.command.entries import unpacked
from adapters.engine import AccuracyParameter, Setting
from adapters.mujoco.mjcf_of_case import model_xml
from adapters.registry import ENGINES, built_in
from adapters.request import run_request
from adapters.trajectory import to_frame
from barchain.judge.error_model import ErrorModel
from barchain.judge.written import Declared
from barchain.metrics.quantities import TRACK
from barchain.record.claim import claim
from reports.results.writing import make_folder, write_atomically
from reports.text.words import escape_text
from scenarios import scene_names
from scenarios.channels import CHANNELS, UNITS
from scenarios.effect_equations import MOTION, NOTATION, laws_of
from scenarios.toml.writing import scene_toml

if TYPE_CHECKING:
    import pandas as pd

    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

ACCURACIES = (1e-6, 1e-8, 1e-10, 1e-12)
"""Requested errors of one step for which a case tells what can be compared"""
REQUESTED = Setting(AccuracyParameter.RTOL, 1e-10)
"""Setting in a case's request"""
FILES = ("README.md", "scene.json", "samples.csv", "settings.json", "picture.svg", "LICENSE")
MODEL, PROGRAM, OWN_SCENE = "chain.xml", "basilisk_chain.py", "scene.toml"
"""Further files: of MuJoCo, of Basilisk, and of a scene that does not come with barchain"""
BASILISK = "basilisk"
"""Engine whose program is written"""
SAID = {"shipped": "a certified solution: quadruple precision, by equations derived apart from barchain's own"}


def write_case(solution: ReferenceSolution, folder: Path, picture: str, *, mjcf: bool, overwrite: bool) -> list[str]:
    """Write the folder of a scene.

    Parameters
    ----------
    solution : ReferenceSolution
        Judging solution of the scene, at its own samples.
    folder : Path
    picture : str
        Drawing of the scene in SVG, of fixed colours.
    mjcf : bool
        Whether MuJoCo's model of the chain is written too, where MuJoCo carries the scene, and Basilisk's program,
        where Basilisk does.
    overwrite : bool
        Whether files of a case that are there are replaced.

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
    named = (*FILES, MODEL, PROGRAM, OWN_SCENE)
    claim([folder / name for name in named], f"{folder} holds a case", overwrite=overwrite)
    request, facts = run_request(scene, REQUESTED), settings(solution)
    model, program = (mujoco_model(scene), basilisk_program(scene, request)) if mjcf else ("", "")
    drawn = picture.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    texts = {
        "README.md": problem(scene, request, facts, solution, model=bool(model), program=bool(program)),
        "scene.json": json.dumps(request, indent=1),
        "samples.csv": samples(solution).to_csv(index=False),
        "settings.json": json.dumps(facts, indent=1),
        "picture.svg": drawn,
        "LICENSE": distribution("barchain").read_text("licenses/LICENSE") or "",
    } | {name: text for name, text in ((MODEL, model), (PROGRAM, program)) if text}
    if scene.name not in scene_names():
        texts[OWN_SCENE] = scene_toml(scene)
    folder.parent.mkdir(parents=True, exist_ok=True)
    make_folder(folder.parent, folder.name)
    for name, text in texts.items():
        write_atomically(folder / name, text)
    return list(texts)


def samples(solution: ReferenceSolution) -> pd.DataFrame:
    """Samples of a solution, with the error bar of each quantity."""
    n = len(solution.amplification)
    frame = to_frame(solution.trajectory.samples(slice(n)).of_run(solution.scene))
    frame = frame[[name for name in frame if not str(name).startswith(("gap", "com_residual", "position"))]]
    bars = {f"error_{CHANNELS[name].column_of()}": values[:n] for name, values in solution.error.items()}
    return frame.assign(**bars)


def settings(solution: ReferenceSolution) -> dict[str, Any]:
    """Duration, limits and tolerances for several accuracies, ready for JSON."""
    scene, found = solution.scene, []
    for rtol in ACCURACIES:
        declared = Declared(rtol=rtol)
        errors = ErrorModel(declared.engine, declared.setting, solution, solution.trajectory)
        inside = errors.t_s <= errors.limit_s
        allowed = {
            name: float(bound[: errors.n][inside if name not in TRACK else slice(None)].max())
            for name, bound in errors.bound.items()
        }
        found.append({"rtol": rtol, "predictability_limit_s": errors.limit_s, "largest_difference": allowed})
    return {
        "scene": scene.name,
        "duration_s": scene.run.duration_s,
        "period_s": scene.period_s,
        "samples": scene.run.samples,
        "solution": SAID.get(str(solution.source), "barchain's reference"),
        "solution_limit_s": solution.limit_s,
        "amplification": float(solution.amplification[-1]),
        "units": {name: UNITS[name] for name in solution.error},
        "accuracies": found,
    }


def problem(
    scene: Scene, request: dict[str, Any], facts: dict[str, Any], solution: ReferenceSolution, *, model: bool,
    program: bool,
) -> str:  # fmt: skip
    """Problem of a scene in words and equations."""
    chain = scene.chain
    effects = {name: json.dumps(table) for name, table in request["scene"]["effects"].items() if name != "gravity"}
    made = Environment(
        loader=PackageLoader("barchain.result_files", "template"), undefined=StrictUndefined, autoescape=False
    )
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
        noise=unpacked(built_in()[BASILISK].entry)[1].noise if program else {},
    )


def mujoco_model(scene: Scene) -> str:
    """Chain as MuJoCo's XML; empty where MuJoCo does not carry the scene."""
    return "" if ENGINES["mujoco"].declarations().unsupported(scene) else model_xml(scene)


def basilisk_program(scene: Scene, request: dict[str, Any]) -> str:
    """Program that carries the chain in Basilisk; empty where Basilisk does not carry the scene."""
    if built_in()[BASILISK].declarations().unsupported(scene) or basilisk_chain.why_left_out(request):
        return ""
    return Path(basilisk_chain.__file__).read_text(encoding="utf-8")
