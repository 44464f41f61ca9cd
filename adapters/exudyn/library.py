"""Exudyn itself, imported when it is first needed and with the user's own settings kept out."""

from __future__ import annotations

import os
from typing import Any

os.environ["EXUDYN_NO_USER_SETTINGS"] = "1"  # read when exudyn is imported; a user's defaults must not steer a run


def exu() -> Any:
    """Return the package; typed loosely, its own type stubs lag behind it."""
    import exudyn

    return exudyn


def items() -> Any:
    """Return the module of nodes, bodies, markers, connectors and sensors."""
    import exudyn.itemInterface

    return exudyn.itemInterface


def symbolic_function(mbs: Any, function: Any, name: str, item: str) -> Any:
    """Return the C++ form of a Python user function; it must be kept alive as long as the system."""
    from exudyn.advancedUtilities import CreateSymbolicUserFunction

    return CreateSymbolicUserFunction(mbs, function, name, itemTypeName=item)
