"""Time and problems by stage."""

from __future__ import annotations

from threading import Barrier, Thread

from solidwhirl.bodies.reduction import Clock
from solidwhirl.rotordyn.core.ledger import SYSTEMS


def test_threads_that_share_a_clock_count_their_own():
    """Both are in a stage at once; neither closes that of the other."""
    clock, both = Clock(), Barrier(2)

    def work(name, count):
        with clock.stage(name):
            both.wait(60)
            SYSTEMS.add("eigenproblems", count)
            both.wait(60)

    threads = [Thread(target=work, args=asked) for asked in (("campbell", 2), ("checks", 3))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    found = {name: dict(counts) for name, counts in clock.solved.items()}
    assert found == {"campbell": {"eigenproblems": 2}, "checks": {"eigenproblems": 3}}
    assert set(clock.seconds) == {"campbell", "checks"}
