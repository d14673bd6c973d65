"""Given meshes of one of N sectors, or of the whole that one is taken from.

Copies of the sector, turned and joined where nodes are within 2e-12 of the size, have to be the
whole: closed, of the same mass, with all outer facets and no others.
"""

from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np
import pytest
from mesh_makers import STEEL, brick, file_mesh, prism, request
from sector_makers import TO_VTK, bladed, copied, of_msh, paddles, ring, shuffled, turn
from sometimes import often

from solidwhirl.geometry import MATERIALS
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported import sectors
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_from_file, mesh_of
from solidwhirl.meshing.imported.formats.step import mesh_step, step_geometry
from solidwhirl.meshing.imported.measures import mass_integrals
from solidwhirl.meshing.imported.records import MeshInterface, StepSize
from solidwhirl.meshing.imported.split import as_tetrahedra
from solidwhirl.meshing.imported.surface import faces_of, refuse_unjoined

RNG = np.random.default_rng


def cyclic(path, count, **changes):
    return request(path, shape="cyclic", sectors=count, **changes)


def sector_of(found, count, **changes):
    """The mesh that is made of a file, and its body."""
    asked = cyclic("given.msh", count, **changes)
    mesh = mesh_of(found, asked, "disk")
    return mesh, body_of_mesh("disk", asked, mesh)


def whole_of(found, count):
    """A file of all sectors of a file of one, of second-order tetrahedra."""
    points, cells = copied(found.points, found.blocks[0].nodes, count)
    return file_mesh(points, tetra10=cells)


def assert_copies_are_the_whole(mesh, body):
    """Join the copies and look at the whole as a mesh of its own."""
    count = mesh.sector.count
    points, cells = copied(mesh.points, mesh.cells, count)
    faces = faces_of(cells)
    refuse_unjoined(points, cells, faces)
    outer = sectors.outer_facets(mesh.points, mesh.cells, count)
    assert faces.outside.sum() == count * len(outer)
    own = mass_integrals(
        replace(
            mesh,
            points=points,
            cells=cells,
            cell_material=np.tile(mesh.cell_material, count),
            sector=None,
        )
    )
    assert body.mass.mass_kg == pytest.approx(own.mass_kg, rel=1e-12)
    inertia = np.array(own.inertia_kg_m2)
    assert np.allclose(body.mass.inertia_kg_m2, inertia, rtol=0, atol=1e-12 * np.trace(inertia))
    length = np.ptp(points[:, 2])
    centre = np.subtract(body.mass.center_of_gravity_m, own.center_of_gravity_m)
    assert np.abs(centre).max() < 1e-12 * length


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("sectors")


@pytest.fixture(scope="module")
def staggered(folder):
    """One sector of twelve, whose blade hangs over both cuts' planes with 60°."""
    bladed(folder / "staggered.msh", stagger_deg=60.0)
    return of_msh(folder / "staggered.msh")


def test_mass_of_a_bladed_disk(folder):
    """12 blades at 30°: sector mass in closed form but for the tip, by the disk and a plate.

    Between x = 0.1 cos(t) and the flat tip the plate is cut by a cylinder: integrated over |y| < b
    with b the largest tangential coordinate, x = sqrt(r² - y²).
    """
    bladed(folder / "plain.msh", stagger_deg=30.0)
    mesh, body = sector_of(of_msh(folder / "plain.msh"), 12)
    s, t = np.meshgrid(np.linspace(-0.01, 0.01, 2001), np.linspace(-0.002, 0.002, 401))
    y = s * np.sin(np.pi / 6.0) + t * np.cos(np.pi / 6.0)
    # outside |z| <= 0.006 the blade goes on to x = 0.095
    z = s * np.cos(np.pi / 6.0) - t * np.sin(np.pi / 6.0)
    start = np.where(np.abs(z) <= 0.006, np.sqrt(0.01 - y**2), 0.095)
    plate = np.mean(0.15 - start) * 0.02 * 0.004
    disk = np.pi * (0.1**2 - 0.03**2) * 0.012 / 12.0
    assert mesh.sector.count == 12
    assert body.volume_m3 / 12.0 == pytest.approx(disk + plate, rel=2e-4)
    assert body.mass.mass_kg == pytest.approx(STEEL.density_kg_per_m3 * body.volume_m3, rel=1e-12)
    assert_copies_are_the_whole(mesh, body)


