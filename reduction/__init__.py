"""From a mesh to a superelement: operators of the spinning body and their reduction."""

# first: it says how dolfinx is imported
import solidwhirl.reduction.compat  # noqa: F401
from solidwhirl.reduction.craig_bampton import MAXIMUM_HOOP_STRAIN
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.reduce import ReductionWork, reduce_body
from solidwhirl.reduction.reduced_order import ReductionRequest
from solidwhirl.reduction.solvers import expected_factor

__all__ = [
    "MAXIMUM_HOOP_STRAIN",
    "ReductionError",
    "ReductionRequest",
    "ReductionWork",
    "expected_factor",
    "reduce_body",
]
