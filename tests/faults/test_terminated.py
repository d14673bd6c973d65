"""SIGTERM at any moment of a command: one line or none, no traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SCENE = Path(__file__).parents[2] / "scenes" / "ferraris.toml"

MOMENTS_S = [0.3, 0.8, 1.4, *(pytest.param(t, marks=pytest.mark.verify) for t in (0.5, 1.1, 1.9))]


@pytest.mark.parametrize("moment_s", MOMENTS_S)
def test_ends_without_a_traceback(moment_s):
    # Starting, reading, planning and leaving again: the windows around the guarded work.
    job = subprocess.Popen(
        [sys.executable, "-m", "solidwhirl", "plan", str(SCENE)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(moment_s)
    job.send_signal(signal.SIGTERM)
    _, said = job.communicate(timeout=30)
    assert job.returncode in (0, 128 + signal.SIGTERM, -signal.SIGTERM)
    assert "Traceback" not in said
    assert job.returncode != 128 + signal.SIGTERM or "ended by the system (SIGTERM)" in said