def eight(value):
    """A number in eight characters."""
    text = (f"{value:.{digits}f}" for digits in (6, 5, 4, 3))
    return next(t for t in text if len(t) <= 8).rjust(8)


@pytest.mark.parametrize("suffix", [".msh", ".vtu", ".inp", ".bdf", ".nas"])
def test_one_sector_in_every_format(folder, staggered, suffix):
    cells = staggered.blocks[0].nodes
    path, out = folder / f"one{suffix}", meshio.Mesh(staggered.points, [("tetra10", cells)])
    unit_m = 1.0
    if suffix == ".nas":  # eight characters for a number: five digits and more of millimetres
        unit_m, text = 1e-3, ["BEGIN BULK"]
        for k, x in enumerate(1e3 * staggered.points):
            text.append(f"GRID    {k + 1:8}        " + "".join(eight(v) for v in x))
        for k, row in enumerate(cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]] + 1):
            text.append(f"CTETRA,{k + 1},1,{','.join(map(str, row[:6]))},+")
            text.append(f"+,{','.join(map(str, row[6:]))}")
        path.write_text("\n".join([*text, "ENDDATA", ""]))
    elif suffix == ".bdf":
        out.points = np.round(out.points, 9)
        meshio.nastran.write(path, out, point_format="fixed-large")
    elif suffix == ".msh":
        meshio.gmsh.write(path, out, fmt_version="2.2", binary=False)
    else:
        out.write(path)
    asked = cyclic(path, 12, unit_m=unit_m)
    mesh = mesh_from_file(asked, "disk")
    assert_copies_are_the_whole(mesh, body_of_mesh("disk", asked, mesh))


@pytest.mark.parametrize("stagger_deg", often([0.0, 60.0], 60.0))
def test_a_whole_gives_one_sector(folder, stagger_deg):
    bladed(folder / "one.msh", stagger_deg=stagger_deg)
    one = of_msh(folder / "one.msh")
    whole = shuffled(whole_of(one, 12))
    mesh, body = sector_of(whole, 12)
    assert 12 * len(mesh.cells) == len(whole.blocks[0].nodes)
    assert_copies_are_the_whole(mesh, body)
    given = mass_integrals(mesh_of(whole, request("whole.msh"), "disk"))
    assert body.mass.mass_kg == pytest.approx(given.mass_kg, rel=1e-12)
    assert np.allclose(body.mass.inertia_kg_m2, given.inertia_kg_m2, rtol=1e-10, atol=1e-14)
    # of fewer sectors as well: several of its own make one
    mesh, body = sector_of(whole, 4)
    assert 4 * len(mesh.cells) == len(whole.blocks[0].nodes)
    assert_copies_are_the_whole(mesh, body)


@pytest.mark.parametrize("around", [1, 3])
@pytest.mark.parametrize("sectors", [1, 7])
@pytest.mark.parametrize("twist", [0.0, 0.3])
def test_hexahedra_are_cut_alike_on_both_sides(around, sectors, twist):
    points, cells = ring(7, 3, around, sectors=sectors, twist=twist)
    mesh, body = sector_of(shuffled(file_mesh(points, hexahedron=cells)), 7)
    assert len(mesh.cells) in range(5 * 9 * around, 6 * 9 * around + 1)
    assert_copies_are_the_whole(mesh, body)


def cut_at_random(seed, twist=0.0):
    """Hexahedra of a sector of 12 cut as if another line were their axis: other diagonals."""
    points, cells = ring(12, 2, 2, twist=twist)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    cut = as_tetrahedra(file_mesh(points @ turn, hexahedron=cells))
    return file_mesh(cut.points @ turn.T, tetra=cut.cells[:, :4])


@pytest.mark.parametrize("seed", range(3))
def test_cuts_with_other_diagonals_are_joined_by_their_nodes(seed):
    points, cells = ring(12, 2, 2)
    mesh, body = sector_of(cut_at_random(seed), 12)
    alike, same = sector_of(file_mesh(points, hexahedron=cells), 12)
    assert body.mass.mass_kg == pytest.approx(same.mass.mass_kg, rel=1e-12)
    assert np.allclose(body.mass.inertia_kg_m2, same.mass.inertia_kg_m2, rtol=1e-12)
    outer = [len(sectors.outer_facets(m.points, m.cells, 12)) for m in (mesh, alike)]
    assert outer[0] == outer[1]


