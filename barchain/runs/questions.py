"""Questions to an engine, answered in its own process as JSON and float64 arrays; declarations with their checks."""

from __future__ import annotations

import dataclasses
import inspect
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.command.entries import OWN_CLOCK
from adapters.engine import QUESTIONS, AccuracyParameter, AccuracySweep, Coordinates, Engine, own_questions
from adapters.trajectory import Observable, Trajectory
from barchain.runs.message import DeclarationError, MessageError, plain_info, plain_number, plain_text
from barchain.runs.phases import Peak, enter, three_phases

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.engine import Setting
    from adapters.registry import Registration
    from adapters.trajectory import Array
    from scenarios import Scene

Answer = tuple[dict[str, Any], dict[str, "Array"]]
WORDS = {"ended", "info", "scene", "engine", "setting", "torque_bars", "run_scene"}
"""Fields of a trajectory that are no arrays"""
ARRAYS = tuple(f.name for f in dataclasses.fields(Trajectory) if f.name not in WORDS)
HIGHEST_ORDER = 40.0
"""Taylor series in double precision have about half of it"""
LARGEST_STEP_CONSTANT = 10.0
NAME_LENGTH, TITLE_LENGTH = 60, 200


@dataclass(frozen=True)
class Declaration:
    """One declaration of engines."""

    types: tuple[type, ...]
    meant: Callable[[Any], Any]
    """Value of its form in a message; raises for another one, as the message may come from a process gone astray"""
    check: Callable[[Any], object] = bool
    """Raises for a value out of range"""


def declared(engine: type[Engine], name: str) -> Any:
    """Value of a declaration.

    Raises
    ------
    DeclarationError
        If it is missing, of another type than :data:`DECLARED` says, or out of range.
    """
    if not hasattr(engine, name):
        raise DeclarationError(f"it does not declare {name}")
    value, types = getattr(engine, name), DECLARED[name].types
    if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
        wanted = " or ".join("None" if t is type(None) else t.__name__ for t in types)
        raise DeclarationError(f"{name} is a {type(value).__name__}, expected {wanted}")
    DECLARED[name].check(value)
    return value


def check_order(order: float | None) -> None:
    """Check the range of an order."""
    if order is not None and not 1.0 <= order <= HIGHEST_ORDER:
        raise DeclarationError(f"order is {order:g}, allowed: 1 to {HIGHEST_ORDER:g}, or None")


def check_step_constant(constant: float) -> None:
    """Check the range of a step constant."""
    if not 0.0 < constant <= LARGEST_STEP_CONSTANT:
        raise DeclarationError(
            f"step_constant is {constant:g}, allowed: greater than 0, at most {LARGEST_STEP_CONSTANT:g}"
        )


def check_sweep(sweep: AccuracySweep) -> None:
    """Check that settings go from coarse to fine."""
    values = [float(v) for v in sweep.values]
    coarse_first = sorted(values, reverse=AccuracyParameter(sweep.parameter) is AccuracyParameter.RTOL)
    if not values or values != coarse_first:
        raise DeclarationError(f"sweep.values are not sorted from coarse to fine: {plain_text(values, 120)}")
    if len(set(values)) < len(values):
        raise DeclarationError(f"sweep.values repeat a value: {plain_text(values, 120)}")
    if not all(math.isfinite(v) and v > 0.0 for v in (*values, float(sweep.default))):
        raise DeclarationError("sweep holds a value that is not positive and finite")
    if not 0.0 < float(sweep.finer_rtol) < 1.0:
        raise DeclarationError(
            f"sweep.finer_rtol is {float(sweep.finer_rtol):g}, allowed: between 0 and 1, the requested error of the "
            "finer run over that of the run itself"
        )


def plain(value: Any) -> Any:
    """Form of a declaration in a message."""
    if isinstance(value, AccuracySweep):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, (set, frozenset)):
        return sorted(plain_text(name, NAME_LENGTH) for name in value)
    if isinstance(value, dict):
        return {plain_text(name, NAME_LENGTH): plain_text(reason) for name, reason in value.items()}
    if isinstance(value, (tuple, list)):
        return [float(each) for each in value]
    if value is None or isinstance(value, bool):
        return value
    return plain_text(value, TITLE_LENGTH) if isinstance(value, str) else float(value)


