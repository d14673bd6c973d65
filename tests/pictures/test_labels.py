"""Labels keep their order, do not overlap, and stay as near as can be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from solidwhirl.pictures.labels import spread

PLACES = st.lists(st.floats(-10, 10), min_size=1, max_size=12)


@settings(max_examples=60, deadline=None)
@given(PLACES, st.floats(0.1, 3.0))
def test_no_label_covers_another(places, width):
    shown = np.sort(spread(places, [width] * len(places)))
    # 1e-9: rounding of places of the size 10
    assert (np.diff(shown) >= width - 1e-9).all()


def test_labels_with_room_stay_where_they_belong():
    np.testing.assert_array_equal(spread([3.0, 0.0, 9.0], [1.0, 2.0, 0.5]), [3.0, 0.0, 9.0])
    assert spread([], []).size == 0


def test_nearest_places_as_a_minimiser_finds_them():
    places, widths = np.array([0.0, 0.2, 0.3, 4.0, 4.1, 9.0]), np.array([1, 2, 1, 1, 3, 1.0])
    gap = 0.5 * (widths[1:] + widths[:-1])
    found = minimize(
        lambda x: ((x - places) ** 2).sum(),
        np.cumsum(np.append(0.0, gap)),
        constraints={"type": "ineq", "fun": lambda x: np.diff(x) - gap},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 400},
    )
    # SLSQP stops where the square of the distance is flat to rounding
    np.testing.assert_allclose(spread(places, widths), found.x, atol=1e-5)


def test_order_of_the_labels_is_kept():
    shown = spread([5.0, 4.9, 5.1], [1.0, 1.0, 1.0])
    assert shown[1] < shown[0] < shown[2]
    assert shown.mean() == pytest.approx(5.0)
