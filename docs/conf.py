"""Configuration of the documentation's site; built offline, warnings are errors."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "barchain"
author = "The barchain team"
project_copyright = author
version = release = version_of("barchain")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # MathJax from a wheel: the site loads nothing from elsewhere
    "sphinx_click",
    "sphinx_copybutton",
    "generated_pages",
    "links_to_sources",
    "themed_images",
]
exclude_patterns = ["extensions", "recipes", "build"]
root_doc = "index"
suppress_warnings = ["mystnb.unknown_mime_type"]
nb_execution_mode = "force"  # the notebook is stored without outputs
nb_execution_timeout = 300
nb_execution_raise_on_error = True
default_role = "code"
nitpicky = False  # docstrings name types of libraries whose inventories are not at hand offline

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_typehints = "none"  # numpydoc's parameter tables have them
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True  # a default that is a folder would show where the site was built
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

html_theme = "furo"
html_title = f"barchain {release}"
html_static_path = ["images"]
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"top_of_page_buttons": []}
