"""Predicted unknowns, time and memory against runs, scaling laws, and refusals made of them."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from solidwhirl.build import cylinder
from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.core.machine import machine_speed
from solidwhirl.cost import coefficients as cost_coefficients
from solidwhirl.cost import machine as machines
from solidwhirl.cost import run_coefficients
from solidwhirl.cost.effects import effect_costs
from solidwhirl.cost.forecast import forecast
from solidwhirl.cost.machine import GROUPS, REFERENCE, this_machine, uniform
from solidwhirl.cost.memory import refuse_what_does_not_fit
from solidwhirl.cost.stand_in import stand_in, stepped_parts
from solidwhirl.cost.tables import cost_rows, forecast_document, forecast_rows
from solidwhirl.cost.work import STAGES, predict_body_cost, predict_cost
from solidwhirl.meshing import mesh_meridian
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

MODES = 8


@pytest.fixture
def planned():
    """Function: scene, bodies and plan of scene data."""

    def plan(data, **model):
        scene = parse_scene({**data, "model": {**data.get("model", {}), **model}})
        bodies = build_bodies(scene)
        return scene, bodies, make_plan(scene, bodies)

    return plan


@pytest.fixture
def rotor(planned, small_scene):
    """The small scene's rotor: its body, and the plan with a finer mesh."""
    _, bodies, plan = planned(small_scene(), level="harmonic", order=3, corner_size_m=1e-4)
    return bodies["rotor"], plan.bodies["rotor"]


def sized(plan, factor=1.0, degree=None):
    """The plan with sizes multiplied by a factor."""
    size = plan.resolution.size
    size = replace(size, size_m=factor * size.size_m, corner_size_m=factor * size.corner_size_m)
    degree = degree or plan.resolution.degree
    return replace(plan, resolution=replace(plan.resolution, size=size, degree=degree))


@pytest.mark.parametrize("name", ["uhbr_lp", "uhbr_fan", "ferraris", "laval"])
def test_unknowns_of_scenes_within_a_factor_of_one_and_a_half(planned, scene_data, name):
    _, bodies, plan = planned(scene_data(name), level="harmonic")
    for key, body in bodies.items():
        own = plan.bodies[key]
        cells = mesh_meridian(body, own.resolution.size).cells[:, :3]
        pairs = np.vstack([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]])
        edges = len(np.unique(np.sort(pairs, axis=1), axis=0))
        families = sum(2 if order else 1 for order in own.orders)
        for p in (2, 3, 4):
            inside = (p - 1) * (p - 2) // 2
            nodes = len(np.unique(cells)) + (p - 1) * edges + inside * len(cells)
            cost = predict_body_cost(body, sized(own, degree=p), modes=MODES)
            assert 1 / 1.5 < cost.unknowns / (3 * families * nodes) < 1.5, (key, p)


@pytest.mark.solver
@pytest.mark.parametrize(
    ("level", "extra", "factor"),
    [("harmonic", {}, 1.5), ("harmonic", {"axial_stiffness_n_per_m": 1e7}, 1.5), ("solid", {}, 2)],
)
def test_prediction_of_a_run(planned, small_scene, level, extra, factor):
    """Unknowns as in the results; coordinates are an upper bound that is not far off."""
    body = {"sections": [cylinder("shaft", 0.0, 0.4, 0.06)]} if level == "solid" else None
    data = small_scene(bearing=extra, body=body)
    data["model"] = {"level": level, "accuracy": 0.1, "modes": MODES, "corner_size_m": 6e-3}
    data["model"]["estimates"] = "off"
    data["campbell"] = {"branches": 4}
    scene, bodies, plan = planned(data)
    cost = predict_cost(plan, scene, bodies, modes={"rotor": MODES}).whole
    results = run_scene(scene)
    made = results.bodies["rotor"].element
    assert 1.0 / factor < cost.unknowns / made.full_dofs < factor
    # modes at rest and at the top speed may be the same vectors, so there can be fewer
    assert 0.6 * cost.coordinates <= len(made.coordinates) <= cost.coordinates


def test_nothing_is_negative_and_stages_are_in_order(rotor):
    body, plan = rotor
    cost = predict_body_cost(body, plan, modes=MODES, estimates=True)
    assert all(spent >= 0.0 for spent in cost.seconds.values())
    assert list(cost.seconds) == [stage for stage in STAGES if stage in cost.seconds]
    assert {"meshing", "assembly", "factorisations", "eigensolutions"} <= set(cost.seconds)
    assert cost.total_s == pytest.approx(sum(cost.seconds.values()))
    for table in (cost_coefficients.LAWS, cost_coefficients.MEMORY, cost_coefficients.MESHING):
        assert all(value >= 0.0 for row in table.values() for value in row)


