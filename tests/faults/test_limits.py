"""Full and read-only disks, too little memory, signals: one message, and the next run finishes."""

from __future__ import annotations

import shutil
import subprocess

import pytest

pytestmark = pytest.mark.solver


def mounts():
    """Command that may mount; none where that is not allowed."""
    command = ("unshare", "--mount")
    if shutil.which("unshare") is None:
        return None
    trial = [*command, "mount", "-t", "tmpfs", "none", "/mnt"]
    allowed = subprocess.run(trial, capture_output=True, check=False).returncode == 0
    return command if allowed else None


def refused(state, code=2):
    """One message, no traceback, nothing half, nothing left."""
    assert state["code"] == code, state
    assert len(state["errors"]) == 1, state
    assert state["said"].rstrip().splitlines()[-1] == state["errors"][0][-600:], state
    assert not state["traceback"], state
    assert state["leftovers"] == [], state
    return state["errors"][0]


def finishes(state):
    assert state["next_code"] == 0, state
    assert state["next_right"], state


def test_disk_that_is_full_or_read_only(script, scene_path, tmp_path):
    command = mounts()
    if command is None:
        pytest.skip("file systems can not be mounted here")
    found = script("limits.py", scene_path("one_body"), tmp_path, "disk", prefix=command)["disk"]
    whole = {name: found.pop(name) for name in ("read-only", "full, old results")}
    late = 0
    for state in found.values():
        assert "No space left on device" in refused(state)
        assert state["problems"], "half a run passes the check"
        finishes(state)
        late += "write the results" in state["said"]
    assert late >= 1  # others are refused before the work
    for state in whole.values():
        message = refused(state)
        assert "can not be written" in message
        assert "mesh" not in state["said"]
        assert state["problems"] == []
        assert state["right"]
    assert whole["read-only"]["seconds"] < 5.0


def test_files_that_can_not_grow(script, scene_path, tmp_path):
    found = script("limits.py", scene_path("one_body"), tmp_path, "files")["files"]
    for state in found.values():
        assert "File too large" in refused(state)
        assert state["problems"]
        finishes(state)


def test_limit_of_memory(script, scene_path, tmp_path):
    """Those that are not enough end in one message; none in a wait."""
    found = script("limits.py", scene_path("one_body"), tmp_path, "memory")["memory"]
    said = []
    for state in found.values():
        assert state["seconds"] < 50.0
        if state["code"] == 0:
            assert state["right"]
            continue
        finishes(state)
        if state["code"] > 0:  # a library's own crash is a signal
            said.append(refused(state))
    assert len(said) >= 2
    assert all("not enough memory" in text for text in said)


def test_signals_and_two_at_once(script, scene_path, tmp_path):
    found = script("limits.py", scene_path("one_body"), tmp_path, "signals")["signals"]
    assert "ended by the system (SIGTERM)" in refused(found["SIGTERM"], 143)
    assert "interrupted" in refused(found["SIGINT"], 130)
    for name in ("SIGTERM", "SIGINT"):
        assert found[name]["problems"]
        finishes(found[name])
    second = found["second"]
    assert second["code"] == 2
    (message,) = second["errors"]
    assert f"process {second['pid']} since" in message
    assert "mesh" not in second["said"]
    assert second["right"]
