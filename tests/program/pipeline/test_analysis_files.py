"""Analyses of scenes: results.json, pictures, files and their names."""

from __future__ import annotations

import copy
import math
import tomllib

import pytest
from engine_of_all_kinds import ENGINE
from engine_of_all_kinds import KINDS as ASKED
from everything import SCENE, everything
from results_read import numbers, results_in

from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import check_superelement, read_superelement
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver


def run(data, *analyses):
    return run_scene(parse_scene({**copy.deepcopy(data), "analyses": list(analyses)}))


KINDS = [a["kind"] for a in tomllib.loads(SCENE.read_text(encoding="utf-8"))["analyses"]]
# suffixes of the files of each analysis after its name
FILES = {
    "unbalance_response": [".png", "_bearing_forces.png", "_orbits.png"],
    "mode_shapes": [f"_{n}rpm{t}.png" for n in (0, 9000) for t in ("", "_participation", "_lp")],
    "run_up": [".npz", ".png"]
    + [f"_{t}.png" for t in ("spectrogram", "waterfall", "response", "complexity")],
    "state_space": [".h5", ".npz", ".mat"],
    "bearing_laws": ["_rear.png"],
    "static": ["_0rpm.png", "_6000rpm.png"],
    "api617": [".png", "_stability.png"],
    "impact_test": [".png", "_modes.png", ".unv"],
}
# lengths of what keys hold; none where that is a number, or of any length
SHAPES = tomllib.loads("""
impact_test = { hammer = [1], sensor = [2], frequency_hz = [40], real_m_per_s2_n = [1, 2, 40] }
unbalance_response = { unbalances = [2], exciters = [2] }
place_map = { frequency_hz = [3], amplitude_m = [3], peaks = [3] }
waterfall = { speed_rpm = [4], frequency_hz = [25], amplitude_m = [4, 25], highest_m = [4, 25], \
    peaks = [] }
critical_speed_map = { stiffness_n_per_m = [5], free_rpm = [], rigid_rpm = [], whirl = [] }
stiffness_study = { stiffness_n_per_m = [3], frequency_hz = [33], amplitude_m = [3, 33], \
    highest_m = [3, 33] }
rotating_campbell = { speed_rpm = [10], bodies = [2] }
mode_shapes = { speeds = [2] }
api617 = { journals = [2], assumptions = [], overhung_kg = [2] }
separation_margins = { operating = [2], margins = [] }
bearing_laws = { bearings = [1], notes = [] }
run_up = { largest_mount_force_n = [], force_spectrum_peaks = [], energy = [5] }
nonlinear_response = { unbalances = [1], nonlinear = [1], branches = [1] }
static = { speeds = [2], forces = [1], gears = [], notes = [] }
state_space = { inputs = [6], outputs = [36], speed_rpm = [], files = [3] }
stability = { speed_rpm = [5], smallest_log_decrement = [5], growing_motions = [5], threshold = [] }
""")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_results(everything().results, tmp_path_factory.mktemp("engine") / "out")


@pytest.fixture(scope="module")
def document(folder):
    return results_in(folder)


UNITS = (
    *("_m", "_m_per_s", "_hz", "_rpm", "_n", "_deg", "_kg_m", "_s", "_per_s", "_j", "_kg"),
    *("_n_per_m", "_kg_per_m3", "_mm_per_s", "_m_per_s2", "_rad", "_n_per_m3"),
)
PURE = """
    amplification amplification_factor frequency_ratio speed_ratio orders share mirrored margin
    share_of_kinetic_energy kinetic_energy strain_energy_of_bodies strain_energy_of_joints
    interface_deflection required required_api_617 branch checks
    log_decrement smallest_log_decrement growing_motions
    largest_relative_residual relative_residual states steps steps_per_frozen_speed_at_most
    force_per_force
    frequency_error_estimate amplitude_error_estimate sampling_error_estimate error_parts
    count relative_difference computed mac damping_ratio
    to_spare value limit margin required_margin error_estimate height_error_estimate
    speed_error_estimate scale_factor times_expected critical_speed_ratio applied_at
    log_decrement_at_expected worst_to_spare
    harmonics period_multiple largest_multiplier truncation_error_estimate
    coordinates peak_force_error response_error_by_band choice_is_at_the_end_of_the_range
    lateral torsional axial disk largest_error_estimate
"""


@pytest.mark.parametrize("kind", KINDS)
def test_document(document, kind):
    """Lengths as asked, numbers finite, their units in the keys."""
    entry = document["analyses"][kind]
    assert entry["kind"] == kind
    assert numbers(entry)
    for number, keys in numbers(entry):
        assert math.isfinite(number)
        assert any(key.endswith(UNITS) or key in PURE.split() for key in keys), keys
    for key, shape in SHAPES[kind].items():
        value = entry[key]
        for length in shape:
            assert len(value) == length, key
            value = value[0] if isinstance(value, list) else None
    assert document["plan"]["analyses"] == [{"name": k, "kind": k} for k in KINDS]


