"""Modes of nearly equal frequency: kept together, and told apart by circumferential order."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from solidwhirl.reduction.merging import is_of_order
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.vectors import project

FloatArray = NDArray[np.float64]
#: Modes this near in λ are one cluster: their directions are not determined.
CLUSTER = 1e-6


def whole_clusters(values: FloatArray, wanted: int, highest: float) -> int:
    """Number of leading modes near the wanted one that cuts no repeated mode in half.

    The last cluster may lack a member unless a mode of another order was found beyond it.

    Parameters
    ----------
    values
        (m,) rising eigenvalues of the wanted orders.
    wanted
        Number asked for.
    highest
        Highest eigenvalue of all orders.
    """
    beyond = np.append(values[1:], highest)
    ends = [k + 1 for k in range(len(values)) if beyond[k] - values[k] > CLUSTER * abs(beyond[k])]
    enough = [k for k in ends if k >= wanted]
    return enough[0] if enough else (ends[-1] if ends else 0)


def modes_of_orders(
    operators: BodyOperators, values: FloatArray, vectors: FloatArray, orders: tuple[int, ...]
) -> tuple[FloatArray, FloatArray]:
    """Modes of the wanted circumferential orders, by the Rayleigh quotient of J².

    Parameters
    ----------
    operators
        Of a solid.
    values, vectors
        (m,) rising and (local û, m) M-orthonormal eigenpairs of all orders.
    orders
        Wanted.

    Returns
    -------
    values, vectors
        Those of the wanted orders, rising.
    """
    squared = project(operators.circulation, vectors, operators.comm)
    gram = project(operators.mass, vectors, operators.comm)
    start = 0
    found, turned = [np.empty(0)], [vectors[:, :0]]
    for stop in range(1, len(values) + 1):
        if stop < len(values) and values[stop] - values[stop - 1] <= CLUSTER * abs(values[stop]):
            continue
        span = slice(start, stop)
        n2, turn = scipy.linalg.eigh(squared[span, span], gram[span, span])
        for order in sorted(set(orders)):
            own = turn[:, is_of_order(n2, (order,))]
            # members of a cluster are near each other, not equal: each gets its own value again
            own_values, again = np.linalg.eigh(own.T * values[span] @ own)
            found.append(own_values)
            turned.append(vectors[:, span] @ own @ again)
        start = stop
    kept, rotated = np.concatenate(found), np.hstack(turned)
    rising = np.argsort(kept, kind="stable")
    return kept[rising], rotated[:, rising]
