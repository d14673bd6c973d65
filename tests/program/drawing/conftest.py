"""Small runs that several tests draw."""

from __future__ import annotations

import sys
from pathlib import Path

from engine_runs import geared, laval, twin

__all__ = ["geared", "laval", "twin"]

sys.path.insert(0, str(Path(__file__).parent))
