"""Groups of indices that a relation joins, against the graph library."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from solidwhirl.rotordyn.core.arrays import together


def test_groups_are_the_components_of_a_graph():
    chance = np.random.default_rng(3)
    for count in (1, 2, 7, 30):
        for links in (0.3, 1.0, 2.0):
            near = chance.random((count, count)) < links / count
            number, label = connected_components(near, directed=False)
            found = together(near)
            assert [g.tolist() for g in found] == [
                np.flatnonzero(label == k).tolist() for k in range(number)
            ]
    chain = np.eye(200, k=1, dtype=bool)
    assert [g.size for g in together(chain)] == [200]
    assert together(np.zeros((0, 0), dtype=bool)) == []
