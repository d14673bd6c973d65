"""Meshes of other programs: formats, cutting into tetrahedra, axis, groups, refusals."""

from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np
import pytest
from mesh_makers import BDF, INP, brick, file_mesh, prism, request
from scipy.spatial import ConvexHull
from shapes import body, interface, section

from solidwhirl.geometry import MATERIALS
from solidwhirl.meshing import MeshSize, mesh_solid, write_gmsh
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_from_file, mesh_of
from solidwhirl.meshing.imported.formats.files import read_mesh_file
from solidwhirl.meshing.imported.measures import mass_integrals
from solidwhirl.meshing.imported.records import MeshInterface
from solidwhirl.meshing.imported.split import as_tetrahedra
from solidwhirl.meshing.imported.surface import faces_of, refuse_unjoined

STEEL, TITANIUM = MATERIALS["steel"], MATERIALS["titanium"]
# meshio numbers the last two edges of a tetrahedron as VTK does
TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


@pytest.fixture(scope="module")
def rotor():
    """A stepped shaft with curved elements and an interface."""
    shape = body(
        section("shaft", 0.0, 0.3, 0.0, 0.02),
        section("disk", 0.1, 0.13, 0.02, 0.08),
        interfaces=(interface("seat", "outer", 0.0, 0.03),),
    )
    return mesh_solid(shape, MeshSize(size_m=0.05, corner_size_m=0.02, growth=0.8, around=8))


def written(mesh, path):
    """The mesh in the format of a suffix, through meshio, with its seat as a group."""
    cells = [("tetra10", mesh.cells[:, TO_VTK]), ("triangle6", mesh.interfaces["seat"])]
    out = meshio.Mesh(np.array(mesh.points), cells)
    part, seat = np.full(len(cells[0][1]), 1), np.full(len(cells[1][1]), 2)
    if path.suffix == ".vtu":
        out.cell_data = {"part": [part, seat]}
        out.write(path)
        return "part:2"
    if path.suffix == ".bdf":
        out.cell_data = {"nastran:ref": [part, seat]}
        out.points = np.round(out.points, 9)  # meshio can't write more digits of negative numbers
        meshio.nastran.write(path, out, point_format="fixed-large")
        return "2"
    if path.suffix == ".inp":
        nodes = np.unique(mesh.interfaces["seat"])
        meshio.Mesh(np.array(mesh.points), cells[:1], point_sets={"SEAT": nodes}).write(path)
        return "SEAT"
    out.cell_data = {"gmsh:physical": [part, seat], "gmsh:geometrical": [part, seat]}
    out.field_data = {"body": np.array([1, 3]), "seat of the bearing": np.array([2, 2])}
    meshio.gmsh.write(path, out, fmt_version="2.2", binary=path.stem == "binary")
    return "seat of the bearing"


@pytest.mark.parametrize("name", ["a.vtu", "a.inp", "a.bdf", "a.msh", "binary.msh"])
def test_formats_give_back_the_mesh(rotor, tmp_path, name):
    group = written(rotor, tmp_path / name)
    seat = MeshInterface(name="seat", coupling="distributing", group=group)
    asked = request(tmp_path / name, interfaces=(seat,))
    mesh = mesh_from_file(asked, "rotor")
    assert len(mesh.cells) == len(rotor.cells)
    assert len(mesh.points) == len(rotor.points)
    assert len(mesh.interfaces["seat"]) == len(rotor.interfaces["seat"])
    found, own = mass_integrals(mesh), mass_integrals(rotor)
    # 9 decimals of metres in Nastran's format, all or 16 digits in the others
    limit = 1e-7 if name.endswith("bdf") else 1e-12
    assert found.mass_kg == pytest.approx(own.mass_kg, rel=limit)
    inertia = np.array(own.inertia_kg_m2)
    assert np.abs(np.array(found.inertia_kg_m2) - inertia).max() < limit * np.trace(inertia)
    made = body_of_mesh("rotor", asked, mesh)
    assert made.interfaces[0].position_m == pytest.approx((0.0, 0.0, 0.015), abs=1e-6)