@pytest.mark.parametrize("kind", KINDS)
def test_files(folder, kind):
    starts = {
        ".png": b"\x89PNG\r\n\x1a\n",
        ".npz": b"PK",
        ".h5": b"\x89HDF",
        ".mat": b"MATLAB 5.0",
        ".unv": b"    -1",
    }
    found = {p.name for p in folder.iterdir() if p.name.startswith(kind)}
    assert found == {kind + suffix for suffix in FILES.get(kind, [".png"])}
    report = (folder / "report.md").read_text(encoding="utf-8")
    for name in found:
        path = folder / name
        assert path.read_bytes().startswith(starts[path.suffix])
        assert path.stat().st_size > 1000
        assert name in report


def test_simple_bodies_have_files_too(folder):
    for name in ("lp", "fan", "casing"):
        element = read_superelement(folder / "bodies" / f"{name}.h5")
        assert [c for c in check_superelement(element) if not c.passed] == []


def many_of_everything():
    """More places, speeds and bearings than one picture has room for."""
    data = copy.deepcopy(ENGINE)
    places = [f"lp.{n}" for n in "amb"] + ["hp.a", "hp.b"] + [f"casing.{n}" for n in "abc"]
    more = [{**data["bearings"][1], "name": f"more_{k}"} for k in range(3)]
    data["bearings"] += more
    asked = {"kind": "unbalance_response", **ASKED["unbalance_response"], "observe": places}
    asked |= {"unbalances": [{"at": p, "moment_kg_m": 1e-5} for p in ("lp.m", "hp.a")]}
    asked["orbits_at_rpm"] = [500.0 * (k + 1) for k in range(9)]
    return data, asked


def laws(scene):
    return {b.name: bool(b.speed_law) for b in scene.bearings}


@pytest.mark.verify
def test_what_has_no_room_in_a_picture_is_in_the_next(tmp_path):
    """Eight places, nine speeds and eight bearings: 2 pictures, 2 x 2 and 2."""
    data, asked = many_of_everything()
    shapes = {"kind": "mode_shapes", "speeds_rpm": [6e3], "modes": 20, "bodies": ["lp"]}
    files = run(data, asked, shapes).analyses
    suffixes = ["", "_2", "_bearing_forces", "_bearing_forces_2"]
    suffixes += ["_orbits", "_orbits_2", "_orbits_3", "_orbits_4"]
    written = set(files["unbalance_response"].files)
    assert written == {f"unbalance_response{s}.png" for s in suffixes}
    scene = parse_scene({**data, "analyses": [asked]})
    assert written <= set(scene.analyses[0].possible_files(laws(scene)))
    assert len(files["mode_shapes"].document["speeds"][0]["frequency_hz"]) > 12
    further = {n: w for e in files.values() for n, w in e.files.items() if n.endswith("_2.png")}
    assert len(further) >= 3
    for name, write in further.items():
        write(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000


def test_names_of_files_are_known_beforehand(folder):
    """What is written is among what is checked for equal names."""
    scene = everything().results.scene
    for spec in scene.analyses:
        found = {p.name for p in folder.iterdir() if p.name.startswith(spec.label)}
        assert found <= set(spec.possible_files(laws(scene)))


def test_beams_and_rigid_bodies_are_in_the_results(document, folder):
    """A hollow shaft with a fan by hand; the casing as the scene has it."""
    bodies = document["bodies"]
    assert list(bodies) == ["lp", "fan", "casing"]
    assert bodies["casing"]["mass_kg"] == 400.0
    assert bodies["casing"]["polar_inertia_kg_m2"] == 30.0
    assert bodies["casing"]["inertia_kg_m2"][0] == [40.0, 0.0, 0.0]
    fan = bodies["fan"]
    shaft_kg = fan["mass_kg"] - 60.0
    polar = shaft_kg * (0.05**2 + 0.02**2) / 2 + 6.0
    assert fan["polar_inertia_kg_m2"] == pytest.approx(polar, rel=1e-9)
    center = (0.5 * 60.0 + 0.3 * shaft_kg) / fan["mass_kg"]
    assert fan["center_of_gravity_m"] == pytest.approx([0.0, 0.0, -center])
    effects = {e["name"]: e for e in document["plan"]["effects"]}
    for name in ("stress_stiffening", "spin_softening"):
        assert not effects[name]["on"]
        assert "no solid body" in effects[name]["why"]
    assert "| casing |" in (folder / "report.md").read_text(encoding="utf-8")


def test_nothing_is_overwritten():
    """An analysis named as a stage has its own time; speeds that round alike have own pictures."""
    stage = {"kind": "stability", **ASKED["stability"], "name": "assembly"}
    shapes = {"kind": "mode_shapes", "speeds_rpm": [99.8, 100.2], "modes": 2}
    results = run(ENGINE, stage, shapes)
    assert {"assembly", "analysis assembly", "analysis mode_shapes"} <= set(results.timings_s)
    files = [name for entry in results.analyses.values() for name in entry.files]
    assert len({*files, "campbell.png"}) == 1 + len(files) == 1 + 1 + 4
