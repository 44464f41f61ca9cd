"""Digest of content: equal for equal data, on every machine."""

from __future__ import annotations

import dataclasses
import datetime
import hashlib
import json


def content_digest(content: object) -> str:
    """Hash of dataclasses, lists and plain values; numbers count with all their digits."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), default=plain, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def plain(value: object) -> object:
    """Fields of a dataclass, or a date as text."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, datetime.datetime):
        return value.isoformat()
    raise TypeError(f"{type(value).__name__} has no content digest")