def test_gmsh_41_with_named_groups(rotor, tmp_path):
    # written by gmsh itself from the file that this program writes
    import gmsh

    write_gmsh(rotor, tmp_path / "old.msh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "old.msh"))
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.write(str(tmp_path / "new.msh"))
    finally:
        gmsh.finalize()
    seat = MeshInterface(name="seat", coupling="distributing", group="interface_seat")
    materials = (("shaft", STEEL), ("disk", TITANIUM))
    asked = request(tmp_path / "new.msh", interfaces=(seat,), material=None, materials=materials)
    mesh = mesh_from_file(asked, "rotor")
    assert len(mesh.interfaces["seat"]) == len(rotor.interfaces["seat"])
    disk = np.flatnonzero(rotor.cell_section == rotor.section_names.index("disk"))
    of_titanium = mesh.cell_material == mesh.materials.index(TITANIUM)
    assert int(of_titanium.sum()) == len(disk)
    assert mesh.section_names == ("shaft", "disk")


def test_hexahedra_and_wedges_match_however_their_nodes_are_numbered():
    points, hexahedra = brick((1.0, 1.0, 2.0), (2, 2, 4))
    # the upper half as wedges, cut in the plane of x and z
    lower = points[hexahedra].mean(axis=1)[:, 2] < 1.0
    top = hexahedra[~lower]
    wedges = np.vstack([top[:, [0, 4, 1, 3, 7, 2]], top[:, [1, 4, 5, 2, 7, 6]]])
    random = np.random.default_rng(3)
    for _ in range(10):
        number = random.permutation(len(points))
        moved = np.empty_like(points)
        moved[number] = points
        mesh = file_mesh(moved, hexahedron=number[hexahedra[lower]], wedge=number[wedges])
        found = as_tetrahedra(mesh)
        faces = faces_of(found.cells)
        refuse_unjoined(found.points, found.cells, faces)
        x = found.points[found.cells[:, :4]]
        volume = np.linalg.det(x[:, 1:] - x[:, :1]) / 6.0
        assert volume.min() > 0.0
        assert volume.sum() == pytest.approx(2.0, rel=1e-14)
        # the surface of the box and nothing inside it
        a, b, c = (found.points[faces.nodes[faces.outside][:, k]] for k in range(3))
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        assert area.sum() == pytest.approx(10.0, rel=1e-14)


@pytest.mark.parametrize(
    ("kind", "turn"), [("even", 4), ("odd", 4), ("curved", 4), ("wedges", 6), ("one wedge", 3)]
)
def test_what_is_the_same_after_a_turn_is_cut_alike(kind, turn):
    """However nodes are numbered, also where an element encloses the axis."""
    if "wedge" in kind:
        points, cells = prism(6, 2, 0.3, 0.4)
        if kind == "one wedge":
            angles = 2.0 * np.pi * np.arange(3) / 3.0
            flat = np.column_stack([np.cos(angles), np.sin(angles)])
            points = np.vstack([np.column_stack([flat, np.full(3, z)]) for z in (0.0, 1.0, 2.0)])
            cells = np.array([np.arange(6), np.arange(3, 9)])
        shape, corners = "wedge", 6
    else:
        count = 2 if kind == "even" else 3
        points, cells = brick((0.6, 0.6, 0.5), (count, count, 2), (-0.3, -0.3, 0.0))
        shape, corners = "hexahedron", 8
    if kind == "curved":
        pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
        pairs += [(0, 4), (1, 5), (2, 6), (3, 7)]
        ends = np.sort(np.vstack([cells[:, list(p)] for p in pairs]), axis=1)
        edges, at = np.unique(ends, axis=0, return_inverse=True)
        middles = points[edges].mean(axis=1)
        middles[:, 2] += 0.01 * np.hypot(middles[:, 0], middles[:, 1])
        rows = len(points) + np.asarray(at).reshape(12, -1).T
        points, cells, shape = (
            np.vstack([points, middles]),
            np.hstack([cells, rows]),
            "hexahedron20",
        )
    random = np.random.default_rng(7)
    for _ in range(5):
        number = random.permutation(len(points))
        moved = np.empty_like(points)
        moved[number] = points
        found = as_tetrahedra(file_mesh(moved, **{shape: number[cells]}))
        refuse_unjoined(found.points, found.cells, faces_of(found.cells))
        x = found.points[found.cells]
        volume = np.linalg.det(x[:, 1:4] - x[:, :1]) / 6.0
        assert volume.min() > 0.0
        first = points[cells[:, :corners]]
        assert volume.sum() == pytest.approx(
            np.ptp(first[..., 2]) * ConvexHull(points[:, :2]).volume, rel=1e-12
        )

        # tetrahedra and the middles of their edges, in any order
        def listed(x):
            return {tuple(sorted(map(tuple, (np.round(own, 9) + 0.0).tolist()))) for own in x}

        c, s = np.cos(2.0 * np.pi / turn), np.sin(2.0 * np.pi / turn)
        assert listed(x @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])) == listed(x)


