"""Wrong verdicts of the judge: one scene of each kind, written, and replaced by the simplest that still shows it.

Simpler forms of a scene have fewer effects, bars and samples, a shorter run, rounder numbers. One part after the other
is made as simple as the finding allows; each candidate is tried as a case.
"""

from __future__ import annotations

import copy
import math
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.cases import Runner, Running
from reports.results.writing import write_atomically
from scenarios import Gravity, SceneError, parse_scene
from scenarios.toml.writing import TABLES, scene_data, scene_toml, toml

from .campaign import again
from .scenes import draw

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

    from barchain.runs.executors import Executor
    from scenarios import Scene
    from scenarios.scene import Array

    from .rating import RatedTrial

    Data = dict[str, Any]

SAMPLES, SHARES, DIGITS = (3, 5, 11, 31, 101), (0.05, 0.1, 0.2, 0.5), (1, 2, 3, 5)
"""Simpler values of the parts of a scene, the simplest first"""
EXACT = 17
"""Digits of a number that is left as it is"""
JOINT_LISTS = ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_deg")
INSTANTS = {"at_s", "start_s", "times_s", "duration_s"}


def kinds(findings: Iterable[RatedTrial]) -> list[list[RatedTrial]]:
    """Findings that differ by their scene alone, together; missed faults first."""
    groups: dict[tuple[str, ...], list[RatedTrial]] = {}
    for one in findings:
        groups.setdefault((one.engine, one.fault, one.outcome, one.quantity), []).append(one)
    return sorted(groups.values(), key=lambda group: not group[0].fault)


def written(finding: RatedTrial, folder: Path, seconds: float, executor: Executor) -> Path:
    """Write the scene of a finding into a folder; if there are some seconds, as simple a scene as is found in them.

    The candidates' runs are made in the executor: an engine that dies or hangs there costs its candidate alone.
    """
    number = finding.scene.rpartition("/")[2]
    words = (number, finding.engine.strip("()").replace(" ", "-"), finding.fault)
    path, scene = folder / f"{'-'.join(filter(None, words))}.toml", draw(int(number))
    folder.mkdir(parents=True, exist_ok=True)
    write_scene(scene, finding, path)
    if seconds > 0.0:
        shrink(scene, finding, path, seconds, executor)
    return path


def write_scene(scene: Scene, finding: RatedTrial, path: Path) -> None:
    """Write a scene with its finding as description."""
    what = f"{finding.engine} with {finding.fault}" if finding.fault else finding.engine
    said = f"{what}: {finding.rating}, {finding.outcome}. {finding.quantity} {finding.reason}".strip()
    write_atomically(path, scene_toml(replace(scene, title=f"From {finding.scene}", description=said)))


def shrink(scene: Scene, finding: RatedTrial, path: Path, seconds: float, executor: Executor) -> None:
    """Write ever simpler scenes that show a finding."""
    with executor.session() as session:

        def shows(candidate: Scene) -> bool:
            runner = Runner(lambda: session)
            runner.resume(Running(again(candidate, finding, seconds), candidate.digest), None)
            ((_, found),) = runner.results()
            return alike(found, finding)

        simplest(scene, shows, seconds, lambda one: write_scene(one, finding, path))


def alike(found: RatedTrial | None, finding: RatedTrial) -> bool:
    """Whether a trial on another scene is the same finding."""
    if found is None or (found.engine, found.rating) != (finding.engine, finding.rating):
        return False
    return bool(finding.fault) or found.outcome == finding.outcome


def simplest(
    scene: Scene,
    shows: Callable[[Scene], bool],
    seconds: float,
    told: Callable[[Scene], None] = lambda _: None,
) -> Scene:
    """Simplest scene found in the time that still shows a finding.

    Parameters
    ----------
    scene : Scene
        Shows it.
    shows : callable
        Whether a scene does.
    seconds : float
        After which no further scene is tried.
    told : callable
        Given each scene that is simpler than all before.
    """
    end, known = time.monotonic() + seconds, {scene.digest: True}

    def tried(form: Form) -> Scene | None:
        candidate = simplified(scene, form)
        if candidate is None:
            return None
        if candidate.digest not in known:
            known[candidate.digest] = time.monotonic() < end and shows(candidate)
        return candidate if known[candidate.digest] else None

    form, best = whole(scene), scene
    while (found := next(((f, one) for f in simpler_forms(form) if (one := tried(f)) is not None), None)) is not None:
        form, best = found
        told(best)
    return best


@dataclass(frozen=True)
class Form:
    """Parts of a scene that are kept."""

    effects: tuple[bool, ...]
    """For each of :func:`effects_of`, whether it is kept"""
    bars: int
    samples: int
    share: float
    """Of the run's duration; what is timed in it keeps its place"""
    digits: int
    """Significant digits of all numbers"""


