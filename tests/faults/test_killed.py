"""Runs killed by SIGKILL at moments spread over their length, and the runs after them."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.solver

SCENES = [("one_body", ()), ("two_bodies", ("--no-pictures",))]


def check(found, count):
    assert len(found) == count
    for one in found:
        assert one["good_is_whole"], one  # nothing half-written passes the check
        assert not one["damaged"], one  # no entry was found that is not whole
        assert one["code"] == 0, one
        assert one["differs"] == [], one  # to the last bit
        assert one["problems"] == [], one
        assert one["leftovers"] == [], one
        # what was complete is not done again
        assert (one["kept"] > 0) == (one["stages_left"] > 0), one
    # how many were still running depends on what else the machine does
    assert sum(one["killed"] for one in found) >= 0.4 * count
    assert len({one["stages_left"] for one in found}) > 1
    assert any(one["over_old"] and one["killed"] for one in found)


def test_next_run_finishes(script, scene_path, tmp_path):
    options = ("--no-pictures", "--level", "beam")  # a fork need not load what makes meshes then
    check(script("killed.py", scene_path("one_body"), tmp_path, 4, 1, *options), 4)


@pytest.mark.verify
@pytest.mark.parametrize(("name", "options"), SCENES)
def test_next_run_finishes_after_any_moment(script, scene_path, tmp_path, name, options):
    """One moment in each twelfth of a run; killed.py takes any number."""
    check(script("killed.py", scene_path(name), tmp_path, 12, 2, *options), 12)
