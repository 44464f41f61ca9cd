"""Numbers that scripts of pages print, which closed forms or other people confirm, are those on the pages."""

import sys

import pytest

from tests.documents.running import FILE, blocks, run
from tests.documents.snippets import PUBLISHED, TUTORIALS
from tests.support.slow import exhaustive_but


@pytest.mark.parametrize("name", exhaustive_but(["an_arm", "a_tether"], ["a_tether"]))
def test_the_script_of_a_tutorial_prints_the_numbers_on_its_page(name, tmp_path):
    scene, script, shown = (
        next(block.text for block in blocks(TUTORIALS / f"{name}.md") if block.language == language)
        for language in ("toml", "python", "text")
    )
    (tmp_path / FILE.match(scene).group(1)).write_text(scene, encoding="utf-8")
    assert run([sys.executable, "-c", script], tmp_path, 0) == shown


@pytest.mark.slow
def test_numbers_that_others_published_are_met_as_the_page_says(tmp_path):
    shown = blocks(PUBLISHED)
    scripts = list(zip(shown[::2], shown[1::2], strict=True))
    assert len(scripts) == 5
    for script, printed in scripts:
        assert (script.language, printed.language) == ("python", "text")
        assert run([sys.executable, "-c", script.text], tmp_path, 0) == printed.text
