"""Meshes of asymmetric bodies: one keyway, two flats, two poles, one blade."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree
from shapes import STEEL, body, interface, plane, section
from simplex import gauss_rule, mesh_mass_kg, second_order
from sometimes import often

from solidwhirl.geometry import (
    Blade,
    Flat,
    Hole,
    Keyway,
    RingCut,
    Slot,
    mass_properties,
    mirror_angle,
    sector_count,
    symmetry,
)
from solidwhirl.meshing import MeshSize, refined_sector
from solidwhirl.meshing.imported.measures import mass_integrals
from solidwhirl.meshing.own.features.sector import mesh_whole_body
from solidwhirl.meshing.own.prediction import predict_mesh, predict_refined

SIZE = MeshSize(size_m=0.02, corner_size_m=0.006, growth=0.6)
SECTIONS = section("shaft", 0.0, 0.3, 0.0, 0.03), section("disk", 0.12, 0.16, 0.03, 0.1)
SEATS = (
    interface("keyed", "outer", 0.0, 0.1),
    interface("flattened", "outer", 0.2, 0.3),
    plane("middle", 0.25),
)
KEY = Keyway(name="key", within="shaft", width_m=0.012, depth_m=0.008, start_m=0.02, end_m=0.08)
FLAT = Flat(name="flat", within="shaft", distance_m=0.024, start_m=0.2, end_m=0.3)
CUT = RingCut(name="cut", within="disk", width_deg=70.0, depth_m=0.03, start_m=0.12, end_m=0.16)
HOLE = Hole(name="hole", within="disk", count=1, pitch_radius_m=0.05, diameter_m=0.02)
POLES = Slot(
    name="poles",
    within="disk",
    count=2,
    width_m=0.008,
    depth_m=0.03,
    start_m=0.12,
    end_m=0.16,
    per_group=4,
    pitch_deg=20.0,
)
FAN = Blade(
    name="fan",
    on="disk",
    count=2,
    length_m=0.1,
    chord_m=(0.03, 0.02),
    thickness_m=(0.012, 0.006),
    material=STEEL,
)
TWISTED = replace(FAN, stagger_deg=(20.0, 45.0))

CASES = {
    "keyway": (KEY,),
    "square keyway": (replace(KEY, ends="square", angle_deg=30.0),),
    "keyways opposite": (KEY, replace(KEY, name="b", start_m=0.21, end_m=0.27, angle_deg=180.0)),
    "flat": (replace(FLAT, angle_deg=20.0),),
    "flats": (replace(FLAT, count=2, angle_deg=-40.0),),
    "cut": (CUT,),
    "half of the rim": (replace(CUT, width_deg=180.0, angle_deg=90.0),),
    "most of the rim": (replace(CUT, width_deg=300.0, angle_deg=45.0),),
    "hole": (replace(HOLE, angle_deg=10.0),),
    "blind holes": (replace(HOLE, count=2, start_m=0.14),),
    "blade": (replace(FAN, count=1, angle_deg=33.0),),
    "blades": (FAN,),
    "twisted blade": (replace(TWISTED, count=1, angle_deg=100.0),),
    "twisted blades": (TWISTED,),
    "poles": (POLES,),
    "poles and turned keyways": (POLES, replace(KEY, count=2, angle_deg=33.0)),
    "keyway and turned hole": (KEY, replace(HOLE, angle_deg=100.0)),
    "counts of 5 and 1": (replace(HOLE, count=5), replace(KEY, angle_deg=17.0)),
    "a flat through the bearing seat": (replace(FLAT, count=2), replace(KEY, angle_deg=90.0)),
}
# One of each kind of feature, meshed with all tests.
QUICK = ("keyway", "flats", "cut", "blind holes", "twisted blade", "poles")


def carrying(*features):
    return replace(body(*SECTIONS, interfaces=SEATS), features=features)


@pytest.fixture(scope="module")
def meshes():
    """Function: body and mesh of a case, made once."""
    made = {}

    def of(case):
        if case not in made:
            found = carrying(*CASES[case])
            made[case] = found, mesh_whole_body(found, SIZE)
        return made[case]

    return of


@pytest.mark.parametrize(
    "case",
    often(CASES, *QUICK),
)
def test_mass_centre_and_inertia_are_those_of_the_drawing(meshes, case):
    """As integrals over the mesh; arcs of second order, 24 around, lack some 3e-6 of a shaft."""
    item, mesh = meshes(case)
    assert symmetry(item) == "asymmetric" and mesh.sector is None
    assert mesh.quality.minimum_scaled_jacobian > 0.0
    found, exact = mass_integrals(mesh), mass_properties(item)
    assert found.mass_kg == pytest.approx(exact.mass_kg, rel=2e-5)
    assert mesh_mass_kg(mesh) == pytest.approx(found.mass_kg, rel=1e-12)
    size = np.trace(exact.inertia_kg_m2)
    length = math.sqrt(size / exact.mass_kg)
    off = np.array(found.center_of_gravity_m) - exact.center_of_gravity_m
    assert np.abs(off).max() < 1e-5 * length
    assert np.abs(np.array(found.inertia_kg_m2) - exact.inertia_kg_m2).max() < 1e-5 * size


def turned_onto_itself(mesh, matrix):
    """Whether an orthogonal map takes nodes to nodes and cells to cells, to round-off."""
    gap, partner = cKDTree(mesh.points).query(mesh.points @ matrix.T)
    rows = [np.unique(np.sort(c, axis=1), axis=0) for c in (mesh.cells, partner[mesh.cells])]
    return gap.max() < 1e-14 and np.array_equal(*rows)


@pytest.mark.parametrize("case", often(CASES, *QUICK, "twisted blades", "keyway and turned hole"))
def test_what_leaves_the_features_leaves_the_mesh(meshes, case):
    item, mesh = meshes(case)
    count, angle = sector_count(item.features), mirror_angle(item)
    mirrors = [] if angle is None else [angle + k * math.pi / count for k in range(count)]
    for plane_angle in mirrors:
        c, s = math.cos(2.0 * plane_angle), math.sin(2.0 * plane_angle)
        assert turned_onto_itself(mesh, np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]]))
    assert turned_onto_itself(mesh, np.diag([-1.0, -1.0, 1.0])) == (count == 2)


def area(mesh, name):
    """Area of an interface's second-order triangles."""
    bary, weight = gauss_rule(2, 4)
    _, slope = second_order(bary)
    rows = np.einsum("cnd,qne->cqde", mesh.points[mesh.interfaces[name]], slope)
    return float((np.linalg.norm(np.cross(rows[..., 0], rows[..., 1]), axis=-1) @ weight).sum())


