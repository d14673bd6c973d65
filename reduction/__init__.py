"""From a mesh to a superelement: operators of the spinning body and their reduction."""

# first: h5py before dolfinx, and how that is imported
import solidwhirl.rotordyn.core.hdf5  # noqa: I001
import solidwhirl.reduction.operators.compat  # noqa: F401
from solidwhirl.core.reduction_work import ReductionWork
from solidwhirl.reduction.basis.craig_bampton import MAXIMUM_HOOP_STRAIN
from solidwhirl.reduction.body.reduce import reduce_body
from solidwhirl.reduction.body.request import ReductionRequest
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.solver_choice import expected_factor

__all__ = [
    "MAXIMUM_HOOP_STRAIN",
    "ReductionError",
    "ReductionRequest",
    "ReductionWork",
    "expected_factor",
    "reduce_body",
]
