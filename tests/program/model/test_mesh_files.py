"""What a mesh file says of reference nodes and masses, in the scene that names it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.reader import parse_scene

sys.path.insert(0, str(Path(__file__).parents[2] / "meshing"))

from mesh_makers import BDF, INP

RBE = (
    "GRID,99,,.5,.5,2.5\nRBE3,7,,99,123456,1.,123,21,22,+\n+,23,24\n"
    "GRID,98,,.5,.5,0.\nRBE2,8,98,123456,1,2,3,4\n"
)
CONM2 = "CONM2,30,99,,4.,0.,0.,.25,,+\n+,.2,0.,.2,0.,0.,.3\n"
COUPLED = (
    "*NODE\n99, .5, .5, 2.5\n*COUPLING, CONSTRAINT NAME=Seat-1, REF NODE=99, SURFACE=ROOF\n"
    "*KINEMATIC\n"
)


def read(folder, name, text, bearings=(), **body):
    (folder / name).write_text(text)
    own = {
        "file": name,
        "length_unit": "mm",
        "material": "steel",
        "axis": {"origin": [0.5, 0.5, 0]},
    }
    data = {"name": "own", "mesh_bodies": {"rotor": own | body}, "speeds": {"list_rpm": [0.0]}}
    held = [
        {"name": f"b{k}", "first": at, "stiffness_n_per_m": 1e6} for k, at in enumerate(bearings)
    ]
    return parse_scene(data | {"bearings": held}, folder / "scene.toml").mesh_bodies["rotor"]


def bdf(more):
    return BDF.replace("CQUAD4         9", f"{more}CQUAD4         9", 1)


def test_couplings_become_interfaces(tmp_path):
    """The rigid one always, the distributing one where the scene or a mass needs it."""
    (rigid,) = read(tmp_path, "a.bdf", bdf(RBE)).interfaces
    assert (rigid.name, rigid.coupling, rigid.node_m) == ("rbe2_8", "rigid", (0.0, 0.0, 0.0))
    named = read(tmp_path, "a.bdf", bdf(RBE), bearings=["rotor.rbe3_7"]).interfaces
    assert {i.name: i.coupling for i in named} == {"rbe2_8": "rigid", "rbe3_7": "distributing"}
    loaded = read(tmp_path, "a.bdf", bdf(RBE + CONM2))
    assert {i.name: i.node_m for i in loaded.interfaces}["rbe3_7"] == (0.0, 0.0, 2.5e-3)
    (disk,) = loaded.rigid_disks
    # t and mm
    assert (disk.interface, disk.mass_kg, disk.offset_m) == ("rbe3_7", 4000.0, 0.25e-3)
    assert disk.polar_inertia_kg_m2 == pytest.approx(0.3 * 1e3 * 1e-6)
    in_kg = read(tmp_path, "a.bdf", bdf(RBE + CONM2), mass_unit="kg")
    assert in_kg.rigid_disks[0].mass_kg == 4.0


@pytest.mark.parametrize("group", ["roof", "seat-1"])
def test_an_interface_of_the_same_surface_takes_the_coupling(tmp_path, group):
    text = INP.replace("*SOLID SECTION", f"{COUPLED}*SOLID SECTION")
    given = [{"name": "top", "group": group}]
    (top,) = read(tmp_path, "a.inp", text, interfaces=given).interfaces
    assert (top.name, top.group, top.coupling) == ("top", group, "rigid")
    kept = [{"name": "top", "group": group, "coupling": "distributing", "node": "axis"}]
    (top,) = read(tmp_path, "a.inp", text, interfaces=kept).interfaces
    assert (top.coupling, top.node_m) == ("distributing", None)
    (own,) = read(tmp_path, "a.inp", text).interfaces
    assert (own.name, own.group) == ("Seat-1", "Seat-1")


def test_read_again_nothing_is_added(tmp_path):
    first = read(tmp_path, "a.bdf", bdf(RBE + CONM2))
    body = first.model_dump(mode="json", exclude_defaults=True)
    again = parse_scene({"name": "own", "mesh_bodies": {"rotor": body}}, tmp_path / "scene.toml")
    assert again.mesh_bodies["rotor"].interfaces == first.interfaces
    assert again.mesh_bodies["rotor"].rigid_disks == first.rigid_disks


def test_included_files_count(tmp_path):
    """Another content of what is included is another mesh."""
    (tmp_path / "more.txt").write_text(RBE)
    text = bdf("INCLUDE 'more.txt'\n")
    first = read(tmp_path, "a.bdf", text)
    (tmp_path / "more.txt").write_text(RBE + CONM2)
    second = read(tmp_path, "a.bdf", text)
    assert first.sha256 != second.sha256
    assert len(second.rigid_disks) == 1


def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.inp")
    (tmp_path / "circle.bdf").symlink_to(tmp_path / "circle.bdf")
    for name, said in (("pipe.inp", "is no regular file"), ("circle.bdf", "Too many levels")):
        body = {"file": name, "length_unit": "mm", "material": "steel"}
        with pytest.raises(SceneError, match=rf"mesh_bodies\.rotor\.file: .*{name}: .*{said}"):
            parse_scene({"name": "x", "mesh_bodies": {"rotor": body}}, tmp_path / "scene.toml")
