"""Places of labels beside a drawing so that none covers another."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from solidwhirl.pictures import labels


def spread(places: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Move labels apart so that none overlaps the next, see `solidwhirl.pictures.labels.spread`.

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
    moved: list[float] = labels.spread(places, widths).tolist()
    return moved
