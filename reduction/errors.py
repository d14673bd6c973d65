"""Errors of the reduction stage."""

from __future__ import annotations


class ReductionError(ValueError):
    """A body that can not be reduced as asked."""


class FactorMemoryError(ReductionError):
    """A factor that needs more memory than the machine has."""
