"""Labels keep their order, do not overlap, and stay as near as can be; rulers are round."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from solidwhirl.drawing.labels import Label, label_block, label_height, spread
from solidwhirl.drawing.shapes import Words, ruler_steps


def test_labels_with_room_stay_where_they_belong():
    np.testing.assert_array_equal(spread([3.0, 0.0, 9.0], [1.0, 2.0, 0.5]), [3.0, 0.0, 9.0])
    assert spread([], []).size == 0


def test_order_of_the_labels_is_kept():
    shown = spread([5.0, 4.9, 5.1], [1.0, 1.0, 1.0])
    assert shown[1] < shown[0] < shown[2]
    assert shown.mean() == pytest.approx(5.0)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0, 100, allow_nan=False), st.floats(1, 30, allow_nan=False)),
        min_size=1,
        max_size=6,
    )
)
def test_labels_are_apart_and_move_as_little_as_can_be(found):
    found = sorted(found)
    places, widths = np.array([p for p, _ in found]), np.array([w for _, w in found])
    at = spread(list(places), list(widths))
    gaps = 0.5 * (widths[1:] + widths[:-1])
    assert (np.diff(at) >= gaps - 1e-9).all()
    # the same least squares in the first place and the distances, which have lower bounds
    steps = np.tril(np.ones((len(places), len(places))))
    least = np.concatenate([[-1e4], gaps])
    best = scipy.optimize.lsq_linear(steps, places, bounds=(least, 1e4), method="bvls", tol=1e-14)
    np.testing.assert_allclose(at, steps @ best.x, atol=1e-6)


def test_many_labels_stay_inside_the_picture():
    labels = [Label(x=900.0 + 0.1 * k, words=(f"body.node{k}",)) for k in range(30)]
    height = label_height(labels, 1040.0)
    shapes = label_block(labels, 1040.0, base=height, target=400.0, way="up")
    feet = [s.x for s in shapes if isinstance(s, Words)]
    assert len(feet) == 30
    # the line of text is 15 units high; slanted by 55° it needs 15 / sin 55° along the axis, of
    # which letters fill all but 2
    assert min(b - a for a, b in itertools.pairwise(feet)) >= 15.0 / np.sin(np.radians(55)) - 2.1
    assert min(feet) >= 0.0
    assert max(feet) <= 1040.0


@settings(max_examples=50, deadline=None)
@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e4), st.integers(3, 20))
def test_rulers_have_round_steps(low, span, most):
    steps = np.array(ruler_steps(low, low + span, most))
    assert len(steps) <= most + 1
    assert (steps >= low - 1e-9 * (abs(low) + span)).all()
    assert (steps <= low + span + 1e-9 * (abs(low) + span)).all()
    if len(steps) > 1:
        step = np.diff(steps).mean()
        first = step / 10.0 ** np.floor(np.log10(step) + 1e-9)
        assert min(abs(first - f) for f in (1.0, 2.0, 5.0)) < 1e-3
