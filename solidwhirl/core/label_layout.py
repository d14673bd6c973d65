"""Labels along a line that do not cover each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray


def spread(places: Sequence[float], widths: Sequence[float]) -> FloatArray:
    """Return places of labels, as near as can be to those they belong to, without overlaps.

    Returns
    -------
    ndarray
        Their places in the order given. The sum of squares of the distances is the smallest one
        that keeps their order (isotonic regression by pooling of neighbours).
    """
    wanted = np.asarray(places, dtype=float)
    if not wanted.size:
        return wanted
    order = np.argsort(wanted, kind="stable")
    size = np.asarray(widths, dtype=float)[order]
    # measured from where each would be if all stood side by side, they only need to rise
    packed = np.concatenate(([0.0], np.cumsum(0.5 * (size[1:] + size[:-1]))))[: len(size)]
    groups: list[tuple[float, int]] = []
    for value in wanted[order] - packed:
        total, count = float(value), 1
        while groups and groups[-1][0] / groups[-1][1] > total / count:
            before = groups.pop()
            total, count = total + before[0], count + before[1]
        groups.append((total, count))
    level = np.repeat([total / count for total, count in groups], [n for _, n in groups])
    out = np.empty(len(wanted))
    out[order] = level + packed
    return out
