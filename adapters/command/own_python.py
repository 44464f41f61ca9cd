"""Pythons of programs: environments with packages of their own, by their requirements."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from platformdirs import user_cache_path

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

VARIABLE = "BARCHAIN_ENVIRONMENTS"
READY = "ready.txt"
"""File of an environment that is whole"""
KEY = 20
REMOVED = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
"""Variables of this Python that another one must not have: it would import this one's packages"""


def environments_folder() -> Path:
    """Folder of all environments: by the variable, else in the user's cache."""
    given = os.environ.get(VARIABLE)
    return Path(given) if given else user_cache_path("barchain") / "environments"


def python_in(folder: Path) -> Path:
    """Interpreter of an environment."""
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def without_own(variables: Mapping[str, str]) -> dict[str, str]:
    """Variables of a process for another Python."""
    return {name: value for name, value in variables.items() if name not in REMOVED}


def environment_of(requirements: Sequence[str]) -> Path:
    """Folder of the environment with some packages, for the kind of Python that runs here; it need not be made yet."""
    key = json.dumps([sys.version, sys.platform, sorted(requirements)])
    return environments_folder() / f"own-{hashlib.sha256(key.encode()).hexdigest()[:KEY]}"
