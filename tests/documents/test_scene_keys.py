"""The reference page of a scene's keys tells type, unit, default and range of every key in words."""

from __future__ import annotations

import pytest

from scenarios import SceneFile
from scenarios.toml.key_tables import HEAD, key_tables

ENDS = ("orbits", "_m", "_s", "_kg", "_N", "_deg", "_rad", "_Pa", "_s2", "_m2", "_m3")


@pytest.fixture(scope="module")
def rows() -> dict[str, dict[str, dict[str, str]]]:
    """Cells by table, key and heading."""
    return {
        title.strip("`"): {row[0].strip("`"): dict(zip(HEAD, row, strict=True)) for row in found}
        for title, _, found in key_tables()
    }


def test_every_key_of_the_schema_has_a_row(rows: dict[str, dict[str, dict[str, str]]]) -> None:
    definitions = SceneFile.model_json_schema()["$defs"]
    tables = [table["properties"] for table in definitions.values() if "properties" in table]
    assert sorted(map(sorted, tables)) == sorted(sorted(found) for title, found in rows.items() if title != "Top level")
    assert set(rows["Top level"]) == set(SceneFile.model_json_schema()["properties"])


def test_no_cell_is_empty_and_no_type_is_a_missing_value(rows: dict[str, dict[str, dict[str, str]]]) -> None:
    for title, found in rows.items():
        for key, cells in found.items():
            assert all(cells.values()), (title, key, cells)
            assert "nothing" not in cells["type"]


def test_required_keys_say_so(rows: dict[str, dict[str, dict[str, str]]]) -> None:
    required = {key for key, cells in rows["[chain]"].items() if cells["default"] == "required"}
    assert required == {"bars", "mass_kg", "length_m"}
    assert rows["[run]"]["orbits"]["default"] == "required unless duration_s is given"
    assert rows["[orbit]"]["altitude_m"]["default"] == "required unless a state or elements are given"


def test_the_inertia_is_a_number_with_unit_default_and_range(rows: dict[str, dict[str, dict[str, str]]]) -> None:
    cells = rows["[chain]"]["inertia_kg_m2"]
    assert cells["type"] == "number or list of numbers"
    assert (cells["unit"], cells["default"], cells["allowed"]) == ("kg m²", "slender uniform bar", "above 0")


def test_keys_whose_name_ends_with_a_unit_have_it(rows: dict[str, dict[str, dict[str, str]]]) -> None:
    for found in rows.values():
        for key, cells in found.items():
            assert (cells["unit"] == "–") != key.endswith(ENDS)
            assert cells["type"] != "text" or "characters" in cells["allowed"]
