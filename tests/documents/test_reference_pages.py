"""Pages for looking up: every key of a scene with type, unit, default and range in words, and every outcome."""

from __future__ import annotations

import re

from reports.results.outcome import Outcome
from scenarios import SceneFile
from scenarios.toml.key_tables import HEAD, key_tables
from tests.structure.product import ROOT

ENDS = ("orbits", "_m", "_s", "_kg", "_N", "_deg", "_rad", "_Pa", "_s2", "_m2", "_m3")
TABLES = {
    title.strip("`"): {row[0].strip("`"): dict(zip(HEAD, row, strict=True)) for row in found}
    for title, _, found in key_tables()
}
"""Cells by table, key and heading"""


def test_every_key_of_the_schema_has_a_row() -> None:
    schema = SceneFile.model_json_schema()
    tables = [table["properties"] for table in schema["$defs"].values() if "properties" in table]
    below = [found for title, found in TABLES.items() if title != "Top level"]
    assert sorted(map(sorted, tables)) == sorted(map(sorted, below))
    assert set(TABLES["Top level"]) == set(schema["properties"])


def test_no_cell_is_empty_and_keys_whose_name_ends_with_a_unit_have_it() -> None:
    for title, found in TABLES.items():
        for key, cells in found.items():
            assert all(cells.values()), (title, key, cells)
            assert "nothing" not in cells["type"]
            assert (cells["unit"] == "–") != key.endswith(ENDS)
            assert cells["type"] != "text" or "characters" in cells["allowed"]


def test_required_keys_say_so_and_others_their_default() -> None:
    required = {key for key, cells in TABLES["[chain]"].items() if cells["default"] == "required"}
    assert required == {"bars", "mass_kg", "length_m"}
    assert TABLES["[run]"]["orbits"]["default"] == "required unless duration_s is given"
    inertia = TABLES["[chain]"]["inertia_kg_m2"]
    assert (inertia["unit"], inertia["default"], inertia["allowed"]) == ("kg m²", "slender uniform bar", "above 0")


def test_every_outcome_has_one_row_in_reading_the_report() -> None:
    page = (ROOT / "docs/howto/reading_the_report.md").read_text("utf-8")
    named = re.findall(r"^\| `(\w+)` \|", page.split("## Outcomes, and what to do")[1], re.MULTILINE)
    assert sorted(named) == sorted(Outcome)
