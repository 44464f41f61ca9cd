"""Folder of machine code on disk.

A file is named by the hash of everything that decides its contents and begins with the hash of the rest, so that a
damaged or foreign file is noticed and compiled anew. A folder that can't be written costs the compilation only.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from pathlib import Path

from platformdirs import user_cache_path

PLACE = "BARCHAIN_COMPILED"
"""Environment variable: folder of compiled code, by default in the user's cache"""
TITLE = b"barchain machine code 1\n"
SUFFIX = ".o"


def folder() -> Path:
    """Folder of compiled code."""
    given = os.environ.get(PLACE)
    return Path(given) if given else user_cache_path("barchain") / "compiled"


def read(key: str) -> bytes | None:
    """Machine code kept under a key; None if there is none, or it is damaged."""
    try:
        content = (folder() / f"{key}{SUFFIX}").read_bytes()
    except OSError:
        return None
    head = len(TITLE) + hashlib.sha256().digest_size
    if content[: len(TITLE)] != TITLE or content[len(TITLE) : head] != hashlib.sha256(content[head:]).digest():
        return None
    return content[head:]


def write(key: str, code: bytes) -> None:
    """Keep machine code under a key, atomically; a folder that can't be written is left alone."""
    with contextlib.suppress(OSError):
        folder().mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=folder(), suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(TITLE + hashlib.sha256(code).digest() + code)
            Path(name).replace(folder() / f"{key}{SUFFIX}")
        except OSError:
            Path(name).unlink(missing_ok=True)
            raise
