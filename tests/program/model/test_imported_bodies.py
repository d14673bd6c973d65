"""Bodies of a scene that come from files: the same as at home, and against closed forms."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from imported_tube import (
    AREA,
    BENDING,
    DENSITY,
    ENTRY,
    INNER,
    LENGTH,
    MILLIMETRES,
    MOUNT_N_PER_MM,
    OUTER,
    mounts,
    scene_of,
    tube,
)
from results_read import numbers
from scipy.optimize import brentq

from solidwhirl.build import beam, unbalance
from solidwhirl.core.errors import SceneError
from solidwhirl.model.imported_bodies import imported_element
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.cached_stages import open_store
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import (
    Disk,
    SuperelementError,
    beam_superelement,
    check_superelement,
    read_superelement,
    rigid_superelement,
    write_superelement,
)
from solidwhirl.rotordyn.exchange.matrices.arrays_npz import read_npz, write_npz
from solidwhirl.rotordyn.exchange.matrices.dmig import write_dmig
from solidwhirl.rotordyn.exchange.matrices.matrix_market import write_matrix_market
from solidwhirl.rotordyn.exchange.matrices.op4 import write_op4
from solidwhirl.scene_reading.reader import parse_scene, read_scene, scene_hash

ROOT = Path(__file__).resolve().parents[3]
SPRINGS = [
    {"name": "left", "first": "rotor.left", "stiffness_n_per_m": [1e7, 2e7]},
    {"name": "right", "first": "rotor.right", "stiffness_n_per_m": 1e7},
]


# -- a body of this program, out and in again -----------------------------------------------------


@pytest.fixture(scope="module")
def home(tmp_path_factory, small_scene):
    """A run of the small rotor with its own solid, and its body in every format."""
    folder = tmp_path_factory.mktemp("home")
    data = small_scene(rpm=(0.0, 15000.0, 30000.0))
    data["bearings"] = SPRINGS
    results = run_scene(parse_scene(data))
    element = results.elements["rotor"]
    write_superelement(element, folder / "rotor.h5")
    write_npz(element, folder / "rotor.npz")
    write_dmig(element, folder / "rotor.pch")
    write_op4(element, folder / "rotor.op4")
    write_matrix_market(element, folder / "rotor")
    return folder, results


NODES = {"interfaces": {"left": 1, "right": 2}, "length_unit": "m", "mass_unit": "kg"}


@pytest.mark.solver
@pytest.mark.parametrize(
    ("file", "more", "limit"),
    [
        ("rotor.h5", {}, 0.0),
        # written with all digits: rounding of other cleaning of the rigid motions only
        ("rotor.npz", {}, 1e-9),
        ("rotor.op4", {}, 1e-9),
        ("rotor/body.json", {}, 1e-9),
        # 12 digits
        ("rotor.pch", NODES, 1e-6),
        ("rotor.bdf", NODES, 1e-6),
    ],
)
def test_a_body_comes_back_as_it_left(home, file, more, limit):
    folder, own = home
    entry = {"file": file, "speed_ratio": 1.0, **more}
    tables = {"speeds": {"list_rpm": [0.0, 15000.0, 30000.0]}, "campbell": {"branches": 4}}
    found = run_scene(scene_of(entry, folder, bearings=SPRINGS, **tables))
    assert not [c for c in found.checks if c.passed is False]
    error = np.abs(found.campbell.frequency_hz / own.campbell.frequency_hz - 1.0).max()
    assert error <= limit, error
    assert len(found.critical_speeds) == len(own.critical_speeds) >= 2
    for first, second in zip(found.critical_speeds, own.critical_speeds, strict=True):
        assert first.critical.speed_rad_s == pytest.approx(
            second.critical.speed_rad_s, rel=max(limit, 1e-15)
        )
        assert first.critical.whirl == second.critical.whirl


@pytest.mark.solver
def test_results_say_where_a_body_came_from_and_that_its_error_is_not_known(home, tmp_path):
    folder, _ = home
    scene = scene_of({"file": "rotor.npz"}, folder, bearings=SPRINGS)
    document = results_document(run_scene(scene))
    body = document["bodies"]["rotor"]
    assert body["level"] == "imported"
    assert body["import"]["file"] == "rotor.npz" and body["import"]["format"] == "npz"
    assert body["import"]["sha256"] == scene.imported["rotor"].sha256
    assert document["accuracy"]["bodies_without_estimate"] == ["rotor"]
    assert document["accuracy"]["met"] is document["accuracy"]["largest_error_estimate"] is None
    assert document["verdict"]["accuracy"]["not_estimated"] == ["rotor"]
    totals = np.array(document["campbell"]["frequency_error_estimate"], dtype=float)
    assert np.isnan(totals).all()
    # it stands still: nobody excites a critical speed
    assert document["critical_speeds"] == []
    write_superelement(run_scene(scene).elements["rotor"], tmp_path / "again.h5")
    assert read_superelement(tmp_path / "again.h5").level == "imported"


@pytest.mark.solver
def test_a_superelement_file_at_another_place_under_other_names(home):
    """Moved along the axis with its bearings, a body has the same frequencies; all checks pass."""
    folder, own = home
    entry = {
        "file": "rotor.h5",
        "speed_ratio": 1.0,
        "origin_m": 0.7,
        "interfaces": {"front": "left", "rear": "right"},
    }
    joints = [{**SPRINGS[0], "first": "rotor.front"}, {**SPRINGS[1], "first": "rotor.rear"}]
    tables = {"speeds": {"list_rpm": [0.0, 15000.0, 30000.0]}, "campbell": {"branches": 4}}
    found = run_scene(scene_of(entry, folder, bearings=joints, **tables))
    np.testing.assert_allclose(found.campbell.frequency_hz, own.campbell.frequency_hz, rtol=1e-12)
    element, before = found.elements["rotor"], own.elements["rotor"]
    assert element.level == "harmonic" and element.provenance["import"]["format"] == "superelement"
    assert element.interface_node("front").position_m[2] == pytest.approx(0.7)
    np.testing.assert_allclose(
        element.center_of_gravity_m, before.center_of_gravity_m + np.array([0.0, 0.0, 0.7])
    )
    failed = [c.name for c in check_superelement(element) if c.passed is False]
    assert failed == []


# -- foreign matrices against closed forms --------------------------------------------------------


def lateral_hz(count):
    """Euler-Bernoulli beam on a spring at each end, from the roots of its determinant [Hz]."""

    def determinant(number):
        b = number / LENGTH
        spring = MOUNT_N_PER_MM / (BENDING * b**3)
        c, s, ch, sh = np.cos(number), np.sin(number), np.cosh(number), np.sinh(number)
        # w = A cos + B sin + C cosh + D sinh; w'' = 0, and EI w''' = −k w at 0, +k w at the end
        rows = np.array(
            [
                [-1.0, 0.0, 1.0, 0.0],
                [-c, -s, ch, sh],
                [spring, -1.0, spring, 1.0],
                [s - spring * c, -c - spring * s, sh - spring * ch, ch - spring * sh],
            ]
        )
        return la.det(rows / np.abs(rows).max(axis=1, keepdims=True))

    grid = np.linspace(0.05, 20.0, 4000)
    values = [determinant(x) for x in grid]
    roots = [
        brentq(determinant, a, b, xtol=1e-13)
        for a, b, u, v in zip(grid, grid[1:], values, values[1:], strict=False)
        if u * v < 0.0
    ]
    rate = np.sqrt(BENDING / (DENSITY * AREA)) / LENGTH**2
    return np.array(roots[:count]) ** 2 * rate / (2.0 * np.pi)


def test_a_tube_in_other_units_and_axes_against_the_closed_form(tmp_path):
    np.savez(tmp_path / "casing.npz", **tube())
    scene = scene_of(ENTRY, tmp_path, body="casing", bearings=mounts())
    results = run_scene(scene)
    element = results.elements["casing"]
    mass = DENSITY * AREA * LENGTH * 1e3
    assert element.mass_kg == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(element.center_of_gravity_m, [0.0, 0.0, 0.6], atol=1e-12)
    slender = mass * 1.2**2 / 12.0
    np.testing.assert_allclose(np.diag(element.inertia_kg_m2)[:2], slender, rtol=1e-12)
    polar = mass * 0.5e-6 * (OUTER**2 + INNER**2)
    assert element.inertia_kg_m2[2, 2] == pytest.approx(polar, rel=1e-12)
    assert not [c for c in results.checks if c.passed is False]
    found = results.at_rest.frequency_hz
    # each in two planes; cubic elements of a wave number b and a length h are off by (b h)⁴/1440
    for wanted in lateral_hz(4):
        wave = np.sqrt(2.0 * np.pi * wanted) * (DENSITY * AREA / BENDING) ** 0.25
        limit = 1.05 * (wave * LENGTH / 16) ** 4 / 1440 + 1e-8
        assert np.count_nonzero(np.abs(found / wanted - 1.0) < limit) == 2, (wanted, found[:12])
    assert element.provenance["import"]["notes"] == []


def test_a_pylon_that_is_fixed_to_the_ground(tmp_path):
    """A tube held at its far end: no free rigid motion, as is said, and modes of a cantilever."""
    whole = tube()
    arrays = {  # without the coordinates of the last node, which does not move
        **whole,
        "MASS": whole["MASS"][:96, :96],
        "STIFF": whole["STIFF"][:96, :96],
        "dof_node": whole["dof_node"][:96],
        "dof_component": whole["dof_component"][:96],
    }
    np.savez(tmp_path / "casing.npz", **arrays)
    joint = {"name": "tip", "first": "casing.front", "stiffness_n_per_m": 1e-3}
    entry = {**ENTRY, "interfaces": {"front": 1}}
    results = run_scene(scene_of(entry, tmp_path, body="casing", bearings=[joint]))
    element = results.elements["casing"]
    assert not element.rigid_body_present.any()
    assert element.provenance["import"]["notes"][0].endswith("the body is fixed to the ground.")
    # cos x cosh x = −1
    first = 1.8751040687119611**2 * np.sqrt(BENDING / (DENSITY * AREA)) / LENGTH**2 / (2 * np.pi)
    np.testing.assert_allclose(results.at_rest.frequency_hz[:2], first, rtol=1e-5)
    assert 0.95 < element.mass_kg / (DENSITY * AREA * LENGTH * 1e3) < 1.0


def test_a_rigid_casing_from_a_file_is_that_of_the_scene(tmp_path):
    """A rotor in a casing, unbalance and shapes: the casing from a table, and from matrices."""
    places = {"front": 0.1, "rear": 0.8, "foot": 0.45}
    shaft = beam([0.0, 0.3, 0.6, 0.9], 0.025, {"front": 0.1, "rear": 0.8, "wheel": 0.6})
    sweep = {"kind": "unbalance_response", "from_rpm": 100, "to_rpm": 6000, "count": 5}
    sweep |= {"unbalances": [unbalance("shaft.wheel", 1e-4)]}
    sweep |= {"observe": ["casing.front", "shaft.wheel"]}
    tables = {
        "speeds": {"to_rpm": 6000, "count": 3},
        "beams": {"shaft": shaft},
        "bearings": [
            *({"name": end, "first": f"shaft.{end}", "second": f"casing.{end}",
               "stiffness_n_per_m": 5e7} for end in ("front", "rear")),
            {"name": "m", "first": "casing.foot", "stiffness_n_per_m": [2e7, 3e7],
             "tilt_stiffness_n_m_per_rad": 1e6, "axial_stiffness_n_per_m": 1e7,
             "torsion_stiffness_n_m_per_rad": 1e6},
        ],
        "analyses": [sweep, {"kind": "mode_shapes", "speeds_rpm": [3000]}],
    }  # fmt: skip
    body = {"mass_kg": 30.0, "center_of_gravity_m": [0, 0, 0.4], "inertia_kg_m2": [2.0, 2.0, 1.0]}
    table = {**body, "interfaces": places}
    own = run_scene(parse_scene({"name": "own", "rigid_bodies": {"casing": table}, **tables}))
    made = rigid_superelement("casing", *body.values(), places)
    write_npz(made, tmp_path / "casing.npz")
    found = run_scene(scene_of({"file": "casing.npz"}, tmp_path, body="casing", **tables))
    np.testing.assert_allclose(found.campbell.frequency_hz, own.campbell.frequency_hz, rtol=1e-9)
    assert {n for c in found.critical_speeds for n in c.excited_by} == {"shaft"}
    both = [r.analyses["unbalance_response"].document for r in (own, found)]
    assert (
        json.dumps(both[0]).count("casing.front") == json.dumps(both[1]).count("casing.front") > 0
    )
    values = [np.array([n for n, _ in numbers(document)]) for document in both]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-7, atol=1e-12)


def test_interior_nodes_may_be_left_as_they_are_or_reduced(tmp_path):
    """The tube in Craig-Bampton form, all modes kept, done here by hand: the same frequencies."""
    arrays = tube()
    seats = np.r_[0:6, 96:102]
    inside = np.setdiff1d(np.arange(102), seats)
    k, m = arrays["STIFF"], arrays["MASS"]
    values, modes = la.eigh(k[np.ix_(inside, inside)], m[np.ix_(inside, inside)])
    basis = np.zeros((102, 102))
    basis[seats, :12] = np.eye(12)
    basis[np.ix_(inside, range(12))] = -la.solve(
        k[np.ix_(inside, inside)], k[np.ix_(inside, seats)]
    )
    basis[np.ix_(inside, range(12, 102))] = modes
    reduced = {
        **arrays,
        "MASS": basis.T @ m @ basis,
        "STIFF": basis.T @ k @ basis,
        "dof_node": np.r_[np.repeat([1, 17], 6), np.zeros(90, int)],
        "dof_component": np.r_[np.tile(np.arange(1, 7), 2), np.zeros(90, int)],
    }
    frequencies = []
    for data in (arrays, reduced):
        np.savez(tmp_path / "casing.npz", **data)
        results = run_scene(scene_of(ENTRY, tmp_path, body="casing", bearings=mounts()))
        assert results.elements["casing"].rigid_body_present.all()
        assert not [c for c in results.checks if c.passed is False]
        frequencies.append(results.at_rest.frequency_hz[:20])
    np.testing.assert_allclose(frequencies[1], frequencies[0], rtol=1e-8)
    named = [c.frequency_hz for c in results.elements["casing"].coordinates if c.kind == "modal"]
    np.testing.assert_allclose(named, np.sqrt(values) / (2 * np.pi), rtol=1e-6)


# -- content counts, folders do not ---------------------------------------------------------------


def test_a_scene_is_known_by_the_content_of_its_files(tmp_path):
    hashes = []
    np.savez(tmp_path / "casing.npz", **tube())
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        shutil.copy(tmp_path / "casing.npz", tmp_path / folder / "casing.npz")
        scene = scene_of(ENTRY, tmp_path / folder, body="casing", bearings=mounts())
        hashes.append(scene_hash(scene))
    assert hashes[0] == hashes[1]
    heavier = tube()
    heavier["MASS"] *= 1.01
    np.savez(tmp_path / "two" / "casing.npz", **heavier)
    with pytest.raises(SuperelementError, match="has changed since the scene was read"):
        imported_element("other", scene.imported["casing"])
    changed = scene_of(ENTRY, tmp_path / "two", body="casing", bearings=mounts())
    assert scene_hash(changed) != hashes[0]
    # as data and back, as a study hands a scene to another process
    again = parse_scene(json.loads(json.dumps(changed.model_dump(mode="json"))))
    assert scene_hash(again) == scene_hash(changed)
    pinned = {**ENTRY, "sha256": scene.imported["casing"].sha256}
    with pytest.raises(SceneError, match=r"imported\.casing\.sha256: the content of casing\.npz"):
        scene_of(pinned, tmp_path / "two", body="casing", bearings=mounts())
    assert scene_of(pinned, tmp_path / "one", body="casing").imported


def test_stages_are_kept_by_content(tmp_path):
    np.savez(tmp_path / "casing.npz", **tube())

    def run():
        scene = scene_of(ENTRY, tmp_path, body="casing", bearings=mounts())
        return run_scene(scene, store=open_store(tmp_path / "kept"))

    first, second = run(), run()
    assert first.stages["Campbell diagram"] == "computed"
    assert second.stages["Campbell diagram"] == "kept"
    heavier = tube()
    heavier["MASS"] *= 1.01
    np.savez(tmp_path / "casing.npz", **heavier)
    third = run()
    assert third.stages["Campbell diagram"] == "computed"
    assert third.at_rest.frequency_hz[0] < second.at_rest.frequency_hz[0]


# -- digits and units ------------------------------------------------------------------------------


def test_single_precision_leaves_no_spring_in_rigid_motion(tmp_path):
    """Rounding to 9 digits holds a free body with a fraction of a hertz; it is taken out and said.

    Free of springs, the six lowest frequencies are zero then.
    """
    arrays = tube()
    for name in ("MASS", "STIFF"):
        rounded = np.vectorize(lambda v: float(f"{v:.8e}"))(arrays[name])
        arrays[name] = 0.5 * (rounded + rounded.T)
    arrays["STIFF"][1, 7] += 1e-8 * arrays["STIFF"][7, 7]
    np.savez(tmp_path / "casing.npz", **arrays)
    scene = scene_of(ENTRY, tmp_path, body="casing")
    results = run_scene(scene)
    element = results.elements["casing"]
    assert element.rigid_body_present.all()
    notes = element.provenance["import"]["notes"]
    (note,) = [n for n in notes if "taken out" in n]
    assert "Rounding of the file holds rigid motions" in note
    assert any("stiffness matrix was made symmetric" in n for n in notes)
    failed = [c.name for c in check_superelement(element) if c.passed is False]
    assert failed == []


def test_a_turning_shaft_in_millimetres(tmp_path):
    """A shaft with a disk, its matrices brought into mm and t by hand."""
    shaft = beam_superelement(
        "s", np.linspace(0.0, 0.8, 5), 0.02, 0.0, (2e11, 0.3, 7800.0), {"left": 0.0, "right": 0.8},
        [Disk(name="d", position_m=0.3, mass_kg=9.0, polar_kg_m2=0.08, diametral_kg_m2=0.05)],
    )  # fmt: skip
    write_npz(shaft, tmp_path / "metres.npz")
    with np.load(tmp_path / "metres.npz") as found:
        arrays = {name: found[name] for name in found.files}
    size = np.where(np.isin(arrays["dof_component"], (1, 2, 3)), 1e3, 1.0)
    for name in ("M", "K0", "G"):  # t mm² per rad², t per translation
        arrays[name] = arrays[name] * 1e3 / np.outer(size, size)
    for name in ("rigid_modes", "L", "recovery_modes", "recovery_position", "mass", "inertia",
                 "center_of_gravity", "length_unit", "mass_unit"):  # fmt: skip
        arrays.pop(name)
    arrays["node_position"] = arrays["node_position"] * 1e3
    np.savez(tmp_path / "millimetres.npz", **arrays)
    tables = {"speeds": {"list_rpm": [0.0, 9000.0]}, "bearings": SPRINGS}
    pair = [
        run_scene(scene_of({"file": file, "speed_ratio": 1.0, **more}, tmp_path, **tables))
        for file, more in (("metres.npz", {}), ("millimetres.npz", MILLIMETRES))
    ]
    np.testing.assert_allclose(
        pair[1].campbell.frequency_hz, pair[0].campbell.frequency_hz, rtol=1e-9
    )
    assert pair[1].elements["rotor"].mass_kg == pytest.approx(shaft.mass_kg, rel=1e-10)


# -- the scene that comes with the program --------------------------------------------------------


@pytest.mark.verify
@pytest.mark.solver
def test_the_casing_file_is_what_its_tool_makes(tmp_path):
    """Other machines round otherwise: matrices to 1e-6, frequencies to 1e-8."""
    spec = importlib.util.spec_from_file_location("casing", ROOT / "tools" / "make_casing.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    tool.main(tmp_path / "casing.npz")
    kept, made = (read_npz(f / "casing.npz") for f in (ROOT / "scenes" / "casing", tmp_path))
    assert kept.names == made.names and kept.size == made.size
    frequencies = [
        np.sqrt(la.eigvalsh(b.matrices["K0"], b.matrices["M"])[6:]) for b in (kept, made)
    ]
    np.testing.assert_allclose(frequencies[1], frequencies[0], rtol=1e-8)


@pytest.mark.solver
def test_twin_rotor_in_its_casing(root):
    """Axial and torsional modes of the casing on its mounts; the rest needs both rotors."""
    scene = read_scene(root / "scenes" / "casing.toml")
    model = scene.model.model_copy(update={"accuracy": 0.05, "estimates": "off"})
    speeds = scene.speeds.model_copy(update={"count": 3})
    scene = scene.model_copy(update={"model": model, "speeds": speeds, "analyses": ()})
    results = run_scene(scene)
    assert not [c for c in results.checks if c.passed is False]
    casing, found = results.elements["casing"], results.at_rest.frequency_hz
    for stiffness, inertia in ((1e7, casing.mass_kg), (1e6, casing.inertia_kg_m2[2, 2])):
        rigid = np.sqrt(stiffness / inertia) / (2.0 * np.pi)
        # the tube gives by 0.2 % at its mounts
        assert np.abs(found / rigid - 1.0).min() < 4e-3
        assert np.all(np.abs(found / rigid - 1.0) > 1e-4)
    excited = {name for c in results.critical_speeds for name in c.excited_by}
    assert excited == {"inner", "outer"}
