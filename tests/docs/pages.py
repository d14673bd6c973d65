"""The pages of the documentation and their fenced blocks."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
# Pages whose commands are run block by block in test_commands.py. A mark before a block says when:
# <!-- test --> with all tests, <!-- test: verify --> with the long ones, after all blocks that
# stand before it. Commands without a mark, and those of other pages: test_other_commands.py.
FOLLOWED = ("README.md", "docs/tutorial.md", "docs/howto.md", "docs/audited_page.md")
FENCE = re.compile(
    r"^(?:<!-- (test[^>]*?) -->\n)?```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE
)


def name_of(page):
    return str(page.relative_to(ROOT))


def blocks(page):
    """(mark, language, text) of a page's blocks, in order; the mark is the comment before one."""
    return FENCE.findall((ROOT / page).read_text(encoding="utf-8"))
