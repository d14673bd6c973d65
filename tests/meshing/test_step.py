"""STEP: parametric bodies out and in again."""

from __future__ import annotations

import os
import re
import signal
from dataclasses import replace

import gmsh
import numpy as np
import pytest
from mesh_makers import drawn, request
from shapes import STEEL, section
from shapes import body as body_of

from solidwhirl.geometry import MATERIALS, Joint, mass_properties
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_of
from solidwhirl.meshing.imported.formats.step import mesh_step, step_geometry
from solidwhirl.meshing.imported.records import MeshInterface, StepSize
from solidwhirl.meshing.own.step_write import write_step

TITANIUM = MATERIALS["titanium"]


def rotor(fillet_m=0.004, disk=STEEL):
    return body_of(
        section("solid", 0.0, 0.1, 0.0, 0.02),
        section("bored", 0.1, 0.3, 0.008, (0.02, 0.03)),
        section("disk", 0.04, 0.06, 0.02, 0.08, disk),
        fillet=fillet_m,
    )


def of_step(path, step, **changes):
    """A round steel body in millimetres."""
    return request(path, unit_m=1e-3, shape="round", step=step, **changes)


@pytest.mark.parametrize(
    ("direction", "origin"),
    [
        pytest.param((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), marks=pytest.mark.verify),
        ((0.0, 0.0, -1.0), (0, 0, 300.0)),
    ],
)
def test_boxes_are_cut_into_the_geometry(tmp_path, direction, origin):
    """Area and place of a seat on coarse elements, against those of the cylinder."""
    path = tmp_path / "shaft.step"
    shaft = body_of(section("s", 0.0, 0.3, 0.0, 0.03))
    write_step((shaft,), path, unit_m=1e-3)
    boxes = {
        "end": ((-1.0, -1.0, -0.001), (1.0, 1.0, 0.021)),
        "seat": ((-0.1, -0.1, 0.2), (0.1, 0.1, 0.2213)),
        "across": ((-0.1, -0.1, 0.21), (0.1, 0.1, 0.25)),
    }
    asked = of_step(
        path,
        StepSize(size_m=0.03, smallest_m=0.006, around=24),
        direction=direction,
        origin=origin,
        interfaces=tuple(
            MeshInterface(name=name, coupling="distributing", box_m=box)
            for name, box in boxes.items()
        ),
    )
    mesh = mesh_of(mesh_step(asked), asked, "shaft")
    found = {i.name: i for i in body_of_mesh("shaft", asked, mesh).interfaces}
    round_m, face_m2 = 2.0 * np.pi * 0.03, np.pi * 0.03**2
    areas = {"end": round_m * 0.021 + face_m2, "seat": round_m * 0.0213, "across": round_m * 0.04}
    places = {"end": round_m * 0.021 * 0.0105 / areas["end"], "seat": 0.21065, "across": 0.23}
    for name in boxes:
        assert found[name].area_m2 == pytest.approx(areas[name], rel=2e-3)
        assert found[name].position_m[2] == pytest.approx(places[name], rel=2e-3)
        assert found[name].cut_facets == 0
    assert body_of_mesh("shaft", asked, mesh).volume_m3 == pytest.approx(0.3 * face_m2, rel=5e-3)


def test_kernel_of_the_geometry_prints_nothing(tmp_path, capfd):
    (tmp_path / "bad.step").write_text("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('')\n")
    size = StepSize(size_m=0.03, smallest_m=0.01, around=12)
    with pytest.raises(MeshingError, match=r"bad\.step: can not be read as STEP"):
        step_geometry(of_step(tmp_path / "bad.step", size))
    assert capfd.readouterr().out == ""