def test_diagonals_that_pass_each_other_are_told():
    """On a cut that leans their middles lie apart: no node of the one is one of the other."""
    with pytest.raises(
        MeshingError, match=r"nodes of the cuts match, but \d of .* other triangles"
    ):
        sector_of(cut_at_random(2, twist=0.3), 12)


@pytest.mark.parametrize("count", [3, 4, 9])
def test_sectors_that_meet_on_the_axis(count):
    """Wedges around a line of nodes; with three in all each is a sector."""
    points, wedges = prism(3 * count, 4, 0.5, 2.0)
    mesh, body = sector_of(shuffled(file_mesh(points, wedge=wedges)), count)
    area = 1.5 * count * 0.25 * np.sin(2.0 * np.pi / (3 * count))
    assert body.volume_m3 == pytest.approx(2.0 * area, rel=1e-12)
    assert_copies_are_the_whole(mesh, body)
    points, wedges = prism(count, 4, 0.5, 2.0)
    mesh, body = sector_of(shuffled(file_mesh(points, wedge=wedges)), count)
    assert_copies_are_the_whole(mesh, body)
    assert (mesh.points[np.hypot(*mesh.points[:, :2].T) < 1e-9, :2] == 0.0).all()


def test_where_the_sector_lies_and_which_way_the_axis_goes_does_not_matter(staggered):
    _, straight = sector_of(staggered, 12)
    elsewhere = replace(staggered, points=turn(staggered.points, 2.9) + np.array([0.3, -0.1, 0.7]))
    for direction in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)):
        mesh, body = sector_of(elsewhere, 12, origin=(0.3, -0.1, 0.7), direction=direction)
        assert_copies_are_the_whole(mesh, body)
        assert body.mass.mass_kg == pytest.approx(straight.mass.mass_kg, rel=1e-12)


def test_left_handed_elements_and_mirrored_blades(staggered):
    """A mirror image has its blades the other way round, and is a sector as well."""
    mirrored = replace(staggered, points=staggered.points * [1.0, -1.0, 1.0])
    mesh, body = sector_of(mirrored, 12)
    assert_copies_are_the_whole(mesh, body)
    moment = [
        float(np.sum(m.points[:, 1] * m.points[:, 2])) for m in (mesh, sector_of(staggered, 12)[0])
    ]
    assert moment[0] == pytest.approx(-moment[1], rel=1e-6)
    assert abs(moment[0]) > 1e-4


def test_coordinates_that_are_rounded_are_joined(staggered):
    noise = RNG(3).uniform(-4e-7, 4e-7, staggered.points.shape)
    mesh, body = sector_of(replace(staggered, points=staggered.points + noise), 12)
    assert_copies_are_the_whole(mesh, body)


def test_straightened_elements_stay_alike():
    """A middle on one cut, and its partner, bent so far that the elements beside it fold."""
    points, cells = ring(7, 2, 2)
    straight = sector_of(file_mesh(points, hexahedron=cells), 7)[0]
    bent, count = np.array(straight.points), 7
    angle = np.arctan2(bent[:, 1], bent[:, 0])
    corners = np.unique(straight.cells[:, :4])
    on_first = np.setdiff1d(np.flatnonzero(np.abs(angle) < 1e-9), corners)
    node = on_first[np.argmin(np.abs(np.hypot(*bent[on_first, :2].T) - 0.85))]
    other = np.argmin(np.linalg.norm(bent - turn(bent[node], 2.0 * np.pi / count), axis=1))
    bent[node] += [0.3, 0.0, 0.2]
    bent[other] = turn(bent[node], 2.0 * np.pi / count)
    found = file_mesh(bent, tetra10=straight.cells[:, TO_VTK])
    mesh, body = sector_of(found, count)
    assert mesh.quality.straightened_elements > 0
    assert_copies_are_the_whole(mesh, body)


def seat(**where):
    return (MeshInterface(name="seat", coupling="rigid", **where),)


