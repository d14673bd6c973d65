"""Recovery of displacement and stress in a scene: states, files, results, refusals."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from engine_parts import RIGID
from results_read import results_in

from solidwhirl.analyses.recovery.records import RecoveryStateSpec
from solidwhirl.analyses.recovery.states import engine_states
from solidwhirl.core.blocks import CutBodies
from solidwhirl.core.errors import SceneError
from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.cached_stages import open_store
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.scene_checks.speeds_asked import top_speed
from solidwhirl.scene_reading.reader import parse_scene

RPM = np.pi / 30.0
UNBALANCES = [{"at": "rotor.disk", "moment_kg_m": 1e-4, "phase_deg": 20.0}]
SWEEP = {
    "name": "sweep",
    "kind": "unbalance_response",
    "to_rpm": 20000,
    "count": 41,
    "unbalances": UNBALANCES,
    "observe": ["rotor.disk"],
}
START = {
    "name": "start",
    "kind": "run_up",
    "to_rpm": 12000,
    "ramp_s": 0.5,
    "sampling_hz": 4000,
    "record_hz": 2000,
    "unbalances": UNBALANCES,
    "observe": ["rotor.disk"],
    "mount": "left",
}
STATES = [
    {"mode": 1, "speed_rpm": 9000, "amplitude_m": 2e-4, "phases": 3},
    {"mode": 2, "speed_rpm": 9000},
    {"response": "sweep", "speed_rpm": 9000},
    {"response": "sweep", "peak": "rotor.disk"},
    {"run_up": "start", "peak": "rotor.disk", "between_rpm": [3000, 12000]},
    {"name": "series", "run_up": "start", "time_s": [0.1, 0.5]},
    {"speed_rpm": 9000},
]
RECOVERY = {"name": "stress", "kind": "recovery", "bodies": ["rotor"], "sectors": 16}


@pytest.fixture
def asked(small_scene):
    """Function: the small scene with a disk interface, dampers, and analyses."""

    def build(*analyses, **tables):
        data = small_scene(bearing={"damping_n_s_per_m": 2e3}, **tables)
        data["bearings"][1]["damping_n_s_per_m"] = 2e3
        data["bodies"]["rotor"]["interfaces"].append(
            {"name": "disk", "kind": "outer", "start_m": 0.1, "end_m": 0.14}
        )
        return {**data, "analyses": list(analyses)}

    return build


@pytest.fixture(scope="module")
def folder(small_scene, tmp_path_factory):
    """A run with a store, from the command line's functions."""
    data = asked.__wrapped__(small_scene)(SWEEP, START, {**RECOVERY, "states": STATES})
    out = tmp_path_factory.mktemp("recovery")
    runs = []
    for name in ("first", "again"):
        said = []
        store = open_store(out / "stages")
        results = run_scene(parse_scene(data), progress=said.append, store=store)
        said = [str(event) for event in said]
        write_results(results, out / name, pictures=False)
        runs.append((results, said))
    return out, runs


@pytest.fixture(scope="module")
def document(folder):
    return results_in(folder[0] / "first")


@pytest.mark.solver
def test_states_files_and_results(folder, document):
    out = folder[0] / "first"
    states = {s["state"]: s for s in document["analyses"]["stress"]["states"]}
    assert list(states) == [
        *("mode1_9000rpm", "mode2_9000rpm", "sweep_9000rpm", "sweep_peak", "start_peak"),
        *("series_0.1s", "series_0.5s", "spin_9000rpm"),
    ]
    names = {p.name for p in (out / "recovery").iterdir()}
    frames = {f"stress_rotor_mode1_9000rpm_{k:03d}.vtu" for k in range(3)}
    series = {"stress_rotor_mode1_9000rpm.pvd", "stress_rotor_series.pvd"}
    assert names == {f"stress_rotor_{s}.vtu" for s in states} | frames | series
    text = (out / "recovery" / "stress_rotor_series.pvd").read_text(encoding="utf-8")
    assert 'timestep="0.1" group="" part="0" file="stress_rotor_series_0.1s.vtu"' in text
    listed = (out / "SHA256SUMS").read_text(encoding="utf-8")
    assert all(f"recovery/{name}" in listed for name in names)
    states.pop("spin_9000rpm")
    for name, state in states.items():
        body = state["bodies"]["rotor"]
        mesh = meshio.read(out / "recovery" / f"stress_rotor_{name}.vtu")
        fields = mesh.point_data
        scaled = state["scaled_to_m"]
        assert (scaled is not None) == name.startswith("mode")
        if name.startswith("mode"):
            assert body["largest_displacement_m"] == pytest.approx(scaled, rel=1e-12)
        # the field's largest values are those of the results, which look between the sectors too
        steady, dynamic = fields["von_mises_steady"], fields["von_mises_dynamic"]
        assert steady.max() == pytest.approx(body["steady"]["largest_von_mises_pa"], rel=1e-6)
        assert dynamic.max() <= body["dynamic"]["largest_von_mises_pa"] * (1.0 + 1e-6)
        assert dynamic.max() >= body["dynamic"]["largest_von_mises_pa"] * np.cos(np.pi / 16)
        total = body["total"]
        assert (total is None) == (name == "mode2_9000rpm")  # nobody gave its amplitude
        if total is not None:
            summed = steady + dynamic
            field = fields["von_mises_total"]
            assert (field <= summed * (1.0 + 1e-5)).all()
            assert (field >= np.abs(steady - dynamic) * (1.0 - 1e-5) - 1.0).all()
            # and the tensors of the file give the same
            now = fields["stress"] if "stress" in fields else fields["stress_0deg"]
            both = von_mises(now + fields["stress_steady"])
            assert (both <= field * (1.0 + 1e-4) + 1.0).all()


