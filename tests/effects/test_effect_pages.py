"""The pages in docs/effects: each has an example that loads, and the keys of its effect."""

import re
from pathlib import Path

import pytest

from pictures.pages.effect_tables import WITH_KEYS
from scenarios.effect_types import Gravity
from scenarios.load import parse_scene

PAGES = Path(__file__).parents[2] / "docs" / "effects"
KEYS = {
    "oblateness": ["oblateness"],
    "third_body": ["third_body"],
    "drag": ["drag"],
    "solar_pressure": ["solar_pressure"],
    "joint_spring_damper": ["joint_spring_damper", "joint_spring_damper.set_point"],
    "joint_torque": ["joint_torque"],
    "prescribed_rotation": ["prescribed_rotation"],
    "thrust": ["thrust", "impulse"],
}
"""Effects whose keys a page includes"""
EXAMPLES = ["gravity", *KEYS]
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


def test_every_effect_has_a_page_with_its_keys() -> None:
    assert {p.stem for p in PAGES.glob("*.md")} == {*EXAMPLES, "README"}
    assert sorted(effect for effects in KEYS.values() for effect in effects) == sorted(WITH_KEYS)
    assert not [model.value for model in Gravity if f"`{model.value}`" not in text("gravity")]
    for name, effects in KEYS.items():
        assert [
            effect for effect in WITH_KEYS if f"generated: keys-{effect.replace('.', '-')} " in text(name)
        ] == sorted(effects, key=WITH_KEYS.index)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_of_a_page_is_a_scene(name: str) -> None:
    example = re.search(r"```toml\n(.*?)```", text(name), re.DOTALL)
    assert example
    bars = 5 if name == "prescribed_rotation" else 4
    scene = parse_scene(FRAME.format(bars=bars) + example[1], name=name, file=name)
    assert any(found.startswith(name) for found in scene.effects.names)
