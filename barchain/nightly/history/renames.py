"""Figures that go on under another name: in a scene of equal content, or at another value of their setting.

It is decided on the first night of the new name, and stands. A name that stays is the same figure.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from barchain.nightly.figures.figure import FigureKind

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from barchain.nightly.figures.figure import Figure, FigureIdentity
    from barchain.nightly.history.levels import Level


SCENE = "scene:"
"""Beginning of the names of parts that are scenes"""
PARAMETERS = frozenset(map(str, AccuracyParameter))
"""Parameters of settings; in some studies the place of a setting has a target or a size"""


class Role(Enum):
    """What stays of a figure that gets another name; the value has the words for it."""

    SCENE = "the scene {0.scene} became {1.scene}"
    """Its setting, in a scene of equal content"""
    SETTING = "the setting {0.setting} of {1.engine} became {1.setting}"
    """Its scene, at another value of the parameter"""
    BOTH = "the scene {0.scene} and the setting {0.setting} of {1.engine} became {1.scene} and {1.setting}"
    """The content of its scene, and the parameter"""

    def key(self, identity: FigureIdentity, content: str) -> FigureIdentity | None:
        """What stays of a figure whose scene has a content; None where it is not known, or there is no parameter.

        Bits are other ones at another setting.
        """
        parameter, given, _ = identity.setting.partition("=")
        known = given and parameter in PARAMETERS and identity.kind is not FigureKind.BITS
        if (self is not Role.SETTING and not content) or (self is not Role.SCENE and not known):
            return None
        return replace(
            identity,
            scene=identity.scene if self is Role.SETTING else content,
            setting=identity.setting if self is Role.SCENE else parameter,
        )


@dataclass(frozen=True)
class Renames:
    """Levels under the names of a night."""

    rows: dict[FigureIdentity, Level]
    words: tuple[str, ...] = ()
    settings: dict[tuple[str, str], tuple[str, str]] = field(default_factory=dict)
    """Old and new setting by scene and engine"""


def carried_on(
    rows: Mapping[FigureIdentity, Level], here: Mapping[FigureIdentity, Figure], contents: Mapping[str, str]
) -> Renames:
    """Levels under the names of a night.

    A figure continues another one if no other one of its role begins on the night, and no two of the role end on the
    same night. Of equal content and parameter only, all others of the role have to be gone.

    Parameters
    ----------
    rows : mapping
        Levels before the night.
    here : mapping
        Figures of the night.
    contents : mapping
        Digests of the night's scenes by name.
    """
    found = dict(rows)
    begins = [identity for identity, figure in here.items() if identity not in rows and not figure.not_run]
    if not begins or not rows:
        return Renames(found)
    fork_earlier_names(found, begins, here, contents)
    words: dict[str, None] = {}
    settings: dict[tuple[str, str], tuple[str, str]] = {}
    for role in Role:
        for old, new in pairs(role, found, begins, here, contents):
            row = found.pop(old)
            found[new] = renamed(row, new, (*row.earlier, (old, row.present)))
            words[role.value.format(old, new)] = None
            if old.setting != new.setting:
                both = old.setting, new.setting
                settings |= {(scene, new.engine): both for scene in (old.scene, new.scene)}
    for identity in [i for i in found if i.kind is FigureKind.BITS and i not in here]:
        if settings.get((identity.scene, identity.engine), ("",))[0] == identity.setting:
            del found[identity]  # the bits of another setting are a series of their own
    return Renames(found, tuple(words), settings)


def pairs(
    role: Role,
    rows: Mapping[FigureIdentity, Level],
    begins: Iterable[FigureIdentity],
    here: Mapping[FigureIdentity, Figure],
    contents: Mapping[str, str],
) -> list[tuple[FigureIdentity, FigureIdentity]]:
    """Names that end and those that continue them, in one role."""
    coming: dict[FigureIdentity, list[FigureIdentity]] = defaultdict(list)
    for identity in begins:
        key = role.key(identity, contents.get(identity.scene, "")) if identity not in rows else None
        if key is not None:
            coming[key].append(identity)
    ending: dict[FigureIdentity, list[FigureIdentity]] = defaultdict(list)
    staying: set[FigureIdentity] = set()
    for identity, row in rows.items() if coming else ():
        key = role.key(identity, row.content)
        if key in coming and identity in here:
            staying.add(key)
        elif key in coming:
            ending[key].append(identity)
    found = []
    for key, names in ending.items():
        latest = max(rows[name].present for name in names)
        last = [name for name in names if rows[name].present == latest]
        if len(last) == len(coming[key]) == 1 and not (role is Role.BOTH and (key in staying or len(names) > 1)):
            found.append((last[0], coming[key][0]))
    return found


def fork_earlier_names(
    rows: dict[FigureIdentity, Level],
    begins: Iterable[FigureIdentity],
    here: Mapping[FigureIdentity, Figure],
    contents: Mapping[str, str],
) -> None:
    """Begin a name that a figure had before, while the figure is there under its other name, at the figure's level."""
    known = {name: identity for identity, row in rows.items() if identity in here for name, _ in row.earlier}
    for identity in begins:
        if identity in known and rows[known[identity]].content == contents.get(identity.scene, ""):
            row = rows[known[identity]]
            there = row._replace(told=row.level, last=row.level, last_night=row.since, steps=(), better=(), seen=())
            rows[identity] = renamed(there, identity, ())


def renamed(row: Level, identity: FigureIdentity, earlier: tuple[tuple[FigureIdentity, str], ...]) -> Level:
    """Level under another name."""
    return row.mapped(lambda figure: replace(figure, identity=identity), earlier=earlier)
