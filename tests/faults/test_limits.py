"""Full and read-only disks, too little memory, signals: one message, and the next run finishes."""

from __future__ import annotations

import shutil
import subprocess

import pytest

pytestmark = [pytest.mark.solver, pytest.mark.verify]


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


@pytest.fixture(scope="module", params=["short", "long"])
def found(request, script, scene_path, tmp_path_factory):
    """What runs said and left under all limits that can be set here, by the limit."""
    command = mounts()
    kinds = ("files", "memory", "signals", *(["disk"] if command else []))
    folder = tmp_path_factory.mktemp("limits")
    words = (scene_path("one_body"), folder, request.param, *kinds)
    return script("limits.py", *words, prefix=command or ())


def test_disk_that_is_full_or_read_only(found):
    if "disk" not in found:
        pytest.skip("file systems can not be mounted here")
    disks = dict(found["disk"])
    whole = {name: disks.pop(name) for name in ("read-only", "full, old results")}
    late = 0
    for state in disks.values():
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


def test_files_that_can_not_grow(found):
    for state in found["files"].values():
        assert "File too large" in refused(state)
        assert state["problems"]
        finishes(state)


def test_limit_of_memory(found):
    """Those that are not enough end in one message; none in a wait."""
    said = []
    for state in found["memory"].values():
        assert state["seconds"] < 50.0
        if state["code"] == 0:
            assert state["right"]
            continue
        finishes(state)
        if state["code"] > 0:  # a library's own crash is a signal
            said.append(refused(state))
    assert len(said) >= 2
    assert all("not enough memory" in text for text in said)


def test_signals_and_two_at_once(found):
    signals = found["signals"]
    assert "ended by the system (SIGTERM)" in refused(signals["SIGTERM"], 143)
    assert "interrupted" in refused(signals["SIGINT"], 130)
    for name in ("SIGTERM", "SIGINT"):
        assert signals[name]["problems"]
        finishes(signals[name])
    second = signals["second"]
    assert second["code"] == 2
    (message,) = second["errors"]
    assert f"process {second['pid']} since" in message
    assert "mesh" not in second["said"]
    assert second["right"]
