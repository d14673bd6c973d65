"""Scripts and styles of pages as files; what draws the charts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Environment

_FOLDER = Path(__file__).parents[1] / "assets"


def environment(*folders: Path) -> Environment:
    """Return what makes pages of the templates in some folders, and of those of the report."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader([*folders, _FOLDER]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def asset(name: str) -> str:
    """Return the text of a script or style of the page."""
    return (_FOLDER / name).read_text(encoding="utf-8")


def plotly_file() -> Path:
    """Return the script of the drawing library, as its package brings it.

    Raises ModuleNotFoundError: it is not installed.
    """
    # the file itself: importing the package to find it takes longer than the page
    from importlib.util import find_spec

    spec = find_spec("plotly")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("plotly is not installed, which draws the charts of a page")
    return Path(spec.origin).parent / "package_data" / "plotly.min.js"
