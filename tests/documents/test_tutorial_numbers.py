"""Numbers that the tutorials of an arm and a tether print, which closed forms confirm, are those on their pages."""

import sys

import pytest

from tests.documents.running import FILE, blocks, run
from tests.documents.snippets import TUTORIALS


@pytest.mark.parametrize("name", ["an_arm", "a_tether"])
def test_the_script_of_a_tutorial_prints_the_numbers_on_its_page(name, tmp_path):
    scene, script, shown = (
        next(block.text for block in blocks(TUTORIALS / f"{name}.md") if block.language == language)
        for language in ("toml", "python", "text")
    )
    (tmp_path / FILE.match(scene).group(1)).write_text(scene, encoding="utf-8")
    assert run([sys.executable, "-c", script], tmp_path, 0) == shown
