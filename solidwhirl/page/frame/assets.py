"""Scripts and styles of pages as files; what draws the charts."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[1] / "assets"


def asset(name: str) -> str:
    """Return the text of a script or style of the page."""
    return (FOLDER / name).read_text(encoding="utf-8")


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
