"""A figure goes on under another name; what a night told of it stands, whatever the names are used for later."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.nightly.figures.figure import Figure, NightPart
from barchain.nightly.figures.suspects import suspects_of
from barchain.nightly.history.acceptances import accept, accepted, accepting
from barchain.nightly.history.judging import changes_named, judge
from barchain.nightly.history.news import keep_judgement
from barchain.nightly.history.pruning import needed_nights
from barchain.nightly.history.standing import every_change, still_holding
from tests.nightly.history.noise import noise
from tests.nightly.history.synthetic import PARTS, bits, error, night, ratio

if TYPE_CHECKING:
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore

RIGHT, WRONG = 1e-5, 1e-3
LATER = datetime.datetime(2100, 1, 1, tzinfo=datetime.UTC)
BEGUN = 26
"""Night that is judged first, shortly before a step"""


def named(figure: Figure, scene: str, setting: str = "steps_per_orbit=1000") -> Figure:
    return replace(figure, identity=replace(figure.identity, scene=scene, setting=setting))


def parts_of(**contents: str) -> tuple[NightPart, ...]:
    return *PARTS, *(NightPart(f"scene:{scene}", "", content) for scene, content in contents.items())


def add(store: NightStore, number: int, *figures: Figure, **contents: str) -> JudgedNight:
    store.add(night(*figures, number=number, parts=parts_of(**contents)))
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
        assert every_change(judged) == []


@pytest.mark.parametrize("content", ["x", "y"])
def test_a_regression_holds_after_the_old_name_is_used_again(store: NightStore, content: str) -> None:
    worse_since_its_new_name(store)
    for k in range(4, 7):
        own = named(error(WRONG), "new"), named(error(RIGHT), "old")
        judged = add(store, k, *own, new="x", old=content)
        assert (judged.tonight, holding(judged)) == ((), [("new", "2026-01-04")])


@pytest.mark.parametrize("content", ["x", "y"])
def test_an_old_name_that_is_used_again_shares_no_later_change_with_the_renamed_figure(
    store: NightStore, content: str
) -> None:
    worse_since_its_new_name(store)
    for k in range(4, 7):
        again = error(2.0 * WRONG if k > 5 else RIGHT)
        judged = add(store, k, named(error(WRONG), "new"), named(again, "old"), new="x", old=content)
        assert judged.new == (k == 4 and content == "y")  # of another content it is a new figure
    assert [(c.identity.scene, c.names) for c in judged.tonight] == [("old", (judged.tonight[0].identity.name,))]
    accept(store, changes_named(judged, "old:*"), "me", "meant", pattern="old:*")
    (held,) = still_holding(judged)
    assert (held.identity.scene, accepting(held, accepted(store), LATER)) == ("new", None)


@pytest.mark.parametrize("gap", [1, 3])
def test_a_figure_that_comes_back_beside_a_copy_of_its_scene_is_judged_by_its_own_past(
    store: NightStore, gap: int
) -> None:
    for k in range(3):
        add(store, k, named(error(RIGHT), "own"), own="x")
    for k in range(3, 3 + gap):
        add(store, k, named(error(RIGHT), "copy"), copy="x")
    judged = add(store, 3 + gap, named(error(WRONG), "own"), named(error(RIGHT), "copy"), own="x", copy="x")
    assert [(c.identity.scene, str(c.direction)) for c in judged.tonight] == [("own", "worse")]


def test_a_name_that_stays_is_the_same_figure_also_where_its_scene_is_edited(store: NightStore) -> None:
    for k in range(3):
        add(store, k, named(error(RIGHT), "s"), s="x")
    judged = add(store, 3, named(error(RIGHT), "s-kept"), named(error(WRONG), "s"), **{"s-kept": "x", "s": "y"})
    assert [(c.identity.scene, str(c.direction)) for c in judged.tonight] == [("s", "worse")]
    assert judged.new == 1


def test_names_that_move_on_are_followed_by_their_contents(store: NightStore) -> None:
    for k in range(3):
        add(store, k, named(error(RIGHT), "old"), named(error(WRONG), "draft"), old="x", draft="z")
    for k in range(3, 6):
        add(store, k, named(error(RIGHT), "older"), named(error(WRONG), "draft"), older="x", draft="z")
    judged = add(store, 6, named(error(RIGHT), "older"), named(error(WRONG), "old"), older="x", old="z")
    assert (every_change(judged), judged.renamed) == ([], ("the scene draft became old",))


def test_what_changes_with_another_setting_has_the_setting_as_a_suspect(store: NightStore) -> None:
    for setting in ("steps_per_orbit=1000", "steps_per_orbit=500"):
        figure = named(error(RIGHT if setting.endswith("1000") else WRONG), "old", setting)
        judged = add(store, len(store.nights()), figure, old="x")
    (change,) = judged.tonight
    (suspect,) = suspects_of(change, judged.by_name)
    assert suspect.words == f"setting:{change.identity.engine} steps_per_orbit=1000 → steps_per_orbit=500"
    later = add(store, 2, named(error(WRONG), "old", "steps_per_orbit=250"), old="x")
    (change,) = still_holding(later)
    assert suspects_of(change, later.by_name) == (suspect,)


def test_the_bits_of_a_setting_that_an_engine_has_no_longer_are_not_missing(store: NightStore) -> None:
    for k in range(6):
        setting = f"steps_per_orbit={1000 if k < 3 else 2000}"
        judged = add(store, k, named(bits(setting), "s", setting), named(error(RIGHT), "s", setting), s="x")
        assert (judged.tonight, holding(judged)) == ((), [])


@pytest.mark.parametrize("setting", ["attitude<=1e-{}", "bars={}"])
def test_a_target_or_a_size_is_no_setting(store: NightStore, setting: str) -> None:
    add(store, 0, named(error(RIGHT), "s", setting.format(6)), s="x")
    judged = add(store, 1, named(error(WRONG), "s", setting.format(9)), s="x")
    assert (every_change(judged), judged.renamed, judged.new) == ([], (), 1)


def test_two_settings_that_become_one_continue_neither(store: NightStore) -> None:
    for k in range(3):
        add(store, k, *(named(error(RIGHT), "s", f"rtol=1e-{n}") for n in (6, 8)), s="x")
    judged = add(store, 3, named(error(WRONG), "s", "rtol=1e-7"), s="x")
    assert judged.renamed == ()


def test_pruning_keeps_the_nights_on_which_a_figure_got_another_name(store: NightStore) -> None:
    for k in range(8):
        scene, content = ("old", "x") if k < 3 else ("new", "x" if k < 5 else "y")
        add(store, k, named(error(RIGHT if k < 2 else WRONG), scene), **{scene: content})
    before = holding(judge(store))
    assert store.prune(keep=1, spared=needed_nights(store))
    assert holding(judge(store)) == before == [("new", "2026-01-03")]


def test_a_figure_that_gets_its_old_name_back_is_the_same_figure(store: NightStore) -> None:
    for k in range(12):
        scene, value = ("new", WRONG) if 3 <= k < 6 else ("old", RIGHT)
        judged = add(store, k, named(error(value), scene), **{scene: "x"})
        assert judged.renamed == {3: ("the scene old became new",), 6: ("the scene new became old",)}.get(k, ())
        assert judged.worse is (k == 3)
        assert holding(judged) == ([("new", "2026-01-04")] if k in {4, 5} else [])


def test_two_scenes_that_take_turns_are_two_scenes(store: NightStore) -> None:
    for k in range(8):
        scene, value = ("one", RIGHT) if k % 2 else ("other", WRONG)
        judged = add(store, k, named(error(value), scene), **{scene: f"content of {scene}"})
    assert (every_change(judged), judged.renamed) == ([], ())


def test_two_new_scenes_of_one_content_continue_none(store: NightStore) -> None:
    add(store, 0, named(error(RIGHT), "old"), old="x")
    judged = add(store, 1, named(error(WRONG), "a"), named(error(WRONG), "b"), a="x", b="x")
    assert (every_change(judged), judged.renamed, judged.new) == ([], (), 2)


@pytest.mark.parametrize("pattern", ["old:mujoco:steps_per_orbit=1000:attitude.max", "old:*"])
def test_an_accepted_change_stays_accepted_under_another_name(store: NightStore, pattern: str) -> None:
    for k in range(4):
        judged = add(store, k, named(error(RIGHT if k < 3 else WRONG), "old"), old="x")
    accept(store, changes_named(judged, pattern), "me", "meant", pattern=pattern)
    told = judged.tonight[0]
    judged = add(store, 4, named(error(WRONG), "new", "steps_per_orbit=1000"), new="x")
    judged = add(store, 5, named(error(WRONG), "new", "steps_per_orbit=500"), new="x")
    (change,) = still_holding(judged)
    assert change.identity.scene == "new"
    assert told.id in change.ids
    assert accepting(change, accepted(store), LATER) is not None


def test_a_step_that_a_night_told_is_held_under_another_name(store: NightStore) -> None:
    values = noise(24, 6, 60, 0.02, 0.3)
    values[0, 30:] += 0.08  # so small that most later nights would not tell it anew
    seen = []
    for k in range(42):
        scene = "old" if k < 36 else "new"
        own = [named(ratio(float(np.exp(row[k])), f"time_ratio.{q}"), scene) for q, row in enumerate(values)]
        if k < BEGUN:
            store.add(night(*own, number=k, parts=parts_of(**{scene: "x"})))
            continue
        judged = add(store, k, *own, **{scene: "x"})
        keep_judgement(store, judged)
        seen.append("told" if judged.worse else "holds" if still_holding(judged) else "")
    told = seen.index("told")
    assert told < 36 - BEGUN
    assert set(seen[:told]) == {""}
    assert set(seen[told + 1 :]) == {"holds"}
