"""`solidwhirl export`: every format from one body, what it says, and what it refuses."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.commands.export_command import FORMATS
from solidwhirl.rotordyn import Disk, beam_superelement, read_superelement, write_superelement
from solidwhirl.rotordyn.storage.sidecar import superelement_document


@pytest.fixture(scope="module")
def body(tmp_path_factory):
    """A beam with a disk: it has all that formats ask for."""
    disk = Disk(name="wheel", position_m=0.25, mass_kg=3.0, polar_kg_m2=0.02, diametral_kg_m2=0.011)
    element = beam_superelement(
        "rotor",
        np.linspace(0.0, 0.6, 7),
        0.02,
        0.0,
        (2e11, 0.3, 7800.0),
        {"left": 0.0, "right": 0.6},
        disks=[disk],
        components=("ux", "uy", "uz", "rx", "ry", "rz"),
    )
    path = tmp_path_factory.mktemp("body") / "rotor.h5"
    write_superelement(element, path)
    return path


def called(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_written_alike_each_time_and_says_what_it_carries(body, tmp_path, name):
    written = []
    for folder in (tmp_path / "new" / "a", tmp_path / "new" / "b"):
        out = folder / f"rotor{FORMATS[name].ending}"
        done = called(body, "--format", name, "-o", out)
        assert done.exit_code == 0, done.output
        assert out.exists()
        assert f"written: {out}" in done.output and "carried: " in done.output
        # nothing is left beside what is named
        named = {line.removeprefix("written: ") for line in done.output.splitlines()}
        assert {str(path) for path in folder.iterdir()} <= named | {str(out)}
        written.append([p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()])
    assert written[0] == written[1]


def test_sidecar_holds_what_the_body_is(body, tmp_path):
    out = tmp_path / "rotor.json"
    assert called(body, "--format", "json", "-o", out).exit_code == 0
    found = json.loads(out.read_text(encoding="utf-8"))
    element = read_superelement(body)
    assert found == json.loads(json.dumps(superelement_document(element)))
    assert [row["row"] for row in found["coordinates"]] == list(range(len(element.coordinates)))
    # mass of shaft and disk in closed form
    assert found["mass_kg"] == pytest.approx(3.0 + 7800.0 * np.pi * 0.02**2 * 0.6, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--format", "elf"), "--format: unknown 'elf'; allowed are sid, mbdyn"),
        (("--format", "Nastran"), "unknown 'Nastran'; that program reads dmig and op4; "),
        (("--format", "simpack"), "that program reads sid; "),
        (("--format", "abaqus"), "unknown 'abaqus'; matrix-market and npz hold the matrices"),
        (("--format", "npz", "--layout", "mode"), "--layout: not an option of npz; sid have it"),
        (("--format", "dmig", "--speed-rpm", "nan"), "--speed-rpm: found nan, a finite number"),
        (("--format", "json", "--modes", "3"), "--modes: not an option of json"),
    ],
)
def test_wrong_options(body, tmp_path, arguments, said):
    done = called(body, *arguments, "-o", tmp_path / "x")
    assert done.exit_code == 2
    assert said in done.output
    assert list(tmp_path.iterdir()) == []


def test_wrong_places(body, tmp_path):
    """Of the file to write and of the body to read; nothing is written, no folder is made."""
    run, empty = tmp_path / "run", tmp_path / "empty"
    (run / "bodies").mkdir(parents=True)
    shutil.copy(body, run / "bodies" / "rotor.h5")
    empty.mkdir()
    damaged = tmp_path / "damaged.h5"
    data = bytearray(body.read_bytes())
    data[len(data) // 2] ^= 1
    damaged.write_bytes(data)
    x = tmp_path / "other" / "x.npz"
    bodies = f"{run}: is a folder of a run; bodies in it: {run / 'bodies' / 'rotor.h5'}"
    for source, out, said in (
        (body, damaged / "no" / "x.npz", "x.npz: can not be written: "),
        (body, tmp_path, "it is a folder"),
        (body, body, "is the file to export"),
        (run, x, bodies),
        (empty, x, "is a folder without bodies"),
        (damaged, x, str(damaged)),
        (tmp_path / "none.h5", x, "none.h5"),
    ):
        done = called(source, "--format", "npz", "-o", out)
        assert done.exit_code == 2 and said in done.output.replace("\n", "")
    assert not x.parent.exists()


def test_formats_are_listed():
    done = CliRunner().invoke(app, ["formats"])
    assert [line.split()[0] for line in done.output.splitlines()] == list(FORMATS)


def test_exports_need_no_solver(body, tmp_path):
    # a reduced body leaves on a machine without the finite element libraries
    text = f"""
import sys
for name in ("dolfinx", "petsc4py", "slepc4py", "gmsh", "mpi4py", "exudyn", "pyNastran", "ross"):
    sys.modules[name] = None
from pathlib import Path
from solidwhirl.commands.export_command import FORMATS, export_body
for name in FORMATS:
    export_body(Path({str(body)!r}), name, Path({str(tmp_path)!r}) / ("x" + name), {{}})
"""
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
