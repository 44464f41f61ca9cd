"""Size and speed of a long history: many synthetic nights made of one real night.

    python benchmarks/many_nights.py nights/NIGHT --nights 1000 --history many --out out

Each synthetic night has the figures of the real one; times and memory with noise, one series with a step of 15 % on the
last third, one engine whose errors all move every 20 nights, and an error twice as large on the last night. What is
printed is measured on this machine.
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import resource
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from barchain.cli.nightly.documents import write_documents
from barchain.nightly.figures.figure import Figure, FigureKind, Night, NightPart
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import open_store
from barchain.nightly.telling.trends import trend_charts

if TYPE_CHECKING:
    from collections.abc import Callable

FIRST = datetime.datetime(2023, 3, 1, 2, 0, tzinfo=datetime.UTC)
NOISE, STEP = 0.02, 1.15
MOVES_EVERY, MOVE = 20, 1.001


def synthetic(real: Night, number: int, nights: int, random: np.random.Generator) -> Night:
    """Night of a number."""
    ratios = sorted(f.identity.name for f in real.figures if f.identity.kind is FigureKind.RATIO)
    slow = ratios[0] if ratios else ""
    wrong = next((f.identity.name for f in real.figures if is_clear(f)), "")
    moving = max({f.identity.engine for f in real.figures})
    figures = tuple(moved(changed(f, number, nights, random, slow, wrong), number, moving) for f in real.figures)
    last = number == nights - 1
    parts = tuple(newer(p) if last and p.name.startswith("adapter:") else p for p in real.parts)
    started = FIRST + datetime.timedelta(days=number)
    return dataclasses.replace(
        real, started=started, figures=figures, parts=parts, void=None, complete=True, label="synthetic"
    )


def is_clear(figure: Figure) -> bool:
    """Whether a figure is an error far beyond its rounding."""
    return figure.identity.kind is FigureKind.ERROR and (figure.value or 0.0) > 100.0 * (figure.tolerance or np.inf)


def newer(part: NightPart) -> NightPart:
    """Part with other sources."""
    return NightPart(part.name, part.version, part.digest[::-1])


def changed(
    figure: Figure, number: int, nights: int, random: np.random.Generator, slow: str, wrong: str
) -> Figure:  # fmt: skip
    """Figure of a night: noise of times and memory, a step, and an error on the last night."""
    if figure.value is None:
        return figure
    name, factor = figure.identity.name, 1.0
    if figure.identity.kind in {FigureKind.RATIO, FigureKind.MEMORY}:
        factor = float(np.exp(NOISE * random.standard_normal()))
        if name == slow and number >= 2 * nights // 3:
            factor *= STEP
    if name == wrong and number == nights - 1:
        factor = 2.0
    if factor == 1.0:
        return figure
    low, high = (end if end is None else end * factor for end in (figure.low, figure.high))
    return dataclasses.replace(figure, value=figure.value * factor, low=low, high=high)


def moved(figure: Figure, number: int, engine: str) -> Figure:
    """Figure of a night; errors of an engine that each of its versions moves."""
    if figure.identity.engine != engine or figure.identity.kind is not FigureKind.ERROR or figure.value is None:
        return figure
    return dataclasses.replace(figure, value=figure.value * MOVE ** (number // MOVES_EVERY))


def timed(words: str, work: Callable[[], object]) -> None:
    """Print the time of some work."""
    start, used = time.perf_counter(), time.process_time()
    work()
    print(f"{words}: {time.perf_counter() - start:.2f} s, {time.process_time() - used:.2f} s of the processor")


def main() -> None:
    """Make the history, and measure it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("night", type=Path)
    parser.add_argument("--nights", type=int, default=1000)
    parser.add_argument("--history", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    random = np.random.default_rng(0)
    real = open_store(str(asked.night.absolute().parent)).night(asked.night.name)
    store = open_store(str(asked.history), create=True)
    start = time.perf_counter()
    for number in range(len(store.nights()), asked.nights):
        store.add(synthetic(real, number, asked.nights, random))
    each = (time.perf_counter() - start) / asked.nights
    print(f"{asked.nights} nights of {len(real.figures)} figures, {each:.2f} s to add one")
    print(f"size: {sum(file.stat().st_size for file in asked.history.rglob('*.*')) / 1e6:.0f} MB")
    name = real.figures[0].identity.name
    timed("numbers of all nights", store.numbers)
    timed("list of nights", store.nights)
    timed("one figure over all nights", lambda: store.series(name))
    timed("one whole night", lambda: store.night("latest"))
    timed("charted figures", lambda: trend_charts(store.numbers(), store.nights()))
    timed("judgement of the last night", lambda: judge(store))
    timed("judgement and all documents", lambda: write_documents(store, "latest", asked.out))
    print(f"peak memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB")
    print(f"page: {(asked.out / 'nightly.html').stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
