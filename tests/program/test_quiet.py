"""Quiet runs still say what is doubtful, and all runs end with what is not as it should be."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app

pytestmark = pytest.mark.solver
ABSURD = """
[[analyses]]
name = "unbalance"
kind = "unbalance_response"
to_rpm = 1000
count = 5
unbalances = [{ at = "rotor.middle", moment_kg_m = 36.3 }]
observe = ["rotor.middle"]
"""


@pytest.fixture
def laval(root):
    return (root / "scenes" / "laval.toml").read_text("utf-8")


@pytest.fixture
def run(tmp_path):
    """Function: run a text as beams, without pictures."""

    def start(text, *options):
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        words = ["run", str(path), "--out", str(tmp_path / "out"), "--level", "beam"]
        return CliRunner().invoke(app, [*words, "--no-pictures", *options])

    return start


def test_doubts_are_said_in_quiet(run, laval):
    """Before the run that of a number, after it that of the supports; a line each, else nothing."""
    done = run(laval, "-q")
    assert (done.exit_code, done.output) == (0, "")
    head, _, second = laval.partition("[[bearings]]")
    one = head + "[[bearings]]" + second.partition("[[bearings]]")[0]
    done = run(one + ABSURD, "-q")
    assert (done.exit_code, done.stdout) == (0, ""), done.stderr
    first, last = done.stderr.splitlines()
    assert first.startswith("warning: analyses[0].unbalances[0].moment_kg_m: 36.3 kg m")
    assert last.startswith("warning: bearings: 'rotor' is held by one bearing only ('left')")


@pytest.mark.parametrize(
    "options", [("-q",), pytest.param(("--json",), marks=pytest.mark.verify), ()]
)
def test_an_accuracy_that_is_not_met_is_the_last_line(run, laval, tmp_path, options):
    # a thick shaft, whose beam theories differ
    thick = laval.replace('"light_steel"', '"steel"').replace("radius_m = 0.01 ", "radius_m = 0.1 ")
    done = run(thick, "--accuracy", "1e-5", *options)
    assert done.exit_code == 0
    line = done.stderr.splitlines()[-1]
    said = re.fullmatch(r"warning: accuracy not met: estimated error (.+) %, asked 0\.001 %", line)
    assert said, line
    found = json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))["accuracy"]
    assert found["met"] is False
    assert float(said[1]) == pytest.approx(100.0 * found["largest_error_estimate"], rel=0.05)
    if options == ("-q",):
        assert done.output == f"{line}\n"
