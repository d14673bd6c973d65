"""Small runs that several tests draw."""

from __future__ import annotations

from engine_runs import geared, laval, twin

__all__ = ["geared", "laval", "twin"]
