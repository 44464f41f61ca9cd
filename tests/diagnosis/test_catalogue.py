"""The catalogue of mistakes: unique names, sentences of one form, sections that exist."""

from __future__ import annotations

import re
from pathlib import Path

from barchain.judge.diagnosis.altered_scenes.catalogue import SCENES
from barchain.judge.diagnosis.mistake import PAGE, Mistake
from barchain.judge.diagnosis.readings.catalogue import READINGS, TIMINGS

MISTAKES: tuple[Mistake, ...] = (*READINGS, *TIMINGS, *SCENES)
ROOT = Path(__file__).parents[2]


def anchors() -> set[str]:
    """Anchors of the page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", (ROOT / PAGE).read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_names_and_sentences_are_unique() -> None:
    assert len({m.name for m in MISTAKES}) == len(MISTAKES)
    assert len({m.sentence for m in MISTAKES}) == len(MISTAKES)


def test_every_mistake_has_a_plain_sentence_and_a_section() -> None:
    for mistake in MISTAKES:
        assert re.fullmatch(r"[a-z0-9-]+", mistake.name)
        assert mistake.sentence.startswith("the "), mistake.name
        assert not mistake.sentence.endswith("."), mistake.name
        assert mistake.section in anchors(), mistake.name
        assert mistake.anchor == f"docs/explanation/engine_conventions.md#{mistake.section}"


def test_a_mistake_in_the_scene_alters_the_scene_or_the_equations() -> None:
    assert all((m.scene is None) != (m.model is None) for m in SCENES)