def test_interfaces_are_what_copies_complete():
    """The bore by a box around the whole, one around a part of it, and by groups."""
    for number in (1, 12):
        points, cells = ring(12, 2, 2, sectors=number)
        bore = np.flatnonzero(np.hypot(*points[:, :2].T) < 0.401)
        inside = {"node_groups": {"BORE": bore}}
        found = replace(file_mesh(points, hexahedron=cells), **inside)
        area = 24 * 2.0 * 0.4 * np.sin(np.pi / 24.0) * 0.5
        boxes = [
            ((-0.41, -0.41, -0.1), (0.41, 0.41, 0.6)),
            ((0.3, -0.01, -0.1), (0.41, 0.22, 0.6)),
        ]
        for where in ({"group": "BORE"}, *({"box_m": box} for box in boxes)):
            mesh, body = sector_of(shuffled(found), 12, interfaces=seat(**where))
            own = body.interfaces[0]
            assert own.area_m2 == pytest.approx(area, rel=1e-12)
            assert own.mean_m == pytest.approx((0.0, 0.0, 0.25), abs=1e-12)
            assert own.position_m == pytest.approx((0.0, 0.0, 0.25), abs=1e-12)
            assert np.hypot(*mesh.points[mesh.interfaces["seat"][:, :3], :2].reshape(-1, 2).T) == (
                pytest.approx(0.4)
            )


def test_a_surface_of_one_sector_of_the_whole_stands_for_all():
    points, cells = ring(12, 2, 2, sectors=12)
    middle = points[cells].mean(axis=1)
    radius, angle = np.hypot(*middle[:, :2].T), np.arctan2(middle[:, 1], middle[:, 0])
    # faces at the bore of one element of one sector
    chosen = cells[(radius < 0.6) & (angle > 3.0)]
    bore = np.hypot(*points[:, :2].T)[chosen] < 0.401
    faces = np.array([row[own] for row, own in zip(chosen, bore, strict=True)])[:, [0, 1, 3, 2]]
    found = replace(file_mesh(points, hexahedron=cells), face_groups={"PAD": (faces,)})
    _, body = sector_of(found, 12, interfaces=seat(group="PAD"))
    area = 12 * 2.0 * 0.4 * np.sin(np.pi / 24.0) * 0.5
    assert body.interfaces[0].area_m2 == pytest.approx(area * len(faces) / 2.0, rel=1e-12)


def test_a_box_that_cuts_facets_says_how_many_of_all_sectors():
    """A square box and four sectors: the same as of the whole."""
    points, cells = ring(4, 2, 4, sectors=4)
    box = ((-0.41, -0.41, -0.1), (0.41, 0.41, 0.4))
    found = file_mesh(points, hexahedron=cells)
    own = sector_of(found, 4, interfaces=seat(box_m=box))[1].interfaces[0]
    asked = request("whole.msh", interfaces=seat(box_m=box))
    whole = body_of_mesh("ring", asked, mesh_of(found, asked, "ring")).interfaces[0]
    assert own.area_m2 == pytest.approx(whole.area_m2, rel=1e-12)
    assert own.area_m2 == pytest.approx(16 * 0.8 * np.sin(np.pi / 16.0) * 0.25, rel=1e-12)
    # diagonals of the quadrilaterals may lie the other way
    assert own.cut_facets == pytest.approx(whole.cut_facets, rel=0.2)
    assert own.cut_area_m2 == pytest.approx(whole.cut_area_m2, rel=0.1)


def test_materials_by_groups():
    points, cells = ring(5, 2, 2, sectors=5)
    outer = np.flatnonzero(np.hypot(*points[cells].mean(axis=1)[:, :2].T) > 0.7)
    found = replace(file_mesh(points, hexahedron=cells), element_groups={"RIM": {0: outer}})
    titanium = {"materials": (("RIM", MATERIALS["titanium"]),)}
    mesh, body = sector_of(found, 5, **titanium)
    given = mass_integrals(mesh_of(found, request("a.inp", **titanium), "ring"))
    assert body.mass.mass_kg == pytest.approx(given.mass_kg, rel=1e-12)
    assert_copies_are_the_whole(mesh, body)
    uneven = replace(found, element_groups={"RIM": {0: outer[1:]}})
    with pytest.raises(MeshingError, match="group 'RIM' is not the same in all sectors; 1 of"):
        sector_of(uneven, 5, **titanium)


