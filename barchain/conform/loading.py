"""Loading: entry point, class, declarations, and the time and the side effects of the import."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.registry import engines
from barchain.conform.checks import Check, CheckState, Group
from barchain.runs.asking import ask
from barchain.runs.limits import OutsideLimits
from scenarios import nearest
from scenarios.effect_types import all_effect_names

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.conform.target import Examined
    from barchain.runs.asking import Reply

SLOW_IMPORT_S = 1.0
"""Import of an adapter from which on users wait at every command that lists engines"""
CLASS = ("import", "class")
"""Steps before the declarations"""
PAGE = "docs/explanation/engine_conventions.md#declarations"


def loading(engine: Examined) -> Iterator[Check]:
    """Checks of the entry point, the import, the class and its declarations."""
    yield name_check(engine)
    reply = ask("examined_class", engine.registration, limits=OutsideLimits())
    if reply.problem:
        yield Check(Group.LOADING, "import", CheckState.FAILED, reply.problem, PAGE)
        return
    steps = reply.header["steps"]
    for name, fault in steps:
        if fault:
            yield Check(Group.LOADING, str(name), CheckState.FAILED, str(fault), PAGE)
    if any(fault for _, fault in steps):
        return
    yield Check(Group.LOADING, "class", CheckState.PASSED, engine.registration.target, PAGE)
    yield Check(Group.LOADING, "declarations", CheckState.PASSED, f"{len(steps) - len(CLASS)} of the right types", PAGE)
    yield effects_check(reply)
    yield order_check(engine)
    yield import_check(reply)


def name_check(engine: Examined) -> Check:
    """Check that a distribution provides the engine, or tell how a class is registered."""
    r = engine.registration
    if r.missing:
        return Check(Group.LOADING, "entry point", CheckState.FAILED, r.missing, PAGE)
    if not engine.registered:
        known = next((name for name, other in engines().items() if other.target == r.target), "")
        if known:
            return Check(Group.LOADING, "entry point", CheckState.PASSED, f"registered as {known}", PAGE)
        said = f'none; `{engine.name} = "{r.target}"` under [project.entry-points."barchain.engines"] registers it'
        return Check(Group.LOADING, "entry point", CheckState.WARNING, said, PAGE)
    if not engine.own and r.version == "none":
        said = "no distribution provides it, so that results can't be told apart by its version"
        return Check(Group.LOADING, "entry point", CheckState.FAILED, said, PAGE)
    provided = f"{r.distribution or r.requires or 'barchain'} {r.version}"
    return Check(Group.LOADING, "entry point", CheckState.PASSED, f"{engine.name} of {provided}", PAGE)


def effects_check(reply: Reply) -> Check:
    """Check that all declared effects are effects of scenes."""
    known, said = all_effect_names(), reply.header["effects"]
    unknown = [name for name in said if name not in known]
    if unknown:
        words = "; ".join(f"{name!r} is no effect{nearest(name, known)}" for name in unknown)
        return Check(Group.LOADING, "effect names", CheckState.FAILED, words, PAGE)
    words = f"{len(said)} of {len(known)}, each model of gravity counted by itself"
    return Check(Group.LOADING, "effect names", CheckState.PASSED, words, PAGE)


def order_check(engine: Examined) -> Check:
    """Check that a method has an order exactly if it takes equal steps."""
    from adapters.engine import AccuracyParameter  # noqa: PLC0415

    loaded = engine.load()
    chooses = loaded.sweep.parameter is AccuracyParameter.RTOL
    if chooses and loaded.order is not None:
        said = f"order is {loaded.order:g}, though the method chooses its steps; expected None"
        return Check(Group.LOADING, "order and setting", CheckState.FAILED, said, PAGE)
    if not chooses and loaded.order is None:
        said = "order is None, though the method takes equal steps; expected its order"
        return Check(Group.LOADING, "order and setting", CheckState.FAILED, said, PAGE)
    said = "chooses its steps" if chooses else f"equal steps of order {loaded.order:g}"
    return Check(Group.LOADING, "order and setting", CheckState.PASSED, said, PAGE)


def import_check(reply: Reply) -> Check:
    """Check that the import is quick, and that libraries are imported inside methods only."""
    seconds, libraries = float(reply.header["import_s"]), reply.header["libraries"]
    if libraries:
        said = f"imports {', '.join(libraries)} at its top ({seconds:.2f} s); import inside methods"
        return Check(Group.LOADING, "time of import", CheckState.WARNING, said, PAGE)
    state = CheckState.WARNING if seconds > SLOW_IMPORT_S else CheckState.PASSED
    return Check(Group.LOADING, "time of import", state, f"{seconds:.2f} s", PAGE)
