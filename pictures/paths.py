"""Folders of the project that the command reads and writes."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
GALLERY = DOCS / "gallery"
ENGINE_PAGES = DOCS / "engines"
RECORD = DOCS / "record"
IMAGES = DOCS / "images"
