"""The page of a run as one HTML file: everything that it shows and needs is inside it."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence
from functools import cache

from solidwhirl.cache.codec import fingerprint
from solidwhirl.cache.files import StageStore
from solidwhirl.core.machine import user_cache
from solidwhirl.core.stages import silent
from solidwhirl.page.frame import render
from solidwhirl.page.frame.assets import asset, environment, plotly_file
from solidwhirl.page.frame.records import Block, Chart, ModeViewer, Section


def page_html(sections: Sequence[Section], *, title: str, name: str) -> str:
    """Return a page as HTML; a short name stands beside its title.

    Raises ValueError if two sections or two charts have the same name.
    """
    blocks = [block for section in sections for block in section.every_block]
    drawn = [block for block in blocks if isinstance(block, Chart | ModeViewer)]
    names = [s.name for s in sections] + [b.name for b in drawn]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"sections or charts with the same name: {', '.join(twice)}")
    made = environment()
    made.filters |= {
        "line": render.inline_html,
        "text": render.text_html,
        "rows": render.table_html,
        "picture": render.picture_html,
        "data": render.data_json,
    }
    return made.get_template("page.html").render(
        sections=sections,
        title=title,
        name=name,
        style=asset("style.css"),
        library=_plotly() if drawn else "",
        scripts=_scripts(blocks),
        kind=lambda block: type(block).__name__,
    )


def _scripts(blocks: Sequence[Block]) -> list[str]:
    """The page's own script, and the viewer's."""
    scripts = [asset("page.js")]
    if any(isinstance(block, ModeViewer) for block in blocks):
        scripts.append(asset("shapes.js"))
    return scripts


@cache
def _plotly() -> str:
    """The drawing library, compressed, which takes a third of its size.

    Compressing takes longer than the rest of a page: the user's cache folder keeps it.
    """
    file, store = plotly_file(), StageStore(user_cache() / "page")
    state = file.stat()
    key = fingerprint(["plotly, compressed", str(file), state.st_size, state.st_mtime_ns])
    packed: bytes | None = store.find(key, silent)
    if packed is None:
        packed = gzip.compress(file.read_bytes(), compresslevel=6, mtime=0)
        store.keep(key, "plotly, compressed", packed, silent)
        store.prune(0)
    return base64.b64encode(packed).decode("ascii")
