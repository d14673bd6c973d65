"""The folder of a run: names and shapes that other programs rely on, and that it is whole."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from results_read import results_in

from solidwhirl.output.documents import write_results
from solidwhirl.rotordyn import (
    Bearing,
    End,
    Rotor,
    assemble,
    check_superelement,
    modes_at_speed,
    read_superelement,
)
from solidwhirl.scene_reading.reader import parse_scene, scene_hash

pytestmark = pytest.mark.solver

FILES = {
    *("SHA256SUMS", "scene.json", "results.json", "report.md", "report.html"),
    *("campbell.png", "campbell_errors.png", "critical_speeds.png"),
    *("unbalance_response.png", "unbalance_response_bearing_forces.png"),
    *(f"bodies/{name}.{kind}" for name in ("inner", "outer") for kind in ("h5", "json")),
    *(f"meshes/{name}.{kind}" for name in ("inner", "outer") for kind in ("vtu", "msh")),
}
TOP = {
    "schema", "scene", "plan", "accuracy", "bodies", "modes_at_rest", "campbell", "critical_speeds",
    "bearing_notes", "operating", "verdict", "doubts", "invariants", "predicted_cost", "analyses",
    "timings_s", "dense_problems", "body_problems", "peak_memory_gib", "packages",
    "bearings_beyond_theory",
}  # fmt: skip
ESTIMATE = {"frequency_error_estimate", "error_parts"}
PARTS = {"mesh", "mode_truncation", "speed_interpolation", "interface_coupling", "eigen_solver"}
BODY = {
    "mass_kg", "center_of_gravity_m", "polar_inertia_kg_m2", "diametral_inertia_kg_m2", "level",
    "full_dofs", "reduced_dofs", "free_frequencies_hz", "fixed_interface_frequencies_hz",
    "interfaces", "element_order", "modes_per_family", "free_frequency_error_estimate", "mesh",
    "assembled", "solved", "solver", "orthogonality_error", "hoop_strain_at_top_speed",
}  # fmt: skip
DIAGRAM = ESTIMATE | {
    "frame", "speed_rpm", "frequency_hz", "whirl", "kind", "shares", "log_decrement",
    "critically_damped", "interface_motion", "notes",
}  # fmt: skip
CRITICAL = ESTIMATE | {
    "speed_rpm", "frequency_hz", "whirl", "kind", "shares", "log_decrement",
    "amplification_factor", "critically_damped", "shafts", "exciters", "excited_by", "excited",
    "excited_why", "interface_motion",
}  # fmt: skip


@pytest.fixture(scope="session")
def folder(computed, tmp_path_factory):
    """The written results of the ferraris scene."""
    return write_results(computed("ferraris"), tmp_path_factory.mktemp("run") / "deep" / "out")


@pytest.fixture(scope="session")
def document(folder):
    return results_in(folder)


# -- names ----------------------------------------------------------------------------------------


def test_files(folder):
    found = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert found == FILES
    assert not [p for p in folder.rglob("*") if p.name.startswith(".")]


def test_top_level(document, scene_data):
    assert set(document) == TOP | {"references"}  # which this scene has
    assert document["schema"] == "solidwhirl-results-1"
    data = scene_data("ferraris")
    assert set(document["scene"]) == {"name", "title", "notes", "sha256"}
    assert document["scene"]["name"] == "ferraris"
    assert document["scene"]["title"] == data["title"]
    assert document["scene"]["notes"] == data["notes"]
    assert document["scene"]["sha256"] == scene_hash(parse_scene(data))
    assert document["packages"].keys() >= {"python", "solidwhirl", "numpy", "gmsh"}
    assert document["timings_s"].keys() >= {"meshing", "reduction", "assembly", "campbell"}
    assert all(0.0 <= spent < 600.0 for spent in document["timings_s"].values())
    assert 0.05 < document["peak_memory_gib"] < 8.0


def test_plan(document):
    plan = document["plan"]
    assert set(plan) == {"effects", "bodies", "analyses", "speeds_beyond"}
    for effect in plan["effects"]:
        assert set(effect) == {"name", "on", "why", "cost"}
        assert isinstance(effect["on"], bool)
    assert {e["name"] for e in plan["effects"] if e["on"]} == {
        *("gyroscopic", "stress_stiffening", "spin_softening"),
        *("error_estimate", "checks", "coupling_comparison"),
    }
    for body in plan["bodies"].values():
        assert body["circumferential_orders"] == [1]
        assert body["maximum_speed_rpm"] == pytest.approx(20000.0, rel=1e-12)


@pytest.mark.parametrize("name", ["inner", "outer"])
def test_bodies(document, name):
    assert set(document["bodies"]) == {"inner", "outer"}
    body = document["bodies"][name]
    assert set(body) == BODY
    assert len(body["center_of_gravity_m"]) == 3
    assert body["center_of_gravity_m"][:2] == [0.0, 0.0]
    assert body["level"] == "harmonic"
    assert isinstance(body["full_dofs"], int)
    assert isinstance(body["reduced_dofs"], int)
    assert body["full_dofs"] > 10 * body["reduced_dofs"]
    assert len(body["free_frequencies_hz"]) == 10
    for key in ("free_frequencies_hz", "fixed_interface_frequencies_hz"):
        values = np.array(body[key])
        assert np.all(values > 0.0)
        assert np.all(np.diff(values) >= -1e-9 * values[1:])
        # cos and sin families are the same problem
        np.testing.assert_allclose(values[0::2], values[1::2], rtol=1e-9)
    assert body["orthogonality_error"] < 1e-10


def test_campbell(document):
    diagram = document["campbell"]
    assert set(diagram) == DIAGRAM
    assert diagram["frame"] == "inertial"
    np.testing.assert_allclose(diagram["speed_rpm"], np.linspace(0, 20000, 21), rtol=1e-12)
    for key in ("frequency_hz", "whirl", "log_decrement"):
        assert [len(branch) for branch in diagram[key]] == [21] * 6, key
    senses = {sense for branch in diagram["whirl"] for sense in branch}
    assert senses <= {"forward", "backward", "mixed", "straight"}
    assert {"forward", "backward"} <= senses
    # the first column is the spectrum at rest, computed apart from it
    first = [branch[0] for branch in diagram["frequency_hz"]]
    np.testing.assert_allclose(first, document["modes_at_rest"]["frequency_hz"][:6], rtol=1e-9)


def test_estimates_stand_beside_the_frequencies(document):
    """Same shape as the frequencies; the total is the sum of the parts but the coupling."""
    for table in (document["campbell"], document["modes_at_rest"], *document["critical_speeds"]):
        parts, total = table["error_parts"], np.array(table["frequency_error_estimate"])
        assert set(parts) <= PARTS
        assert total.shape == np.shape(table["frequency_hz"])
        summed = sum(np.array(v) for part, v in parts.items() if part != "interface_coupling")
        np.testing.assert_allclose(summed, total, rtol=1e-12)
    assert set(document["campbell"]["error_parts"]) == PARTS
    assert set(document["modes_at_rest"]) == {"frequency_hz", "branch", "kind", "shares", *ESTIMATE}
    values = document["modes_at_rest"]["frequency_hz"]
    assert values == sorted(values)
    # 2 x 4 x reduced coordinates at most, fewer by the rigid joints
    assert 20 < len(values) <= sum(b["reduced_dofs"] for b in document["bodies"].values())


def test_accuracy_is_met_and_said(document):
    found = document["accuracy"]
    assert found["asked"] == 5e-3
    assert found["met"] is True
    largest = np.max(document["campbell"]["frequency_error_estimate"])
    speeds = [c["frequency_error_estimate"] for c in document["critical_speeds"]]
    assert found["largest_error_estimate"] == pytest.approx(max(largest, *speeds), rel=1e-12)
    assert found["bodies_without_estimate"] == []
    last = found["rounds"][-1]
    assert last["refined"] == []
    assert last["largest_error_estimate"] <= 5e-3
    assert last["unknowns"] == {n: b["full_dofs"] for n, b in document["bodies"].items()}


def test_critical_speeds(document):
    speeds = [c["speed_rpm"] for c in document["critical_speeds"]]
    assert speeds == sorted(speeds)
    for entry in document["critical_speeds"]:
        assert set(entry) == CRITICAL
        # both shafts turn at the reference speed: synchronous means f = rpm / 60
        assert entry["frequency_hz"] == pytest.approx(entry["speed_rpm"] / 60.0, rel=1e-12)
        assert 0.0 < entry["speed_rpm"] <= 20000.0
        assert entry["whirl"] in ("forward", "backward", "mixed", "straight")


# -- the other files ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["inner", "outer"])
def test_superelement_file(folder, document, name):
    element = read_superelement(folder / "bodies" / f"{name}.h5")
    checks = check_superelement(element)
    assert len(checks) >= 10
    assert [c for c in checks if not c.passed] == []
    body = document["bodies"][name]
    assert len(element.coordinates) == body["reduced_dofs"]
    assert element.mass_kg == pytest.approx(body["mass_kg"], rel=1e-9)
    assert element.provenance["scene_sha256"] == document["scene"]["sha256"]
    assert element.provenance["scene"] == "ferraris"


def test_results_follow_from_the_files(folder, document):
    """The superelements as read, put on the scene's bearings by hand, give the same spectrum."""
    rotors = {
        name: Rotor(element=read_superelement(folder / "bodies" / f"{name}.h5"), speed_ratio=ratio)
        for name, ratio in (("inner", 1.0), ("outer", -1.0))
    }
    stiff, soft = 1e10 * np.eye(2), np.diag([8e6, 0.0])
    ends = {"A": "inner.A", "B": "inner.B", "C": "inner.C", "kxx": "inner.C", "D": "outer.D"}
    bearings = [
        Bearing(
            name=name,
            first=End(body=end[:5], interface=end[6:]),
            second=End(body="outer", interface="C") if name == "C" else None,
            stiffness_n_per_m=soft if name == "kxx" else stiff,
        )
        for name, end in ends.items()
    ]
    modes = modes_at_speed(assemble(rotors, bearings), 20000.0 * np.pi / 30.0, 6)
    last = sorted(branch[-1] for branch in document["campbell"]["frequency_hz"])
    np.testing.assert_allclose(modes.frequency_hz[:4], last[:4], rtol=1e-9)


