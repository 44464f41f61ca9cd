"""Figures that go on under another name: in a scene of equal content, or at another value of their setting.

Whether a figure continues another one is decided on its first night, from that night and the earlier ones. Later nights
change nothing of it: what a night told of a renamed figure stands, whatever the old name is used for afterwards.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.nightly.figures import FigureKind, FigureSeries

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.changes import Change
    from barchain.nightly.figures import FigureIdentity, NightSummary
    from barchain.nightly.vanished import Presence


SCENE = "scene:"
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


class Piece(NamedTuple):
    """Name of a figure from a night on."""

    number: int
    """Of the identity"""
    begin: int
    """Place of the night"""


class Lineages:
    """Names of each figure over some nights."""

    def __init__(self, nights: Sequence[NightSummary], presence: Presence) -> None:
        """Find which figures continue others.

        Parameters
        ----------
        nights : sequence of NightSummary
            In their order.
        presence : Presence
            Which figures are there, on these nights and maybe others.
        """
        self.nights, self.presence, self.identities = nights, presence, list(presence.number)
        place = {night.name: k for k, night in enumerate(presence.nights)}
        self.columns = [place[night.name] for night in nights]
        self.there = presence.there[:, self.columns]
        self.contents, self.unknown = contents_of(nights), np.full(len(nights), -1, np.int32)
        self.pieces: dict[int, list[Piece]] = {}
        """Names of each figure in their order, of those that continue others, and of those whose name is used again"""
        self.after: dict[int, int] = {}
        """Number of the figure that a figure goes on as, of those that are not there any more"""
        self.renames: dict[tuple[str, str], None] = {}
        """First nights of other names, and the words for them"""
        self.settings: dict[tuple[str, str], dict[str, tuple[str, ...]]] = defaultdict(dict)
        """Old and new setting by the first night of the new one, by scene and engine"""
        self.said: set[str] = set()
        """Words for the figures that could continue one another, and are followed now"""
        for own in self.alike():
            self.follow(own)

    def alike(self) -> Iterable[list[int]]:
        """Figures that could continue one another: equal but for their settings' values, and scenes of some content."""
        scenes = same_scenes(self.contents)
        groups: dict[FigureIdentity, list[int]] = defaultdict(list)
        for k in np.flatnonzero(self.there.any(axis=1)).tolist():
            identity = self.identities[k]
            scene, setting = scenes.get(identity.scene, identity.scene), parameter_of(identity) or identity.setting
            groups[replace(identity, scene=scene, setting=setting)].append(k)
        return (own for own in groups.values() if len(own) > 1)

    def follow(self, own: Sequence[int]) -> None:
        """Follow the nights on which a name begins, has another content, or comes back after it was continued."""
        coming = {(at, k) for k in own for at in self.turns(k)}
        begun: set[int] = set()
        self.said = set()
        while coming:
            at = min(coming)[0]
            new = {k for night, k in coming if night == at}
            if at:
                self.decide(new, begun, at)
            begun |= new
            coming = {each for each in coming if each[0] > at}
            for old in begun & self.after.keys():
                later = np.flatnonzero(self.there[old, at + 1 :])
                coming |= {(at + 1 + int(k), old) for k in later[:1]}

    def turns(self, number: int) -> list[int]:
        """Nights on which a name begins, or has another content than on its night before."""
        at = np.flatnonzero(self.there[number])
        before = np.concatenate([at[:1] - 1, at[:-1]])
        content = self.content(number)
        found: list[int] = at[(before < at[0]) | (content[at] != content[before])].tolist()
        return found

    def decide(self, new: set[int], begun: set[int], at: int) -> None:
        """Decide what the new names of a night are.

        A name that comes back with its content is the figure that had it. Any other one continues the last figure of
        its role that is gone: not there, or there with another content. Else it is the figure that had the name, unless
        another one continues that, or a new one.
        """
        edited = [k for k in sorted(new) if k not in begun or self.is_edited(k, at)]
        for k in sorted(new.difference(edited)):
            end = self.end(k)
            self.after.pop(k, None)
            if end != k and not self.there[end, at]:
                self.after[end] = k
                self.tell(end, k, self.same_role(end, k), at)
        continued = {k for k in edited if self.after.pop(k, k) != k}
        found = self.continuations(edited, begun - continued, at)
        names = {old: self.names(old) for old, _, _ in found}
        for old, figure, role in found:
            self.pieces[figure] = [*names[old], Piece(figure, at)]
            self.after |= {} if self.there[old, at] else {old: figure}
            self.tell(old, figure, role, at)
        anew = continued | {old for old in names if self.there[old, at]}
        self.pieces |= {k: [Piece(k, at)] for k in anew.difference(figure for _, figure, _ in found)}

    def same_role(self, old: int, figure: int) -> Role:
        """What stays of a figure whose earlier name is there again."""
        one, other = self.identities[old], self.identities[figure]
        return Role.SETTING if one.scene == other.scene else Role.SCENE if one.setting == other.setting else Role.BOTH

    def tell(self, old: int, figure: int, role: Role, at: int) -> None:
        """Keep the words for another name, once: names may take turns."""
        before, after = self.identities[old], self.identities[figure]
        for scene in {before.scene, after.scene} if role is not Role.SCENE else ():
            self.settings[scene, after.engine][self.nights[at].name] = before.setting, after.setting
        words = role.value.format(before, after)
        if words not in self.said:
            self.renames[self.nights[at].name, words] = None
            self.said.add(words)

    def other_settings(self, change: Change) -> tuple[str, ...]:
        """Old and new setting of an engine that has another one in a scene since a change; empty without one."""
        known = self.settings.get((change.identity.scene, change.identity.engine), {})
        return next((known[night] for night in reversed(known) if change.last < night <= change.since), ())

    def is_edited(self, number: int, at: int) -> bool:
        """Whether the content of a figure's scene is another one than on the figure's night before."""
        content = self.content(number)
        return bool(content[at] != content[self.last(number, at - 1)])

    def continuations(self, new: Sequence[int], begun: Iterable[int], at: int) -> list[tuple[int, int, Role]]:
        """Old and new figures of a night, and the role that stays.

        A figure continues another one if no other one of its role begins on the night, and no two of the role end on
        the same night. Of equal content and parameter only, all others of the role have to be gone.
        """
        found: list[tuple[int, int, Role]] = []
        left, known = list(new), [k for k in sorted(begun) if k not in self.after]
        for role in Role:
            roles: dict[Hashable, list[int]] = defaultdict(list)
            for k in left:
                roles[self.role(role, k, at)].append(k)
            taken = {old for old, _, _ in found}
            for key, (figure, *others) in roles.items():
                last = {k: self.last(k, at - 1) for k in known if k != figure and k not in taken}
                alike = [k for k, before in last.items() if self.role(role, k, before) == key]
                gone = [k for k in alike if not self.there[k, at] or (k in new and role is Role.SCENE)]
                ends = [last[k] for k in gone]
                several = ends.count(max(ends, default=-1)) > 1
                if key is not None and gone and not others and not several and (gone == alike or role is not Role.BOTH):
                    found.append((max(gone, key=lambda k: last[k]), figure, role))
                    left.remove(figure)
        return found

    def role(self, role: Role, number: int, at: int) -> Hashable:
        """Role of a figure on a night; None where the content of its scene, or a setting, is not known.

        The bits of a trajectory stay the same in a scene of equal content alone.
        """
        identity = self.identities[number]
        content, parameter = int(self.content(number)[at]), parameter_of(identity)
        if (role is not Role.SETTING and content < 0) or (role is not Role.SCENE and not parameter):
            return None
        scene = identity.scene if role is Role.SETTING else content
        return scene, identity.setting if role is Role.SCENE else parameter

    def content(self, number: int) -> NDArray[np.int32]:
        """Number of the content of a figure's scene on each night, -1 where it is not known."""
        return self.contents.get(self.identities[number].scene, self.unknown)

    def last(self, number: int, at: int) -> int:
        """Place of the last night of a figure up to one."""
        return int(np.flatnonzero(self.there[number, : at + 1])[-1])

    def end(self, number: int) -> int:
        """Figure that a figure goes on as in the end."""
        while number in self.after:
            number = self.after[number]
        return number

    def names(self, number: int) -> list[Piece]:
        """Names of a figure in their order."""
        return self.pieces.get(number, [Piece(number, 0)])

    def places(self, number: int) -> Iterable[tuple[int, range]]:
        """Numbers of the names of a figure, and the places of the nights on which it has them."""
        own = self.names(number)
        for piece, end in zip(own, [*(later.begin for later in own[1:]), len(self.nights)], strict=True):
            yield piece.number, range(piece.begin, end)

    @property
    def borders(self) -> NDArray[np.bool_]:
        """Last night of each name and the first of the next, among the nights of the presence, (figures, nights)."""
        found = np.zeros_like(self.presence.there)
        for number in self.pieces:
            for name, places in self.places(number):
                own = np.flatnonzero(self.there[name, places.start : places.stop]) + places.start
                found[name, [self.columns[own[0]], self.columns[own[-1]]]] = True
        return found


