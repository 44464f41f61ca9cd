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
from tests.support.slow import one_in

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
    "one last bit by another BLAS": Planted("blas", last_bit=True),
    "another Python": Planted("python", steps=2.0),
    "a sign in the reference": Planted("reference", error=1e6, verdict="inconsistent"),
    "a judge that is too strict": Planted("judge", verdict="exceeds_bound"),
    "another harness that drops a quantity": Planted("harness", verdict="incomplete"),
    **{f"tolerance x 3 in {e}": Planted(f"adapter:{e}", error=3.0, engines=(e,)) for e in ENGINES},
    **{f"half the steps in {e}": Planted(f"adapter:{e}", error=4.0, steps=0.5, engines=(e,)) for e in ENGINES},
    **{
        f"a lost order in {e}": Planted(f"adapter:{e}", error=80.0, verdict="exceeds_bound", engines=(e,))
        for e in ENGINES
    },
    **{
        f"a late channel in {e}": Planted(f"adapter:{e}", error=1e3, verdict="inconsistent", engines=(e,))
        for e in ENGINES
    },
    **{f"another wheel of {e}": Planted(f"engine:{e}", error=1.01, last_bit=True, engines=(e,)) for e in ENGINES},
    **{f"more accurate wheel of {e}": Planted(f"engine:{e}", error=0.2, engines=(e,)) for e in ENGINES},
    **{f"{e} fails": Planted(f"engine:{e}", error=1.0, verdict="failed", engines=(e,)) for e in ENGINES},
    **{f"another scene {s}": Planted(f"scene:{s}", error=1.5, scenes=(s,)) for s in SCENES},
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


def judged_with(change: Planted, nights: int = 6, at: int = 5) -> JudgedNight:
    """Judgement of the last night of a history in which a part changes on night `at`, beside one that nothing uses."""
    parts, environment = {}, {}
    for k in range(at, nights):
        parts[k] = tuple(
            dataclasses.replace(p, version="1.1", digest="ee") if p.name == change.part else p for p in PARTS
        )
        if change.part == "machine":
            environment[k] = dataclasses.replace(ENVIRONMENT, cpu="Other CPU")
    figures = [measured(change if k >= at else None) for k in range(nights)]
    history = history_of(*figures, parts=dict.fromkeys(range(nights), PARTS) | parts, environment=environment)
    return judged_last(history)


@pytest.mark.parametrize("name", one_in(3, PLANTED))
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


def test_there_are_at_least_thirty_planted_changes() -> None:
    assert len(PLANTED) >= 30


def test_a_change_is_told_on_its_own_night_only_and_keeps_its_night() -> None:
    judged = judged_with(PLANTED["tolerance x 3 in mujoco"], nights=9, at=5)
    assert judged.tonight == ()
    assert {c.since for c in every_change(judged)} == {judged.compared_with[5].name}


def test_two_parts_that_change_at_once_are_both_suspects() -> None:
    changed = {"engine:mujoco", "adapter:mujoco"}
    new = tuple(dataclasses.replace(p, digest="ee") if p.name in changed else p for p in PARTS)
    history = history_of(measured(None), measured(PLANTED["tolerance x 3 in mujoco"]), parts={0: PARTS, 1: new})
    judged = judged_last(history)
    nights = {night.name: night for night in history}
    assert {s.name for s in suspects_of(judged.tonight[0], nights)} == changed


def test_a_part_without_digest_is_named_as_unknown() -> None:
    unknown = tuple(dataclasses.replace(p, digest="") for p in PARTS)
    figures = (measured(None), measured(PLANTED["tolerance x 3 in mujoco"]))
    history = history_of(*figures, parts={0: unknown, 1: unknown})
    judged = judged_last(history)
    change, nights = judged.tonight[-1], {night.name: night for night in history}
    assert suspects_of(change, nights) == ()
    assert "adapter:mujoco" in unknown_parts(change, nights)


def test_what_nothing_explains_says_so() -> None:
    history = history_of(measured(None), measured(PLANTED["tolerance x 3 in mujoco"]), parts={0: PARTS, 1: PARTS})
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
    told = [timed(1, 60, after, FigureKind.RATIO, 1.0 / 1.3)[0] for after in range(2, 10)]
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