@pytest.mark.parametrize("level", ["harmonic", "solid"])
def test_finer_meshes_cost_more(planned, small_scene, level):
    _, bodies, plan = planned(small_scene(), level=level, size_m=0.02)
    costs = [
        predict_body_cost(bodies["rotor"], sized(plan.bodies["rotor"], f), modes=MODES)
        for f in (1.0, 0.5, 0.25)
    ]
    for coarse, fine in pairwise(costs):
        assert fine.unknowns > coarse.unknowns
        assert fine.peak_memory_gib > coarse.peak_memory_gib
        for stage, spent in coarse.seconds.items():
            assert fine.seconds[stage] > spent or stage == "around", stage


def test_what_a_body_costs_follows_its_plan(rotor):
    body, plan = rotor
    base = predict_body_cost(body, plan, modes=MODES)
    modes = predict_body_cost(body, plan, modes=4 * MODES)
    assert modes.seconds["eigensolutions"] > base.seconds["eigensolutions"]
    assert modes.seconds["factorisations"] == base.seconds["factorisations"]
    assert modes.coordinates > base.coordinates
    tilting = dict.fromkeys(plan.interface_components, ("ux", "uy", "rx", "ry"))
    tilt = predict_body_cost(body, replace(plan, interface_components=tilting), modes=MODES)
    # each of the 4 further motions brings a constraint mode and its inertia correction
    assert tilt.coordinates == base.coordinates + 8
    assert tilt.seconds["static_solutions"] > base.seconds["static_solutions"]
    estimated = predict_body_cost(body, plan, modes=MODES, estimates=True)
    assert estimated.seconds["error_estimate"] > 0.0
    assert estimated.peak_memory_gib > base.peak_memory_gib
    # of a sector the error of the mesh is found with elements of one order higher, of a whole not
    solid = replace(plan, level="solid", resolution=replace(plan.resolution, degree=2))
    for own, is_compared in ((solid, True), (replace(solid, shape="round"), False)):
        costs = [predict_body_cost(body, own, modes=MODES, estimates=e) for e in (False, True)]
        assert (costs[0].peak_memory_gib < costs[1].peak_memory_gib) is is_compared
        assert costs[1].seconds["error_estimate"] > 0.0
    beam = predict_body_cost(body, replace(plan, level="beam"), modes=MODES)
    assert beam.unknowns < 100
    assert beam.total_s < 0.1
    # counts of the plan multiply what one costs
    twice = replace(plan, matrices=2 * plan.matrices, factorisations=plan.factorisations + 1)
    cost = predict_body_cost(body, twice, modes=MODES)
    assert cost.seconds["assembly"] == pytest.approx(2.0 * base.seconds["assembly"])
    share = (plan.factorisations + 1) / plan.factorisations
    assert cost.seconds["factorisations"] == pytest.approx(share * base.seconds["factorisations"])
    # a machine twice as fast takes half the time
    cost = predict_body_cost(body, plan, modes=MODES, machine=uniform(0.5))
    assert cost.total_s == pytest.approx(0.5 * base.total_s)
    assert cost.peak_memory_gib == base.peak_memory_gib


def test_engine_grows_with_the_cube_of_its_coordinates(planned, small_scene):
    scene, bodies, plan = planned(small_scene(rpm=np.linspace(0.0, 3e4, 11)), level="harmonic")
    costs = [predict_cost(plan, scene, bodies, modes={"rotor": m}).whole for m in (400, 800, 1600)]
    n = [c.coordinates for c in costs]
    drawn = [c.seconds["campbell"] for c in costs]
    # differences take out the part that does not grow
    ratio = (drawn[2] - drawn[1]) / (drawn[1] - drawn[0])
    assert ratio == pytest.approx((n[2] ** 3 - n[1] ** 3) / (n[1] ** 3 - n[0] ** 3), rel=1e-9)
    scene, bodies, plan = planned(small_scene(rpm=(0.0,)), level="harmonic")
    still = predict_cost(plan, scene, bodies, modes={"rotor": 8}).whole
    assert "critical_speeds" not in still.seconds


