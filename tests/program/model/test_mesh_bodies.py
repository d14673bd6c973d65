"""Bodies from meshes and STEP files: against profiles, closed forms and rigid bodies."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from scipy.optimize import brentq

from solidwhirl.build import cylinder
from solidwhirl.commands.geometry import geometry_command
from solidwhirl.core.errors import MemoryShortageError, SceneError
from solidwhirl.cost.work import predict_body_cost
from solidwhirl.geometry import GeometryError
from solidwhirl.meshing import MeshingError, mesh_revolved, write_gmsh
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.interface_documents import mesh_doubts
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.output.documents import results_document
from solidwhirl.page.run.masses import interfaces_table
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene, scene_hash

sys.path.insert(0, str(Path(__file__).parents[2] / "meshing"))

from mesh_makers import brick, drawn
from toml_text import toml

pytestmark = pytest.mark.solver

# A short rotor with a disk; the faces at its ends are on bearings.
PROFILE = {
    "material": "steel",
    "sections": [
        cylinder("shaft", 0.0, 0.3, 0.03),
        cylinder("disk", 0.1, 0.16, 0.08, inner_radius_m=0.03),
    ],
    "interfaces": [
        {"name": "front", "kind": "face", "at_m": 0.0},
        {"name": "rear", "kind": "face", "at_m": 0.3},
    ],
}
FRONT = [[-0.04, -0.04, -0.001], [0.04, 0.04, 0.001]]
REAR = [[-0.04, -0.04, 0.299], [0.04, 0.04, 0.301]]
MESHED = {
    "file": "rotor.msh",
    "length_unit": "m",
    "material": "steel",
    "interfaces": [{"name": "front", "group": "interface_front"}, {"name": "rear", "box_m": REAR}],
}
BEARINGS = [
    {"name": "front", "first": "rotor.front", "stiffness_n_per_m": 5e7},
    {"name": "rear", "first": "rotor.rear", "stiffness_n_per_m": [5e7, 8e7]},
]
MODEL = {
    "accuracy": 0.1,  # few elements around
    "modes": 4,
    "estimates": "off",
    "level": "solid",
    "size_m": 0.1,
    "corner_size_m": 0.04,
    "growth": 1.5,
}


def scene(folder, model=None, **tables):
    data = {
        "name": "own",
        "speeds": {"list_rpm": [0.0, 30000.0]},
        "campbell": {"branches": 6},
        "model": {"estimates": "off", "modes": 3} if model is None else model,
        "bearings": BEARINGS,
    }
    return parse_scene(data | tables, folder / "scene.toml")


def run(asked):
    results = run_scene(asked)
    assert [c for c in results.checks if c.passed is False] == []
    return results


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the mesh that the program makes of the profile, and with its geometry."""
    out = tmp_path_factory.mktemp("own")
    parametric = scene(out, model=MODEL, bodies={"rotor": PROFILE})
    body = build_bodies(parametric)["rotor"]
    size = choose_resolution(body, "solid", parametric.model).size
    write_gmsh(whole_mesh(mesh_revolved(body, size))[0], out / "rotor.msh")
    profile = {k: PROFILE[k] for k in ("material", "sections")}
    (out / "profile.toml").write_text(toml({"name": "profile", "bodies": {"rotor": profile}}))
    geometry_command(out / "profile.toml", out / "rotor.step")
    points, hexahedra = brick((120.0, 170.0, 40.0), (3, 4, 1), (-40.0, -200.0, -20.0))
    meshio.Mesh(
        points,
        [("hexahedron", hexahedra)],
        point_sets={
            "FEET": np.flatnonzero(points[:, 1] < -199.0),
            "SEAT": np.flatnonzero(points[:, 1] > -31.0),
        },
    ).write(out / "block.inp")
    return out


@pytest.fixture(scope="module")
def read(folder):
    return run(scene(folder, mesh_bodies={"rotor": MESHED}))


