"""The page as HTML: the style and the charts of a report, and the script that follows."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from solidwhirl.page.frame.assets import asset, environment

_FOLDER = Path(__file__).with_name("assets")


@cache
def watch_page() -> str:
    """Return the page; all that it shows comes over its connection."""
    styles = (asset("style.css"), _text("watch.css"))
    scripts = (asset("page.js"), _text("watch.js"))
    return environment(_FOLDER).get_template("watch.html").render(styles=styles, scripts=scripts)


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
