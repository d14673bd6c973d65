"""Signs of the directions of whirl in texts and tables, so that colour alone tells nothing."""

from __future__ import annotations

WHIRL_SIGNS = {"forward": "●", "backward": "□", "mixed": "◆", "planar": "◇"}
_NONE = "◇"


def whirl_text(whirl: str | None) -> str:
    """Word of a whirl with its sign before it, which a table shows in the colour of the whirl."""
    return f"{WHIRL_SIGNS.get(whirl or '', _NONE)} {whirl or 'none'}"
