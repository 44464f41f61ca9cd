"""Functions of higher packages that show or complete objects: registered by name, and imported on first use.

They draw objects in notebooks, and compute derived channels of a trajectory.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

RENDERERS = {"scene_file": "scenarios.toml.changing:scene_file"}
"""``module:function`` of each kind of object; that of a scene's file is always there"""


def register(renderers: Mapping[str, str]) -> None:
    """Register renderers, as ``module:function`` by the kind of object; nothing is imported."""
    RENDERERS.update(renderers)


def renderer(kind: str) -> Callable[..., Any] | None:
    """Renderer of a kind of object; None where none is registered."""
    module, _, name = RENDERERS.get(kind, "").partition(":")
    return getattr(import_module(module), name) if module else None


def html(kind: str, *shown: object) -> str | None:
    """HTML of an object; None where no renderer is registered: a notebook then shows the object's text."""
    found = renderer(kind)
    return None if found is None else str(found(*shown))
