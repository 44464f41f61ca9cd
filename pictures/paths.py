"""Folders of the project that the command reads and writes."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
RECORD = DOCS / "record"
IMAGES = DOCS / "images"
GENERATED = DOCS / "generated"
"""Pages and pictures that each build of the documentation's site writes; not committed"""
GALLERY = GENERATED / "gallery"
ENGINE_PAGES = GENERATED / "engines"
