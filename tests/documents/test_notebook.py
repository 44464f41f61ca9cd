"""The notebook of the tutorials is stored without outputs; tests/documents/test_site.py runs it."""

import pytest

from tests.structure.product import ROOT

nbformat = pytest.importorskip("nbformat", reason="the notebook needs the extra docs")
PAGE = ROOT / "docs" / "tutorials" / "notebook.ipynb"


def test_the_notebook_is_stored_without_outputs() -> None:
    assert not any(cell.get("outputs") for cell in nbformat.read(PAGE, as_version=4).cells)