def uneven_whole(folder):
    """A whole as gmsh meshes it, which does not repeat."""
    points, cells = ring(12, 2, 2, sectors=12)
    points = points.copy()
    points[::7] += RNG(1).uniform(-0.01, 0.01, points[::7].shape)
    return file_mesh(points, hexahedron=cells)


def unlike_cuts(folder):
    bladed(folder / "unlike.msh", periodic=False)
    return of_msh(folder / "unlike.msh")


def one_face_unlike(folder):
    """Two hexahedra at one cut replaced by wedges along the other diagonal."""
    points, cells = ring(12, 2, 2)
    mesh = sector_of(file_mesh(points, hexahedron=cells), 12)[0]
    moved = np.array(mesh.points)
    corners = np.unique(mesh.cells[:, :4])
    angle = np.arctan2(moved[:, 1], moved[:, 0])
    radius = np.hypot(*moved[:, :2].T)
    inner = corners[(np.abs(angle[corners]) < 1e-9) & (np.abs(radius[corners] - 0.7) < 1e-9)]
    moved[inner[np.abs(moved[inner, 2] - 0.25) < 1e-9]] += [0.02, 0.0, 0.0]
    return file_mesh(moved, tetra=mesh.cells[:, :4])


def other_middles(folder):
    points, cells = ring(7, 2, 2)
    mesh = sector_of(file_mesh(points, hexahedron=cells), 7)[0]
    moved = np.array(mesh.points)
    corners = np.unique(mesh.cells[:, :4])
    on_first = np.flatnonzero(np.abs(np.arctan2(moved[:, 1], moved[:, 0])) < 1e-9)
    moved[np.setdiff1d(on_first, corners)[0], 0] += 0.01
    return file_mesh(moved, tetra10=mesh.cells[:, TO_VTK])


def around_the_axis(folder):
    points, hexahedra = brick((1.0, 1.0, 1.0), (1, 1, 2), (-0.5, -0.5, 0.0))
    return file_mesh(points, hexahedron=hexahedra)


def sectors_of_ring(number, count=12):
    points, cells = ring(count, 2, 2, sectors=number)
    return lambda folder: file_mesh(points, hexahedron=cells)


