"""Planted changes: told on the night on which they happen, or within some nights for times, with the right culprit."""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.figure import Figure, FigureKind, NightPart
from barchain.nightly.figures.suspects import suspects_of, unknown_parts
from barchain.nightly.history.standing import every_change
from barchain.nightly.telling.document import change_entries
from tests.nightly.history.histories import history_of, judged_last
from tests.nightly.history.noise import noise
from tests.nightly.history.synthetic import ENVIRONMENT, identity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.levels import JudgedNight

ENGINES = ("mujoco", "exudyn", "rebound")
SCENES = ("paper/fig05", "paper/fig13")
COMMON = ("reference", "judge", "harness", "library:numpy", "python", "blas")
PARTS = tuple(
    NightPart(name, "1.0", f"{k:02x}")
    for k, name in enumerate(
        (*COMMON, *(f"{kind}:{e}" for kind in ("engine", "adapter") for e in ENGINES), *(f"scene:{s}" for s in SCENES))
    )
)


@dataclass(frozen=True)
class Planted:
    """A change: the part that causes it, and what it makes of figures of an engine in a scene."""

    part: str
    error: float = 1.0
    """Factor of the errors"""
    last_bit: bool = False
    steps: float = 1.0
    verdict: str = "pass"
    engines: Sequence[str] = field(default=ENGINES)
    scenes: Sequence[str] = field(default=SCENES)


PLANTED = {
    "one last bit in the reference": Planted("reference", last_bit=True),
    "one last bit by another NumPy": Planted("library:numpy", last_bit=True),
    "another Python": Planted("python", steps=2.0),
    "a sign in the reference": Planted("reference", error=1e6, verdict="inconsistent"),
    "a judge that is too strict": Planted("judge", verdict="exceeds_bound"),
    "another harness that drops a quantity": Planted("harness", verdict="incomplete"),
    "a tolerance x 3": Planted("adapter:mujoco", error=3.0, engines=("mujoco",)),
    "half the steps": Planted("adapter:exudyn", error=4.0, steps=0.5, engines=("exudyn",)),
    "a lost order": Planted("adapter:rebound", error=80.0, verdict="exceeds_bound", engines=("rebound",)),
    "another wheel": Planted("engine:mujoco", error=1.01, last_bit=True, engines=("mujoco",)),
    "a more accurate wheel": Planted("engine:exudyn", error=0.2, engines=("exudyn",)),
    "a wheel that fails": Planted("engine:rebound", verdict="failed", engines=("rebound",)),
    "another scene": Planted("scene:paper/fig13", error=1.5, scenes=("paper/fig13",)),
    "another machine class": Planted("machine", last_bit=True),
    "another machine class, other counts": Planted("machine", steps=1.01),
}


def measured(change: Planted | None) -> list[Figure]:
    """Figures of a night."""
    found = []
    for scene, engine in itertools.product(SCENES, ENGINES):
        hit = change is not None and engine in change.engines and scene in change.scenes
        c = change if hit and change is not None else Planted("")
        depends = (*COMMON, f"engine:{engine}", f"adapter:{engine}", f"scene:{scene}", "machine")
        bare = tuple(name for name in depends if name != "judge")
        bits = "00" if c == Planted("") or c.part == "judge" else "01"
        own = {"scene": scene, "engine": engine, "setting": "default"}
        off = 1e-15 if c.last_bit else 0.0
        found += [
            Figure(identity("trajectory", FigureKind.BITS, **own), word=bits, depends=bare),
            Figure(identity("steps", FigureKind.COUNT, **own), 1000.0 * c.steps, depends=bare),
            Figure(identity("attitude.max", **own), 1e-5 * c.error + off, tolerance=1e-12, depends=depends),
            Figure(identity("verdict", FigureKind.VERDICT, **own), word=c.verdict, depends=depends),
        ]
    return found


def judged_with(change: Planted) -> JudgedNight:
    """Judgement of the last of four nights, on which a part changes."""
    newer = tuple(dataclasses.replace(p, version="1.1", digest="ee") if p.name == change.part else p for p in PARTS)
    environment = {3: dataclasses.replace(ENVIRONMENT, cpu="Other CPU")} if change.part == "machine" else {}
    figures = [*[measured(None)] * 3, measured(change)]
    parts = dict.fromkeys(range(3), PARTS) | {3: newer}
    return judged_last(history_of(*figures, parts=parts, environment=environment))


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_change_is_told_the_same_night_with_its_culprit(name: str) -> None:
    change = PLANTED[name]
    judged = judged_with(change)
    assert judged.tonight
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    for told in judged.tonight:
        assert [s.name for s in suspects_of(told, nights)] == [change.part]
        assert told.identity.engine in change.engines
        assert told.identity.scene in change.scenes
    worse = {c.identity.quantity for c in judged.tonight if c.direction is Direction.WORSE}
    assert ("verdict" in worse) == (change.verdict != "pass")
    assert ("attitude.max" in worse) == (change.error > 1.0)
    if change.last_bit and change.error == 1.0:
        assert {c.identity.kind for c in judged.tonight} == {FigureKind.BITS}
        assert judged.same
        assert not judged.worse