def contents_of(nights: Sequence[NightSummary]) -> dict[str, NDArray[np.int32]]:
    """Numbers of the contents of each scene, (nights,), equal for equal contents; -1 where it is not known."""
    found: dict[str, NDArray[np.int32]] = {}
    numbers: dict[str, int] = {}
    for k, night in enumerate(nights):
        for part in night.parts:
            if part.name.startswith(SCENE) and part.digest:
                name = part.name.removeprefix(SCENE)
                own = found.setdefault(name, np.full(len(nights), -1, np.int32))
                own[k] = numbers.setdefault(part.digest, len(numbers))
    return found


def same_scenes(contents: Mapping[str, NDArray[np.int32]]) -> dict[str, str]:
    """One name for all scenes that ever had an equal content, by name."""
    names = {scene: scene for scene in contents}
    owner: dict[int, str] = {}
    for scene, numbers in contents.items():
        for content in np.unique(numbers[numbers >= 0]).tolist():
            one, other = names[scene], names[owner.setdefault(content, scene)]
            if one != other:
                names = {each: other if same == one else same for each, same in names.items()}
    return names


def parameter_of(identity: FigureIdentity) -> str:
    """Parameter of a figure's setting; empty without one, and of bits, which are other ones at another setting."""
    name, given, _ = identity.setting.partition("=")
    return name if given and name in PARAMETERS and identity.kind is not FigureKind.BITS else ""


def continued(series: Sequence[FigureSeries], lineages: Lineages) -> list[FigureSeries]:
    """Series, each with the earlier nights of those that it continues; these are no series of their own."""
    known = {one.identity: one for one in series}
    found = []
    for one in series:
        number = lineages.presence.number[one.identity]
        if number not in lineages.after:
            found.append(one_series(number, lineages, known) if number in lineages.pieces else one)
    return found


def one_series(number: int, lineages: Lineages, known: Mapping[FigureIdentity, FigureSeries]) -> FigureSeries:
    """Series of a figure of several names, with the last one."""
    last, rows, names = lineages.identities[number], [], []
    for k, places in lineages.places(number):
        own = known.get(lineages.identities[k])
        names.append((lineages.identities[k], lineages.nights[lineages.last(k, places[-1])].name))
        among = {lineages.nights[place].name for place in places}
        rows += [row for row in zip(own.nights, own.figures, strict=True) if row[0].name in among] if own else []
    figures = tuple(replace(figure, identity=last) for _, figure in rows)
    return FigureSeries(last, tuple(night for night, _ in rows), figures, tuple(names[:-1]))
