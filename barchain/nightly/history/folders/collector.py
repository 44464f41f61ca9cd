"""Figures as they are collected from stored tables: numbers that are none become missing figures with a reason."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from barchain.nightly.history.folders.merging import standing
from barchain.nightly.history.model.figures import Figure, FigureIdentity, FigureKind, FigureUnit
from barchain.nightly.history.model.parts import depends_on
from reports.tables.reading import brief

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

NO_NUMBER = "no number is stored"
STUDY_SEPARATOR = "."


class FigureCollector:
    """Figures of one study, each with the parts that it depends on."""

    def __init__(self, study: str = "") -> None:
        """Begin without figures; `study` begins the name of each quantity, so that studies don't collide."""
        self.study = study
        self.found: dict[FigureIdentity, Figure] = {}
        self.depends: dict[tuple[str, str, FigureKind, str], tuple[str, ...]] = {}

    def number(
        self, place: tuple[str, str, str], quantity: str, kind: FigureKind, value: Any, unit: str = "1",
        anchor: str = "", reason: str = "", **more: Any,
    ) -> None:  # fmt: skip
        """Add a number; one that is not finite is missing, for `reason`.

        Parameters
        ----------
        place : tuple of str
            Scene, engine and setting.
        quantity : str
        kind : FigureKind
        value : float
        unit, anchor, reason : str
        **more : Any
            `low`, `high`, `tolerance` and `trajectory` of the figure; ends that are not finite are none.
        """
        identity = self.identity(place, quantity, kind, unit, anchor)
        known = real(value)
        if known is None:
            self.keep(Figure(identity, reason=brief(reason) or NO_NUMBER, depends=self.parts(identity)))
            return
        low, high, tolerance = (real(more.get(name)) for name in ("low", "high", "tolerance"))
        trajectory = str(more.get("trajectory") or "")
        self.keep(Figure(identity, known, "", low, high, tolerance, trajectory, self.parts(identity)))

    def word(self, place: tuple[str, str, str], quantity: str, kind: FigureKind, word: str, reason: str = "") -> None:
        """Add a digest or an outcome; without one the figure is missing, for `reason`."""
        identity = self.identity(place, quantity, kind, "", "")
        said = brief(reason) or ("" if word else NO_NUMBER)
        self.keep(Figure(identity, word=word, reason=said, depends=self.parts(identity)))

    def counts(self, place: tuple[str, str, str], info: Mapping[str, Any], quantity: str = "") -> None:
        """Add the counters of a run; other entries are left out."""
        for name, value in info.items():
            known = real(value)
            if known is not None and known == int(known) and known >= 0.0 and not name.endswith("_s"):
                self.number(place, f"{quantity}{name}", FigureKind.COUNT, known)

    def identity(
        self, place: tuple[str, str, str], quantity: str, kind: FigureKind, unit: str, anchor: str
    ) -> FigureIdentity:
        """Identity of a figure of this study."""
        scene, engine, setting = map(brief, place)
        named = f"{self.study}{STUDY_SEPARATOR}{quantity}" if self.study else quantity
        return FigureIdentity(scene, engine, setting, brief(named), kind, FigureUnit(unit), brief(anchor))

    def parts(self, identity: FigureIdentity) -> tuple[str, ...]:
        """Parts that a figure depends on."""
        key = (identity.scene, identity.engine, identity.kind, identity.anchor)
        if key not in self.depends:
            self.depends[key] = depends_on(*key)
        return self.depends[key]

    def keep(self, figure: Figure) -> None:
        """Take a figure; of two of the same name the first counts, of two verdicts the graver one."""
        there = self.found.setdefault(figure.identity, figure)
        if there is not figure and figure.identity.kind is FigureKind.VERDICT:
            self.found[figure.identity] = standing(there, figure)

    @property
    def figures(self) -> tuple[Figure, ...]:
        """All figures."""
        return tuple(self.found.values())


def real(value: Any) -> float | None:
    """Finite number, or None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) else None


def records(frame: Any) -> Iterable[dict[str, Any]]:
    """Rows of a table as plain Python values."""
    rows: list[dict[str, Any]] = frame.to_dict("records")
    return rows
