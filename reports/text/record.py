"""What a record tells of a study and of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from reports.text.numerals import number
from reports.text.words import written

LEAST_ORBITS = 0.25  # a shorter time is told in seconds


def is_complete(record: dict[str, Any]) -> bool:
    """Whether every result of a study is there; its report is rendered before the record says finished."""
    parts = (record.get("parts") or {}).values()
    return bool(record.get("complete") or record.get("finished")) and all(part.get("complete") for part in parts)


@dataclass(frozen=True)
class SceneRecord:
    """Record of a scene."""

    name: str
    data: dict[str, Any]

    def text(self, key: str) -> str:
        """Text of a key, formulas in typographic form; empty without it."""
        value = self.data.get(key)
        return "" if value is None else written(str(value))

    def value(self, key: str) -> float | None:
        """Number of a key; None without it."""
        return number(self.data.get(key))

    def values(self, key: str) -> list[float]:
        """Numbers of a key's list."""
        return [float(v) for v in self.data.get(key) or ()]

    @property
    def title(self) -> str:
        """Title; the name of a scene without one."""
        return self.text("title") or self.name

    @property
    def tags(self) -> list[str]:
        """Tags of the scene."""
        return self.lines("tags")

    def lines(self, key: str) -> list[str]:
        """Texts of a key's list."""
        return [written(str(t)) for t in self.data.get(key) or ()]

    @property
    def period_s(self) -> float:
        """Orbital period, unit of time of the charts, s; 0 if unknown."""
        return self.value("period_s") or 0.0

    @property
    def closed(self) -> bool:
        """Whether the orbit is closed: with gravity, and below the escape speed."""
        speed = self.value("speed_factor") or 0.0
        return self.period_s > 0.0 and self.text("gravity") != "none" and speed**2 < 2.0

    @property
    def in_orbits(self) -> bool:
        """Whether times of the run are told in orbits: a run of less than a quarter of one is told in seconds."""
        return self.closed and (self.value("duration_s") or self.period_s) >= LEAST_ORBITS * self.period_s

    @property
    def prescribed(self) -> list[dict[str, Any]]:
        """Prescribed rotations."""
        return self.data.get("prescribed") or []
