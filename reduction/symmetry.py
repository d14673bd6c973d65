"""Fields with the symmetry of a mesh that is unchanged by a part of a turn.

Under a turn R of 360°/k about the axis a field of a body of revolution can be sought with
``u(R x) = χ R u(x)``: k = 2, χ = -1 holds all lateral motion (odd circumferential orders),
k = 4, χ = +1 the centrifugal field (order 0, and multiples of 4). Only the unknowns of one sector
remain, and what belongs to other orders costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solidwhirl.reduction.errors import ReductionError

IntArray = NDArray[np.int64]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Symmetry:
    """u(R x) = character · R u(x), R a turn of 360°/turns about z.

    Attributes
    ----------
    turns
        1 (no symmetry), 2 or 4: the turns whose matrices are signed permutations.
    character
        +1 or -1.
    """

    turns: int
    character: int

    def power(self, m: int) -> FloatArray:
        """(χ R)^m as a (3, 3) matrix of 0, 1 and -1."""
        turn = {
            1: np.eye(3),
            2: np.diag([-1.0, -1.0, 1.0]),
            4: np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        }[self.turns]
        return np.asarray(np.linalg.matrix_power(self.character * turn, m))


NONE = Symmetry(turns=1, character=1)
LATERAL = Symmetry(turns=2, character=-1)
AXISYMMETRIC = Symmetry(turns=4, character=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class SymmetricUnknowns:
    """How the local unknowns follow from those of one sector.

    Attributes
    ----------
    source
        (n local unknowns,) global unknown that each follows, -1: zero by symmetry.
    sign
        (n,) its factor.
    kept
        (n,) whether it is one of the sector's own unknowns.
    """

    source: IntArray
    sign: FloatArray
    kept: NDArray[np.bool_]


def symmetric_unknowns(space: Any, symmetry: Symmetry) -> SymmetricUnknowns:
    """Relate the unknowns of a vector space of three components to those of one sector.

    Raises
    ------
    ReductionError
        The mesh does not have the symmetry.
    """
    nodes, comm = space.dofmap.index_map, space.mesh.comm
    first = nodes.local_range[0]
    if symmetry.turns == 1:
        own = 3 * first + np.arange(3 * nodes.size_local, dtype=np.int64)
        return SymmetricUnknowns(
            source=own, sign=np.ones(len(own)), kept=np.ones(len(own), dtype=bool)
        )
    x = space.tabulate_dof_coordinates()[: nodes.size_local]
    representative, steps = _orbits(np.vstack(comm.allgather(x)), symmetry.turns)
    local = slice(first, first + nodes.size_local)
    on_axis = np.hypot(x[:, 0], x[:, 1]) == 0.0
    source = np.empty((nodes.size_local, 3), dtype=np.int64)
    sign = np.empty((nodes.size_local, 3))
    for m in range(symmetry.turns):
        matrix = symmetry.power(m)
        rows = np.flatnonzero(steps[local] == m)
        column = np.abs(matrix).argmax(axis=1)
        source[rows] = 3 * representative[local][rows, None] + column
        sign[rows] = matrix[np.arange(3), column]
    # on the axis only what the turn leaves alone can be
    fixed = np.diag(symmetry.power(1)) == 1.0
    source[np.ix_(on_axis, ~fixed)] = -1
    own = np.arange(nodes.size_local) + first
    kept = (representative[local] == own)[:, None] & (source >= 0)
    return SymmetricUnknowns(source=source.ravel(), sign=sign.ravel(), kept=kept.ravel())


def _orbits(points: FloatArray, turns: int) -> tuple[IntArray, IntArray]:
    """Representative of every node and how many turns lead from it to the node."""
    x, y, z = points.T
    turned = np.column_stack([-x, -y, z] if turns == 2 else [-y, x, z])
    gap, following = cKDTree(points).query(turned)
    if gap.max() > 1e-9 * np.abs(points).max():
        raise ReductionError(
            f"the mesh is not unchanged by a turn of {360 // turns}°: a node is off by "
            f"{gap.max():.3g} m"
        )
    orbit = [np.arange(len(points))]
    for _ in range(turns - 1):
        orbit.append(following[orbit[-1]])
    orbits = np.array(orbit)
    return orbits.min(axis=0), (turns - orbits.argmin(axis=0)) % turns
