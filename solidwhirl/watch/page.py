"""The page as HTML: the style and the charts of a report, and the script that follows."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from solidwhirl.page.frame.assets import asset

_FOLDER = Path(__file__).with_name("assets")


@cache
def watch_page() -> str:
    """Return the page; all that it shows comes over its connection."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    styles = (asset("style.css"), _text("watch.css"))
    scripts = (asset("page.js"), _text("watch.js"))
    return environment.get_template("watch.html").render(styles=styles, scripts=scripts)


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
