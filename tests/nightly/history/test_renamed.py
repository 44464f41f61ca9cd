"""A figure goes on under another name; what a night told of it stands, whatever the names are used for later."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.nightly.acceptances import accept, accepted, accepting
from barchain.nightly.figures import Figure, NightPart
from barchain.nightly.judging import changes_named, judge, still_holding
from barchain.nightly.table import DENSE_NIGHTS
from barchain.nightly.told import keep_judgement
from tests.nightly.history.noise import noise
from tests.nightly.history.synthetic import PARTS, error, night, ratio

if TYPE_CHECKING:
    from barchain.nightly.changes import JudgedNight
    from barchain.nightly.history import NightStore

RIGHT, WRONG = 1e-5, 1e-3
LATER = datetime.datetime(2100, 1, 1, tzinfo=datetime.UTC)


def named(figure: Figure, scene: str, setting: str = "steps_per_orbit=1000") -> Figure:
    return replace(figure, identity=replace(figure.identity, scene=scene, setting=setting))


def add(store: NightStore, number: int, *figures: Figure, **contents: str) -> JudgedNight:
    parts = (*PARTS, *(NightPart(f"scene:{scene}", "", content) for scene, content in contents.items()))
    store.add(night(*figures, number=number, parts=parts))
    return judge(store)


def holding(judged: JudgedNight) -> list[tuple[str, str]]:
    return [(change.identity.scene, change.since[:10]) for change in still_holding(judged)]


def worse_since_its_new_name(store: NightStore) -> None:
    for k in range(3):
        add(store, k, named(error(RIGHT), "old"), old="x")
    assert add(store, 3, named(error(WRONG), "new"), new="x").worse


def test_a_regression_holds_after_the_renamed_scene_is_edited(store: NightStore) -> None:
    worse_since_its_new_name(store)
    for k in range(4, 7):
        assert holding(add(store, k, named(error(WRONG), "new"), new="y")) == [("new", "2026-01-04")]


def test_a_sound_figure_is_not_missing_after_the_renamed_scene_is_edited(store: NightStore) -> None:
    for k in range(9):
        scene, content = ("old", "x") if k < 3 else ("new", "x" if k < 6 else "y")
        judged = add(store, k, named(error(RIGHT), scene), **{scene: content})
        assert judged.changes == ()


@pytest.mark.parametrize("content", ["x", "y"])
def test_a_regression_holds_after_the_old_name_is_used_again(store: NightStore, content: str) -> None:
    worse_since_its_new_name(store)
    for k in range(4, 7):
        own = named(error(WRONG), "new"), named(error(RIGHT), "old")
        judged = add(store, k, *own, new="x", old=content)
        assert (judged.tonight, holding(judged)) == ((), [("new", "2026-01-04")])


def test_a_new_figure_under_an_old_name_shares_no_change_with_the_renamed_one(store: NightStore) -> None:
    worse_since_its_new_name(store)
    for k in range(4, 7):
        judged = add(
            store, k, named(error(WRONG), "new"), named(error(2.0 * WRONG if k > 5 else WRONG), "old"), new="x", old="x"
        )
        assert judged.new == (k == 4)
    assert [(c.identity.scene, c.names) for c in judged.tonight] == [("old", (judged.tonight[0].identity.name,))]
    accept(store, changes_named(judged, "old:*"), "me", "meant", pattern="old:*")
    (held,) = still_holding(judged)
    assert (held.identity.scene, accepting(held, accepted(store), LATER)) == ("new", None)


def test_a_regression_holds_after_the_old_setting_is_used_again(store: NightStore) -> None:
    for k in range(3):
        add(store, k, named(error(RIGHT), "s", "tolerance=1e-6"))
    for k in range(3, 9):
        again = [named(error(RIGHT), "s", "tolerance=1e-6")] if k > 5 else []
        judged = add(store, k, named(error(WRONG), "s", "tolerance=1e-8"), *again)
    assert holding(judged) == [("s", "2026-01-04")]


def test_a_figure_that_gets_its_old_name_back_is_the_same_figure(store: NightStore) -> None:
    nights = 3 * DENSE_NIGHTS
    for k in range(nights):
        scene, value = ("new", WRONG) if 3 <= k < 6 else ("old", RIGHT)
        judged = add(store, k, named(error(value), scene), **{scene: "x"})
    assert [(c.last[:10], c.since[:10], str(c.direction)) for c in judged.changes] == [
        ("2026-01-03", "2026-01-04", "worse"), ("2026-01-06", "2026-01-07", "better"),
    ]  # fmt: skip


def test_two_scenes_that_take_turns_are_two_scenes(store: NightStore) -> None:
    for k in range(8):
        scene, value = ("one", RIGHT) if k % 2 else ("other", WRONG)
        judged = add(store, k, named(error(value), scene), **{scene: f"content of {scene}"})
    assert (judged.changes, judged.renamed) == ((), ())


def test_two_new_scenes_of_one_content_continue_none(store: NightStore) -> None:
    add(store, 0, named(error(RIGHT), "old"), old="x")
    judged = add(store, 1, named(error(WRONG), "a"), named(error(WRONG), "b"), a="x", b="x")
    assert (judged.changes, judged.renamed, judged.new) == ((), (), 2)


@pytest.mark.parametrize("pattern", ["old:mujoco:steps_per_orbit=1000:attitude.max", "old:*"])
def test_an_accepted_change_stays_accepted_under_another_name(store: NightStore, pattern: str) -> None:
    for k in range(4):
        judged = add(store, k, named(error(RIGHT if k < 3 else WRONG), "old"), old="x")
    accept(store, changes_named(judged, pattern), "me", "meant", pattern=pattern)
    told = judged.tonight[0]
    judged = add(store, 4, named(error(WRONG), "new", "steps_per_orbit=1000"), new="x")
    judged = add(store, 5, named(error(WRONG), "new", "steps_per_orbit=500"), new="x")
    (change,) = still_holding(judged)
    assert (change.identity.scene, change.id) == ("new", told.id)
    assert accepting(change, accepted(store), LATER) is not None


def test_a_step_that_a_night_told_is_held_under_another_name(store: NightStore) -> None:
    values = noise(24, 6, 60, 0.02, 0.3)
    values[0, 30:] += 0.08  # so small that most later nights would not tell it anew
    seen = []
    for k in range(45):
        scene = "old" if k < 36 else "new"
        own = [named(ratio(float(np.exp(row[k])), f"time_ratio.{q}"), scene) for q, row in enumerate(values)]
        judged = add(store, k, *own, **{scene: "x"})
        keep_judgement(store, judged)
        seen.append("told" if judged.worse else "holds" if still_holding(judged) else "")
    told = seen.index("told")
    assert told < 36
    assert set(seen[:told]) == {""}
    assert set(seen[told + 1 :]) == {"holds"}
