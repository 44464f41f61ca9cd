"""Measures of a run: ``largest(reaction_N)``, one number of one channel over time."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.derived import DerivedError
from scenarios import nearest
from scenarios.channels import STORED, numbered_part
from scenarios.derived_channels import DERIVED, channel_of
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from adapters.trajectory import Array
    from scenarios import Scene
    from scenarios.channels import Channel

OVER_TIME: dict[str, Callable[[Array], Array]] = {
    "largest": lambda values: values.max(axis=0),
    "least": lambda values: values.min(axis=0),
    "peak": lambda values: np.abs(values).max(axis=0),
    "final": lambda values: values[-1],
    "rms": lambda values: np.sqrt(np.mean(values**2, axis=0)),
}
"""Functions of samples (n, k), one number for each of k bars or joints"""
PERCENTILE = re.compile(r"p(\d{1,2}(?:\.\d+)?|100)")
FORM = re.compile(r"\s*(\w+(?:\.\d+)?)\s*\(\s*(\w+)\s*(?:\[\s*(\d{1,9}|last)\s*\])?\s*\)\s*")
LAST = -1
"""Number of the last bar or joint of a run"""
FORMS = f"{', '.join(OVER_TIME)} or p95 of a channel, a bar or joint, or a column: largest(tension), final(attitude[2])"
USUAL = ("largest(reaction)", "largest(altitude)", "least(altitude)")
"""Measures where none is given, as far as the scene has them"""
CHANNELS = {channel.name: channel for channel in (*STORED, *DERIVED) if channel.name != "condition"}
"""Channels that may be measured: all but the condition number, which a run has on request alone"""
VECTOR = ("x", "radial")
"""Ends of the stems of a vector's first component"""


class MeasureError(ValueError):
    """A measure that does not exist, or that a scene has not; one line."""


@dataclass(frozen=True)
class Measure:
    """One number of a run."""

    over: str
    """Key of :data:`OVER_TIME`, or a percentile: ``p95``"""
    channel: Channel
    number: int = 0
    """Of the bar or joint, from 1, or :data:`LAST`; 0: the worst of all"""
    column: str = ""
    """The only column that counts, if one is named"""

    def __str__(self) -> str:
        """``largest(tension_N[2])``, with the unit in the channel's name as in that of a column."""
        number = "last" if self.number == LAST else self.number
        of = self.column or f"{self.channel.column_of()}{f'[{number}]' if number else ''}"
        return f"{self.over}({of})"

    def of(self, columns: Mapping[str, Array]) -> float:
        """Value of the columns of its channel, each (n,), in the channel's unit.

        Of all bars or joints the largest value counts for ``largest``, the least for ``least``, else the one of largest
        size. Of a vector the magnitude counts, unless a column names a component.

        Raises
        ------
        DerivedError
            If the column, bar or joint is not among them.
        """
        numbers = {column: (numbered_part(column) or ("", 0))[1] for column in columns}
        number = max(numbers.values(), default=0) if self.number == LAST else self.number
        wanted = [
            values
            for column, values in columns.items()
            if column == (self.column or column) and number in (0, numbers[column])
        ]
        if not wanted:
            raise DerivedError(f"{self}: the run gives none in this scene")
        values = np.stack(wanted, axis=1)
        if not self.column and self.channel.stems[0].endswith(VECTOR):
            values = np.hypot(values[:, ::2], values[:, 1::2])
        each = self.over_time(values)
        if self.over in ("largest", "least"):
            return float(OVER_TIME[self.over](each))
        return float(each[np.argmax(np.abs(each))])

    def over_time(self, values: Array) -> Array:
        """One number for each column of samples (n, k)."""
        if self.over in OVER_TIME:
            return OVER_TIME[self.over](values)
        return np.asarray(np.percentile(values, float(self.over[1:]), axis=0))

    def missing_in(self, scene: Scene) -> str:
        """Why a scene has no such channel, bar or joint; empty if it has."""
        if not self.channel.of.numbered:
            return ""
        numbers = self.channel.numbers(scene)
        if not numbers or self.channel.absent_from(scene):
            return f"{scene.name} has no {self.channel.words}"
        part = numbered_part(self.column)
        number = part[1] if part else self.number
        allowed = f"{numbers[0]} to {numbers[-1]}"
        return "" if number in (0, LAST, *numbers) else f"no {self.channel.of.value} {number}, allowed: {allowed}"


def measures_of(texts: Iterable[str], scene: Scene) -> tuple[Measure, ...]:
    """Measures by their texts; the usual ones of the scene where none is given.

    Parameters
    ----------
    texts : iterable of str
    scene : Scene
        The one of the sweep with the most bars.

    Raises
    ------
    MeasureError
        If one has another form, or the scene has no such channel, bar or joint.
    """
    found = tuple(dict.fromkeys(map(parse, texts)))
    for measure in found:
        if missing := measure.missing_in(scene):
            raise MeasureError(f"--measure {measure}: {missing}")
    return found or tuple(measure for measure in map(parse, USUAL) if not measure.missing_in(scene))


def parse(text: str) -> Measure:
    """Measure of a text.

    Raises
    ------
    MeasureError
        If it has another form; with the nearest name.
    """
    match = FORM.fullmatch(text)
    if not match:
        raise MeasureError(f"--measure: {shorten(text)} given, allowed: {FORMS}")
    over, of, number = match.groups()
    if over not in OVER_TIME and not PERCENTILE.fullmatch(over):
        raise MeasureError(
            f"--measure {text}: no {over}{nearest(over, OVER_TIME)}, allowed: {', '.join(OVER_TIME)}, p0 to p100"
        )
    named = next((channel for channel in CHANNELS.values() if of in (channel.name, channel.column_of())), None)
    channel = named or channel_of(of)
    if channel is None or channel.name not in CHANNELS:
        near = nearest(of, CHANNELS)
        raise MeasureError(f"--measure {text}: no channel or column {of}{near}; `barchain explain channels` lists them")
    if number is not None:
        place = LAST if number == "last" else int(number)
        if not named or not channel.of.numbered or not place:
            raise MeasureError(
                f"--measure {text}: [{number}] given, allowed: the number of a bar or joint, from 1, or last"
            )
        return Measure(over, channel, place)
    return Measure(over, channel, column="" if named else of)
