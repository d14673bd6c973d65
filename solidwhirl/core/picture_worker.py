"""What a process that draws pictures does; it imports what its pictures need, and no more."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from multiprocessing.reduction import ForkingPickler
from pathlib import Path


def follow_parent() -> None:
    """Leave interruptions to the process that waits for this one, and end when it is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def draw(job: bytes, path: Path) -> None:
    """Draw a picture to a file; `job`: a function that does so, as it came from the parent."""
    path.parent.mkdir(parents=True, exist_ok=True)
    ForkingPickler.loads(job)(path)