def read_by_gmsh(path, unit):
    """Volume, centre and inertia of every solid, as the CAD kernel computes them of the file."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", unit)
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        found = []
        for _, tag in gmsh.model.getEntities(3):
            # all faces of a closed solid belong to one shell, and no edge is open
            assert gmsh.model.getBoundary([(3, tag)], combined=True)
            shell = gmsh.model.getBoundary([(3, tag)], oriented=False)
            assert not gmsh.model.getBoundary(shell, combined=True, oriented=False)
            name = gmsh.model.getEntityName(3, tag).rsplit("/", 1)[-1]
            volume = gmsh.model.occ.getMass(3, tag)
            centre = np.array(gmsh.model.occ.getCenterOfMass(3, tag))
            inertia = np.array(gmsh.model.occ.getMatrixOfInertia(3, tag)).reshape(3, 3)
            found.append((name, volume, centre, inertia))
        # nothing but solids and what bounds them
        assert len(gmsh.model.getEntities(2)) == len(
            {t for _, v in gmsh.model.getEntities(3)
             for _, t in gmsh.model.getBoundary([(3, v)], oriented=False)}
        )  # fmt: skip
        return found
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("fillet_m", [0.0, 0.004])
@pytest.mark.parametrize(("unit_m", "unit"), [(1e-3, "M"), (1.0, "MM")])
def test_solids_have_the_mass_of_the_profile(tmp_path, fillet_m, unit_m, unit):
    body = rotor(fillet_m)
    assert write_step([body], tmp_path / "r.step", unit_m=unit_m) == ("rotor_steel",)
    ((_, volume, centre, inertia),) = read_by_gmsh(tmp_path / "r.step", unit)
    length = {"M": 1.0, "MM": 1e-3}[unit]
    exact = mass_properties(body)
    density = STEEL.density_kg_per_m3
    assert volume * density * length**3 == pytest.approx(exact.mass_kg, rel=1e-6)
    assert centre[2] * length == pytest.approx(exact.center_of_gravity_m[2], rel=1e-6)
    inertia = inertia * density * length**5
    assert inertia[2, 2] == pytest.approx(exact.polar_inertia_kg_m2, rel=1e-6)
    assert inertia[0, 0] == pytest.approx(exact.diametral_inertia_kg_m2, rel=1e-6)


def test_materials_are_solids_of_their_own(tmp_path):
    body = rotor(disk=TITANIUM)
    names = write_step([body], tmp_path / "r.step")
    assert sorted(names) == ["rotor_steel", "rotor_titanium"]
    found = {name: volume for name, volume, _, _ in read_by_gmsh(tmp_path / "r.step", "M")}
    density = {"rotor_steel": STEEL, "rotor_titanium": TITANIUM}
    mass = sum(density[n].density_kg_per_m3 * v for n, v in found.items())
    assert mass == pytest.approx(mass_properties(body).mass_kg, rel=1e-6)


def test_meshes_converge_to_the_profile_and_keep_materials(tmp_path):
    body = rotor(fillet_m=0.0, disk=TITANIUM)
    write_step([body], tmp_path / "r.step")
    exact = mass_properties(body)
    errors = []
    for around in (8, 16):
        size = StepSize(size_m=0.03, smallest_m=0.004, around=around)
        asked = of_step(tmp_path / "r.step", size, materials=(("rotor_titanium", TITANIUM),))
        mesh = mesh_of(mesh_step(asked), asked, "rotor")
        found = body_of_mesh("rotor", asked, mesh)
        errors.append(abs(found.mass.mass_kg / exact.mass_kg - 1.0))
        assert found.roundness.uneven_mass < 1e-3
        expected = step_geometry(of_step(tmp_path / "r.step", size)).expected
        # said before it is meshed, within a factor 3
        assert expected.cells / 3.0 < len(mesh.cells) < 3.0 * expected.cells
    # fourth power of the angle; circles need not halve exactly, so 6 of 16 is asked
    assert errors[0] < 2e-3
    assert errors[1] < errors[0] / 6.0


def test_what_is_no_solid_is_refused(tmp_path):
    size = StepSize(size_m=0.03, smallest_m=0.01, around=8)
    with pytest.raises(MeshingError, match=r"none\.step: no such file"):
        step_geometry(of_step(tmp_path / "none.step", size))
    (tmp_path / "text.step").write_text("ISO-10303-21;\nHEADER;\n")
    with pytest.raises(MeshingError, match=r"can not be read as STEP|has no solid"):
        step_geometry(of_step(tmp_path / "text.step", size))
    with pytest.raises(MeshingError, match=r"unit_m is 2.0; allowed are 0.001, 1.0"):
        write_step([rotor()], tmp_path / "r.step", unit_m=2.0)
    assert not (tmp_path / "r.step").exists()


@pytest.mark.parametrize("overlap_mm", [0.01, 0.05, 0.1])
def test_fits_as_drawn_are_named(tmp_path, overlap_mm):
    """The common ring has 2 π r t h; its mean thickness is the overlap."""
    drawn(tmp_path / "fit.step", 10.0 - overlap_mm)
    asked = of_step(tmp_path / "fit.step", StepSize(size_m=0.02, smallest_m=0.004, around=8))
    volume = np.pi * (10.0**2 - (10.0 - overlap_mm) ** 2) * 20.0
    said = (
        rf"'shaft' and 'hub' overlap by ([\d.]+) mm, in {volume:.4g}\d* mm³ about \(0, 0, 50\) mm"
    )
    with pytest.raises(MeshingError, match=said) as caught:
        step_geometry(asked)
    found = re.search(said, str(caught.value))
    assert float(found[1]) == pytest.approx(overlap_mm, rel=0.01)
    assert 'joints = [{ between = ["shaft", "hub"] }]' in str(caught.value)


def fitted(path, *joints, **changes):
    """What is asked of a drawing whose solids are joined, its geometry, mesh and body."""
    size = StepSize(size_m=0.01, smallest_m=0.002, around=8)
    asked = replace(of_step(path, size, joints=joints, **changes), shape="cyclic")
    found = step_geometry(asked)
    asked = replace(asked, joints=found.joints)
    mesh = mesh_of(mesh_step(asked), asked, "fit")
    return found, mesh, body_of_mesh("fit", asked, mesh)


@pytest.mark.parametrize(
    ("between", "seat_m"), [(("shaft", "hub"), 0.01), (("Hub", "SHAFT"), 0.00995)]
)
def test_fits_as_drawn_become_joints(tmp_path, between, seat_m):
    """The first solid keeps its surface; mass, interference and areas are those of the rings."""
    drawn(tmp_path / "fit.step", 10.0 - 0.05)
    rear = MeshInterface(name="rear", coupling="rigid", box_m=((-0.1, -0.1, 0.07), (0.1, 0.1, 0.1)))
    found, mesh, body = fitted(
        tmp_path / "fit.step",
        Joint(between=between),
        materials=(("hub", TITANIUM),),
        interfaces=(rear,),
    )
    (joint,) = body.joints
    assert joint.between == tuple(name.lower() for name in between)
    assert joint.interference_m == pytest.approx(5e-5, rel=1e-6)
    shaft = 0.08 * 0.01**2 + 0.02 * seat_m**2
    hub = 0.02 * (0.03**2 - seat_m**2)
    assert found.volume_m3 == pytest.approx(np.pi * (shaft + hub), rel=1e-6)
    # arcs of 7.5 degrees as parabolas
    mass = np.pi * (shaft * STEEL.density_kg_per_m3 + hub * TITANIUM.density_kg_per_m3)
    assert body.mass.mass_kg == pytest.approx(mass, rel=2e-6)
    area = 2.0 * np.pi * 0.01 * 0.03 + np.pi * 0.01**2
    # measured on flat pieces of a quarter of that
    assert body.interfaces[0].area_m2 == pytest.approx(area, rel=1e-4)
    (seat,) = mesh.meridian.seats
    z, r = mesh.meridian.points[seat].reshape(-1, 2).T
    assert r == pytest.approx(np.full(len(r), seat_m), rel=1e-9)
    assert (z.min(), z.max()) == pytest.approx((0.04, 0.06))
    assert not set(seat[:, 0].ravel()) & set(seat[:, 1].ravel())
    assert found.expected.cells / 3.0 < len(mesh.cells) < 3.0 * found.expected.cells


@pytest.mark.parametrize(
    ("bore_mm", "joint", "changes", "message"),
    [
        (9.95, {"between": ("shaft", "disk")}, {}, "no solid 'disk'; it has 'hub', 'shaft'"),
        (9.95, {"interference_m": 2e-5}, {}, "drawn with an interference of 5e-05 m; leave int"),
        (9.95, {"pressure_pa": 1e7}, {}, "pressure_pa is given, and the solids are drawn"),
        (5.0, {}, {}, r"r from 5 to 10 mm: that is no fit .* thinner than 0\.01 of its radius"),
        (9.95, {}, {"origin": (1.0, 0.0, 0.0)}, "that is no fit on a cylinder about the axis"),
        (10.0, {}, {}, "nothing says how it joins; .* or draw the solids with their interference"),
        (10.1, {"interference_m": 2e-5}, {}, "'shaft' and 'hub' do not hang together"),
        (10.0, {"pressure_pa": 1e7}, {"origin": (1.0, 0.0, 0.0)}, "'shaft' is none about this ax"),
    ],
)
def test_what_is_no_fit_is_refused(tmp_path, bore_mm, joint, changes, message):
    drawn(tmp_path / "fit.step", bore_mm)
    with pytest.raises(MeshingError, match=message):
        fitted(tmp_path / "fit.step", Joint(**{"between": ("shaft", "hub")} | joint), **changes)


def test_solids_of_unlike_material_that_overlap_are_refused(tmp_path):
    drawn(tmp_path / "r.step", None)
    size = StepSize(size_m=0.03, smallest_m=0.004, around=8)
    unlike = of_step(tmp_path / "r.step", size, materials=(("hub", TITANIUM),))
    with pytest.raises(MeshingError, match=r"'shaft' and 'hub' overlap .* 6283 mm³ .* of steel"):
        step_geometry(unlike)
    # of one material the common part counts once
    once = np.pi * (0.1 * 0.01**2 + 0.02 * (0.03**2 - 0.01**2))
    assert step_geometry(of_step(tmp_path / "r.step", size)).volume_m3 == pytest.approx(once)
    drawn(tmp_path / "r.step", 10.0)
    touching = of_step(tmp_path / "r.step", size, materials=(("hub", TITANIUM),))
    assert step_geometry(touching).volume_m3 == pytest.approx(once)


def test_what_the_kernel_does_not_survive_is_refused(tmp_path, monkeypatch):
    """Numbers beyond all measure at once; a crash and an endless loop, by a stand-in for it."""
    import gmsh

    from solidwhirl.meshing.imported.formats import step

    path = tmp_path / "r.step"
    drawn(path, None)
    asked = of_step(path, StepSize(size_m=0.03, smallest_m=0.004, around=8))
    sound = path.read_text()
    for number in ("1E999", "-1.5E+300", "1.E31"):
        path.write_text(
            re.sub(r"(CARTESIAN_POINT\('[^']*',\()[^,]*", rf"\g<1>{number}", sound, count=1)
        )
        with pytest.raises(MeshingError, match=r"r\.step: line \d+: \S+ is no length"):
            step_geometry(asked)
    path.write_text(sound)
    monkeypatch.setattr(step, "_FIRST_S", 1)
    monkeypatch.setattr(step, "_S_PER_BYTE", 0.0)

    def crash(*_, **__):
        os.kill(os.getpid(), signal.SIGSEGV)

    def hang(*_, **__):
        while True:
            pass

    for stand_in, said in ((crash, r"breaks down on it \(signal 11\)"), (hang, "come to an end")):
        monkeypatch.setattr(gmsh.model.occ, "importShapes", stand_in)
        with pytest.raises(MeshingError, match=rf"r\.step: can not be read .* kernel .*{said}"):
            step_geometry(asked)
