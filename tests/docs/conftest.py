"""The browser of the pages' tests, for the site of the documentation."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "program" / "page"))

from browser import browser


@pytest.fixture(scope="module")
def driver():
    with browser() as found:
        yield found