@pytest.mark.solver
def test_steady_spin_is_the_centrifugal_part_of_any_state(folder, document):
    states = {s["state"]: s["bodies"]["rotor"] for s in document["analyses"]["stress"]["states"]}
    spin, mode = states["spin_9000rpm"], states["mode1_9000rpm"]
    assert spin["steady"] == mode["steady"]
    assert spin["dynamic"] is None and spin["total"] is None and spin["strain_energy_j"] is None
    one, other = (
        meshio.read(folder[0] / "first" / "recovery" / f"stress_rotor_{name}.vtu").point_data
        for name in ("spin_9000rpm", "mode1_9000rpm")
    )
    assert "displacement" not in one and "von_mises_total" not in one
    np.testing.assert_array_equal(one["displacement_steady"], other["displacement_steady"])
    np.testing.assert_array_equal(one["stress_steady"], other["stress_steady"])
    moved = np.linalg.norm(one["displacement_steady"], axis=1).max()
    assert spin["largest_displacement_m"] == pytest.approx(moved, rel=1e-6)  # single precision


@pytest.mark.solver
def test_page_shows_halves_of_the_bodies(folder):
    """What is drawn has the numbers of the results, and half of the body."""
    outcome = folder[1][0][0].analyses["stress"]
    (cut,) = [b for b in outcome.blocks() if isinstance(b, CutBodies)]
    assert [b.label for b in cut.bodies] == [
        *("mode1_9000rpm, rotor", "mode2_9000rpm, rotor", "sweep_9000rpm, rotor"),
        *("sweep_peak, rotor", "start_peak, rotor", "series_0.1s, rotor"),
    ]
    first = outcome.document["states"][0]["bodies"]["rotor"]["total"]
    assert 1e6 * cut.bodies[0].largest == pytest.approx(first["largest_von_mises_pa"], rel=0.02)
    for body in cut.bodies:
        assert body.points_m[:, 0].min() > -1e-9 and body.points_m[:, 0].max() > 0.01
        assert body.values.min() >= 0.0 and body.values.max() <= body.largest
        assert set(np.unique(body.triangles)) == set(range(len(body.points_m)))


def von_mises(s):
    x, y, z, xy, yz, xz = s.astype(float).T
    shear = 6.0 * (xy**2 + yz**2 + xz**2)
    return np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2 + shear))


@pytest.mark.solver
def test_energy_checks_are_among_the_invariants(document):
    found = [c for c in document["invariants"] if "recovered field" in c["name"]]
    assert len(found) == 7
    assert all(c["passed"] for c in found)
    # measured 4e-13: bearings are no softer than the shaft
    assert max(c["value"] for c in found) < 1e-10
    assert {e["name"]: e["on"] for e in document["plan"]["effects"]}["recovery"]


@pytest.mark.solver
def test_a_kept_recovery_is_not_computed_again(folder):
    out, ((_, said), (results, later)) = folder
    assert any("again, for its fields" in text for text in said)
    assert not any("again, for its fields" in text for text in later)
    assert results.stages["analysis stress"] == "kept"
    for path in (out / "first" / "recovery").iterdir():
        assert path.read_bytes() == (out / "again" / "recovery" / path.name).read_bytes()


