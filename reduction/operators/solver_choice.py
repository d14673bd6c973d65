"""Choice between a factorisation and multigrid for the systems of one body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from solidwhirl.reduction.errors import FactorMemoryError, ReductionError
from solidwhirl.reduction.operators import kinematics
from solidwhirl.reduction.operators.dofs import Unknowns, motion_vectors
from solidwhirl.reduction.operators.kinematics import COMPONENTS, Kinematics
from solidwhirl.reduction.solvers.constrained import (
    ConstrainedFactor,
    factorise,
    predicted_factor_bytes,
)
from solidwhirl.reduction.solvers.hierarchy import BlockPlaces, hierarchy_of
from solidwhirl.reduction.solvers.memory import available_memory_bytes
from solidwhirl.reduction.solvers.multigrid import ConstrainedIteration, constrained_iteration
from solidwhirl.rotordyn.core.arrays import FloatArray

#: What `ConstrainedFactor` and `ConstrainedIteration` have in common: `solve` and `destroy`.
Solver = ConstrainedFactor | ConstrainedIteration
#: How the systems of a solid may be solved.
SOLVERS = ("auto", "direct", "iterative")


@dataclass(frozen=True, kw_only=True)
class ExpectedFactor:
    """Whether a factorisation is expected to fit."""

    needed_bytes: float  #: Predicted memory of the factor, on all ranks
    #: Memory there is, for all ranks; None where the system does not tell
    available_bytes: float | None

    @property
    def fits(self) -> bool:
        """Whether it fits, as far as is known."""
        return self.available_bytes is None or self.needed_bytes <= self.available_bytes


def expected_factor(unknowns: int, comm: Any) -> ExpectedFactor:
    """Compare the predicted memory of a factor with what is available.

    `comm`: mpi4py communicator; all ranks must call.
    """
    each = available_memory_bytes(comm)
    return ExpectedFactor(
        needed_bytes=predicted_factor_bytes(unknowns),
        available_bytes=None if each is None else float(each) * comm.size,
    )


def solver_name(solver: Solver) -> str:
    """Return "direct" or "iterative"."""
    return "direct" if isinstance(solver, ConstrainedFactor) else "iterative"


def prepared_solver(
    stiffness: Any,
    matrix: Any,
    rows: FloatArray,
    places: Callable[[], BlockPlaces],
    *,
    choice: str,
    free: FloatArray,
    momentum: FloatArray,
    shift: float = 0.0,
) -> Solver:
    """Prepare solutions with a symmetric matrix under constraint rows.

    `places`: makes the places of the unknowns, where they are needed. `choice`: of `SOLVERS`.
    "auto" factorises if the factor's predicted memory is there, and if MUMPS agrees after its
    analysis. Raises ReductionError: an unknown choice; what both ways of solving raise.
    """
    if choice not in SOLVERS:
        raise ReductionError(f"solver {choice!r}: allowed are {', '.join(SOLVERS)}")
    size, comm = matrix.getSize()[0], matrix.comm.tompi4py()
    if choice == "direct" or (choice == "auto" and expected_factor(size, comm).fits):
        try:
            return factorise(matrix, rows)
        except FactorMemoryError:
            if choice == "direct":
                raise
    return constrained_iteration(
        hierarchy_of(stiffness, places()),
        matrix,
        rows,
        free=free,
        momentum=momentum,
        owns_matrix=matrix is not stiffness,
        shift=shift,
    )


def block_places(
    space: Any, kin: Kinematics, unknowns: Unknowns, masters: dict[str, FloatArray]
) -> BlockPlaces:
    """Places of a whole solid's unknowns û in blocks of three.

    `masters`: values of the rigid motions in the unknowns of rigid masters, which come after them
    on the last rank, by component.
    """
    kept = unknowns.kept
    assert kept is not None
    _, node = np.unique(kept // 3, return_inverse=True)
    nodes = int(node.max(initial=-1)) + 1
    motions = [COMPONENTS.index(c) for c in COMPONENTS if c in kin.rigid_motions]
    followers = len(next(iter(masters.values()), np.empty(0)))
    count = followers // max(len(motions), 1)
    ends = (3 * nodes + 6 * np.arange(count)[:, None] + np.array(motions, dtype=np.int64)).ravel()
    rigid = np.zeros((len(kept) + followers, len(COMPONENTS)))
    for k, values in enumerate(motion_vectors(space, kinematics.solid(space.mesh), 0.0).values()):
        rigid[: len(kept), k] = values[kept]
    for c, values in masters.items():
        rigid[len(kept) :, COMPONENTS.index(c)] = values
    place = np.concatenate([3 * node + kept % 3, ends])
    return BlockPlaces(place=place.astype(np.int64), blocks=nodes + 2 * count, rigid=rigid)
