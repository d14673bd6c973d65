"""The thread that works on the newest request alone."""

from __future__ import annotations

import threading

from solidwhirl.watch.newest import Newest


def test_what_came_before_the_newest_and_was_not_begun_is_dropped():
    done, begun, go = [], threading.Event(), threading.Event()

    def work(request):
        begun.set()
        assert go.wait(60)
        done.append(request)

    newest = Newest(work, "test")
    newest.start()
    newest.ask(0)
    assert begun.wait(60)
    assert not newest.is_outdated()
    for request in range(1, 100):
        newest.ask(request)
    assert newest.is_outdated()
    last = threading.Event()
    done_before = list(done)
    go.set()
    while done[-1:] != [99]:
        last.wait(0.01)
    assert done_before == [] and done == [0, 99]
    assert newest.end(60)


def test_it_waits_for_what_is_newer_and_ends():
    asked = threading.Event()
    seen = []

    def work(request):
        asked.set()
        seen.append(newest.is_outdated(60))

    newest = Newest(work, "test")
    newest.start()
    newest.ask("first")
    assert asked.wait(60)
    assert newest.end(60)  # which is told to the work that waits
    assert seen == [True]
    assert Newest(work, "never begun").end(0)