@pytest.mark.parametrize(
    ("nodes", "peak_gib"), [(3246, 0.47), (9255, 1.08), (11255, 1.42), (32501, 3.3)]
)
def test_memory_of_a_bladed_sector_within_a_factor_of_one_and_a_half(small_scene, nodes, peak_gib):
    """Largest resident memory of runs of wheels with 24 and 36 blades, by the nodes of a mesh."""
    blades = {"name": "fan", "on": "disk", "count": 24, "length_m": 0.05, "chord_m": 0.01}
    data = small_scene(body={"blades": [blades | {"thickness_m": 4e-3, "stagger_deg": 30}]})
    scene = parse_scene(data | {"model": {"level": "solid"}})
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies, "solid").bodies["rotor"]
    none = PredictedMesh(dimension=2, cells=0, vertices=0, edges=0, facets=0, graded_places=0)
    mesh = replace(none, dimension=3, vertices=nodes, cut_face=none)
    cost = predict_body_cost(bodies["rotor"], plan, modes=6, estimates=True, mesh=mesh)
    assert 1 / 1.5 < cost.peak_memory_gib / peak_gib < 1.5


def test_this_machine_is_measured():
    speed = machine_speed()
    # between a slow single-board computer and several times today's fastest core
    assert 0.1 < speed.gflops < 1000.0
    assert 0.1 < speed.gbytes_per_s < 1000.0


def test_what_does_not_fit_is_refused_with_what_does(planned, small_scene):
    scene, bodies, plan = planned(small_scene(), level="solid", size_m=2e-3, corner_size_m=2e-3)
    asked = {"modes": {"rotor": MODES}}
    refuse_what_does_not_fit(bodies, plan.bodies, scene.model, available_gib=1e3, **asked)
    with pytest.raises(MemoryShortageError) as refused:
        refuse_what_does_not_fit(bodies, plan.bodies, scene.model, available_gib=1.5, **asked)
    text = str(refused.value)
    assert text.startswith("bodies.rotor: level solid, element order 2, would have about ")
    assert "1.5 GiB are available" in text
    assert "level = 'harmonic'" in text
    # every alternative is said to need less than there is
    needed = [float(v) for v in re.findall(r"need about ([\d.e+]+) GiB", text)]
    assert needed[0] > 1.5
    assert len(needed) == 3
    assert max(needed[1:]) <= 1.5
    # and the sizes that it names are accepted
    size, corner = re.search(r"size_m = (\S+) with corner_size_m = (\S+) ", text).groups()
    scene, bodies, plan = planned(
        small_scene(), level="solid", size_m=float(size), corner_size_m=float(corner)
    )
    refuse_what_does_not_fit(bodies, plan.bodies, scene.model, available_gib=1.5, **asked)
    scene, bodies, plan = planned(small_scene(), level="harmonic", corner_size_m=1e-4)
    asked["available_gib"] = 0.5 * cost_coefficients.BASE_GIB
    with pytest.raises(MemoryShortageError, match="No coarser mesh of its rule fits"):
        refuse_what_does_not_fit(bodies, plan.bodies, scene.model, **asked)


def test_table(planned, small_scene):
    scene, bodies, plan = planned(small_scene(), level="harmonic")
    cost = predict_cost(plan, scene, bodies, modes={"rotor": MODES}, estimates=True)
    rows = cost_rows(cost)
    assert rows[0] == ("what", "unknowns", "predicted s", "predicted GiB")
    assert rows[1][:2] == ("rotor", str(cost.bodies["rotor"].unknowns))
    assert any("error estimate" in row[0] for row in rows)
    assert rows[-1][0] == "all"
    assert float(rows[-1][2]) == pytest.approx(cost.whole.total_s, rel=0.06)  # two digits
    # parts add up to all: shown with two digits each
    parts = [row for row in rows[2:-1] if row[0].startswith("  ") or not row[3]]
    assert sum(float(row[2]) for row in parts) == pytest.approx(cost.whole.total_s, rel=0.06)


STABILITY = {"kind": "stability", "to_rpm": 6000.0, "count": 41}
RUN_UP = {
    "kind": "run_up", "ramp_s": 2.0, "to_rpm": 6000.0, "sampling_hz": 1e4, "record_hz": 1e3,
    "mount": "left",
}  # fmt: skip


