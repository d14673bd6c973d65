"""Settings of Sphinx: the pages as they stand in the tree, links between them as they are."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[1]
_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = _PROJECT["name"]
author = "The solidwhirl authors"
copyright = f"{author}, {_PROJECT['license']['text']}"
version = release = _PROJECT["version"]
language = "en"

# The source is the root of the tree, so that links to scenes, tests and programs lead to files.
root_doc = "docs/index"
include_patterns = ["README.md", "CONTRIBUTING.md", "docs/*.md"]
exclude_patterns = [
    ".*",
    "out",
    "build",
    "tests",
    "bench",
    "scenes",
    "solidwhirl",
    "docs/_templates",
    "**/__pycache__",
]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
templates_path = ["_templates"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
# the anchors of a heading are those that Git hosts make, which tests/docs checks
suppress_warnings = ["myst.header"]

autodoc_typehints = "none"
autodoc_member_order = "groupwise"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_attr_annotations = False

html_theme = "furo"
html_title = f"{project} {version}"
html_show_sourcelink = False
html_copy_source = False
# the start page stands in docs/; this one at the top leads to it
html_additional_pages = {"index": "to_start.html"}
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072B2", "color-brand-content": "#0072B2"},
    "dark_css_variables": {"color-brand-primary": "#56B4E9", "color-brand-content": "#56B4E9"},
}
pygments_style = "friendly"


def _plain_bars(*given: Any) -> None:
    """Magnitudes |x| and names that end in `_` are no markup in docstrings of this project."""
    lines = given[-1]
    lines[:] = [re.sub(r"(numpy\.\w+)_(?!\w)", r"\1\\_", x.replace("|", r"\|")) for x in lines]


def setup(app: Sphinx) -> None:
    """Connect what docstrings need before they are read as markup."""
    app.connect("autodoc-process-docstring", _plain_bars, priority=100)
