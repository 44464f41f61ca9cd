"""Import of Exudyn on first use, without the user's own settings."""

from __future__ import annotations

import os
from typing import Any

os.environ["EXUDYN_NO_USER_SETTINGS"] = "1"  # read when exudyn is imported; a user's defaults must not steer a run


def exu() -> Any:
    """The package exudyn; its own type stubs are incomplete."""
    import exudyn

    return exudyn


def items() -> Any:
    """Module of nodes, bodies, markers, connectors and sensors."""
    import exudyn.itemInterface

    return exudyn.itemInterface


def symbolic_function(mbs: Any, function: Any, name: str, item: str) -> Any:
    """C++ form of a Python user function; the caller must keep a reference as long as the system exists."""
    from exudyn.advancedUtilities import CreateSymbolicUserFunction

    return CreateSymbolicUserFunction(mbs, function, name, itemTypeName=item)
