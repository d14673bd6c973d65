"""One circumferential order of a body in reduced coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.superelement.record import Coordinate


@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedBlock:
    """One circumferential order (or the solid) in reduced, named coordinates."""

    coordinates: tuple[Coordinate, ...]
    #: "mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening": (n, n)
    matrices: Mapping[str, FloatArray]
    rigid: FloatArray  #: (n, 6) rigid motions about the origin
    present: BoolArray  #: (6,) which of them the block can make
    recovery: FloatArray  #: (m, 3, n) displacement of the recovery points
    fixed_frequencies_hz: FloatArray
    #: (n, n) change of the coordinates in a small turn of the field about the axis; None if it is
    #: no exchange of coordinates
    generator: FloatArray | None
    #: (n,) how the coordinates came from the families' own: sign, then order
    signs: FloatArray
    order: IntArray


def planes(matrix: Matrix) -> FloatArray:
    """Matrix of q1 and q2 from that of c = q1 - i q2, (2 n, 2 n).

    `matrix`: (n, n), complex, or real of planes that do not couple.
    """
    return np.block([[matrix.real, matrix.imag], [-matrix.imag, matrix.real]])


def joined_order(body: AnyBody, blocks: Sequence[ReducedBlock]) -> IntArray:
    """Order of the superelement's coordinates among those of the stacked blocks, (n,).

    Interface coordinates of all blocks come by interface and component, then the modes.
    """
    names = [i.name for i in body.interfaces]
    coordinates = [c for block in blocks for c in block.coordinates]

    def key(k: int) -> tuple[int, int, int]:
        c = coordinates[k]
        if c.kind == "modal":
            return (1, k, 0)
        return (0, names.index(c.interface), COMPONENTS.index(c.component))

    return np.array(sorted(range(len(coordinates)), key=key), dtype=np.int64)


def joined_rows(body: AnyBody, blocks: Sequence[ReducedBlock]) -> list[IntArray]:
    """Coordinates of the superelement that each block's own are."""
    ends = np.cumsum([len(block.coordinates) for block in blocks])
    return np.split(np.argsort(joined_order(body, blocks)), ends[:-1])