def test_all_of_a_run_is_in_the_forecast(planned, small_scene):
    """Twice the steps, twice the time; the total has all rows of the table."""
    found = []
    for factor in (1, 2):
        analyses = [{**STABILITY, "count": 41 * factor}, {**RUN_UP, "ramp_s": 50.0 * factor}]
        scene, bodies, plan = planned(small_scene() | {"analyses": analyses}, level="harmonic")
        found.append(forecast(scene, plan, bodies, machine=REFERENCE))
    for name in ("stability", "run_up"):
        first, second = (f.analyses[name] for f in found)
        assert second.seconds == pytest.approx(2.0 * first.seconds, rel=0.2)
    assert found[1].analyses["run_up"].memory_gib > found[0].analyses["run_up"].memory_gib
    rows = {row[0]: row[2] for row in forecast_rows(found[0])}
    parts = [
        float(spent)
        for what, spent in rows.items()
        if not what.startswith(("what", "  ", "all", "with --pictures"))
    ]
    assert sum(parts) == pytest.approx(found[0].seconds, rel=0.06)  # two digits each
    assert float(rows["all"]) == pytest.approx(found[0].seconds, rel=0.06)
    document = forecast_document(found[0])
    assert document["cpu_s"] == found[0].seconds
    assert document["pictures_cpu_s"] > document["page_cpu_s"] > 0.0


def test_a_comparison_of_levels_costs_a_run_on_the_other_one(planned, small_scene):
    """All but start, files and page: bodies, engine and estimates."""
    table = {"kind": "level_comparison", "level": "solid"}
    data = small_scene()
    del data["model"]["modes"]  # the other level has a basis of its own
    scene, bodies, plan = planned(data | {"analyses": [table]}, level="harmonic")
    found = forecast(scene, plan, bodies, machine=REFERENCE)
    scene, bodies, plan = planned(data, level="solid")
    other = forecast(scene, plan, bodies, machine=REFERENCE)
    around = other.start_s + other.writing.files_s + other.writing.page_s
    cost = found.analyses["level_comparison"]
    assert cost.seconds == pytest.approx(other.seconds - around, rel=0.1)
    assert cost.memory_gib > 0.0


def two_shafts(analyses):
    """Two shafts of beams in a casing that is held: none is moved by the other."""
    shaft = {
        "material": "steel", "stations_m": [0.0, 0.3, 0.6], "outer_radius_m": [0.02, 0.02],
        "interfaces": {"left": 0.0, "right": 0.6},
    }  # fmt: skip
    law = {"kind": "table", "speed_rpm": [0, 9000], "stiffness_n_per_m": [1e7, 2e7],
           "damping_n_s_per_m": [1e3, 1e3]}  # fmt: skip
    bearings = [
        {"name": f"{body}_{end}", "first": f"{body}.{end}", "second": f"casing.{body}_{end}",
         "speed_law": "film"}
        for body in ("inner", "outer") for end in ("left", "right")
    ]  # fmt: skip
    ground = {"name": "foot", "first": "casing.foot", "rigid": ["ux", "uy", "rx", "ry"]}
    places = {f"{b}_{e}": z for b in ("inner", "outer") for e, z in (("left", 0.0), ("right", 0.6))}
    casing = {
        "speed_ratio": 0.0, "mass_kg": 50.0, "center_of_gravity_m": [0.0, 0.0, 0.3],
        "inertia_kg_m2": [3.0, 3.0, 1.0], "interfaces": {**places, "foot": 0.3},
    }  # fmt: skip
    return parse_scene(
        {
            "name": "two_shafts",
            "speeds": {"to_rpm": 9000, "count": 5},
            "beams": {"inner": shaft, "outer": {**shaft, "speed_ratio": 1.5}},
            "rigid_bodies": {"casing": casing},
            "bearings": [*bearings, ground],
            "speed_laws": {"film": law},
            "analyses": analyses,
        }
    )


def test_an_engine_is_forecast_as_it_is_solved():
    """Parts that nothing couples; run-ups that are the same once; speeds that are searched."""
    run_up = {**RUN_UP, "mount": "foot", "unbalances": [{"at": "inner.left", "moment_kg_m": 1e-6}]}
    margins = {"kind": "separation_margins", "operating": [
        {"shaft": "inner", "from_rpm": 5000, "to_rpm": 6000}], "search_factor": 1.3}  # fmt: skip
    beyond = {**margins, "name": "beyond", "search_factor": 2.0}
    again = {**run_up, "name": "again", "compare_flexible": [[]], "bands_hz": [[5.0, 50.0]]}
    scene = two_shafts([run_up, again, margins, beyond])
    plan = make_plan(scene, {})
    found = forecast(scene, plan, {}, machine=REFERENCE)
    size = found.first.size
    assert len(size.parts) == 2 and sum(size.parts) == size.coordinates and not size.whole
    stepped = stepped_parts(scene, plan, stand_in(scene, plan, {}), {})
    ((first,), (rigid,)) = stepped["run_up"], stepped["again"]
    assert first.coordinates == 12.0 and rigid.coordinates == 4.0
    spent = {name: cost.seconds for name, cost in found.analyses.items()}
    assert spent["separation_margins"] < 0.2 * spent["beyond"]