def test_interfaces_keep_what_features_leave_of_them(meshes):
    around = 2.0 * math.pi * 0.03
    for case in ("square keyway", "flats", "poles"):
        mesh = meshes(case)[1]
        keyed = flattened = 0.1 * around
        if case == "square keyway":
            keyed -= 0.06 * 2.0 * 0.03 * math.asin(0.006 / 0.03)
        if case == "flats":
            flattened -= 2 * 0.1 * 2.0 * 0.03 * math.acos(0.024 / 0.03)
        assert area(mesh, "keyed") == pytest.approx(keyed, rel=1e-5)
        assert area(mesh, "flattened") == pytest.approx(flattened, rel=1e-5)
    # a cross-section through flats: the circle without two segments
    half = math.acos(0.024 / 0.03)
    cut = 0.03**2 * (math.pi - 2.0 * (half - math.sin(half) * math.cos(half)))
    assert area(meshes("flats")[1], "middle") == pytest.approx(cut, rel=1e-5)


def test_blades_are_sections_of_their_own(meshes):
    _, mesh = meshes("blades")
    blades = mesh.cell_section == mesh.section_names.index("fan")
    corners = mesh.points[mesh.cells[blades][:, :4]]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6.0
    # frustums; the roots follow the surface of the disk, 0.2 mm lower at the edges
    assert volume == pytest.approx(2 * 0.1 * (0.03 * 0.012 + 0.02 * 0.006 + 0.025 * 0.009 * 4) / 6,
                                   rel=2e-3)  # fmt: skip