def test_a_mesh_of_our_own_gives_the_frequencies_of_the_profile(folder, read):
    drawn = run(scene(folder, model=MODEL, bodies={"rotor": PROFILE}))
    held, free = (
        [getattr(r.elements["rotor"], f"{kind}_frequencies_hz")[:6] for r in (drawn, read)]
        for kind in ("fixed_interface", "free")
    )
    # The same tetrahedra: what differs are 16 digits of the coordinates in the file, and that the
    # one is solved on a sector, with fields of the index 1 alone.
    assert held[1] == pytest.approx(held[0], rel=1e-8)
    # The rest of the basis, static answers of many orders, is told apart by order a little
    # differently; with 3 modes the truncation leaves 1e-4.
    assert free[1] == pytest.approx(free[0], rel=1e-4)
    at_speed = [r.campbell.frequency_hz[:, 1] for r in (drawn, read)]
    assert at_speed[1] == pytest.approx(at_speed[0], rel=1e-4)
    element = read.elements["rotor"]
    assert element.spin_generator is not None
    assert read.plan.bodies["rotor"].shape == "round"
    entry = results_document(read)["bodies"]["rotor"]
    assert entry["source"]["file"] == "rotor.msh"
    assert entry["source"]["roundness"]["uneven_mass"] < 1e-10
    assert entry["inertia_kg_m2"][2][2] == pytest.approx(entry["polar_inertia_kg_m2"])