@pytest.mark.parametrize("kind", ["vtu", "msh"])
def test_meshes(folder, document, kind):
    for name, volume in (
        ("inner", np.pi * (0.02**2 * 0.4 + (0.15**2 - 0.02**2) * 0.03)),
        ("outer", np.pi * ((0.035**2 - 0.03**2) * 0.4 / 3 + (0.1**2 - 0.035**2) * 0.03)),
    ):
        mesh = meshio.read(folder / "meshes" / f"{name}.{kind}")
        cells = np.vstack([block.data for block in mesh.cells if block.type == "triangle6"])
        assert len(mesh.points) == document["bodies"][name]["mesh"]["points"]
        assert len(cells) == document["bodies"][name]["mesh"]["cells"]
        # straight-sided triangles turned about the axis: 2 pi times radius times area (Pappus)
        r, z = mesh.points[:, 0][cells[:, :3]], mesh.points[:, 2][cells[:, :3]]
        area = 0.5 * np.abs(
            (r[:, 1] - r[:, 0]) * (z[:, 2] - z[:, 0]) - (r[:, 2] - r[:, 0]) * (z[:, 1] - z[:, 0])
        )
        assert 2 * np.pi * area @ r.mean(axis=1) == pytest.approx(volume, rel=1e-9)


def test_report(folder, document):
    text = (folder / "report.md").read_text(encoding="utf-8")
    assert text.startswith(f"# {document['scene']['title']}\n")
    for note in document["scene"]["notes"]:
        assert note in text
    for effect in document["plan"]["effects"]:
        assert effect["name"] in text
        assert effect["why"] in text
    for found in document["critical_speeds"]:
        assert f"{found['speed_rpm']:.1f}" in text
    assert "nan" not in text.split("## Cost")[0].split("## Bodies")[1]
