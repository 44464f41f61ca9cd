"""Figures that go on under another name: in a scene of equal content, or at another value of their setting.

Whether a figure continues another one is decided on its first night, from that night and the earlier ones. Later nights
change nothing of it: what a night told of a renamed figure stands, whatever the old name is used for afterwards.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from barchain.nightly.figures import FigureSeries

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures import FigureIdentity, NightSummary
    from barchain.nightly.vanished import Presence


SCENE = "scene:"


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
        self.pieces: dict[int, list[Piece]] = {}
        """Names of each figure in their order, of those that continue others"""
        self.after: dict[int, int] = {}
        """Number of the figure that continues another one"""
        self.renames: dict[tuple[str, str], None] = {}
        """First nights of other names, and the words for them"""
        for own in self.alike():
            self.follow(own)

    def alike(self) -> Iterable[list[int]]:
        """Figures that could continue one another: equal but for their settings' values, and scenes of some content."""
        scenes = same_scenes(self.nights)
        groups: dict[FigureIdentity, list[int]] = defaultdict(list)
        for k in np.flatnonzero(self.there.any(axis=1)).tolist():
            identity = self.identities[k]
            scene, parameter = scenes.get(identity.scene, identity.scene), identity.setting.partition("=")[0]
            groups[replace(identity, scene=scene, setting=parameter)].append(k)
        return (own for own in groups.values() if len(own) > 1)

    def follow(self, own: Sequence[int]) -> None:
        """Follow the nights on which a figure begins, or its name comes back after another one has continued it."""
        coming = [(int(self.there[k].argmax()), k) for k in own]
        heapq.heapify(coming)
        begun: list[int] = []
        while coming:
            at, new = coming[0][0], []
            while coming and coming[0][0] == at:
                new.append(heapq.heappop(coming)[1])
            back = [k for k in new if k in self.after]
            found = self.continuations(new, begun, at) if at else ()
            for k in back:
                self.pieces[k] = [Piece(k, at)]
            for old, figure, role in found:
                self.pieces[figure] = [*self.names(old), Piece(figure, at)]
                self.after[old] = figure
                words = role.value.format(self.identities[old], self.identities[figure])
                self.renames[self.nights[at].name, words] = None
                later = np.flatnonzero(self.there[old, at:])
                if len(later):
                    heapq.heappush(coming, (at + int(later[0]), old))
            begun += [k for k in new if k not in begun]

    def continuations(self, new: list[int], begun: Sequence[int], at: int) -> list[tuple[int, int, Role]]:
        """Old and new figures of a night, and the role that stays.

        A figure continues the last one of its role that is not there any more, if no other one of the role begins on
        the same night. Of equal content and parameter only, all others of the role have to be gone. A name that comes
        back continues the figure that had it, if that is gone; else it is the name of a new figure.
        """
        ends = {k: self.end(k) for k in new if k in self.after}
        for k in ends:
            del self.after[k]
        found, left = [], list(new)
        for role in Role:
            roles: dict[Hashable, list[int]] = defaultdict(list)
            for k in left:
                roles[self.role(role, k, at)].append(k)
            for key, (figure, *others) in roles.items():
                known = [ends[figure]] if figure in ends else [k for k in begun if k not in self.after]
                alike = [k for k in known if self.role(role, k, self.last(k, at)) == key and k != figure]
                gone = [k for k in alike if not self.there[k, at]]
                if key is not None and gone and not others and (gone == alike or role is not Role.BOTH):
                    old = max(gone, key=lambda k: self.last(k, at))
                    found.append((old, figure, role))
                    self.after[old] = figure
                    left.remove(figure)
        return found

    def role(self, role: Role, number: int, at: int) -> Hashable:
        """Role of a figure on a night; None where the content of its scene, or a setting, is not known."""
        identity = self.identities[number]
        parameter, given, _ = identity.setting.partition("=")
        part = self.nights[at].part_named.get(f"{SCENE}{identity.scene}")
        scene = identity.scene if role is Role.SETTING else part and part.digest
        setting = identity.setting if role is Role.SCENE else given and parameter
        return (scene, setting) if scene and (setting or role is Role.SCENE) else None

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


def same_scenes(nights: Iterable[NightSummary]) -> dict[str, str]:
    """One name for all scenes that ever had an equal content, by name."""
    contents: dict[str, str] = {}
    names: dict[str, str] = {}
    parts = {part for night in nights for part in night.parts if part.name.startswith(SCENE) and part.digest}
    for part in sorted(parts, key=lambda part: (part.name, part.digest)):
        name = part.name.removeprefix(SCENE)
        own = names.setdefault(name, name)
        other = contents.setdefault(part.digest, own)
        if other != own:
            names = {scene: other if same == own else same for scene, same in names.items()}
            contents = {digest: other if same == own else same for digest, same in contents.items()}
    return names


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