def meant_sweep(said: dict[str, Any]) -> AccuracySweep:
    """Sweep of a message."""
    values = tuple(float(v) for v in said["values"])
    return AccuracySweep(
        AccuracyParameter(said["parameter"]), values, float(said["default"]), float(said["finer_rtol"])
    )


NAMES = Declaration((frozenset, set), lambda names: tuple(map(str, names)))
SWITCH = Declaration((bool,), bool)
DECLARED: dict[str, Declaration] = {
    "title": Declaration((str,), str),
    "coordinates": Declaration((str,), Coordinates, Coordinates),
    "order": Declaration((float, int, type(None)), lambda n: None if n is None else float(n), check_order),
    "sweep": Declaration((AccuracySweep,), meant_sweep, check_sweep),
    "effects": NAMES,
    "observables": Declaration(
        (frozenset, set), lambda names: tuple(map(Observable, names)), lambda names: [*map(Observable, names)]
    ),
    "options": NAMES,
    "joints_in_place": SWITCH,
    "track_by_length": SWITCH,
    "step_constant": Declaration((float, int), float, check_step_constant),
    "unsupported_reasons": Declaration((dict,), lambda said: {str(name): str(reason) for name, reason in said.items()}),
}
"""Declarations of an engine"""


def describe(
    registration: Registration, scenes: Sequence[Scene] = (), settings: Sequence[Setting] = (), t_s: Array | None = None
) -> Answer:
    """Declarations of an engine's class, checked, with its answers on scenes: a process each would take seconds.

    Parameters
    ----------
    registration : Registration
    scenes : sequence of Scene
    settings : sequence of Setting
    t_s : ndarray, shape (n,), optional
        Instants of the noise, s; needed with settings.

    Returns
    -------
    tuple
        Header: ``declared``, the names of replaced ``questions``, and for each scene a reason against it or None,
        ``reasons``. Arrays: noise of a quantity in scene i at setting j, called ``i.j.quantity``, (n,).
    """
    engine = loaded(registration)
    said = {name: plain(declared(engine, name)) for name in DECLARED}
    enter("unsupported")
    reasons = [reason_text(engine.unsupported(scene)) for scene in scenes]
    found = {
        f"{i}.{j}.{name}": values
        for i, scene in enumerate(scenes)
        for j, setting in enumerate(settings)
        if t_s is not None
        for name, values in noise(registration, scene, setting, t_s).items()
    }
    return {"declared": said, "questions": own_questions(engine), "reasons": reasons}, found


def loaded(registration: Registration, then: str = "its declarations") -> type[Engine]:
    """Class of an engine, imported here; `then` is the phase after the import."""
    enter("the import")
    found: object = registration.load()
    enter(then)
    if not (isinstance(found, type) and issubclass(found, Engine)):
        raise DeclarationError(f"{registration.target} is no subclass of adapters.engine.Engine")
    if inspect.isabstract(found):
        lacking = ", ".join(sorted(found.__abstractmethods__))
        raise DeclarationError(f"{registration.target} does not define {lacking}")
    for name in QUESTIONS:
        if not hasattr(getattr(found, name), "__func__"):
            raise DeclarationError(f"{name} is no class method; it needs @classmethod above it")
    return found


def unsupported_motion(registration: Registration, scene: Scene, motion: Trajectory) -> Answer:
    """Reason if the engine does not support a motion, or None."""
    engine = loaded(registration, "unsupported motion")
    return {"reason": reason_text(engine.unsupported_motion(scene, motion))}, {}


def reason_text(reason: object) -> str | None:
    """Reason as one line."""
    if reason is None:
        return None
    if not isinstance(reason, str) or not reason.strip():
        raise DeclarationError(f"its reason against a scene is a {type(reason).__name__}, expected text or None")
    return plain_text(reason)


