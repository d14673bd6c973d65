"""Ranks that die under mpirun: all end, and the next run finishes."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from jobs import SOLID, mpirun, ranks_of

from solidwhirl.files.run_folder import verify_folder
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import read_scene

pytestmark = [
    pytest.mark.solver,
    pytest.mark.mpi,
    pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun"),
]
SCRIPT = Path(__file__).with_name("defect.py")
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
def scene(one_body):
    """The scene with one body as a small solid."""
    return one_body("solid", **SOLID)


@pytest.mark.verify
@pytest.mark.parametrize("rank", [pytest.param(0, marks=pytest.mark.verify), 1])
def test_killed_rank_ends_the_job(scene, tmp_path, rank):
    out = tmp_path / "out"
    words = ("run", scene, "--out", out, "--no-pictures")
    job, ranks = mpirun(2, SCRIPT, f"kill:{rank}", *words), []
    while len(ranks) < 2:
        assert job.poll() is None, job.communicate()
        ranks = ranks_of(job, SCRIPT.name)
    job.communicate(timeout=LIMIT_S)
    assert job.returncode != 0
    gone(ranks)  # mpirun does not wait for them, and one that is still there holds the folder
    assert verify_folder(out)
    again = mpirun(2, "-m", "solidwhirl", *words)
    _, said = again.communicate(timeout=LIMIT_S)
    assert again.returncode == 0, said
    assert verify_folder(out) == []
    stages = json.loads((out / "results.json").read_text(encoding="utf-8"))["stages"]
    assert (stages["mesh rotor"], stages["reduction rotor"]) == ("kept", "computed")
    # on one rank sums come in another order
    alone = run_scene(read_scene(scene)).campbell.frequency_hz
    np.testing.assert_allclose(frequencies(out), alone, rtol=1e-10)


@pytest.mark.parametrize(
    ("kind", "code", "said"),
    [
        ("defect", 1, "RuntimeError: a defect"),
        pytest.param("memory", 2, "not enough memory", marks=pytest.mark.verify),
    ],
)
def test_failure_of_one_rank_ends_all(scene, tmp_path, kind, code, said):
    job = mpirun(2, SCRIPT, kind, "run", scene, "--out", tmp_path / "out")
    _, text = job.communicate(timeout=LIMIT_S)
    assert job.returncode == code
    assert said in text
    assert ("Traceback" in text) == (kind == "defect")
