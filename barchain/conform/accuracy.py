"""Accuracy against the setting: errors that fall as requested, within the promised bound, with the declared order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.conform.checks import FAILED, PASSED, WARNING, Check
from barchain.conform.errors_at_settings import (
    ALL_RUNS_SHARE,
    ASYMPTOTIC,
    compared,
    repeated_scene,
    setting_runs,
    slopes_above,
)
from barchain.conform.noise import COMMON_SHARE
from barchain.conform.physics import INDEPENDENT, unsupported_check
from barchain.conform.runs import TIME_LIMITS
from barchain.conform.scenes import PARTICLE, REPEATED
from barchain.judge.diagnosis.mistake import SINGLE_PRECISION, looks_single
from reports.results.outcome import Outcome
from scenarios.channels import WORDS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.conform.errors_at_settings import Compared, ErrorAtSetting
    from barchain.conform.target import Examined

ORDER_SLACK = 0.5
"""Largest shortfall of a measured order: between it and the next lower order"""
HELD_ORDER = (0.5, 1.5)
"""Measured orders between which something is probably held over a step"""
UNSTEADY = 100.0
"""Ratio of the errors over the requests of two settings from which on a method does not keep requests alike"""
FALL = "errors fall with the setting"


def accuracy(engine: Examined) -> Iterator[Check]:
    """Checks of errors at several settings."""
    loaded = engine.declarations
    name = repeated_scene(loaded)
    if name is None:
        yield unsupported_check(engine, "errors at several settings", (*REPEATED, *PARTICLE))
        return
    runs = setting_runs(engine, name)
    failed = [f"{s}: {fault}" for s, fault in runs.faults.items() if fault]
    if len(runs.results) < len(runs.settings):
        said = f"{len(runs.results)} of {len(runs.settings)} settings end within {ALL_RUNS_SHARE * engine.run_s:g} s"
        yield Check("time of runs", WARNING if runs.results else FAILED, said, scene=name)
    if failed:
        late = any(r.outcome is Outcome.TIMED_OUT for r in runs.results)
        page = TIME_LIMITS if late else ""
        yield Check("runs at several settings", FAILED, "; ".join(failed), page, scene=name)
    found = runs.errors(loaded)
    if not found:
        return
    yield bound_check(found, name, loaded.order)
    yield falling_check(found, loaded.order, name)
    yield request_check(found, name) if loaded.order is None else order_check(found, float(loaded.order), name)


def bound_check(found: list[ErrorAtSetting], name: str, order: float | None = None) -> Check:
    """Check that every error is inside the bound that the setting and the declarations promise.

    The coarsest of equal steps may be outside the method's asymptotic range, where no order tells the error. The finer
    settings decide then, if they are inside their bounds and two of them show the declared order.
    """
    beyond = [e for e in found if not e.bound_ratio <= 1.0]
    if beyond == found[:1] and order is not None and shows_order(found[1:], float(order)):
        e = beyond[0]
        said = (
            f"{e.setting} is outside the asymptotic range of the method, {e.bound_ratio:.3g} times the bound; finer "
            f"settings are at most {max(f.bound_ratio for f in found[1:]):.2g} of it, and show the declared order"
        )
        return Check("errors inside the bound", WARNING, said, scene=name)
    if beyond:
        said = "; ".join(f"{e.bound_ratio:.3g} times the bound at {e.setting}" for e in beyond)
        return Check("errors inside the bound", FAILED, said, scene=name)
    most = max(found, key=lambda e: e.bare_ratio)
    if most.bare_ratio > 1.0:
        said = f"by declared noise alone: {most.bare_ratio:.3g} times the bound without it at {most.setting}"
        return Check("errors inside the bound", WARNING, said, scene=name)
    return Check(
        "errors inside the bound", PASSED, f"at most {max(e.bound_ratio for e in found):.2g} of it", scene=name
    )


def shows_order(found: list[ErrorAtSetting], order: float) -> bool:
    """Whether the two finest settings whose errors tell of the method show an order."""
    pairs = [pair for pair in compared(found) if pair.tells and not pair.noisy]
    return bool(pairs) and pairs[-1].order >= order - ORDER_SLACK


def falling_check(found: list[ErrorAtSetting], order: float | None, name: str) -> Check:
    """Check that a finer setting gives a smaller error, down to rounding, or to noise that two runs do not share."""
    shown, pairs = ", ".join(map(str, found)), compared(found)
    if not pairs:
        few = "one setting gave a result, so that no fall shows"
        said = f"no two errors are below {ASYMPTOTIC:g}, where they have to fall" if len(found) > 1 else few
        return Check(FALL, WARNING, f"{said}: {shown}", scene=name)
    stay = [p for p in pairs if p.tells and not p.falls(order) and not third_setting_falls(found, p, order)]
    wrong = next((pair for pair in stay if not pair.noisy or pair.apart < COMMON_SHARE * pair.fine), None)
    if wrong is not None and all(pair.apart == 0.0 for pair in pairs):
        return Check(FALL, FAILED, f"all settings give the same result: is the setting read? {shown}", scene=name)
    if wrong is not None:
        return Check(FALL, FAILED, f"{stays(wrong)}: {shown}{single_hint(wrong)}", scene=name)
    if stay:
        pair = stay[0]
        said = f"{WORDS[pair.quantity]} stay within declared noise of {pair.noise:.1e} alone, {pair}: {shown}"
        return Check(FALL, WARNING, said, scene=name)
    return Check(FALL, PASSED, shown, scene=name)


def stays(pair: Compared) -> str:
    """Words on an error that does not fall between two settings."""
    said = f"the error of the {WORDS[pair.quantity]} does not follow the setting, {pair}"
    if not pair.noisy:
        return said
    noise = f"declared noise of {pair.noise:.1e} is no reason"
    return f"{said}; {noise}, as the two runs differ by {pair.apart:.1e} from each other"


def single_hint(pair: Compared) -> str:
    """Hint at single precision, if both errors are of the size that it leaves, and random.

    Two random errors differ by as much as the larger of them. What each step adds anew, a damping, is proportional.
    """
    random = pair.apart >= INDEPENDENT * max(pair.coarse, pair.fine)
    single = random and all(looks_single(error) for error in (pair.coarse, pair.fine))
    return f". {SINGLE_PRECISION}" if single else ""


def third_setting_falls(found: list[ErrorAtSetting], pair: Compared, order: float | None) -> bool:
    """Whether the error of a method that chooses its steps falls past a pair of settings between which it does not.

    A sum of errors of any sign may be small at one setting by chance. The next finer setting then decides.
    """
    k = next(k for k, each in enumerate(found) if each.setting == pair.settings[0])
    further = compared([found[k], found[k + 2]]) if order is None and k + 2 < len(found) else []
    return any(further_pair.falls(order) for further_pair in further)


def request_check(found: list[ErrorAtSetting], name: str) -> Check:
    """Tell the ratio of the error to the requested one, and whether the scene amplifies local errors to that."""
    ratios = [e.error / e.setting.value for e in found if e.tells]
    if not ratios:
        return Check("error over request", PASSED, "rounding at all settings", scene=name)
    said = f"{min(ratios):.2g} to {max(ratios):.2g} times the request"
    most = max((e for e in found if e.tells), key=lambda e: e.kept_ratio)
    if most.kept_ratio > 1.0:
        cause = "is the request that of another quantity, or of a whole run?"
        if max(ratios) > UNSTEADY * min(ratios):
            cause = "does a step that was rejected leave something behind, such as its last stage?"
        said += (
            f"; at {most.setting} {most.kept_ratio:.2g} times what a method leaves that keeps its request in each "
            f"step: {cause}"
        )
        return Check("error over request", WARNING, said, scene=name)
    return Check("error over request", PASSED, said, scene=name)


def order_check(found: list[ErrorAtSetting], order: float, name: str) -> Check:
    """Check the declared order of a method of equal steps."""
    slopes = [pair.order for pair in compared(found) if pair.tells and not pair.noisy]
    if not slopes:
        return Check("order", WARNING, "no two settings whose errors show the order", scene=name)
    measured = ", ".join(f"{s:.2f}" for s in slopes)
    said = f"measured {measured}, declared {order:g}{'; the finest pair counts' if len(slopes) > 1 else ''}"
    if slopes[-1] < order - ORDER_SLACK:
        held = HELD_ORDER[0] < slopes[-1] < HELD_ORDER[1]
        hint = "; order 1 is that of Euler's method, or of a force that is held over a step" if held else ""
        return Check("order", FAILED, said + hint, scene=name)
    if slopes_above(found, order):
        return Check("order", WARNING, said, scene=name)
    return Check("order", PASSED, f"measured {measured}; declared {order:g}", scene=name)
