"""Makes the helpers of this folder importable."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))
from reduced import reduced_to


@pytest.fixture
def reduce_to():
    return reduced_to
