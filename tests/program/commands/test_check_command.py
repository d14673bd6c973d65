"""`solidwhirl check`: any superelement file, and the folder of a run."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.linalg as la
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.rotordyn import Disk, beam_superelement, rigid_superelement, write_superelement


def run(*arguments):
    return CliRunner().invoke(app, ["check", *map(str, arguments)], env={"COLUMNS": "200"})


def document(*arguments):
    done = run(*arguments, "--json")
    return done.exit_code, json.loads(done.stdout)


def bad(found):
    return {c["name"] for one in found["paths"] for c in one["checks"] if c["passed"] is False}


def shaft():
    disk = Disk(name="d", position_m=0.3, mass_kg=5.0, diametral_kg_m2=0.02, polar_kg_m2=0.035)
    return beam_superelement(
        "shaft",
        np.linspace(0.0, 0.6, 9),
        0.02,
        0.0,
        (2e11, 0.3, 7800.0),
        {"a": 0.0, "b": 0.6, "mid": 0.3},
        [disk],
    )


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "shaft.h5"
    write_superelement(shaft(), path)
    return path


def test_a_good_file_passes(file):
    done = run(file)
    assert done.exit_code == 0, done.output
    for text in ("mass properties", "modal frequencies", "passed", "can't be trusted if it fails"):
        assert text in done.stdout
    assert done.stderr == ""
    code, found = document(file)
    assert code == found["exit_code"] == 0
    assert found["schema"] == "solidwhirl-checks-1"
    (one,) = found["paths"]
    assert one["problem"] is None
    assert len(one["checks"]) >= 14
    assert all(entry["passed"] for entry in one["checks"])


def test_good_files_of_other_kinds_pass(tmp_path):
    """A rigid body off the axis, one with its interfaces in another place, one held."""
    bodies = [
        rigid_superelement("casing", 9.0, [0.1, 0.0, 0.3], [1.0, 2.0, 2.5], {"p": [0.2, 0.1, 0.0]}),
        rigid_superelement("hub", 3.0, [0, 0, 0], [0.1, 0.1, 0.15], {"p": 0.0}, ("ux", "uy")),
        dataclasses.replace(shaft(), spin_generator=None),
    ]
    for number, body in enumerate(bodies):
        write_superelement(body, tmp_path / f"{number}.h5")
    done = run(*sorted(tmp_path.glob("*.h5")))
    assert done.exit_code == 0, done.output


def elsewhere(path):
    """The same body as another program might write it: other modal coordinates, nothing optional.

    Modal coordinates are mixed in pairs of neighbours, and all of them turned over.
    """
    element = shaft()
    held = sum(c.kind == "interface" for c in element.coordinates)
    n = element.size
    turn = np.eye(n)
    mix = la.qr(np.random.default_rng(1).standard_normal((n - held, n - held)))[0]
    turn[held:, held:] = mix
    names = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    parts = {name: turn.T @ getattr(element, name) @ turn for name in names}
    sign = {"gyroscopic": -1.0}
    parts = {k: 0.5 * (v + sign.get(k, 1.0) * v.T) for k, v in parts.items()}
    write_superelement(
        dataclasses.replace(
            element,
            **parts,
            rigid_body_modes=turn.T @ element.rigid_body_modes,
            recovery_points_m=np.zeros((0, 3)),
            recovery_modes=np.zeros((0, 3, n)),
            free_frequencies_hz=np.empty(0),
            error_forms=(),
            spin_generator=None,
            moments=None,
        ),
        path,
    )
    with h5py.File(path, "r+") as stored:
        del stored["provenance"]
        del stored["operators/Keul"]
        stored.attrs["generator"] = "another program 3.1"
        del stored.attrs["created_utc"]
    unsealed(path)


def test_a_file_from_elsewhere_passes(tmp_path):
    elsewhere(tmp_path / "other.h5")
    code, found = document(tmp_path / "other.h5")
    assert code == 0, found
    names = {entry["name"] for entry in found["paths"][0]["checks"]}
    # what it does not have is not asked for
    assert "rigid motion in pictures" not in names
    assert "the same after a turn about the axis" not in names


def unsealed(path):
    """Set the checksum to zero, as a file has it that another program wrote or changed."""
    with path.open("r+b") as raw:
        raw.write(bytes(512))


def scaled(path, place, index, factor):
    with h5py.File(path, "r+") as stored:
        data = np.array(stored[place][()])
        data[index] *= factor
        stored[place][...] = data
    unsealed(path)


def largest(path, place, factor):
    """The largest entry off the diagonal, on one side; symmetry is relative to the largest."""
    with h5py.File(path) as stored:
        upper = np.abs(np.triu(stored[place][()], 1))
    scaled(path, place, np.unravel_index(upper.argmax(), upper.shape), factor)


# Damage of all other operators and properties: tests of the checks themselves.
@pytest.mark.parametrize(
    ("damage", "name", "concerns"),
    [
        (lambda p: largest(p, "operators/M", 1 + 1e-6), "mass symmetric", "all frequencies"),
        (lambda p: largest(p, "operators/K0", 1 + 1e-6), "stiffness symmetric", "all frequencies"),
        (lambda p: scaled(p, "operators/G", (0, 1), 1 + 1e-4), "gyroscopic skew", "at speed"),
        (lambda p: scaled(p, "body/mass", (), 1.001), "mass properties", "all frequencies"),
        (
            lambda p: scaled(p, "body/rigid_modes", (3, 4), 0.99),
            "rigid motion at the interfaces",
            "bearings and disks",
        ),
    ],
)
def test_one_damage_fails_its_own_check(file, damage, name, concerns):
    damage(file)
    code, found = document(file)
    assert code == 3
    failing = [c for c in found["paths"][0]["checks"] if c["passed"] is False]
    # a rigid motion that is none moves K, M and the points too
    if name != "rigid motion at the interfaces":
        assert [c["name"] for c in failing] == [name]
    entry = next(c for c in failing if c["name"] == name)
    assert concerns in entry["concerns"]
    done = run(file)
    assert done.exit_code == 3
    assert f"check failed: shaft: {name}" in done.stderr
    assert f"can't be trusted: {entry['concerns']}" in done.stderr
    assert "failed" in done.stdout


def test_a_mass_without_inertia_fails_the_check_of_its_inertia(file):
    scaled(file, "body/J_com", np.index_exp[:], 0.0)
    done = run(file)
    assert done.exit_code == 3 and "polar inertia of the tilts: inf" in done.stderr


def test_unreadable_files(file, tmp_path):
    missing = tmp_path / "none.h5"
    cut = tmp_path / "cut.h5"
    cut.write_bytes(file.read_bytes()[:5000])
    text = tmp_path / "text.h5"
    text.write_text("no HDF5")
    for path in (missing, cut, text):
        done = run(path)
        assert done.exit_code == 2
        assert done.stderr.startswith(f"error: {path}")
        assert "Traceback" not in done.output
        assert not done.exception or isinstance(done.exception, SystemExit)
    # what can't be read counts more than what failed; the readable ones are checked all the same
    scaled(file, "body/mass", (), 1.001)
    code, found = document(file, missing)
    assert code == 2
    assert bad(found) == {"mass properties"}
    assert "no such file" in found["paths"][1]["problem"]


def test_names_of_strangers_can_not_move_the_terminal(file):
    with h5py.File(file, "r+") as stored:
        stored.attrs["name"] = "a\x1b[2Jb[red]c"
        stored["body/mass"][...] = 1.0
    unsealed(file)
    done = run(file)
    assert done.exit_code in (2, 3)
    assert "\x1b[2J" not in done.output


# Folders of runs.


def folder(path, invariants):
    """What `check` looks at in the folder of a run."""
    (path / "bodies").mkdir(parents=True)
    write_superelement(shaft(), path / "bodies" / "shaft.h5")
    content = {"schema": "solidwhirl-results-1"}
    if invariants is not None:
        content["invariants"] = invariants
    (path / "results.json").write_text(json.dumps(content))
    names = ["bodies/shaft.h5", "results.json"]
    lines = [f"{hashlib.sha256((path / n).read_bytes()).hexdigest()}  {n}\n" for n in names]
    (path / "SHA256SUMS").write_text("".join(lines))
    return path


GOOD = {
    "name": "no mode is missing",
    "where": "Campbell diagram",
    "value": 0.0,
    "limit": 0.0,
    "passed": True,
    "concerns": "branches of the Campbell diagram",
    "reason": "",
}


def test_the_folder_of_a_run_passes_by_what_the_run_recorded(tmp_path):
    path = folder(tmp_path / "run", [GOOD, {**GOOD, "passed": None, "value": None}])
    code, found = document(path)
    assert code == 0, found
    assert [Path(one["path"]).name for one in found["paths"]] == ["run", "shaft.h5"]
    first = found["paths"][0]["checks"]
    assert [c["name"] for c in first] == [
        "files are as the run wrote them",
        "checks recorded by the run",
    ]
    assert first[1]["reason"] == "2 recorded: 1 passed, 1 not applicable"
    path = folder(tmp_path / "bad", [GOOD, {**GOOD, "passed": False, "value": 1.0}])
    done = run(path)
    assert done.exit_code == 3
    assert "Campbell diagram: no mode is missing" in done.stderr
    assert "can't be trusted: branches of the Campbell diagram" in done.stderr
    code, found = document(folder(tmp_path / "old", None))
    entry = found["paths"][0]["checks"][1]
    assert (code, entry["passed"], entry["reason"]) == (0, None, "the run recorded none")


def test_changed_and_missing_files_fail(tmp_path):
    path = folder(tmp_path / "run", [GOOD])
    body = path / "bodies" / "shaft.h5"
    scaled(body, "operators/Kspin", (0, 0), 1.0)
    changed = bytearray(body.read_bytes())
    changed[-1] ^= 1
    body.write_bytes(changed)
    code, found = document(path)
    assert code in (2, 3)
    assert "files are as the run wrote them" in bad(found)
    (path / "SHA256SUMS").unlink()
    assert "files are as the run wrote them" in bad(document(path)[1])


@pytest.mark.parametrize(
    "content",
    [
        *("{", "[1]", '{"invariants": 3}', '{"invariants": [{"name": 1}]}', '{"a": NaN'),
        *("[" * 100_000, '{"a": 1' + "0" * 400 + "}"),
    ],
)
def test_results_that_can_not_be_read(tmp_path, content):
    path = folder(tmp_path / "run", [GOOD])
    (path / "results.json").write_text(content)
    done = run(path)
    assert done.exit_code == 2
    assert "results.json: " in done.stderr
    assert "Traceback" not in done.output
