"""Words in boxes, and signs of the directions of whirl, so that colour alone tells nothing."""

from __future__ import annotations

from collections.abc import Sequence

from solidwhirl.page.frame.records import Text

WHIRL_SIGNS = {"forward": "●", "backward": "□", "mixed": "◆", "planar": "◇"}
_NONE = "◇"


def whirl_text(whirl: str | None) -> str:
    """Word of a whirl with its sign before it, which a table shows in the colour of the whirl."""
    return f"{WHIRL_SIGNS.get(whirl or '', _NONE)} {whirl or 'none'}"


def warning(lines: Sequence[str]) -> list[Text]:
    """Return lines in a box; nothing where there are none."""
    said = "\n".join(f"- {line}" for line in lines)
    return [Text(text=said, kind="warning")] if lines else []
