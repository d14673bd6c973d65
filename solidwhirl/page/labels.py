"""Places of labels beside a drawing so that none covers another."""

from __future__ import annotations

import itertools
from collections.abc import Sequence


def spread(places: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Move labels apart so that none overlaps the next, as little as possible.

    The sum of squared moves is least (isotonic regression by pooling of neighbours).

    Parameters
    ----------
    places
        Where their centres ought to be, rising.
    widths
        Their widths.

    Returns
    -------
    list of float
        Where they are, in the same order.

    Raises
    ------
    ValueError
        If the places do not rise.
    """
    if any(b < a for a, b in itertools.pairwise(places)):
        raise ValueError("places of labels must rise")
    offsets = [0.0]
    for a, b in itertools.pairwise(widths):
        offsets.append(offsets[-1] + 0.5 * (a + b))
    pools: list[tuple[float, int]] = []  # mean of the shifted places, and how many they are
    for place, offset in zip(places, offsets, strict=False):
        mean, count = place - offset, 1
        while pools and pools[-1][0] > mean:
            before, many = pools.pop()
            mean = (before * many + mean * count) / (many + count)
            count += many
        pools.append((mean, count))
    shifted = [mean for mean, count in pools for _ in range(count)]
    return [s + offset for s, offset in zip(shifted, offsets, strict=False)]
