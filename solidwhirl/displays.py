"""How a scene shows itself, as text and in a notebook, and what other records use for that."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from solidwhirl.scene import Scene

# Rows of a list before the rest is counted.
_MOST = 12
Row = tuple[str, ...]


def scene_text(scene: Scene) -> str:
    """What a scene holds, in a few lines."""
    return "\n".join([f"Scene {scene.name!r}{titled(scene.title)}", *indented(_about(scene))])


def scene_html(scene: Scene) -> str:
    """The same for a notebook."""
    rows = [tuple(line.split(": ", 1)) for line in _about(scene)]
    return heading(f"Scene {scene.name!r}{titled(scene.title)}") + table((), rows)


def percent(value: float) -> str:
    """Return a relative error as text.

    Parameters
    ----------
    value
        nan where it is not known.
    """
    return f"{100.0 * value:.2g} %" if np.isfinite(value) else "unknown"


def titled(title: str) -> str:
    """Return a title behind a name, nothing for none."""
    return f": {title}" if title else ""


def _about(scene: Scene) -> list[str]:
    ratios = scene.speed_ratios()
    names = [f"{name} (speed ratio {ratio:g})" for name, ratio in ratios.items()]
    speeds = scene.speeds
    if speeds.list_rpm is not None:
        low, high, count = speeds.list_rpm[0], speeds.list_rpm[-1], len(speeds.list_rpm)
    else:
        low, high, count = speeds.from_rpm, speeds.to_rpm, speeds.count
    lines = [
        "bodies: " + ", ".join(counted(names)),
        "bearings: " + (", ".join(counted([b.name for b in scene.bearings])) or "none"),
    ]
    lines += ["gears: " + ", ".join(counted([g.name for g in scene.gears]))] if scene.gears else []
    lines.append(f"speeds: {count} from {low:g} to {high:g} rpm")
    lines.append(f"model: level {scene.model.level}, accuracy {scene.model.accuracy:g}")
    asked = [a.label for a in scene.analyses]
    return lines + (["analyses: " + ", ".join(counted(asked))] if asked else [])


def counted(texts: Sequence[str]) -> list[str]:
    """Return the first texts, and how many more there are."""
    more = len(texts) - _MOST
    return [*texts[:_MOST], *([f"and {more} more"] if more > 0 else [])]


def indented(lines: Sequence[str]) -> list[str]:
    """Return lines two places further in."""
    return [f"  {line}" for line in lines]


def heading(text: str) -> str:
    """Return a heading in HTML."""
    return f"<p><strong>{escape(text)}</strong></p>"


def table(names: Row, rows: Sequence[Row]) -> str:
    """Return a table in HTML; nothing without rows."""
    if not rows:
        return ""
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return (
        f"<table>{f'<thead><tr>{head}</tr></thead>' if names else ''}<tbody>{body}</tbody></table>"
    )
