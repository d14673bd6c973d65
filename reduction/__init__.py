"""From a mesh to a superelement: operators of the spinning body and their reduction."""

from solidwhirl.reduction.craig_bampton import MAXIMUM_HOOP_STRAIN
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.reduce import ReductionWork, reduce_body
from solidwhirl.reduction.reduced_order import ReductionRequest

__all__ = [
    "MAXIMUM_HOOP_STRAIN",
    "ReductionError",
    "ReductionRequest",
    "ReductionWork",
    "reduce_body",
]
