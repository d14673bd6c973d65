"""From the energy that single families leave out to the error forms of a superelement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from solidwhirl.reduction.free_motion import straining_part
from solidwhirl.reduction.omitted import Omitted
from solidwhirl.reduction.vectors import symmetric
from solidwhirl.rotordyn.superelement import ErrorForm

if TYPE_CHECKING:
    from solidwhirl.reduction.superelements import ReducedBlock

FloatArray = NDArray[np.float64]
_TERMS = 4  # K, M, G, Kσ - S
# Of these, what a rigid motion feels nothing of: it strains nothing, and the prestress turns with
# the body (K R = 0 and (Kσ - S) R = 0 of the full problem on any mesh).
_OF_STRAIN = (0, 3)


def joined_forms(
    blocks: tuple[ReducedBlock, ...],
    omitted: tuple[tuple[Omitted, ...], ...],
    order: NDArray[np.int64],
) -> tuple[ErrorForm, ...]:
    """Error forms of a superelement.

    Parameters
    ----------
    blocks
        Its reduced blocks.
    omitted
        What every block leaves out, the same parts for all; () for none.
    order
        Order of the superelement's coordinates among those of the stacked blocks.
    """
    if not omitted:
        return ()
    out = []
    for parts in zip(*omitted, strict=True):
        grams = [_of_block(part, block) for part, block in zip(parts, blocks, strict=True)]
        out.append(
            ErrorForm(
                part=parts[0].part,
                gram=_direct_sum(grams, order),
                stiffness_change=None,
                safety=max(part.safety for part in parts),
                cutoff_rad_s=min(part.cutoff_rad_s for part in parts),
            )
        )
    return tuple(out)


def _of_block(omitted: Omitted, block: ReducedBlock) -> FloatArray:
    """Gram matrix (4, n, 4, n) in the coordinates of a block.

    Two families have the same K, M and Kσ - S, and G = [[0, 2N], [-2N, 0]]. Of motions that strain
    nothing the terms of K and Kσ - S are zero by construction: rounding there, of the size of K,
    would be an error without bounds of a slow motion.
    """
    size = len(omitted.gram) // _TERMS
    families = len(block.signs) // size
    single = omitted.gram.reshape(_TERMS, size, _TERMS, size)
    whole = np.zeros((_TERMS, families * size, _TERMS, families * size))
    same, crossed = np.eye(families), 2.0 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    for a in range(_TERMS):
        for b in range(_TERMS):
            left = crossed if (a == 2 and families == 2) else same
            right = crossed if (b == 2 and families == 2) else same
            whole[a, :, b] = np.kron(left.T @ right, single[a, :, b])
    whole *= block.signs[:, None, None] * block.signs
    whole = whole[:, block.order][..., block.order]
    strain = straining_part(block.matrices["mass"], block.rigid)
    for a in _OF_STRAIN:
        whole[a] = np.einsum("ki,kbj->ibj", strain, whole[a])
        whole[:, :, a] = whole[:, :, a] @ strain
    return np.asarray(whole)


def _direct_sum(grams: list[FloatArray], order: NDArray[np.int64]) -> FloatArray:
    """(4 n, 4 n) of several blocks that do not couple."""
    n = len(order)
    out = np.empty((_TERMS, n, _TERMS, n))
    for a in range(_TERMS):
        for b in range(_TERMS):
            joined = scipy.linalg.block_diag(*[g[a, :, b] for g in grams])
            out[a, :, b] = joined[np.ix_(order, order)]
    return symmetric(out.reshape(_TERMS * n, _TERMS * n))