def test_a_full_circle_is_not_drawn_as_one(meshes):
    """Without a mirror plane both halves are meshed at once, and share the nodes between."""
    _, mesh = meshes("keyway and turned hole")
    corners = np.sort(mesh.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3))
    facets, count = np.unique(corners, axis=0, return_counts=True)
    assert count.max() == 2
    # the surface is closed: every edge of it belongs to two facets
    skin = facets[count == 1]
    edges = np.sort(skin[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2))
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}


@pytest.mark.parametrize(
    "case",
    often(
        ["keyway", "flats", "poles", "twisted blades", "counts of 5 and 1"],
        *("keyway", "flats", "poles", "twisted blades"),
    ),
)
def test_numbers_are_predicted(meshes, case):
    item, mesh = meshes(case)
    found = predict_mesh(item, SIZE, "solid")
    assert 1 / 1.5 < found.cells / len(mesh.cells) < 1.5
    assert 1 / 1.5 < found.unknowns(2) / (3 * len(mesh.points)) < 1.5


@pytest.mark.parametrize(
    "case", often(["keyway", "poles and turned keyways", "keyway and turned hole"], "keyway")
)
def test_sizes_over_an_earlier_mesh(meshes, case):
    """Errors at the keyways alone: their elements get small, in the axes of the body.

    Errors e fall as h⁴. With edges times r ~ e^(-1/7), which make Σ r^-3 least, their sum is the
    target for Σ r^-3 = target^(-3/4) (Σ e^(3/7))^(7/4) elements.
    """
    item, mesh = meshes(case)
    points, cells = mesh.points, mesh.cells[:, :4]

    def near_keyway(middles):
        angle = math.radians(item.features[-1 if case.startswith("poles") else 0].angle_deg)
        along = middles[:, 0] * math.cos(angle) + middles[:, 1] * math.sin(angle)
        across = middles[:, 1] * math.cos(angle) - middles[:, 0] * math.sin(angle)
        if case.startswith("poles"):
            along = np.abs(along)
        return (along > 0.018) & (np.abs(across) < 0.01) & (middles[:, 2] < 0.09)

    corners = points[cells]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    at_key = near_keyway(corners.mean(axis=1))
    errors = np.where(at_key, volume, 1e-9 * volume)
    nowhere = np.zeros(len(points), dtype=bool)
    local = refined_sector(
        SIZE, points, cells, errors / errors.sum(), nowhere, degree=2, target=0.02
    )
    made = mesh_whole_body(item, SIZE, local)
    middles = made.points[made.cells[:, :4]].mean(axis=1)
    share = errors[at_key] / errors[at_key].sum()
    # gmsh's tetrahedra are larger than the regular ones of an edge, see `prediction`
    wanted = 0.65 * 0.02**-0.75 * (share ** (3.0 / 7.0)).sum() ** (7.0 / 4.0)
    assert 1 / 2.0 < near_keyway(middles).sum() / wanted < 2.0
    # on the other side of the shaft nothing is asked for
    opposite = middles[:, 2] > 0.2
    assert opposite.sum() <= 1.2 * (corners.mean(axis=1)[:, 2] > 0.2).sum()
    assert made.quality.minimum_scaled_jacobian > 0.0
    assert mass_integrals(made).mass_kg == pytest.approx(mass_properties(item).mass_kg, rel=2e-5)
    if mirror_angle(item) == 0.0:
        assert turned_onto_itself(made, np.diag([1.0, -1.0, 1.0]))


@pytest.mark.parametrize("target", often([0.3, 0.1], 0.3))
@pytest.mark.parametrize(
    "case", often(["keyway", "twisted blades", "keyway and turned hole"], "keyway")
)
def test_numbers_of_refined_meshes_are_predicted(meshes, case, target):
    item, mesh = meshes(case)
    points, cells = mesh.points, mesh.cells[:, :4]
    volume = np.abs(np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]])) / 6.0
    local = refined_sector(
        SIZE, points, cells, volume / volume.sum(), np.zeros(len(points), bool), degree=2,
        target=target,
    )  # fmt: skip
    made, predicted = mesh_whole_body(item, SIZE, local), predict_refined(local, whole=True)
    assert 1 / 1.5 < predicted.cells / len(made.cells) < 1.5
    assert 1 / 1.5 < predicted.unknowns(2) / (3 * len(made.points)) < 1.5
