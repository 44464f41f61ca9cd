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
    documents,
    exists,
    links,
    named_documents,
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
    """A page of the site may lead to one that is there only in the site, whose own test follows it."""
    lost = [link for link in links(document) if not (document.parent / link).exists()]
    assert not [link for link in lost if not is_built(document.parent / link) or DOCS not in document.parents]


def is_built(path: Path) -> bool:
    """Whether each build of the site makes a page anew."""
    return GENERATED in (path.resolve(), *path.resolve().parents)


@every_document
def test_paths_exist(document: Path) -> None:
    lost = {path for path in paths(document) if not exists(path) and not is_built(ROOT / path)}
    assert lost <= {PROGRAM}, "all but the program in exported cases"


@every_document
def test_scenes_exist(document: Path) -> None:
    assert not {*scenes(document)} - {*scene_names()}


@every_document
def test_command_lines_parse(document: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "adapters.registry.third_party", lambda _: dict.fromkeys(READERS, Registration("a_module:AClass"))
    )
    monkeypatch.setattr(Registration, "missing", None)  # a page may name an engine that is not installed here
    faults = {words: fault(words, whole=whole) for words, whole in command_lines(document)}
    assert not {words: reason for words, reason in faults.items() if reason}


@every_document
def test_an_option_in_prose_is_one_of_some_command(document: Path) -> None:
    assert not {*options_in_prose(document)} - options() - OTHER_PROGRAMS.keys()


def test_a_path_in_a_docstring_of_the_product_exists() -> None:
    assert not [(file, path) for file, path in named_documents() if not (ROOT / path).exists()]
