"""What run.json says, read leniently: a record that was cut off or is older still renders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from reports.text.mathematics import written
from reports.text.numerals import number


def mapping(value: object) -> dict[str, Any]:
    """Return `value` if it is a mapping, an empty one otherwise."""
    return value if isinstance(value, dict) else {}


def rows(value: object) -> list[dict[str, Any]]:
    """Return the mappings in a list; none if it is no list."""
    return [v for v in value if isinstance(v, dict)] if isinstance(value, list) else []


@dataclass(frozen=True)
class SceneRecord:
    """What the record says of a scene."""

    name: str
    data: dict[str, Any]

    def text(self, key: str) -> str:
        """Text of a key, its formulas as people write them; empty if it is not there."""
        value = self.data.get(key)
        return "" if value is None else written(str(value))

    def value(self, key: str) -> float | None:
        """Return a key's number; None if it is not there."""
        return number(self.data.get(key))

    def values(self, key: str) -> list[float]:
        """Return a key's list of numbers."""
        found = self.data.get(key)
        return [v for v in map(number, found) if v is not None] if isinstance(found, list) else []

    @property
    def title(self) -> str:
        """Title for people; the name where there is none."""
        return self.text("title") or self.name

    @property
    def tags(self) -> list[str]:
        """Tags of the scene."""
        return self.lines("tags")

    def lines(self, key: str) -> list[str]:
        """Return a key's list of texts."""
        found = self.data.get(key)
        return [written(str(t)) for t in found] if isinstance(found, list) else []

    @property
    def period_s(self) -> float:
        """Unit in which plots count time; 0 if it is not known."""
        return self.value("period_s") or 0.0

    @property
    def closed(self) -> bool:
        """Whether the orbit returns: something pulls, and the speed is below that of escape."""
        speed = self.value("speed_factor") or 0.0
        return self.period_s > 0.0 and self.text("gravity") != "none" and speed**2 < 2.0

    @property
    def prescribed(self) -> list[dict[str, Any]]:
        """Prescribed rotations."""
        return rows(self.data.get("prescribed"))

    @property
    def model_difference(self) -> dict[str, Any]:
        """Declared difference of models: ``com_m``, ``note``."""
        return mapping(self.data.get("model_difference"))