def test_what_rigid_bodies_can_not_be_is_forecast_as_a_whole(planned, small_scene):
    """A body that is held at both ends in all its motions."""
    data = small_scene() | {"analyses": [{**RUN_UP, "mount": "left"}]}
    held = {"rigid": ["ux", "uy", "uz", "rx", "ry", "rz"]}
    data["bearings"] = [
        {"name": name, "first": spec["first"], **(held if k else {"damping_n_s_per_m": 1e3})}
        for k, (name, spec) in enumerate(zip(["left", "held"], data["bearings"], strict=True))
    ]
    data["bearings"][0]["stiffness_n_per_m"] = 1e7
    scene, bodies, plan = planned(data, level="harmonic")
    found = forecast(scene, plan, bodies, machine=REFERENCE)
    assert found.first.size.parts == (float(found.first.size.coordinates),)
    assert found.analyses["run_up"].seconds > 0.0


def test_effects_cost_what_forecasts_without_them_save(planned, small_scene):
    scene, bodies, plan = planned(small_scene(rpm=np.linspace(0.0, 3e4, 11)), level="harmonic")
    expected = forecast(scene, plan, bodies, machine=REFERENCE)
    costs = effect_costs(scene, plan, bodies, expected, REFERENCE)
    # a whole rotor as a solid would be beyond what was measured
    assert {e.name for e in plan.effects} - set(costs) <= {"coupling_comparison", "asymmetry"}
    assert all(cost.seconds >= 0.0 and cost.memory_gib >= 0.0 for cost in costs.values())
    # order 0 is about as much again as order 1; damping makes the eigenproblems general
    body = expected.first.bodies["rotor"]
    reduced = body.total_s - body.seconds["around"] - body.seconds["meshing"]
    assert 0.3 * reduced < costs["axial"].seconds < 2.0 * reduced
    assert costs["bearing_damping"].seconds > 0.0
    assert costs["axial"].seconds > costs["spin_softening"].seconds
    # what is left out saves as much as it costs where it is on
    data = small_scene(rpm=np.linspace(0.0, 3e4, 11), bearing={"axial_stiffness_n_per_m": 1e7})
    scene, bodies, plan = planned(data, level="harmonic")
    expected = forecast(scene, plan, bodies, machine=REFERENCE)
    added = effect_costs(scene, plan, bodies, expected, REFERENCE)["axial"]
    assert plan.on("axial")
    assert added.seconds == pytest.approx(costs["axial"].seconds, rel=0.3)


def test_a_calibration_is_kept_by_machine(tmp_path, monkeypatch):
    """Factors are those of the jobs; what can't be read, or is absurd, is no calibration."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert not this_machine().calibrated
    jobs = {group: 2.0 * spent for group, spent in run_coefficients.JOBS_S.items()}
    path = machines.keep_calibration(jobs)
    found = this_machine()
    assert found.calibrated
    assert [found.factor(group) for group in GROUPS] == pytest.approx([2.0] * len(GROUPS))
    monkeypatch.setattr(machines, "machine_name", lambda: "another")
    assert machines.kept_calibration() is None
    machines.keep_calibration(dict.fromkeys(GROUPS, 1e9))
    assert machines.kept_calibration() is None
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert this_machine().calibrated
    path.write_text("{", encoding="utf-8")
    assert not this_machine().calibrated


def test_modes_are_sought_at_every_frequency_of_a_table(planned, small_scene):
    """A diagram takes an eigenproblem for each, the search for critical speeds none more."""
    rows = [[1e7, 1e7], [2e7, 2e7]]

    def stages(frequencies):
        law = {
            "kind": "frequency_table", "speed_rpm": [0, 20000], "frequency_hz": frequencies,
            "stiffness_n_per_m": [[r for _ in frequencies] for r in rows],
            "damping_n_s_per_m": [[[1e3, 1e3] for _ in frequencies] for _ in rows],
        }  # fmt: skip
        data = {**small_scene(), "speed_laws": {"seal": law}}
        data["bearings"] = [
            {k: v for k, v in b.items() if "stiffness" not in k} | {"speed_law": "seal"}
            for b in data["bearings"]
        ]
        scene, bodies, plan = planned(data, level="harmonic")
        return predict_cost(plan, scene, bodies, modes={"rotor": MODES}).whole.seconds

    few, many = stages([0.0, 100.0]), stages([0.0, 100.0, 200.0, 300.0])
    assert many["campbell"] > 1.5 * few["campbell"]
    assert many["critical_speeds"] == pytest.approx(few["critical_speeds"])
