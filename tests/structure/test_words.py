"""Retired words don't come back: text that people read uses the field's words."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.structure.prose import rooms
from tests.structure.retired_words import TABLE, table

if TYPE_CHECKING:
    from tests.structure.retired_words import Words

ROOMS = rooms()


@pytest.fixture(name="words", scope="module")
def _words() -> Words:
    return table(Path(__file__).parent / TABLE)


@pytest.mark.parametrize("room", ROOMS)
def test_no_text_uses_a_retired_word(room: str, words: Words) -> None:
    found = [line for path in ROOMS[room] for line in words.found(path)]
    assert not found, f"{len(found)} in {room}\n" + "\n".join(found)


def test_every_allowance_has_a_reason(words: Words) -> None:
    assert all(len(each.reason.split()) > 2 for each in words.allowances)


@pytest.mark.parametrize(
    "text", ["the truth of a scene", "engines that can't\n    carry it", "2 bands", "a spoilt run"]
)
def test_a_retired_word_is_found(text: str, words: Words) -> None:
    assert any(word.pattern.search(text) for word in words.retired)


@pytest.mark.parametrize(
    "text",
    [
        "a carry from one digit to the next", "a truth table", "horizontal chain", "bandwidth", "a chain stretched out",
        "velocities jump", "error growth with time", "a killed worker", "banded Cholesky", "a sum carried along",
    ],
)  # fmt: skip
def test_a_word_of_the_field_is_not(text: str, words: Words) -> None:
    assert not any(word.pattern.search(text) for word in words.retired)
