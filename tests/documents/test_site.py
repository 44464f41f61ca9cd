"""The documentation's site builds without a warning, loads nothing from elsewhere, and has no dead link."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pictures.paths import DOCS
from tests.documents.site import dead_links, loads_from_elsewhere, read_site
from tests.structure.product import PACKAGES, ROOT

PICTURE = re.compile(
    r'<a class="full-size (?:only-\w+ )?reference internal" href="[./]*_images/([^"]+)"><img [^>]*class="(only-\w+)" '
    r'src="[./]*_images/([^"]+)"'
)
VARIABLE = re.compile(r"\bBARCHAIN_[A-Z_]+\b")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="the site needs the extra docs")
    folder = tmp_path_factory.mktemp("site")
    line = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", str(DOCS), str(folder)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_has_every_page(site: Path) -> None:
    pages = {path.relative_to(DOCS).with_suffix("") for path in DOCS.rglob("*.md")}
    built = {path.relative_to(site).with_suffix("") for path in site.rglob("*.html")}
    assert pages <= built


@pytest.mark.slow
def test_the_notebook_of_the_site_has_run_and_shows_pictures(site: Path) -> None:
    """Sphinx runs it from its first cell to its last; a cell that fails ends the build."""
    text = (site / "tutorials" / "notebook.html").read_text("utf-8")
    cells = re.findall(r'<div class="cell_output.*?(?=<div class="cell |</article>)', text, re.DOTALL)
    assert sum("<svg" in cell for cell in cells) >= 2
    assert any("image/png" in cell or ".png" in cell for cell in cells)


@pytest.mark.slow
def test_no_link_of_the_site_is_dead_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages = read_site(site)
    assert not [*dead_links(pages), *loads_from_elsewhere(pages)]


@pytest.mark.slow
def test_a_picture_has_a_dark_variant_where_one_lies_beside_it_and_leads_to_its_full_size(site: Path) -> None:
    for page, stem, end in (("index", "chain-light", "svg"), ("studies/cost", "report-cost", "png")):
        text = (site / f"{page}.html").read_text("utf-8")
        pictures = re.findall(PICTURE, text)
        dark = f"{stem.removesuffix('-light')}-dark.{end}"
        assert (f"{stem}.{end}", "only-light", f"{stem}.{end}") in pictures
        assert (dark, "only-dark", dark) in pictures
        assert (site / "_images" / dark).is_file()
    single = (site / "generated" / "engines" / "heyoka.html").read_text("utf-8")
    assert "heyoka-cost.svg" in single
    assert "only-dark" not in single.partition("<article")[2].partition("</article>")[0]


@pytest.mark.slow
def test_a_thumbnail_of_the_gallery_leads_to_the_page_of_its_scene(site: Path) -> None:
    text = (site / "generated" / "gallery" / "index.html").read_text("utf-8")
    assert "full-size" not in text
    assert re.search(r'<a [^>]*href="paper/fig05\.html"[^>]*>(?:<span[^>]*>)?<img [^>]*fig05-small\.svg', text)


def test_the_notebook_is_stored_without_outputs() -> None:
    cells = json.loads((DOCS / "tutorials" / "notebook.ipynb").read_text("utf-8"))["cells"]
    assert not any(cell.get("outputs") for cell in cells)


def test_every_environment_variable_that_the_code_reads_is_documented() -> None:
    files = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    read = {name for path in files for name in VARIABLE.findall(path.read_text("utf-8"))}
    page = (DOCS / "reference" / "command_line.md").read_text("utf-8")
    assert read == set(VARIABLE.findall(page))