def test_interfaces_are_told_with_what_their_boxes_cut(folder, read):
    """A box across elements is a doubt with its share; place and area of all are in the results."""
    low = [[-0.2, -0.2, 0.05], [0.2, 0.2, 0.1234]]
    cut = MESHED | {"interfaces": [MESHED["interfaces"][0], {"name": "rear", "box_m": low}]}
    (doubt,) = mesh_doubts(scene(folder, mesh_bodies={"rotor": cut}))
    assert doubt.key == "mesh_bodies.rotor.interfaces[1].box_m"
    assert "facets of the mesh; they are left out" in doubt.found
    assert not list(mesh_doubts(scene(folder, mesh_bodies={"rotor": MESHED})))
    front, rear = results_document(read)["bodies"]["rotor"]["interfaces"]
    assert front["mean_position_m"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert rear["mean_position_m"] == pytest.approx([0.0, 0.0, 0.3], abs=1e-6)
    assert front["asked"] == "group interface_front"
    assert rear["asked"].startswith("box from (-0.04, -0.04, 0.299)")
    assert "Interfaces" in [
        table.title for table in interfaces_table(results_document(read)["bodies"])
    ]
    # of a profile the area is that of its rings
    drawn = run(scene(folder, model=MODEL | {"level": "harmonic"}, bodies={"rotor": PROFILE}))
    for found, of_mesh in zip(
        results_document(drawn)["bodies"]["rotor"]["interfaces"], (front, rear), strict=True
    ):
        assert found["area_m2"] == pytest.approx(of_mesh["area_m2"], rel=1e-2)
        assert found["position_m"] == pytest.approx(found["mean_position_m"], abs=1e-12)


@pytest.mark.verify
def test_step_is_within_its_estimate_of_the_harmonic_level(folder):
    body = MESHED | {
        "file": "rotor.step",
        "length_unit": "mm",
        "size_m": 0.03,
        "smallest_m": 0.008,
        "around": 12,
        "interfaces": [{"name": "front", "box_m": FRONT}, {"name": "rear", "box_m": REAR}],
    }
    model = {"estimates": "on", "modes": 4, "accuracy": 1e-3}
    # tetrahedra of these sizes are not the same in all directions to more than 0.4 %
    coarse = model | {"accuracy": 1e-2}
    read = run(scene(folder, model=coarse, mesh_bodies={"rotor": body}))
    harmonic = model | {"level": "harmonic", "compare_coupling": "off"}
    drawn = run(scene(folder, model=harmonic, bodies={"rotor": PROFILE}))
    assert drawn.estimates.largest < 1e-3
    for found, exact, estimate in (
        (read.campbell, drawn.campbell, read.estimates.campbell.total),
        (read.at_rest, drawn.at_rest, read.estimates.at_rest.total),
    ):
        count = min(len(estimate), 6)
        error = np.abs(found.frequency_hz[:count] / exact.frequency_hz[:count] - 1.0)
        # the harmonic level is itself good to its own estimate
        assert (error < estimate[:count] + 1e-3).all()
        assert error.max() > 1e-5  # another mesh, not the same numbers
        assert estimate[:count].max() < 0.1
    assert results_document(read)["accuracy"]["meshes_without_estimate"] == []
    # pairs stay pairs on a mesh without symmetry
    rest = read.elements["rotor"].free_frequencies_hz
    assert rest[0:6:2] == pytest.approx(rest[1:6:2], rel=1e-10)


def bar(folder, counts):
    """A free bar of hexahedra, 20 by 20 by 400 mm, of a material without lateral contraction."""
    points, hexahedra = brick((20.0, 20.0, 400.0), counts, (-10.0, -10.0, 0.0))
    meshio.Mesh(points, [("hexahedron", hexahedra)]).write(folder / "bar.vtu")
    straight = {"density_kg_per_m3": 8000.0, "youngs_modulus_pa": 2e11, "poissons_ratio": 0.0}
    body = {"file": "bar.vtu", "length_unit": "mm", "speed_ratio": 0.0, "material": "straight"}
    asked = scene(
        folder,
        materials={"straight": straight},
        mesh_bodies={"bar": body},
        bearings=[],
        speeds={"list_rpm": [0.0]},
        model={"estimates": "off", "modes": 8},
    )
    return run(asked).elements["bar"]


def axial_frequency(element):
    """The first elastic mode that moves points of the surface along the bar alone."""
    motion = (element.recovery_modes**2).sum(axis=0)
    share = motion[2] / motion.sum(axis=0)
    frequency = np.array([c.frequency_hz for c in element.coordinates])
    return frequency[(share > 0.9) & (frequency > 1.0)].min()


def test_a_bar_of_hexahedra_converges_to_the_closed_form(folder):
    # sqrt(E/ρ) / 2L, exact in three dimensions without lateral contraction
    exact = np.sqrt(2e11 / 8000.0) / 0.8
    errors = [axial_frequency(bar(folder, (1, 1, along))) / exact - 1.0 for along in (6, 12)]
    assert 0.0 < errors[1] < 1e-4
    # second-order elements: errors of frequencies fall with the fourth power of their length; of
    # this motion faster, as the cut has the symmetry of the bar
    assert errors[0] / errors[1] > 12.0
    # Euler's and Bernoulli's beam bounds bending from above; rotary inertia and shear take a part
    bending = 22.3733 / (2.0 * np.pi * 0.4**2) * np.sqrt(2e11 / 8000.0) * 0.02 / np.sqrt(12.0)
    fine = bar(folder, (2, 2, 12)).free_frequencies_hz[:2]
    # the section is square, and so is its cut into tetrahedra
    assert fine[1] == pytest.approx(fine[0], rel=1e-9)
    assert 0.97 * bending < fine.mean() < bending


def test_a_bar_with_point_masses_against_the_beam(folder):
    """Masses on the eight corners: Euler's beam with masses and their rotary inertia at its ends.

    With w = A cos βx + B cosh βx between -l and l the moment EI d²w is ω² J dw and the shear force
    EI d³w is -ω² M w at the end l.
    """
    points, hexahedra = brick((20.0, 20.0, 400.0), (2, 2, 12), (-10.0, -10.0, 0.0))
    meshio.Mesh(points, [("hexahedron", hexahedra)]).write(folder / "heavy.inp")
    corner = np.flatnonzero(
        (np.abs(points[:, :2]).min(axis=1) == 10.0) & np.isin(points[:, 2], (0.0, 400.0))
    )
    rows = "".join(f"{9000 + k}, {node + 1}\n" for k, node in enumerate(corner))
    with (folder / "heavy.inp").open("a") as file:
        file.write(f"*ELEMENT, TYPE=MASS, ELSET=HEAVY\n{rows}*MASS, ELSET=HEAVY\n3e-4\n")
    straight = {"density_kg_per_m3": 8000.0, "youngs_modulus_pa": 2e11, "poissons_ratio": 0.0}
    body = {"file": "heavy.inp", "length_unit": "mm", "speed_ratio": 0.0, "material": "straight"}
    asked = scene(
        folder,
        materials={"straight": straight},
        mesh_bodies={"bar": body},
        bearings=[],
        speeds={"list_rpm": [0.0]},
        model={"estimates": "off", "modes": 8},
    )
    element = run(asked).elements["bar"]
    assert element.mass_kg == pytest.approx(1.28 + 8 * 0.3, rel=1e-12)
    stiffness, half, heavy, rotary = 2e11 * 0.02**4 / 12.0, 0.2, 1.2, 1.2 * 0.01**2

    def determinant(beta):
        square = stiffness * beta**4 / (8000.0 * 0.02**2)
        c, s, ch, sh = (f(beta * half) for f in (np.cos, np.sin, np.cosh, np.sinh))
        moment = [-stiffness * beta * c + square * rotary * s,
                  stiffness * beta * ch - square * rotary * sh]  # fmt: skip
        force = [stiffness * beta**3 * s + square * heavy * c,
                 stiffness * beta**3 * sh + square * heavy * ch]  # fmt: skip
        return moment[0] * force[1] - moment[1] * force[0]

    beta = brentq(determinant, 1.0 / half, 2.3 / half)
    euler = beta**2 * np.sqrt(stiffness / (8000.0 * 0.02**2)) / (2.0 * np.pi)
    found = element.free_frequencies_hz[:2]
    # shear and rotary inertia of the bar: (π²/2) (I / A L²) (1 + 2.4) = 0.35 % between pins
    assert 0.99 * euler < found.mean() < 1.001 * euler


def test_a_casing_of_any_shape_stands_beside_the_rotor(folder):
    hard = {"density_kg_per_m3": 7800.0, "youngs_modulus_pa": 2e17, "poissons_ratio": 0.3}
    block = {
        "file": "block.inp",
        "length_unit": "mm",
        "speed_ratio": 0.0,
        "material": "hard",
        "interfaces": [
            {"name": "seat", "group": "SEAT"},
            {"name": "feet", "group": "FEET", "node_m": [0.0, 0.0, 0.0], "coupling": "rigid"},
        ],
    }
    hold = {
        "stiffness_n_per_m": [2e7, 3e7],
        "axial_stiffness_n_per_m": 1e7,
        "tilt_stiffness_n_m_per_rad": [1e5, 2e5],
        "torsion_stiffness_n_m_per_rad": 1e5,
    }
    bearings = [
        BEARINGS[0] | {"second": "casing.seat", "damping_n_s_per_m": 100.0},
        BEARINGS[1],
        {"name": "mount", "first": "casing.feet", **hold},
    ]
    rotor = {"rotor": PROFILE}
    model = {"estimates": "off", "modes": 3, "level": "harmonic", "accuracy": 0.05}
    common = {"model": model, "bodies": rotor, "bearings": bearings, "materials": {"hard": hard}}
    meshed = run(scene(folder, mesh_bodies={"casing": block}, **common))
    element = meshed.elements["casing"]
    # x -40..80, y -200..-30, z -20..20 mm
    assert element.mass_kg == pytest.approx(7800.0 * 0.12 * 0.17 * 0.04, rel=1e-12)
    assert element.center_of_gravity_m == pytest.approx((0.02, -0.115, 0.0), abs=1e-12)
    mass, (a, b, c) = element.mass_kg, (0.12, 0.17, 0.04)
    inertia = mass / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.diag(element.inertia_kg_m2) == pytest.approx(inertia, rel=1e-12)
    rigid = {
        "mass_kg": mass,
        "center_of_gravity_m": [0.02, -0.115, 0.0],
        "inertia_kg_m2": inertia.tolist(),
        "interfaces": {"seat": 0.0, "feet": 0.0},
    }
    lumped = run(scene(folder, rigid_bodies={"casing": rigid}, **common))
    # a body a million times stiffer than its mounts moves as a rigid one
    for found, exact in ((meshed.at_rest, lumped.at_rest), (meshed.campbell, lumped.campbell)):
        assert found.frequency_hz[:6] == pytest.approx(exact.frequency_hz[:6], rel=1e-5)
    steel = run(scene(folder, mesh_bodies={"casing": block | {"material": "steel"}}, **common))
    assert steel.at_rest.frequency_hz[0] < meshed.at_rest.frequency_hz[0]


REFUSED = {
    "missing file": ({"file": "none.msh"}, SceneError, r"none\.msh: no such file"),
    "suffix": ({"file": "rotor.stl"}, SceneError, "has the suffix '.stl'; known are .msh"),
    "unit": ({"length_unit": "cm"}, SceneError, "length_unit: Input should be 'm', 'mm' or 'in'"),
    "sizes of a mesh": ({"size_m": 0.1}, SceneError, "size_m is for STEP files"),
    "sizes of STEP": ({"file": "rotor.step"}, SceneError, "a STEP file needs size_m"),
    "no material": ({"material": None}, SceneError, "material is needed"),
    "material": ({"material": "gold"}, GeometryError, "material: unknown material 'gold'"),
    "both": (
        {"interfaces": [{"name": "front", "group": "a", "box_m": REAR}, MESHED["interfaces"][1]]},
        SceneError,
        "give group or box_m",
    ),
    "damped": (
        {"speed_ratio": 0, "internal_damping": {"modal_ratio": 0.1}},
        SceneError,
        "internal_damping needs to know how the body turns",
    ),
    "one surface twice": (
        {"interfaces": [{"name": "front", "box_m": REAR}, {"name": "rear", "box_m": REAR}]},
        MeshingError,
        "'front' and 'rear' are the same surface",
    ),
    "a turning block": (
        {"file": "block.inp", "length_unit": "mm", "interfaces": []},
        MeshingError,
        "mesh_bodies.rotor: body 'rotor' lies beside its axis",
    ),
    "half a seat": (
        {
            "interfaces": [
                {"name": "front", "box_m": [[-0.04, 0.0, -0.001], [0.04, 0.04, 0.001]]},
                {"name": "rear", "box_m": REAR},
            ]
        },
        MeshingError,
        "interface 'front': its facets do not go evenly around the axis",
    ),
}


JOINED = {"file": "rotor.step", "size_m": 0.03, "joints": [{"between": ["shaft", "hub"]}]}
REFUSED |= {
    "joints of a mesh": (
        {"joints": JOINED["joints"]},
        SceneError,
        "joints are between the solids of STEP files",
    ),
    "joints of sectors": (JOINED | {"sectors": 8}, SceneError, "leave out sectors"),
    "joints twice": (
        JOINED | {"joints": [{"between": ["a b", "c"]}, {"between": ["c", "a b"]}]},
        SceneError,
        "two joints are between the same solids",
    ),
    "part of a seat": (
        JOINED | {"joints": [{"between": ["a", "b"], "over_m": [0.1, 0.2]}]},
        SceneError,
        "over_m is for joints of sections",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals_have_one_message(folder, case):
    changes, kind, message = REFUSED[case]
    body = {k: v for k, v in (MESHED | changes).items() if v is not None}
    with pytest.raises(kind, match=message):
        build_mesh_bodies(scene(folder, mesh_bodies={"rotor": body}, bearings=[]))


def test_a_fit_as_drawn_is_told_with_the_speed_that_loosens_it(tmp_path):
    """Loosening speed of a hub: that of Lamé's rings without contraction, of equal length."""
    drawn(tmp_path / "fit.step", 10.0 - 0.01, beyond_mm=0)
    cork = {"density_kg_per_m3": 8000.0, "youngs_modulus_pa": 2e11, "poissons_ratio": 0.0}
    body = {
        "file": "fit.step",
        "length_unit": "mm",
        "material": "cork",
        "size_m": 0.004,
        "joints": [{"between": ["shaft", "hub"]}],
        "interfaces": [{"name": "rear", "box_m": [[-0.01, -0.01, 0.06], [0.01, 0.01, 0.07]]}],
    }
    asked = scene(
        tmp_path,
        materials={"cork": cork},
        mesh_bodies={"rotor": body},
        bearings=[{"name": "rear", "first": "rotor.rear", "stiffness_n_per_m": 1e7}],
        speeds={"list_rpm": [0.0, 4e4]},
        model={"estimates": "off", "modes": 4},
    )
    document = results_document(run(asked))
    (joint,) = document["bodies"]["rotor"]["joints"]
    loose = np.sqrt(4.0 * 2e11 * 1e-5 / (8000.0 * 0.01 * 3.0 * 0.03**2)) * 30.0 / np.pi
    assert joint["interference_m"] == pytest.approx(1e-5, rel=1e-6)
    assert joint["loose_at_rpm"] == pytest.approx(loose, rel=1e-3)
    assert document["bodies"]["rotor"]["source"]["sectors"] is None


def test_scenes_count_by_the_content_of_their_meshes(folder, tmp_path):
    first = scene(folder, mesh_bodies={"rotor": MESHED})
    (tmp_path / "rotor.msh").write_bytes((folder / "rotor.msh").read_bytes())
    moved = scene(tmp_path, mesh_bodies={"rotor": MESHED})
    assert scene_hash(first) == scene_hash(moved)
    (tmp_path / "rotor.msh").write_text("$MeshFormat\n")
    assert scene_hash(scene(tmp_path, mesh_bodies={"rotor": MESHED})) != scene_hash(first)


def test_the_plan_says_what_a_mesh_costs(folder):
    asked = scene(folder, mesh_bodies={"rotor": MESHED})
    plan = make_plan(asked, {})
    body = build_mesh_bodies(asked)["rotor"]
    points = len(meshio.gmsh.read(folder / "rotor.msh").points)
    cost = predict_body_cost(body, plan.bodies["rotor"], modes=4)
    # nodes are counted, not predicted
    assert cost.unknowns == 3 * points
    assert "meshing" not in cost.seconds


def test_more_memory_than_there_is_is_refused_before_meshing(folder):
    body = MESHED | {
        "file": "rotor.step",
        "size_m": 1e-5,
        "interfaces": [{"name": "front", "box_m": FRONT}, {"name": "rear", "box_m": REAR}],
    }
    message = r"mesh_bodies.rotor: would have .* take a larger size_m"
    with pytest.raises(MemoryShortageError, match=message):
        run(scene(folder, mesh_bodies={"rotor": body}))


@pytest.mark.mpi
@pytest.mark.verify
@pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")
def test_two_ranks_give_the_same(folder, tmp_path):
    ends = [{"name": "front", "box_m": FRONT}, {"name": "rear", "box_m": REAR}]
    data = {
        "name": "ranks",
        "model": {"estimates": "off", "modes": 3},
        "speeds": {"to_rpm": 30000, "count": 2},
        "bearings": BEARINGS,
        "mesh_bodies": {"rotor": MESHED | {"interfaces": ends}},
    }
    (folder / "ranks.toml").write_text(toml(data))
    options = ["--allow-run-as-root", "--oversubscribe", "-n", "2"]
    # this process may have MPI running; its children must not think that they are its ranks
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMIX_", "ORTE_"))}
    found = []
    for k, prefix in enumerate((["mpirun", *options], [])):
        out = tmp_path / str(k)
        command = [sys.executable, "-m", "solidwhirl", "run", str(folder / "ranks.toml")]
        whole = [*prefix, *command, "--out", str(out), "--no-pictures"]
        subprocess.run(whole, check=True, capture_output=True, env=clean, timeout=300)
        document = json.loads((out / "results.json").read_text())
        found.append(np.array(document["campbell"]["frequency_hz"]))
    # sums of many ranks round in another order
    assert found[0] == pytest.approx(found[1], rel=1e-9)


@pytest.mark.parametrize(
    ("cut_mm", "shape"),
    [
        (None, "round"),
        ((21.0, -50.0, -1.0, 50.0, 100.0, 302.0), "asymmetric"),  # a flat along all of it
        ((26.0, -2.5, 280.0, 50.0, 5.0, 30.0), "asymmetric"),  # a notch in one end face
    ],
)
def test_a_geometry_says_itself_whether_it_is_of_revolution(tmp_path, cut_mm, shape):
    """A shaft of 60 mm, and what a box takes from it (corner and edges)."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        solid = [(3, gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 300, 30))]
        if cut_mm is not None:
            gmsh.model.occ.cut(solid, [(3, gmsh.model.occ.addBox(*cut_mm))])
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "shaft.step"))
    finally:
        gmsh.finalize()
    ends = [
        {"name": name, "box_m": [[-0.1, -0.1, z - 1e-6], [0.1, 0.1, z + 1e-6]]}
        for name, z in (("left", 0.0), ("right", 0.3))
    ]
    body = {"file": "shaft.step", "length_unit": "mm", "material": "steel", "size_m": 0.02}
    data = {
        "name": "shaft",
        "speeds": {"to_rpm": 6000.0, "count": 2},
        "mesh_bodies": {"rotor": body | {"interfaces": ends}},
        "bearings": [
            {"name": end, "first": f"rotor.{end}", "stiffness_n_per_m": 1e8}
            for end in ("left", "right")
        ],
    }
    (found,) = build_mesh_bodies(parse_scene(data, folder=tmp_path)).values()
    assert found.request.shape == shape
