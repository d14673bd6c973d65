"""Settings of Sphinx: the pages as they stand in the tree, links between them as they are."""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

from docutils import nodes
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
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md"]
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

# MathJax in one file, glyphs included: no network, no fonts, which some browsers refuse from files
html_static_path = ["_static", str(files("sphinx-mathjax-offline") / "static/mathjax/tex-svg.js")]
html_css_files = ["formulas.css"]
mathjax_path = "tex-svg.js"

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


def _hold_signs(_app: Sphinx, page: nodes.document, _name: str) -> None:
    """Put each inline formula and the signs that touch it in one element, never broken."""
    for formula in list(page.findall(nodes.math)):
        parent, at = formula.parent, formula.parent.index(formula)
        beside = [parent[k] if 0 <= k < len(parent) else None for k in (at - 1, at + 1)]
        before, after = (str(n) if isinstance(n, nodes.Text) else "" for n in beside)
        opening, closing = re.search(r"\(*$", before)[0], re.match(r"[.,;:)]*", after)[0]
        held = nodes.inline("", "", nodes.Text(opening), formula.deepcopy(), nodes.Text(closing))
        held["classes"].append("held")
        parent[at] = held
        if closing:
            parent[at + 1] = nodes.Text(after.removeprefix(closing))
        if opening:
            parent[at - 1] = nodes.Text(before.removesuffix(opening))


def setup(app: Sphinx) -> None:
    """Connect what docstrings need before they are read, and formulas before they are written."""
    app.connect("autodoc-process-docstring", _plain_bars, priority=100)
    app.connect("doctree-resolved", _hold_signs)
