"""Ranks that die under mpirun: all end, and the next run finishes."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from jobs import mpirun, ranks_of

from solidwhirl.files.run_folder import verify_folder

pytestmark = [
    pytest.mark.solver,
    pytest.mark.mpi,
    pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun"),
]
RUN = (2, "-m", "solidwhirl", "run")
# Time in which a job whose rank died must be gone; an undisturbed run takes less, also on two
# cores that run other tests.
LIMIT_S = 150.0


def frequencies(out):
    document = json.loads((out / "results.json").read_text(encoding="utf-8"))
    return document["campbell"]["frequency_hz"]


def gone(ranks):
    """Wait until processes have ended."""
    end = time.monotonic() + LIMIT_S
    while any(Path(f"/proc/{rank}").exists() for rank in ranks):
        assert time.monotonic() < end, "a rank outlives its job"
        time.sleep(0.01)


@pytest.fixture
def scene(scene_path, tmp_path):
    """The scene with one body as a solid, coarse."""
    text = scene_path("one_body").read_text(encoding="utf-8")
    model = 'level = "solid", order = 2, size_m = 0.08, corner_size_m = 0.08'
    path = tmp_path / "solid.toml"
    changed = re.sub("^model = .*$", f"model = {{ modes = 2, {model} }}", text, flags=re.MULTILINE)
    path.write_text(changed.replace("modes = 2", 'modes = 2, estimates = "off"'), encoding="utf-8")
    return path


@pytest.mark.parametrize("rank", [pytest.param(0, marks=pytest.mark.verify), 1])
def test_killed_rank_ends_the_job(scene, tmp_path, rank):
    out = tmp_path / "out"
    options = ("--out", out, "--no-pictures")
    job = mpirun(*RUN, scene, *options)
    while not list(out.glob(".stages/*.stage")):  # the mesh: now both reduce
        assert job.poll() is None
        time.sleep(0.01)
    ranks = ranks_of(job, "solidwhirl")
    os.kill(ranks[rank], signal.SIGKILL)
    job.communicate(timeout=LIMIT_S)
    assert job.returncode != 0
    gone(ranks)  # mpirun does not wait for them, and one that is still there holds the folder
    assert verify_folder(out)
    again = mpirun(*RUN, scene, *options)
    _, said = again.communicate(timeout=LIMIT_S)
    assert again.returncode == 0, said
    assert verify_folder(out) == []
    stages = json.loads((out / "results.json").read_text(encoding="utf-8"))["stages"]
    assert stages["mesh rotor"] == "kept"
    if stages["reduction rotor"] == "kept":
        return
    third = mpirun(*RUN, scene, "--out", tmp_path / "whole", "--no-pictures")
    third.communicate(timeout=LIMIT_S)
    assert third.returncode == 0
    # reduced again on two ranks, whose sums MUMPS makes in the order in which they come in
    own, whole = (frequencies(folder) for folder in (out, tmp_path / "whole"))
    np.testing.assert_allclose(own, whole, rtol=1e-10)


@pytest.mark.parametrize(
    ("kind", "code", "said"),
    [
        ("defect", 1, "RuntimeError: a defect"),
        pytest.param("memory", 2, "not enough memory", marks=pytest.mark.verify),
    ],
)
def test_failure_of_one_rank_ends_all(scene, tmp_path, kind, code, said):
    script = Path(__file__).with_name("defect.py")
    job = mpirun(2, script, kind, "run", scene, "--out", tmp_path / "out")
    _, text = job.communicate(timeout=LIMIT_S)
    assert job.returncode == code
    assert said in text
    assert ("Traceback" in text) == (kind == "defect")
