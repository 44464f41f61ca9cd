"""The notebook of the tutorials runs from its first cell to its last, and shows pictures."""

from pathlib import Path

import pytest

from tests.structure.product import ROOT

nbformat = pytest.importorskip("nbformat", reason="the notebook needs the extra docs")
nbclient = pytest.importorskip("nbclient", reason="the notebook needs the extra docs")
PAGE = ROOT / "docs" / "tutorials" / "notebook.ipynb"


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # of Jupyter's own event loop
def test_the_notebook_runs_and_shows_pictures(tmp_path: Path) -> None:
    notebook = nbformat.read(PAGE, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output["data"] for cell in notebook.cells for output in cell.get("outputs", ()) if "data" in output]
    assert sum("<svg" in data.get("text/html", "") for data in shown) >= 2
    assert any("image/png" in data for data in shown)


def test_the_notebook_is_stored_without_outputs() -> None:
    assert not any(cell.get("outputs") for cell in nbformat.read(PAGE, as_version=4).cells)