@pytest.mark.solver
def test_motion_is_that_of_the_analyses(folder):
    """The coordinates of a state move the interfaces as the analysis it comes from says."""
    results = folder[1][0][0]
    system, scene = results.system, results.scene
    rows = np.array([interface_row(system, "rotor", "disk", c) for c in ("ux", "uy")])
    named = {a.label: a for a in scene.analyses}
    (found,) = engine_states(RecoveryStateSpec(**STATES[2]), named, system)
    (exciter,) = results.analyses["sweep"].document["exciters"]
    at = results.analyses["sweep"].document["speed_rpm"].index(9000.0)
    place = exciter["places"]["rotor.disk"]
    phases = [np.exp(1j * np.radians(place[f"phase_{c}_deg"][at])) for c in "xy"]
    known = [place[f"amplitude_{c}_m"][at] * p for c, p in zip("xy", phases, strict=True)]
    assert rows @ found.motion == pytest.approx(np.array(known), rel=1e-9)
    # the peak is higher than its neighbours, and than the samples
    (peak,) = engine_states(RecoveryStateSpec(**STATES[3]), named, system)
    assert abs(rows[0] @ peak.motion) >= max(place["amplitude_x_m"]) * (1.0 - 1e-9)
    # one run in two pieces ends where one in one piece does
    ends = [
        list(engine_states(RecoveryStateSpec(run_up="start", time_s=t), named, system))[-1]
        for t in ((0.2, 0.3, 0.5), 0.5)
    ]
    first, second = (rows @ end.motion for end in ends)
    # (pieces share frozen speeds differently: second order in their length)
    assert first == pytest.approx(second, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bodies": ["rotr"]}, "did you mean 'rotor'"),
        ({"bodies": ["stub"]}, "'stub' is no solid"),
        ({"bodies": ["rotor", "rotor"]}, "bodies names something twice"),
        ({"states": [{}]}, "one of mode, response, run_up, or speed_rpm alone; found none"),
        ({"states": [{"speed_rpm": 9.0, "phases": 3}]}, "steady spin has none"),
        (
            {"states": [{"speed_rpm": 9.0, "time_s": 1.0}]},
            "spin needs speed_rpm; found speed_rpm, t",
        ),
        ({"states": [{"mode": 1}]}, "mode needs speed_rpm; found neither"),
        ({"states": [{"mode": 1, "run_up": "start"}]}, "found mode, run_up"),
        ({"states": [{"mode": 1, "time_s": 1.0}]}, "mode needs speed_rpm; found time_s"),
        ({"states": [{"response": "sweep"}]}, "needs speed_rpm or peak"),
        ({"states": [{"response": "start", "speed_rpm": 1.0}]}, "no analysis of kind unbalance"),
        ({"states": [{"run_up": "sweep", "time_s": 1.0}]}, "no analysis of kind run_up"),
        ({"states": [{"run_up": "start", "time_s": 0.7}]}, "0.7 is after the end"),
        ({"states": [{"run_up": "start", "time_s": [0.2, 0.1]}]}, "time_s must be rising"),
        ({"states": [{"run_up": "start", "time_s": 0.1, "phases": 3}]}, "phases belongs to"),
        ({"states": [{"response": "sweep", "peak": "rotor.rim"}]}, "no interface 'rotor.rim'"),
        (
            {"states": [{"response": "sweep", "speed_rpm": 9.0, "amplitude_m": 1.0}]},
            "amplitude_m belongs to a mode",
        ),
        (
            {"states": [{"response": "sweep", "speed_rpm": 9.0, "between_rpm": [1, 2]}]},
            "between_rpm belongs to peak",
        ),
        ({"states": [STATES[0], STATES[0]]}, "more than one state is named"),
        ({"sectors": 4}, "greater than or equal to 8"),
        ({"quantities": ["strain"]}, "'displacement' or 'stress'"),
    ],
)
def test_what_can_not_be_recovered_is_refused(asked, change, words):
    data = asked(SWEEP, START, {**RECOVERY, "states": STATES, **change})
    data["rigid_bodies"] = {"stub": RIGID}
    with pytest.raises(SceneError, match=words.replace("(", r"\(")):
        parse_scene(data)


def test_stress_needs_a_solid_and_a_basis_for_its_speed(asked):
    data = asked({**RECOVERY, "states": [{"mode": 1, "speed_rpm": 36000}]})
    assert top_speed(parse_scene(data)) == pytest.approx(36000 * RPM)
    data["model"]["level"] = "beam"
    with pytest.raises(SceneError, match=r"there is no solid to recover"):
        parse_scene(data)


def test_steady_spin_needs_the_stress_of_the_spin(asked):
    data = asked({**RECOVERY, "states": [{"speed_rpm": 9000}]})
    data["effects"] = {"stress_stiffening": "off", "spin_softening": "off"}
    with pytest.raises(SceneError, match=r"states\[0\].speed_rpm: steady spin has no stress"):
        parse_scene(data)


def test_files_of_two_recoveries_do_not_meet(asked):
    states = [{"name": "b_c", "mode": 1, "speed_rpm": 0.0}]
    other = [{"name": "c", "mode": 1, "speed_rpm": 0.0}]
    one = {**RECOVERY, "name": "a", "states": states}
    data = asked(one, {**RECOVERY, "name": "a_rotor_b", "bodies": ["rotor"], "states": other})
    parse_scene(data)
    data["analyses"][1]["states"] = [{"name": "x", "mode": 1, "speed_rpm": 0.0}]
    data["analyses"][1]["name"] = "a"
    with pytest.raises(SceneError):
        parse_scene(data)
