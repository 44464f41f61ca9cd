"""Words of a picture: lengths, times, alternative text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pictures.motion.samples import is_free

if TYPE_CHECKING:
    from pictures.motion.samples import Motion

ENLARGED = 1.5
UNITS = ((1e3, "km"), (1.0, "m"), (1e-3, "mm"), (1e-6, "µm"))


def length(metres: float) -> str:
    """Length in the unit that makes it a small number."""
    factor, unit = next(((f, u) for f, u in UNITS if metres >= f * (1.0 - 1e-9)), UNITS[-1])
    return f"{metres / factor:g} {unit}"


def duration(motion: Motion) -> str:
    """Shown part of the run, in words."""
    start_s, end_s, period_s = float(motion.t_s[0]), float(motion.t_s[-1]), motion.scene.period_s
    if start_s > 0.0:
        return f"{rounded(start_s)} to {rounded(end_s)} s"
    if motion.scene.bound and end_s >= 0.2 * period_s:
        orbits = f"{end_s / period_s:.3g}"
        return f"{orbits} orbit{'s'[: orbits != '1']}"
    return f"{rounded(end_s)} s" if end_s >= 1.0 else f"{rounded(end_s * 1e3)} ms"


def rounded(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{float(f'{value:.3g}'):,.10g}".replace(",", " ")


def alt_text(motion: Motion, factor: float) -> str:
    """Description of both panels for readers who do not see them."""
    scene = motion.scene
    bars = "one bar" if scene.bars == 1 else f"a chain of {scene.bars} bars"
    left = f"{bars} along its path during {duration(motion)}"
    if enlargement(factor):
        left += f", enlarged {enlargement(factor)} times"
    axes = "in inertial axes" if is_free(scene) else "with the vertical upwards"
    right = f"the same chain about its centre of mass, {axes}"
    moved = "" if motion.shape_changes else "; its attitude hardly changes"
    return f"{scene.title}. Left: {left}. Right: {right}{moved}."


def enlargement(factor: float) -> str:
    """Enlargement of the chain relative to its orbit, to two digits; empty for none."""
    if factor < ENLARGED:
        return ""
    million = factor >= 1e6
    return rounded(float(f"{factor / (1e6 if million else 1.0):.2g}")) + " million" * million