def effects_of(scene: Scene) -> list[tuple[str, int]]:
    """Effects that may be dropped one by one: names, and which of several."""
    called = {name: value for name, value in vars(scene.effects).items() if name != "gravity" and value}
    return [(name, k) for name, value in called.items() for k in range(len(value) if name in TABLES else 1)]


def whole(scene: Scene) -> Form:
    """Form that keeps everything."""
    return Form((True,) * len(effects_of(scene)), scene.bars, scene.run.samples, 1.0, EXACT)


def simpler_forms(form: Form) -> Iterator[Form]:
    """Forms that are simpler in one part, the simplest first."""
    for k in (k for k, kept in enumerate(form.effects) if kept):
        yield replace(form, effects=(*form.effects[:k], False, *form.effects[k + 1 :]))
    yield from (replace(form, bars=bars) for bars in range(1, form.bars))
    yield from (replace(form, samples=samples) for samples in SAMPLES if samples < form.samples)
    yield from (replace(form, share=share) for share in SHARES if share < form.share)
    yield from (replace(form, digits=digits) for digits in DIGITS if digits < form.digits)


def simplified(scene: Scene, form: Form) -> Scene | None:
    """Scene in a simpler form; None where that is no valid one."""
    data = copy.deepcopy(scene_data(scene))
    drop_effects(data, scene, form)
    drop_bars(data, form.bars)
    on_grid = form.samples == scene.run.samples and form.share == 1.0 and form.digits == EXACT
    if form.digits < EXACT:
        data = rounded(data, form.digits)
    retime(data, scene, form, on_grid=on_grid)
    if scene.effects.gravity is Gravity.SLENDER:  # a moment of inertia of its own, whatever the rounding
        del data["chain"]["inertia_kg_m2"]
    try:
        return parse_scene("\n".join(toml(data)), name=scene.name, file=scene.name)
    except SceneError:
        return None


def drop_effects(data: Data, scene: Scene, form: Form) -> None:
    """Leave out effects."""
    effects = data["effects"]
    dropped = {pair for pair, kept in zip(effects_of(scene), form.effects, strict=True) if not kept}
    for name in {name for name, _ in dropped}:
        if name in TABLES:
            effects[name] = [one for k, one in enumerate(effects[name]) if (name, k) not in dropped]
        if name not in TABLES or not effects[name]:
            del effects[name]


def drop_bars(data: Data, bars: int) -> None:
    """Keep the first bars; what pushes a bar that is gone pushes the last one, what turns it is gone too."""
    chain, effects = data["chain"], data["effects"]
    chain["bars"] = bars
    for name, value in chain.items():
        if isinstance(value, list):
            chain[name] = value[:bars]
    for name in ("drag", "solar_pressure"):
        if name in effects:
            effects[name]["width_m"] = effects[name]["width_m"][:bars]
    if "joint_spring_damper" in effects:
        springs = effects.pop("joint_spring_damper")
        if bars > 1:
            effects["joint_spring_damper"] = {key: springs[key][: bars - 1] for key in JOINT_LISTS}
    for name in ("thrust", "impulse"):
        for one in effects.get(name, ()):
            one["bar"] = min(one["bar"], bars)
    motors = [one for one in effects.pop("joint_torque", ()) if one["joint"] < bars]
    if motors:
        effects["joint_torque"] = motors
    kept = [one for one in effects.pop("prescribed_rotation", ()) if one["bar"] <= bars]
    if kept:
        effects["prescribed_rotation"] = kept


def rounded(value: Any, digits: int) -> Any:
    """Value whose floats have so many significant digits; instants stay for now."""
    if isinstance(value, dict):
        return {key: one if key in INSTANTS else rounded(one, digits) for key, one in value.items()}
    if isinstance(value, list):
        return [rounded(one, digits) for one in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def retime(data: Data, scene: Scene, form: Form, *, on_grid: bool) -> None:
    """Give the run its duration and samples, and put what is timed on the samples next to it."""
    if on_grid:
        return
    duration = rounded(form.share * scene.run.duration_s, form.digits)
    data["run"] = {"duration_s": duration, "samples": form.samples}
    factor, times = duration / scene.run.duration_s, np.linspace(0.0, duration, form.samples)
    for law in data["effects"].get("prescribed_rotation", ()):
        law["start_s"] = nearest(law["start_s"] * factor, times)
        law["duration_s"] = rounded(law["duration_s"] * factor, form.digits)
    for table in (*data["effects"].get("thrust", ()), *data["effects"].get("joint_torque", ())):
        table["times_s"] = [nearest(t * factor, times) for t in table["times_s"]]
    for impulse in data["effects"].get("impulse", ()):
        impulse["at_s"] = nearest(impulse["at_s"] * factor, times[1:-1])


def nearest(t_s: float, times: Array) -> float:
    """Sample next to an instant; without samples not a number, which no file may hold."""
    return float(times[np.abs(times - t_s).argmin()]) if len(times) else math.nan
