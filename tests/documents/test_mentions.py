"""What the documents name is there: links, paths, scenes, and command lines that parse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from adapters.registry import Registration
from barchain.result_files.case import PROGRAM
from pictures.paths import DOCS, GENERATED
from scenarios import scene_names
from tests.documents.commands import fault, options
from tests.documents.mentions import (
    command_lines,
    docstring_paths,
    documents,
    exists,
    links,
    options_in_prose,
    paths,
    scenes,
)
from tests.structure.product import ROOT, relative

if TYPE_CHECKING:
    from pathlib import Path

READERS = ("spring", "mine")
"""Engines that a reader makes: the tutorial's package, and the program of another language"""

OTHER_PROGRAMS = {
    "--barchain-engine": "barchain/pytest_plugin.py",
    "--barchain-known": "barchain/pytest_plugin.py",
    "--against": "benchmarks/instructions.py, benchmarks/same_bits.py",
    "--reruns": "benchmarks/random_scenes.py",
    "--shrink-seconds": "benchmarks/random_scenes.py",
}
"""Options in prose that belong to another program than barchain"""

every_document = pytest.mark.parametrize("document", documents(), ids=relative)


@every_document
def test_links_lead_to_files(document: Path) -> None:
    lost = [str(m) for m, target in links(document) if not target.exists() and not is_generated(document, target)]
    assert not lost, "\n".join(lost)


def is_generated(document: Path, target: Path) -> bool:
    """Whether a page of the site leads to another one that is there only in the site, whose own test follows it."""
    return DOCS in document.parents and GENERATED in target.resolve().parents


def is_built(path: str) -> bool:
    """Whether a path is that of pages that each build of the site makes anew, or of a program in exported cases."""
    return path == PROGRAM or GENERATED in (ROOT / path, *(ROOT / path).parents)


@every_document
def test_paths_exist(document: Path) -> None:
    lost = [str(mention) for mention in paths(document) if not exists(mention.text) and not is_built(mention.text)]
    assert not lost, "\n".join(lost)


@every_document
def test_scenes_exist(document: Path) -> None:
    names = scene_names()
    lost = [str(mention) for mention in scenes(document) if mention.text not in names]
    assert not lost, "\n".join(lost)


@every_document
def test_command_lines_parse(document: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "adapters.registry.third_party", lambda _: dict.fromkeys(READERS, Registration("a_module:AClass"))
    )
    monkeypatch.setattr(Registration, "missing", None)  # a page may name an engine that is not installed here
    faults = [(mention, fault(mention.text, whole=whole)) for mention, whole in command_lines(document)]
    assert not any(reason for _, reason in faults), "\n".join(f"{m}: {reason}" for m, reason in faults if reason)


@every_document
def test_an_option_in_prose_is_one_of_some_command(document: Path) -> None:
    known = options() | OTHER_PROGRAMS.keys()
    lost = [str(named) for named in options_in_prose(document) if named.text not in known]
    assert not lost, "\n".join(lost)


def test_an_option_of_another_program_is_none_of_barchain_and_is_named() -> None:
    assert not OTHER_PROGRAMS.keys() & options()
    named = {each.text for document in documents() for each in options_in_prose(document)}
    assert OTHER_PROGRAMS.keys() <= named


def test_an_option_that_no_command_has_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Runs go side by side: `--jobs`, `--workers`.\n```sh\nmake --fast\n```\n", encoding="utf-8")
    assert [each.text for each in options_in_prose(page) if each.text not in options()] == ["--jobs"]


def test_a_path_in_a_docstring_of_the_product_exists() -> None:
    lost = [str(mention) for mention in docstring_paths() if not (ROOT / mention.text).exists()]
    assert not lost, "\n".join(lost)


@pytest.mark.parametrize(
    ("words", "said"),
    [("no-such", "no command"), ("compare paper/fig05 --no-such", "no option"), ("compare", "Missing")],
)
def test_a_command_line_with_a_fault_is_found(words: str, said: str) -> None:
    assert said in fault(words, whole=True)