@pytest.mark.parametrize("named", ["quads", "nodes"])
def test_groups_hold_faces_that_are_cut_from_their_middle(named):
    points, cells = brick((0.6, 0.6, 0.5), (3, 3, 2), (-0.3, -0.3, 0.0))
    low = points[:, 2] < 1e-9
    mesh = file_mesh(points, hexahedron=cells)
    quads = cells[low[cells[:, :4]].all(axis=1)][:, :4]
    groups = {"face_groups": {"low": (quads,)}} if named == "quads" else {
        "node_groups": {"low": np.flatnonzero(low)}
    }  # fmt: skip
    seat = MeshInterface(name="low", coupling="rigid", group="low", box_m=None, node="axis")
    made = mesh_of(replace(mesh, **groups), request("a.vtu", interfaces=(seat,)), "a")
    corner = made.points[made.interfaces["low"][:, :3]]
    area = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    assert 0.5 * area.sum() == pytest.approx(0.36, rel=1e-12)


def test_a_pyramid_is_cut_from_its_tip_and_from_its_base():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], dtype=float)
    for shift in range(5):
        number = np.roll(np.arange(5), shift)
        moved = np.empty_like(points)
        moved[number] = points
        found = as_tetrahedra(file_mesh(moved, pyramid=number[None, :]))
        x = found.points[found.cells[:, :4]]
        volume = np.linalg.det(x[:, 1:] - x[:, :1]) / 6.0
        assert len(volume) == 2
        assert volume.sum() == pytest.approx(1.0 / 3.0, rel=1e-14)


def test_second_order_hexahedra_keep_their_curves():
    # rings of curved hexahedra: the volume error falls with the fourth power of the angle
    errors = []
    for around in (6, 12):
        points, hexahedra = ring(around)
        mesh = file_mesh(points, hexahedron20=hexahedra)
        made = mesh_of(mesh, request("ring.vtu"), "ring")
        exact = np.pi * (0.2**2 - 0.1**2) * 0.1 * STEEL.density_kg_per_m3
        errors.append(abs(mass_integrals(made).mass_kg / exact - 1.0))
    assert errors[0] < 5e-3
    assert 14.0 < errors[0] / errors[1] < 18.0


