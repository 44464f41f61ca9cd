"""Figures that go on under another name: of another setting of the same parameter, or of a scene of equal content.

Their role is the same, so that they are compared; as names alone, one would be missing and the other new.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.nightly.history.model.series_model import FigureSeries

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.model.figures import FigureIdentity

    Role = tuple[str, ...]


@dataclass(frozen=True)
class Rename:
    """Name under which figures go on."""

    since: str
    """Name of the first night with the new name"""
    words: str


def continued(series: Sequence[FigureSeries]) -> tuple[list[FigureSeries], list[Rename]]:
    """Series, each with the nights of the one that it continues, and the renames.

    A series continues the last one of its role that ended before it began, if no other one began on its first night.
    """
    found = {one.identity: one for one in series}
    renames: dict[Rename, None] = {}
    for role, words in ((of_scene, scene_words), (of_setting, setting_words)):
        roles: dict[Role, list[FigureIdentity]] = defaultdict(list)
        for one in found.values():
            key = role(one)
            if key is not None:
                roles[key].append(one.identity)
        for names in roles.values():
            for name in sorted(names, key=lambda each: found[each].nights[0].started) if len(names) > 1 else ():
                own = [found[each] for each in names if each in found]
                new, old = found[name], before(found[name], own)
                if old is not None:
                    found[name] = joined(found.pop(old.identity), new)
                    renames[Rename(new.nights[0].name, words(old, new))] = None
    return list(found.values()), list(renames)


def before(new: FigureSeries, own: Sequence[FigureSeries]) -> FigureSeries | None:
    """Series that a new one continues; None if there is none, or several began on its night."""
    first = new.nights[0]
    if sum(one.nights[0].name == first.name for one in own) > 1:
        return None
    ended = [one for one in own if one.nights[-1].started < first.started]
    return max(ended, key=lambda one: one.nights[-1].started, default=None)


def joined(old: FigureSeries, new: FigureSeries) -> FigureSeries:
    """Series with the nights of the one before it."""
    earlier = tuple(replace(figure, identity=new.identity) for figure in old.figures)
    return FigureSeries(new.identity, (*old.nights, *new.nights), (*earlier, *new.figures))


def of_scene(one: FigureSeries) -> Role | None:
    """Role of a figure in a scene of some content; None where the content is not known."""
    i = one.identity
    part = one.nights[-1].part_named.get(f"scene:{i.scene}")
    if part is None or not part.digest:
        return None
    return part.digest, i.engine, i.setting, i.quantity, i.kind, i.unit, i.anchor


def of_setting(one: FigureSeries) -> Role | None:
    """Role of a figure at any value of its setting's parameter; None of a figure without one."""
    i = one.identity
    parameter, given, _ = i.setting.partition("=")
    return (i.scene, i.engine, parameter, i.quantity, i.kind, i.unit, i.anchor) if given else None


def scene_words(old: FigureSeries, new: FigureSeries) -> str:
    """Rename of a scene in words."""
    return f"the scene {old.identity.scene} became {new.identity.scene}"


def setting_words(old: FigureSeries, new: FigureSeries) -> str:
    """Change of a setting in words."""
    return f"the setting {old.identity.setting} of {new.identity.engine} became {new.identity.setting}"
