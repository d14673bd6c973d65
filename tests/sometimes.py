"""Cases of which only some run each time."""

from __future__ import annotations

import pytest


def often(cases, *chosen):
    """Cases as parameters: the chosen ones always, the others with the long comparisons.

    `cases`: values, or tuples of the values of several arguments.
    """
    assert chosen and set(chosen) <= set(cases)
    marks = {True: (), False: (pytest.mark.verify,)}
    values = [(c, c if isinstance(c, tuple) else (c,)) for c in cases]
    return [pytest.param(*own, marks=marks[c in chosen]) for c, own in values]