def noise(registration: Registration, scene: Scene, setting: Setting, t_s: Array) -> dict[str, Array]:
    """Errors that the engine declares, as arrays of shape (n,)."""
    said = loaded(registration, "noise").noise(scene, setting, t_s)
    if not isinstance(said, dict):
        raise DeclarationError(f"noise is a {type(said).__name__}, expected a dict")
    found = {}
    for name, values in said.items():
        try:
            found[plain_text(name, 60)] = np.array(np.broadcast_to(np.asarray(values, float), t_s.shape))
        except (TypeError, ValueError):
            raise DeclarationError(
                f"noise of {plain_text(name, 60)!r} is no number and no array of {t_s.shape}"
            ) from None
    return found


def run(registration: Registration, options: tuple[str, ...], scene: Scene, setting: Setting) -> Answer:
    """Build, simulate and read, each timed."""
    header, result = finished(registration, options, scene, setting)
    return header, sendable(result)


def finished(
    registration: Registration, options: tuple[str, ...], scene: Scene, setting: Setting
) -> tuple[dict[str, Any], Trajectory]:
    """Header of an answer, and the engine's own trajectory."""
    if not registration.entry:  # of which only barchain's code runs here
        loaded(registration)
    result, seconds = three_phases(registration.engine(options), scene, setting)
    if not isinstance(result, Trajectory):
        raise MessageError(f"read() returned a {type(result).__name__}, expected a Trajectory")
    ended = result.ended
    if not isinstance(ended, str):
        raise MessageError(f"ended is a {type(ended).__name__}, expected text")
    info = plain_info(result.info)
    if registration.entry and OWN_CLOCK in info:  # the time of the process has its start in it
        seconds |= {"process": seconds["simulate"], "simulate": float(info[OWN_CLOCK])}
    spent = {phase: plain_number(s) or 0.0 for phase, s in seconds.items()}
    return {"seconds": spent, "ended": plain_text(ended), "info": info}, result


def first_run(
    registration: Registration, options: tuple[str, ...], scene: Scene, setting: Setting, warm: Scene
) -> Answer:
    """Run a small scene to warm up, then another: ``memory_B`` is the peak memory of the second; None if unknown."""
    run(registration, options, warm, setting)
    peak = Peak()
    header, arrays = run(registration, options, scene, setting)
    return header | {"memory_B": plain_number(peak.beyond())}, arrays


def turn(
    registration: Registration, options: tuple[str, ...], scene: Scene, setting: Setting, least_s: float, most: int
) -> Answer:
    """Run once untimed, then until `simulate` has taken `least_s`, at most `most` times: the least time of each phase.

    ``runs`` is the number of timed runs, ``cold`` the additional time of the first to build and simulate.
    """
    header, arrays = run(registration, options, scene, setting)
    cold: dict[str, float] = header["seconds"]
    timings: list[dict[str, float]] = []
    while len(timings) < most and sum(s["simulate"] for s in timings) < least_s:
        header, arrays = run(registration, options, scene, setting)
        timings.append(header["seconds"])
        if sum(sum(s.values()) for s in timings) >= 5.0 * least_s:
            break
    least = {phase: min(s[phase] for s in timings) for phase in cold}
    more = sum(cold[phase] - least[phase] for phase in ("build", "simulate"))
    return header | {"seconds": least | {"runs": float(len(timings)), "cold": more}}, arrays


def sendable(result: Trajectory, *, keep_order: bool = False) -> dict[str, Array]:
    """Arrays of a trajectory, all float64; in C's order of memory, or in their own, which sums may depend on."""
    found = {}
    for name in ARRAYS:
        value = getattr(result, name)
        if value is None and name not in {"t_s", "com_m", "com_velocity_m_s"}:
            continue
        if not isinstance(value, np.ndarray):
            raise MessageError(f"{name} is a {type(value).__name__}, expected an array of float64")
        if value.dtype != np.float64:
            raise MessageError(f"{name} holds {plain_text(value.dtype, 40)}, expected float64")
        found[name] = value if keep_order else np.ascontiguousarray(np.asarray(value))
    return found
