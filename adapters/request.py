"""Request and result of a run as JSON: what a program in any language reads, and what it writes.

A request holds a scene with every number resolved. A result says how the run went, beside a table of samples whose
columns have the names of :func:`adapters.trajectory.to_frame`. `barchain schema request` and `barchain schema result`
print the JSON Schemas.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator

from adapters.common.accuracy_scales import accuracy_scales
from adapters.common.equal_steps import step_s
from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, Setting
from scenarios.effect_equations import laws_of
from scenarios.effect_types import Effects  # noqa: TC001  # pydantic reads it
from scenarios.scene import CentralBody, Chain, Orbit, Run, Scene

if TYPE_CHECKING:
    from collections.abc import Iterator

VERSION: Literal[1] = 1
"""Version of both forms; a change that a program would have to follow raises it"""
Pair = Annotated[list[FiniteFloat], Field(min_length=2, max_length=2)]


Count = Annotated[int, Field(ge=0, le=2**53)]
"""Whole number that a double holds exactly"""


class Form(BaseModel):
    """Base of the forms; a key that is not known is a fault."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)


@dataclass(frozen=True)
class Physics:
    """A scene without its names and texts: all that decides the motion.

    Attributes
    ----------
    central_body : CentralBody
        Gravitational parameter and radius.
    orbit : Orbit
        Initial motion of the chain's centre of mass.
    chain : Chain
        Masses, lengths, inertias, initial angles and rates of the bars.
    effects : Effects
        Gravity and all other effects; one that is absent, null or empty is not there.
    run : Run
        Duration and samples.
    """

    central_body: CentralBody
    orbit: Orbit
    chain: Chain
    effects: Effects
    run: Run


class Start(Form):
    """State at t = 0; it follows from the scene."""

    com_m: Pair
    """Place of the chain's centre of mass from the centre of the central body, m"""
    com_velocity_m_s: Pair
    """Its velocity, m/s"""
    angle_rad: list[FiniteFloat]
    """Angle of each bar from the z1 axis, rad"""
    rate_rad_s: list[FiniteFloat]
    """Rate of each bar's angle, rad/s; of a prescribed bar its law's"""


class Accuracy(Form):
    """Setting of the run. A program follows the part that belongs to its method."""

    parameter: AccuracyParameter
    """rtol: requested error of one step; steps_per_orbit: number of equal steps in `step_period_s`"""
    value: FiniteFloat
    """Value of the parameter"""
    step_period_s: FiniteFloat
    """Unit of time of steps_per_orbit, s"""
    step_s: FiniteFloat | None
    """Equal step that fills the time between two samples a whole, even number of times, s; null with rtol"""
    track_m: FiniteFloat
    """Unit of the centre of mass: rtol times this is the requested error of its place in one step, m"""
    length_m: FiniteFloat
    """Unit of a bar's place relative to the centre of mass, m; of an angle it is 1"""
    rate_rad_s: FiniteFloat
    """Unit of a rate, rad/s; a velocity has this times the unit of its length"""


class Request(Form):
    """One run that is asked for. `scene` decides; all else follows from it, and saves a program the work."""

    version: Literal[1]
    """Version of this form"""
    scene: Physics
    """Physics, in SI units and radians"""
    bars: int
    """Number of bars N"""
    start: Start
    """State at t = 0"""
    sample_times_s: list[FiniteFloat]
    """Instants of the samples that are asked for, s, equal to instants of events bit for bit; the last is the end. The
    run ends before where a point of a bar reaches `central_body.radius_m`"""
    breaks_s: list[FiniteFloat]
    """Instants at which an effect is not smooth in time, s, of impulses and of jumps among them: no step should contain
    one. A sample at one shows the motion just before it; at t = 0, just after it"""
    setting: Accuracy
    """Accuracy that is asked for"""
    laws: dict[str, str]
    """Law of each effect of the scene, in words and equations, by its key in `scene.effects`"""


