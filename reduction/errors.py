"""Errors of the reduction stage."""

from solidwhirl.core.errors import MemoryShortageError, UserError


class ReductionError(UserError):
    """A body that can not be reduced as asked."""


class FactorMemoryError(ReductionError, MemoryShortageError):
    """A factor that needs more memory than the machine has."""


class KernelCacheError(UserError):
    """A cache of kernels that can not be used; the message says what to remove."""
