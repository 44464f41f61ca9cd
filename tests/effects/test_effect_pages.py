"""The pages in docs/effects: their examples load, their tables say what the schema and the registry say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from adapters.registry import ENGINES
from scenarios.load import parse_scene
from tests.effects.effect_pages import engine_table, key_table

PAGES = Path(__file__).parents[2] / "docs" / "effects"
TABLES = {
    "gravity": ["EffectsTable"],
    "oblateness": ["OblatenessTable"],
    "third_body": ["ThirdBodyTable"],
    "drag": ["DragTable"],
    "solar_pressure": ["SolarPressureTable"],
    "joint_spring_damper": ["JointSpringDamperTable"],
    "prescribed_rotation": ["PrescribedRotationTable"],
    "thrust": ["ThrustTable", "ImpulseTable"],
}
FRAME = """title = "t"
source = "s"
[orbit]
altitude_m = 300e3
[chain]
bars = {bars}
mass_kg = 100.0
length_m = 100.0
[run]
duration_s = 5000.0
"""


def text(name: str) -> str:
    """A page."""
    return (PAGES / f"{name}.md").read_text(encoding="utf-8")


def test_every_page_has_its_keys_told() -> None:
    assert {p.stem for p in PAGES.glob("*.md")} == {*TABLES, "README"}


@pytest.mark.parametrize("name", TABLES)
def test_the_keys_of_a_page_are_those_of_the_schema(name: str) -> None:
    for definition in TABLES[name]:
        expected = key_table(definition, *(["gravity"] if name == "gravity" else []))
        assert expected in text(name), f"docs/effects/{name}.md should hold:\n{expected}"


@pytest.mark.parametrize("name", TABLES)
def test_the_example_of_a_page_is_a_scene_in_few_lines(name: str) -> None:
    example = re.search(r"```toml\n(.*?)```", text(name), re.DOTALL)
    assert example
    assert len(example[1].splitlines()) <= 14
    bars = 5 if name == "prescribed_rotation" else 4
    scene = parse_scene(FRAME.format(bars=bars) + example[1], name=name, file=name)
    assert any(found.startswith(name) for found in scene.effects.names)


@pytest.mark.skipif(
    any(r.missing for name, r in ENGINES.items() if name != "drake"), reason="the table speaks of all engines"
)
def test_the_matrix_of_engines_and_effects_is_that_of_the_registry() -> None:
    expected = engine_table()
    assert expected in text("README"), f"docs/effects/README.md should hold:\n{expected}"