def ring(around):
    """Second-order hexahedra of a ring of radii 0.1 and 0.2 and length 0.1."""
    count = 2 * around
    angle = 2.0 * np.pi * np.arange(count) / count
    r, z = np.linspace(0.1, 0.2, 3), np.linspace(0.0, 0.1, 3)
    i = np.arange(count * 9).reshape(count, 3, 3)
    points = np.array([[rr * np.cos(a), rr * np.sin(a), zz] for a in angle for rr in r for zz in z])
    corner = [(0, 0, 0), (0, 2, 0), (2, 2, 0), (2, 0, 0), (0, 0, 2), (0, 2, 2), (2, 2, 2)]
    corner.append((2, 0, 2))
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
    edges += [(0, 4), (1, 5), (2, 6), (3, 7)]
    rows = []
    for k in range(0, count, 2):
        local = [*corner, *(tuple((np.array(corner[a]) + corner[b]) // 2) for a, b in edges)]
        rows.append([i[(k + t) % count, rr, zz] for t, rr, zz in local])
    return points, np.array(rows)


def test_axis_and_unit_put_a_mesh_where_it_belongs(rotor, tmp_path):
    turn = np.array([[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
    place = np.array([30.0, -500.0, 70.0])
    moved = 1e3 * rotor.points @ turn.T + place
    meshio.Mesh(moved, [("tetra10", rotor.cells[:, TO_VTK])]).write(tmp_path / "moved.vtu")
    asked = request(
        tmp_path / "moved.vtu",
        unit_m=1e-3,
        origin=tuple(place),
        direction=tuple(5.0 * turn[:, 2]),
        x_direction=tuple(turn[:, 0] + 3.0 * turn[:, 2]),
        shape="round",
    )
    mesh = mesh_from_file(asked, "rotor")
    # meshio writes VTU with all digits; the turn rounds the last ones
    assert np.abs(np.sort(mesh.points, axis=0) - np.sort(rotor.points, axis=0)).max() < 1e-12
    plain = mesh_from_file(replace(asked, x_direction=None), "rotor")
    for found, exact in zip(meridian(plain), meridian(rotor), strict=True):
        assert np.abs(np.sort(found) - np.sort(exact)).max() < 1e-12


def meridian(mesh):
    """Radii and places along the axis."""
    return np.hypot(*mesh.points[:, :2].T), mesh.points[:, 2]


def test_roundness_of_polygons_is_that_of_their_edges():
    for sides in (16, 24):
        points, wedges = prism(sides, 2, 0.1, 0.3)
        asked = request("prism.vtu", shape="round")
        mesh = mesh_of(file_mesh(points, wedge=wedges), asked, "prism")
        found = body_of_mesh("prism", asked, mesh).roundness
        # a corner that is turned half a side lies r (1 - cos(π/n)) off the side
        sagitta = 1.0 - np.cos(np.pi / sides)
        assert 0.9 * sagitta < found.surface <= sagitta * (1.0 + 1e-12)
        # regular polygons have no moments of orders 1 and 2
        assert found.static_unbalance < 1e-14
        assert found.uneven_mass < 1e-13


@pytest.mark.parametrize(
    ("name", "text", "low", "foot", "roof"),
    [("a.inp", INP, "LOW", "FOOT", "ROOF"), ("a.bdf", BDF, "7", "40", "41")],
)
def test_files_written_by_hand(tmp_path, name, text, low, foot, roof):
    (tmp_path / name).write_text(text)
    asked = request(
        tmp_path / name,
        materials=((low, TITANIUM),),
        interfaces=(
            MeshInterface(name="foot", coupling="rigid", group=foot, node="centroid"),
            MeshInterface(name="roof", coupling="distributing", group=roof, node=(0.1, 0.2, 2.0)),
            MeshInterface(
                name="side", coupling="distributing", box_m=((-0.1, -0.1, 0.9), (0.1, 1.1, 2.1))
            ),
        ),
    )
    mesh = mesh_from_file(asked, "block")
    made = body_of_mesh("block", asked, mesh)
    density = STEEL.density_kg_per_m3 + TITANIUM.density_kg_per_m3
    assert made.mass.mass_kg == pytest.approx(density, rel=1e-14)
    assert made.volume_m3 == pytest.approx(2.0, rel=1e-14)
    places = [i.position_m for i in made.interfaces]
    assert places[0] == pytest.approx((0.5, 0.5, 0.0), abs=1e-14)
    assert places[1] == (0.1, 0.2, 2.0)
    assert places[2] == pytest.approx((0.0, 0.0, 1.5), abs=1e-14)
    assert [len(mesh.interfaces[n]) for n in ("foot", "roof", "side")] == [2, 2, 2]


@pytest.mark.parametrize(("top", "cut", "area"), [(2.0, 0, 0.0), (1.5, 4, 0.5), (1.25, 4, 0.25)])
def test_facets_that_a_box_cuts_are_measured(top, cut, area):
    """On a side of a brick whose elements are 1 by 1/2; half a piece of a facet is the error."""
    points, hexahedra = brick((1.0, 1.0, 2.0), (1, 2, 2))
    box = MeshInterface(
        name="side", coupling="rigid", box_m=((-0.01, -0.1, -0.1), (0.01, 1.1, top))
    )
    asked = request("a.vtu", interfaces=(box,))
    mesh = mesh_of(file_mesh(points, hexahedron=hexahedra), asked, "block")
    (found,) = body_of_mesh("block", asked, mesh).interfaces
    whole = 2.0 if cut == 0 else 1.0
    assert found.area_m2 == pytest.approx(whole, rel=1e-12)
    assert found.mean_m == pytest.approx((0.0, 0.5, 0.5 * whole), abs=1e-12)
    assert found.cut_facets == cut
    assert found.cut_area_m2 == pytest.approx(area, abs=0.13)


def test_surfaces_of_element_faces(tmp_path):
    (tmp_path / "a.inp").write_text(INP)
    found = read_mesh_file(tmp_path / "a.inp")
    wall = np.vstack(found.face_groups["WALL"])
    assert found.points[wall][:, :, 1].max() == 0.0
    assert sorted(map(len, found.element_groups["BOTH"].values())) == [2]