class Result(Form):
    """How a run went. Its samples are in the table beside it."""

    version: Literal[1]
    """Version of this form"""
    outcome: Literal["pass", "failed", "unsupported"] = "pass"
    """pass: the run came to its end; unsupported: the program can't run the scene"""
    reason: str = ""
    """Why it failed or is not supported, in one line"""
    ended_s: FiniteFloat | None = None
    """Instant at which a bar reached the surface, s; null where none did"""
    seconds: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    """Wall time of the integration alone by the program's own clock, s"""
    steps: Count | None = None
    """Number of steps"""
    evaluations: Count | None = None
    """Number of evaluations of the right-hand side"""
    samples: str = ""
    """Name of the table beside this file: .csv with a header, or .jsonl with an object for each sample; empty where it
    is the one that the command line named"""

    @field_validator("samples")
    @classmethod
    def is_beside(cls, samples: str) -> str:
        """Check that the table is in the folder of the run."""
        if samples and (samples != Path(samples).name or samples == ".." or not samples.isprintable()):
            raise ValueError("allowed: the name of a file beside this one, without a folder")
        return samples


def run_request(scene: Scene, setting: Setting) -> dict[str, Any]:
    """Request of a run, ready for JSON; absent effects are left out.

    Parameters
    ----------
    scene : Scene
    setting : Setting

    Returns
    -------
    dict
    """
    state, scales = initial_state(scene), accuracy_scales(scene)
    equal = setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
    made = Request(
        version=VERSION,
        scene=Physics(scene.central_body, scene.orbit, scene.chain, scene.effects, scene.run),
        bars=scene.bars,
        start=Start(
            com_m=state.com_m.tolist(),
            com_velocity_m_s=(state.com_velocity_m_s + 0.0).tolist(),  # -0.0 is 0.0
            angle_rad=state.angle_rad.tolist(),
            rate_rad_s=state.rate_rad_s.tolist(),
        ),
        sample_times_s=scene.times_s.tolist(),
        breaks_s=list(scene.effects.breaks_s),
        setting=Accuracy(
            parameter=setting.parameter,
            value=setting.value,
            step_period_s=scene.step_period_s,
            step_s=step_s(scene, setting.value) if equal else None,
            track_m=scales.track_m,
            length_m=scales.length_m,
            rate_rad_s=scales.rate_rad_s,
        ),
        laws=laws_of(scene),
    ).model_dump(mode="json")
    if not scene.orbit.flight_path_rad:  # what most scenes do not have is absent, as effects are
        del made["scene"]["orbit"]["flight_path_rad"]
    if not scene.chain.end_bodies:
        del made["scene"]["chain"]["end_bodies"]
    if not scene.chain.com_share:
        del made["scene"]["chain"]["com_share"]
    effects = made["scene"]["effects"]
    made["scene"]["effects"] = {name: table for name, table in effects.items() if table not in (None, [])}
    return made


def scene_of(request: Request, name: str = "scene") -> Scene:
    """Scene of a request; its names and texts are not in it."""
    p = request.scene
    return Scene(name, name, "a request", "", (), p.central_body, p.orbit, p.chain, p.effects, p.run)


def request_schema() -> dict[str, Any]:
    """JSON Schema of a request, with a description of each key."""
    return described(Request.model_json_schema())


def result_schema() -> dict[str, Any]:
    """JSON Schema of a result."""
    return Result.model_json_schema()


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """Schema in which keys of dataclasses have the descriptions that their docstrings give them."""
    for table in schema["$defs"].values():
        head, _, attributes = table.get("description", "").partition("\n\nAttributes\n----------\n")
        table["description"] = head
        for key, text in attribute_texts(attributes):
            table["properties"][key].setdefault("description", text)
    return schema


def attribute_texts(attributes: str) -> Iterator[tuple[str, str]]:
    """Names and texts of the section ``Attributes`` of a docstring."""
    for match in re.finditer(r"^(\w+) : .*\n((?: {4}.*\n?)+)", inspect.cleandoc(attributes), re.MULTILINE):
        yield match[1], " ".join(match[2].split())