CHANGED = {"engine:mujoco", "adapter:mujoco"}
BOTH = tuple(dataclasses.replace(p, digest="ee") if p.name in CHANGED else p for p in PARTS)
UNKNOWN = tuple(dataclasses.replace(p, digest="") for p in PARTS)


@pytest.mark.parametrize(("before", "after", "suspects"), [(PARTS, BOTH, CHANGED), (UNKNOWN, UNKNOWN, set())])
def test_parts_that_change_at_once_are_all_suspects_and_those_without_digest_are_unknown(
    before: tuple[NightPart, ...], after: tuple[NightPart, ...], suspects: set[str]
) -> None:
    history = history_of(measured(None), measured(PLANTED["a tolerance x 3"]), parts={0: before, 1: after})
    change, nights = judged_last(history).tonight[-1], {night.name: night for night in history}
    assert {s.name for s in suspects_of(change, nights)} == suspects
    assert ("adapter:mujoco" in unknown_parts(change, nights)) is (not suspects)


def test_what_nothing_explains_says_so() -> None:
    history = history_of(measured(None), measured(PLANTED["a tolerance x 3"]), parts={0: PARTS, 1: PARTS})
    judged = judged_last(history)
    assert judged.tonight[0].irreproducible
    entry = change_entries(judged, ())[0][0]
    assert entry.suspect_words == "none: all parts that the figure depends on are the same"


def timed(seed: int, before: int, after: int, kind: FigureKind, factor: float) -> tuple[JudgedNight, int]:
    """Judgement of a history of times in which mujoco's wheel makes two of its figures larger."""
    x = noise(seed, 30, before + after, 0.02, 0.3)
    x[:2, before:] += np.log(factor)
    nights, parts = [], {}
    for t in range(before + after):
        engines = itertools.cycle(ENGINES)
        nights.append(
            [
                Figure(
                    identity(f"quantity.{k}", kind, engine=(e := next(engines) if k > 1 else "mujoco")),
                    float(np.exp(x[k, t])) * (2.0 if kind is FigureKind.RATIO else 1e8),
                    depends=(*COMMON, f"engine:{e}", f"adapter:{e}"),
                )
                for k in range(30)
            ]
        )
        changed = {"engine:mujoco"} if t >= before else set()
        changed |= {"engine:exudyn"} if t >= before + 1 else set()  # another engine is new a night later
        parts[t] = tuple(dataclasses.replace(p, digest="ee") if p.name in changed else p for p in PARTS)
    history = history_of(*nights, parts=parts)
    return judged_last(history), before


@pytest.mark.parametrize("kind", [FigureKind.RATIO, FigureKind.MEMORY])
def test_slow_downs_and_memory_are_told_with_their_culprit_and_their_night(kind: FigureKind) -> None:
    judged, before = timed(0, 60, 6, kind, 1.2)
    nights = [*judged.compared_with, judged.night]
    assert {c.identity.quantity for c in every_change(judged)} == {"quantity.0", "quantity.1"}
    for change in every_change(judged):
        assert change.direction is Direction.WORSE
        assert change.factor == pytest.approx(1.2, rel=0.05)
        assert change.factor_low <= change.factor <= change.factor_high
        assert change.since == nights[before].name
        assert [s.name for s in suspects_of(change, {n.name: n for n in nights})] == ["engine:mujoco"]


def test_a_speed_up_is_better_and_told_once() -> None:
    told = [timed(1, 60, after, FigureKind.RATIO, 1.0 / 1.3)[0] for after in range(2, 7)]
    first = [k for k, judged in enumerate(told) if judged.tonight]
    assert len({c.identity for judged in told for c in judged.tonight}) == 2
    assert sum(len(judged.tonight) for judged in told) == 2
    assert first[0] <= 4
    assert not any(judged.worse for judged in told)


@pytest.mark.exhaustive
def test_culprits_of_steps_in_times_are_right_in_nineteen_of_twenty() -> None:
    right = []
    for seed in range(20):
        for factor in (1.1, 1.2):
            judged, _ = timed(seed, 60, 10, FigureKind.RATIO, factor)
            nights = {n.name: n for n in (*judged.compared_with, judged.night)}
            right += [[s.name for s in suspects_of(c, nights)] == ["engine:mujoco"] for c in every_change(judged)]
    assert len(right) >= 70
    assert np.mean(right) >= 0.95
