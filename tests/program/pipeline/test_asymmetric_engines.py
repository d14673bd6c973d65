"""Scenes with an asymmetric body: what runs say, and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

from solidwhirl.cache.files import StageStore
from solidwhirl.core.errors import USER_ERRORS
from solidwhirl.datasets.results import datasets
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.rotordyn.superelement.free_body import rigid_centrifugal_energy
from solidwhirl.scene_reading.reader import parse_scene

sys.path.insert(0, str(Path(__file__).parents[2] / "meshing"))

from mesh_makers import brick

pytestmark = pytest.mark.solver

SIZE = (0.03, 0.02, 0.4)
ENDS = ("left", "right")
PLAIN = {"estimates": "off", "modes": 2}
RESPONSE = {
    "kind": "asymmetric_response",
    "from_rpm": 500.0,
    "to_rpm": 6000.0,
    "count": 12,
    "unbalances": [{"at": "bar.left", "moment_kg_m": 1e-4}],
    "gravity_m_per_s2": [0.0, -9.81, 0.0],
    "observe": ["bar.left"],
}
STABILITY = {"kind": "stability", "to_rpm": 24000.0, "count": 9}


def write_bar(path, copies=1):
    """A flat bar of coarse hexahedra, once or several times with gaps."""
    points, cells = brick(SIZE, (2, 2, 6), (-0.5 * SIZE[0], -0.5 * SIZE[1], 0.0))
    sets = {
        "left": np.flatnonzero(points[:, 2] < 1e-9),
        "right": np.flatnonzero(points[:, 2] > SIZE[2] - 1e-9),
        "mid": np.flatnonzero(np.abs(points[:, 2] - 0.5 * SIZE[2]) < SIZE[2] / 6 + 1e-9),
    }
    every = np.vstack([points + np.array([0.0, 0.0, 0.6 * k]) for k in range(copies)])
    blocks = np.vstack([cells + len(points) * k for k in range(copies)])
    meshio.Mesh(every, [("hexahedron", blocks)], point_sets=sets).write(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("bar")
    write_bar(out / "bar.inp")
    write_bar(out / "two.inp", 2)
    return out


def bar(**changes):
    interfaces = [{"name": n, "group": n, "coupling": "rigid"} for n in ENDS]
    given = {"file": "bar.inp", "length_unit": "m", "material": "steel", "modes": 2}
    return given | {"interfaces": interfaces} | changes


def scene(folder, *, drag=100.0, body=None, **tables):
    bearings = [
        {"name": n, "first": f"bar.{n}", "stiffness_n_per_m": 1e7, "damping_n_s_per_m": drag}
        for n in ENDS
    ]
    bearings[0]["axial_stiffness_n_per_m"] = 1e7
    data = {
        "name": "bar",
        "speeds": {"to_rpm": 24000.0, "count": 3},
        "campbell": {"branches": 6},
        "mesh_bodies": {"bar": bar() if body is None else body},
        "bearings": bearings,
    }
    return parse_scene(data | tables, folder / "scene.toml")


def rpm_of(document, key):
    return [r["speed_rpm"] for r in document["asymmetry"][key] if r["motion"] == "lateral"]


@pytest.fixture(scope="module")
def undamped(folder):
    # the second ends within the unstable range
    asked = [STABILITY, STABILITY | {"name": "parted", "to_rpm": 17000.0}]
    results = run_scene(scene(folder, drag=0.0, analyses=asked))
    assert [c for c in results.checks if c.passed is False] == []
    return results


def test_what_a_run_says_of_an_undamped_bar(undamped):
    document = results_document(undamped)
    said = {a.about: a.text for a in answers(document)}
    first, second = rpm_of(document, "critical_speeds")
    assert all(c["amplification_factor"] is None for c in document["critical_speeds"])
    assert "undamped" in said["Critical speeds (AF: amplification factor)"]
    # half of the mean of both planes, less what the split adds in the square
    weight, second_pair = rpm_of(document, "gravity_critical_speeds")
    assert weight == pytest.approx(0.25 * (first + second), rel=0.05)
    assert said["Gravity critical speeds"] == f"{weight:.0f} rpm; {second_pair:.0f} rpm"
    assert said["Stability"].startswith(f"unstable {first:.0f} to {second:.0f} rpm (divergence)")
    resonances = document["asymmetry"]["critical_speeds"]
    resonances = resonances + document["asymmetry"]["gravity_critical_speeds"]
    largest = max(r["error_estimate"] for r in resonances if r["motion"] == "lateral")
    accuracy = document["accuracy"]
    # of the elastic pairs too, which no speed of the range meets
    branches = np.array(document["campbell"]["frequency_error_estimate"], dtype=float)
    assert accuracy["largest_error_estimate"] == max(largest, np.nanmax(branches))
    assert np.nanmax(branches) > largest
    assert accuracy["met"] is (accuracy["largest_error_estimate"] <= accuracy["asked"])
    at_rest = np.array(document["modes_at_rest"]["frequency_error_estimate"][:2], dtype=float)
    assert at_rest == pytest.approx(branches[:2, 0], rel=1e-6)
    tree = datasets(undamped)
    assert tree["critical_speeds"]["frequency_error_estimate"].size == 2


def test_stability_of_a_flat_bar(undamped):
    """Where it grows the lowest motion is that of one mass on a shaft with two stiffnesses.

    (λ² + ω1² − Ω²)(λ² + ω2² − Ω²) + 4 Ω² λ² = 0 in axes of the body; second modes and the tilt of
    the masses change growth by about 1 %.
    """
    (one,) = undamped.asymmetry.ranges
    low, high = one.low_rad_s, one.high_rad_s
    whole, parted = (outcome.document for outcome in undamped.analyses.values())
    (interval,) = whole["unstable_intervals"]
    assert interval["kind"] == whole["threshold"]["kind"] == "divergence"
    ends = np.array([interval["from_rpm"], interval["to_rpm"]]) * np.pi / 30.0
    np.testing.assert_allclose(ends, [low, high], rtol=1e-12)
    for document in (whole, parted):
        speeds = np.array(document["speed_rpm"]) * np.pi / 30.0
        inside = (low < speeds) & (speeds < high)
        assert document["growing_motions"] == inside.astype(int).tolist()
        growth = np.array(document["largest_growth_rate_per_s"])
        assert np.abs(growth[~inside]).max() < 1e-6
        half, product = 0.5 * (low**2 + high**2) + speeds**2, (low**2 - speeds**2)
        product *= high**2 - speeds**2
        wanted = np.sqrt((np.sqrt(half**2 - product) - half)[inside])
        np.testing.assert_allclose(growth[inside], wanted, rtol=0.02)
    (cut,) = parted["unstable_intervals"]
    assert (cut["to_rpm"], cut["closes"]) == (pytest.approx(17000.0), False)
    assert cut["largest_growth_rate_per_s"] == pytest.approx(
        parted["largest_growth_rate_per_s"][-1], rel=1e-6
    )
    # at rest a motion whirls neither way
    assert np.isnan(whole["first_forward"]["frequency_hz"][0])


def test_damping_of_a_flat_bar(folder):
    """Light dampers at both ends: decrements are those of energies, in proportion to them."""
    light, heavy = (
        run_scene(scene(folder, drag=drag, model=PLAIN, analyses=[STABILITY | {"to_rpm": 9000.0}]))
        .analyses["stability"]
        .document
        for drag in (5.0, 10.0)
    )
    least, twice = (np.array(d["smallest_log_decrement"]) for d in (light, heavy))
    np.testing.assert_allclose(twice, 2.0 * least, rtol=1e-2)
    assert (least > 0.0).all()
    assert light["unstable_intervals"] == []
    assert light["threshold"] is None
    assert light["growing_motions"] == [0] * 9


def test_unstable_ranges_are_searched_as_far_as_a_shaft_operates(folder, undamped):
    """Speeds of the diagram that end below them hide no growth at the operating speed."""
    first, second = rpm_of(results_document(undamped), "critical_speeds")
    inside = 0.5 * (first + second)
    operating = [{"shaft": "bar", "from_rpm": inside, "to_rpm": inside}]
    speeds = {"to_rpm": 0.5 * first, "count": 3}
    found = run_scene(scene(folder, drag=0.0, speeds=speeds, operating=operating))
    (at,) = found.stability.at_operating
    assert not at["stable"]
    (grows,) = found.stability.intervals
    assert grows.low_rad_s * 30.0 / np.pi == pytest.approx(first, rel=1e-3)
    assert found.stability.high_rpm == pytest.approx(inside)


def test_mass_off_the_axis_moves_no_critical_speed(folder, undamped):
    """A driven shaft: unbalance is a load, and not in the equations of its small motions."""
    body = bar(axis={"origin": [0.004, 0.003, 0.0], "direction": [0.0, 0.0, 1.0]})
    found = run_scene(scene(folder, drag=0.0, body=body))
    assert rigid_centrifugal_energy(found.elements["bar"]) < 1e-9
    off, even = (results_document(r) for r in (found, undamped))
    assert rpm_of(off, "critical_speeds") == pytest.approx(
        rpm_of(even, "critical_speeds"), rel=1e-3
    )
    # of an unbalanced body the weight shakes torsion too
    weight = [rpm_of(d, "gravity_critical_speeds")[0] for d in (off, even)]
    assert weight[0] == pytest.approx(weight[1], rel=1e-3)
    ends = [[r["from_rpm"] for r in d["asymmetry"]["unstable_ranges"]] for d in (off, even)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-3)
    offset = off["asymmetry"]["bodies"]["bar"]["center_of_gravity_offset_m"]
    assert offset == pytest.approx(0.005)


def test_a_second_run_takes_all_stages_of_the_first(folder, tmp_path):
    asked = scene(folder, analyses=[RESPONSE], model=PLAIN)
    first, second = (run_scene(asked, store=StageStore(tmp_path)) for _ in range(2))
    assert set(first.stages.values()) == {"computed"}
    assert set(second.stages.values()) == {"kept"}
    documents = [results_document(r) for r in (first, second)]
    assert documents[0]["asymmetry"] == documents[1]["asymmetry"]
    assert documents[0]["analyses"] == documents[1]["analyses"]
    # estimates that are off are not told
    assert documents[0]["accuracy"]["largest_error_estimate"] is None
    assert documents[0]["accuracy"]["met"] is None


def test_ground_motion_is_seen_at_other_frequencies_too(folder):
    """Most on the ridge of the whirl, or twice the speed from it; parts add up as of any phase."""
    ends = [
        {"name": n, "first": f"bar.{n}", "stiffness_n_per_m": k, "damping_n_s_per_m": 100.0}
        for n, k in (("left", 1e7), ("right", 8e6))
    ]
    ends[0]["axial_stiffness_n_per_m"] = 1e7
    shaken = {"kind": "waterfall", "to_rpm": 6000.0, "speed_count": 3, "frequency_max_hz": 700.0,
              "frequency_count": 70, "observe": "bar.left"}  # fmt: skip
    results = run_scene(scene(folder, bearings=ends, analyses=[shaken], model=PLAIN))
    found = results_document(results)["analyses"]["waterfall"]
    sides, whole = found["sidebands_m"], np.array(found["amplitude_m"])
    assert list(sides) == ["-2", "2"]
    parts = np.array(list(sides.values()))
    assert (np.linalg.norm(parts, axis=0) <= whole).all()
    assert (np.array(found["highest_m"]) >= whole).all()
    assert not parts[:, 0].any()  # at rest
    hertz, twice = np.array(found["frequency_hz"]), 2.0 * 6000.0 / 60.0
    ridge = hertz[whole[2].argmax()]
    for side, line in zip(parts[:, 2], (ridge + twice, ridge - twice), strict=True):
        highest = hertz[side.argmax()]
        assert min(abs(highest - ridge), abs(highest - line)) <= 2.0 * hertz[0]
    tree = datasets(results)["analyses/waterfall"]
    assert tree["sidebands_m"].sel(multiple=2).shape == whole.shape
    (chart, *_) = results.analyses["waterfall"].blocks()
    assert {"1/rev of the reference shaft", "2/rev of the asymmetric bodies"} <= {
        getattr(part, "name", "") for part in chart.parts
    }
    assert "by the asymmetry" in chart.caption


ROUND = {"kind": "unbalance_response", "unbalances": RESPONSE["unbalances"],
         "observe": ["bar.left"], "from_rpm": 500.0, "to_rpm": 6000.0, "count": 12}  # fmt: skip
AWAY = {"origin": [0.025, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}
BOW = {"at": "bar.left", "between": ["left", "right"], "bow_m": 1e-4}
RUN_UP = {"kind": "run_up", "to_rpm": 6000.0, "ramp_s": 1.0, "unbalances": RESPONSE["unbalances"],
          "mount": "left", "observe": ["bar.left"], "compare_flexible": [["bar"]],
          "bands_hz": [[10.0, 50.0]]}  # fmt: skip
REFUSED = {
    "two pieces": ({"body": bar(file="two.inp")}, "mesh_bodies.bar: .*2 parts that share no face"),
    "axis outside": (
        {"body": bar(axis=AWAY)},
        "mesh_bodies.bar: .*beside its axis: .*passes 0.01 m outside",
    ),
    "not round": (
        {"body": bar(symmetry="revolution")},
        "mesh_bodies.bar: interface 'left': its facets do not go evenly around the axis",
    ),
    "sectors": (
        {"body": bar(symmetry="none", sectors=4)},
        "mesh_bodies.bar: symmetry = 'none', but sectors says it",
    ),
    "static at speed": (
        {"analyses": [{"kind": "static", "speeds_rpm": [3000.0]}]},
        r"analyses\[0\].speeds_rpm: bar is asymmetric.*at speed \"asymmetric_response\" with",
    ),
    "kind": ({"analyses": [ROUND]}, r"analyses\[0\].kind: .*allowed are asymmetric_response, run"),
    "a comparison with rigid bodies": (
        {"analyses": [RUN_UP]},
        r"analyses\[0\].compare_flexible: .*bar is asymmetric; leave it out",
    ),
    "bow of what is not there": (
        {"analyses": [RESPONSE | {"bows": [BOW | {"between": ["left", "rear"]}]}]},
        r"analyses\[0\].bows\[0\].between\[1\]: no interface of 'bar' 'rear'",
    ),
    "bow at its own end": (
        {"analyses": [RESPONSE | {"bows": [BOW]}]},
        r"analyses\[0\].bows\[0\].between: .*the three must differ",
    ),
}


def test_sag_of_a_flat_bar_at_rest(folder):
    """The weight bends each plane by its own flexibility: a tensor over the angle of the bar."""
    asked = {
        "kind": "static",
        "angles_deg": [0.0, 90.0, 45.0, 180.0],
        "gravity_m_per_s2": [0, -1, 0],
    }
    body = bar()
    body["interfaces"] = [*body["interfaces"], {"name": "mid", "group": "mid"}]
    (entry,) = run_scene(scene(folder, body=body, analyses=[asked])).analyses.values()
    states = entry.document["speeds"]
    middle = np.array([s["bodies"]["bar"]["deflection_m"] for s in states])
    middle = middle[:, np.abs(np.array(states[0]["bodies"]["bar"]["axial_m"]) - 0.2).argmin()]
    flat, edge, between, turned = middle
    size = abs(flat[1])
    np.testing.assert_allclose(turned, flat, atol=1e-8 * size)
    # what the first two angles say of weight along the two sides of the bar holds for all
    flexible = np.array([[-edge[1], -flat[0]], [edge[0], -flat[1]]])
    turn = np.sqrt(0.5) * np.array([[1.0, -1.0], [1.0, 1.0]])
    wanted = turn @ flexible @ turn.T @ [0.0, -1.0]
    np.testing.assert_allclose(between, wanted, atol=1e-8 * size)
    # turned from x towards y, the broad side faces −x and y: the bar gives way along it
    assert between[0] > 0.0 > between[1]
    # second moments are as 9 to 4; springs and shear give way alike
    springs = -0.5 * states[0]["bodies"]["bar"]["weight_kg"] / 1e7
    assert (flat[1] - springs) / (edge[1] - springs) == pytest.approx(2.25, rel=0.02)
    for state in states:
        assert state["balance"]["relative_residual"] < 1e-8
        assert state["error_estimate"] is not None
        weight = state["bodies"]["bar"]["weight_kg"]
        assert state["bearings"]["left"]["load_n"] == pytest.approx(0.5 * weight, rel=1e-6)
    assert list(entry.files) == [f"static_{angle}deg.png" for angle in (0, 90, 45, 180)]
    (table,) = (b for b in entry.blocks() if getattr(b, "title", "") == "Sag")
    assert table.rows[2][1] == "at rest, 45°"


@pytest.mark.parametrize("case", REFUSED.values(), ids=REFUSED)
def test_what_is_refused_before_the_long_work(folder, case):
    changes, message = case
    with pytest.raises(USER_ERRORS, match=message):
        run_scene(scene(folder, **changes))


def test_an_interface_far_from_the_axis_is_refused(folder):
    """A facet on the rim of a plate would be tied to the axis through nothing."""
    points, cells = brick((0.3, 0.2, 0.05), (6, 4, 1), (-0.15, -0.1, 0.0))
    meshio.Mesh(points, [("hexahedron", cells)]).write(folder / "plate.inp")
    facet = [{"name": "left", "box_m": [[0.149, -0.001, -0.001], [0.151, 0.051, 0.051]]}]
    with pytest.raises(USER_ERRORS, match=r"interface 'left': its surface lies .* off the axis"):
        run_scene(scene(folder, body=bar(file="plate.inp", interfaces=facet), bearings=[]))
