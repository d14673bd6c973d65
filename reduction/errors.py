"""The one error of the reduction stage."""

from __future__ import annotations


class ReductionError(ValueError):
    """A body that can not be reduced as asked."""
