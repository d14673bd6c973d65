"""Runs of the command on small scenes: what it writes, and what it leaves alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from results_read import results_in
from toml_text import toml
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.output.documents import write_results

pytestmark = pytest.mark.solver


@pytest.fixture
def run(tmp_path):
    """Function: run the command on scene data, return what it did."""

    def start(data, out="out", *options):
        path = tmp_path / "scene.toml"
        path.write_text(toml(data), encoding="utf-8")
        return CliRunner().invoke(app, ["run", str(path), "--out", str(tmp_path / out), *options])

    return start


@pytest.mark.parametrize("rpm", [None, (12000.0,)])
def test_single_speed(run, small_scene, tmp_path, rpm):
    """[speeds] absent means at rest; one column either way."""
    done = run(small_scene(rpm=rpm), "out", "--pictures")
    assert done.exit_code == 0, done.stderr
    document = results_in(tmp_path / "out")
    diagram = document["campbell"]
    assert diagram["speed_rpm"] == pytest.approx([0.0] if rpm is None else list(rpm))
    for key in ("frequency_hz", "whirl", "log_decrement"):
        assert [len(branch) for branch in diagram[key]] == [1] * 4
    assert (tmp_path / "out" / "campbell.png").read_bytes()[:4] == b"\x89PNG"
    found = [branch[0] for branch in diagram["frequency_hz"]]
    rest = document["modes_at_rest"]["frequency_hz"][:4]
    if rpm is None:
        assert document["critical_speeds"] == []
        assert found == pytest.approx(rest, rel=1e-9)
    else:
        assert found[0] < rest[0] < found[1]  # the first pair has split


def test_ended_branch_is_null_not_nan(computed, tmp_path):
    """Where a branch has ended there is no number: null in JSON, a dash in the report."""
    results = computed("laval")
    ended = {}
    for key, absent in (("frequency_hz", np.nan), ("log_decrement", np.nan), ("whirl", "")):
        values = getattr(results.campbell, key).copy()
        values[3, 5:] = absent
        ended[key] = values
    diagram = dataclasses.replace(results.campbell, **ended)
    out = write_results(
        dataclasses.replace(results, campbell=diagram), tmp_path / "out", pictures=False
    )
    written = results_in(out)["campbell"]
    assert written["frequency_hz"][3][5:] == [None] * 8
    assert written["log_decrement"][3][5:] == [None] * 8
    assert None not in written["frequency_hz"][3][:5]
    table = (out / "report.md").read_text(encoding="utf-8").split("## Frequencies")[1]
    last = next(line for line in table.splitlines() if line.startswith("| 4 |"))
    assert last.split("|")[3:5] == [" - ", " - "]  # middle and last speed


def test_rotor_without_bearings(run, small_scene, tmp_path):
    """Free in space: the spectrum is that of the free body, bearings none."""
    data = small_scene(rpm=None)
    data["bearings"] = []
    done = run(data)
    assert done.exit_code == 0, done.stderr
    document = results_in(tmp_path / "out")
    free = document["bodies"]["rotor"]["free_frequencies_hz"]
    np.testing.assert_allclose(document["modes_at_rest"]["frequency_hz"][:4], free[:4], rtol=1e-8)


def test_command_writes_and_options_change_the_model(run, small_scene, tmp_path):
    done = run(small_scene(), "out", "--pictures")
    assert done.exit_code == 0, done.stderr
    for name in ("campbell.png", "report.md", "results.json"):
        assert str(tmp_path / "out" / name) in done.stdout
        assert (tmp_path / "out" / name).is_file()
    assert "mesh rotor" in done.stderr
    quiet = run(small_scene(), "fine", "--accuracy", "0.001", "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, "")
    coarse, fine = (results_in(tmp_path / name) for name in ("out", "fine"))
    assert fine["plan"]["bodies"]["rotor"]["element_order"] == 3
    assert coarse["plan"]["bodies"]["rotor"]["element_order"] == 2
    assert fine["bodies"]["rotor"]["full_dofs"] > coarse["bodies"]["rotor"]["full_dofs"]
    assert fine["scene"]["sha256"] != coarse["scene"]["sha256"]
    # displacement models converge from above; the rule promises 5 % for the coarse one
    first, better = (d["modes_at_rest"]["frequency_hz"][0] for d in (coarse, fine))
    assert better < first < 1.05 * better
