"""Enumerations in words, and names as anchors and in narrow columns."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from markupsafe import Markup

if TYPE_CHECKING:
    from collections.abc import Sequence


def identifier(name: str) -> str:
    """Name of letters, digits, points, underscores and hyphens, different for each name, for use in an id."""
    return re.sub(r"[^A-Za-z0-9_.]", lambda m: "-" if m[0] == "/" else f"-{ord(m[0]):x}-", name)


def anchor(name: str) -> str:
    """Anchor of a scene, valid as an id."""
    return f"scene-{identifier(name)}"


def engine_anchor(name: str) -> str:
    """Anchor of an engine, valid as an id."""
    return f"engine-{identifier(name)}"


def run_anchor(scene: str, engine: str) -> str:
    """Anchor of an engine's run of a scene, valid as an id."""
    return f"{anchor(scene)}:{identifier(engine)}"


def joined(parts: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else "".join(parts)


def breakable(name: str, after: str = "/_") -> Markup:
    """Name that a narrow column breaks after the characters in `after`, a slash or an underscore by default."""
    ends = re.escape(after)
    return Markup("").join(
        Markup("{}<wbr>").format(part) for part in re.findall(rf"[^{ends}]*[{ends}]|[^{ends}]+", name)
    )