REFUSED = {
    "one too many": (sectors_of_ring(1), 13, "Turned by 30°, 8 faces do: is sectors = 12 meant"),
    "one too few": (sectors_of_ring(1), 11, "Turned by 30°, 8 faces do: is sectors = 12 meant"),
    "half a sector": (sectors_of_ring(1, 24), 12, "is sectors = 24 meant, or is the file half a"),
    "two sectors": (sectors_of_ring(2), 12, "about 5[0-9.]*° around. .* is sectors = 6 meant"),
    "all but one": (
        sectors_of_ring(11),
        12,
        r"the whole \(it takes 330° around\), but 9 of 207 nodes, turned by 30°, lie on no other",
    ),
    "two of three": (sectors_of_ring(2, 3), 3, "copies turned by 120° overlap, .* wrong way round"),
    "whole, one too many": (
        sectors_of_ring(12),
        13,
        "lie on no other, the worst at z = .*: 0.0[0-9]* m from the nearest. The 13 sectors have "
        "volumes of .* is the same after a turn for sectors = 3, 4, 6, 8, 12, 24",
    ),
    "uneven whole": (uneven_whole, 12, "nodes, turned by 30°, lie on no other, .* m from the near"),
    "unlike cuts": (unlike_cuts, 12, "faces of the cut have no partner among those of the next"),
    "one node off": (
        one_face_unlike,
        12,
        r"faces of the cut have no partner .* the node at z = 0.25 m, r = 0.7[0-9]* m, θ = ",
    ),
    "middles off": (other_middles, 7, "corners of the cut faces match, but 1 middle nodes do not"),
    "no sector": (
        lambda folder: replace(
            file_mesh(*ring(12, 2, 2)[:1], hexahedron=ring(12, 2, 2)[1]),
            points=ring(12, 2, 2)[0] + np.array([5.0, 0.0, 0.0]),
        ),
        12,
        "The node that comes nearest to another, at z = .* check axis and unit",
    ),
    "axis in elements": (around_the_axis, 4, "the axis goes through 2 elements"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_repeat_is_refused(folder, case):
    make, count, message = REFUSED[case]
    with pytest.raises(MeshingError, match=message):
        sector_of(make(folder), count)


def test_interfaces_that_are_none(folder):
    points, cells = ring(12, 2, 2)
    cut = np.flatnonzero(np.abs(np.arctan2(points[:, 1], points[:, 0])) < 1e-9)
    quads = np.array([row[np.isin(row, cut)] for row in cells if np.isin(row, cut).sum() == 4])
    found = replace(
        file_mesh(points, hexahedron=cells),
        face_groups={"CUT": (quads[:, [0, 1, 3, 2]],)},
        node_groups={"CUT NODES": cut},
    )
    with pytest.raises(MeshingError, match="8 of 8 facets of group 'CUT' lie on the cut faces"):
        sector_of(found, 12, interfaces=seat(group="CUT"))
    with pytest.raises(MeshingError, match="no facet of the surface has all its corners in the no"):
        sector_of(found, 12, interfaces=seat(group="CUT NODES"))
    with pytest.raises(MeshingError, match="nodes of a body that turns lie on its axis"):
        sector_of(found, 12, interfaces=seat(box_m=((-2, -2, -2), (2, 2, 2)), node=(0.1, 0.0, 0.0)))


def of_step(path, count, **changes):
    size = StepSize(size_m=0.015, smallest_m=0.002, around=16)
    return cyclic(path, count, **({"unit_m": 1e-3, "step": size} | changes))


STEPS = {
    "one": {"sectors": 1},
    "whole": {"sectors": 12},
    "paddles over the cuts": {"sectors": 12, "width_mm": 66.0, "turned": 0.1},
    "axis along x": {"sectors": 12, "axis": ((50.0, 7.0, -20.0), (0.0, 0.5 * np.pi, 0.0))},
}


@pytest.mark.parametrize("case", often(STEPS, "one", "axis along x"))
def test_step_of_one_sector_or_of_the_whole(folder, case):
    path = folder / "paddles.step"
    volume = paddles(path, 12, **STEPS[case])
    on = {"origin": (50.0, 7.0, -20.0), "direction": (1.0, 0.0, 0.0)} if "axis" in case else {}
    everything = ((-1.0, -1.0, -0.1), (1.0, 1.0, 0.1))
    asked = of_step(path, 12, **on, interfaces=seat(box_m=everything))
    told = step_geometry(asked)
    assert told.volume_m3 == pytest.approx(volume, rel=1e-6)
    mesh = mesh_of(mesh_step(asked), asked, "disk")
    body = body_of_mesh("disk", asked, mesh)
    assert body.volume_m3 == pytest.approx(volume, rel=1e-4)
    assert 1.0 / 3.0 < len(mesh.cells) / told.expected.cells < 3.0
    assert_copies_are_the_whole(mesh, body)
    assert body.interfaces[0].cut_facets == 0
    assert len(mesh.interfaces["seat"]) == len(sectors.outer_facets(mesh.points, mesh.cells, 12))


def test_boxes_are_cut_into_the_geometry_of_a_sector(folder):
    """A strip of the rim of each sector, by a box at one of them; closed form of a cylinder."""
    path = folder / "strip.step"
    paddles(path, 12, sectors=12)
    low, high = np.radians(8.0), np.radians(12.0)
    box = ((0.09, 0.1 * np.sin(low), -0.003), (0.101, 0.1 * np.sin(high), 0.002))
    asked = of_step(path, 12, interfaces=seat(box_m=box))
    mesh = mesh_of(mesh_step(asked), asked, "disk")
    own = body_of_mesh("disk", asked, mesh).interfaces[0]
    assert own.area_m2 == pytest.approx(12 * 0.1 * (high - low) * 0.005, rel=1e-4)
    assert own.position_m == pytest.approx((0.0, 0.0, -0.0005), abs=1e-8)
    assert own.cut_facets == 0


@pytest.mark.parametrize(
    ("sectors", "count", "message"),
    [
        (1, 11, "no face of the solids, turned by 32.7273° about the axis, is another; they take"),
        (12, 11, "the file holds the whole, of 0.000[0-9]* m³, but 11 sectors cut out of it have"),
    ],
)
def test_steps_that_do_not_repeat_are_refused(folder, sectors, count, message):
    path = folder / "other.step"
    paddles(path, 12, sectors=sectors)
    asked = of_step(path, count)
    with pytest.raises(MeshingError, match=message):
        mesh_step(asked)
