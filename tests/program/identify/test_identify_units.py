"""The identified units of the engine against the published figures, and against each other."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.geometry import mass_properties
from solidwhirl.identify.run import read_problem
from solidwhirl.identify.scene import with_references
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene_reading.reader import parse_scene, read_scene

SCENES = Path(__file__).resolve().parents[3] / "scenes"
UNITS = ("uhbr_fan", "uhbr_hp", "uhbr_lp")

# Müller and Hennings, Table 4: mass, centre of gravity, polar and diametral inertia.
TABLE_4 = {
    "uhbr_fan": ("fan", (611.35, 0.653, 149.38, 78.21)),
    "uhbr_lp": ("lp", (175.62, 1.488, 32.62, 91.18)),
    "uhbr_hp": ("hp", (85.30, 1.85, 1.52, 3.65)),
}
# Their Table 6: the low pressure unit at rest, each frequency a pair.
TABLE_6_HZ = (17.4952, 70.8584, 82.3787, 153.201)


@pytest.fixture(scope="module")
def bodies():
    """Bodies of the three units, by scene."""
    return {u: build_bodies(read_scene(SCENES / f"{u}.toml"))[TABLE_4[u][0]] for u in UNITS}


@pytest.mark.parametrize("unit", UNITS)
def test_units_have_the_published_mass_properties(bodies, unit):
    """The search ends within 0.2 tolerances, of 2e-4 for the mass and 1e-3 for the rest."""
    p = mass_properties(bodies[unit])
    mass, place, polar, diametral = TABLE_4[unit][1]
    assert p.mass_kg == pytest.approx(mass, rel=4e-5)
    assert p.center_of_gravity_m[2] == pytest.approx(place, rel=2e-4)
    assert p.polar_inertia_kg_m2 == pytest.approx(polar, rel=2e-4)
    assert p.diametral_inertia_kg_m2 == pytest.approx(diametral, rel=2e-4)


@pytest.mark.verify
@pytest.mark.solver
def test_low_pressure_unit_has_the_published_frequencies(scene_data):
    """Within 0.2 tolerances of 2e-3 at the scene's accuracy, where they were identified."""
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.rotordyn.assembly.coordinates import interface_row

    data = {k: v for k, v in scene_data("uhbr_lp").items() if k not in ("analyses", "campbell")}
    results = run_scene(parse_scene({**data, "speeds": {}}))
    found = results.at_rest.frequency_hz[:8]
    np.testing.assert_allclose(found[0::2], TABLE_6_HZ, rtol=4e-4)
    np.testing.assert_allclose(found[1::2], found[0::2], rtol=1e-9)
    # node 9 is where the second mode deflects most, as the source says
    rows = [
        [interface_row(results.system, "lp", f"n{k}", c) for c in ("ux", "uy")]
        for k in range(1, 13)
    ]
    deflection = np.abs(np.array(rows) @ results.at_rest.shapes[:, 2]).max(axis=1)
    assert np.argmax(deflection) + 1 == 9


@pytest.mark.parametrize("unit", UNITS)
def test_scene_is_what_its_problem_and_record_say(unit):
    """Problem file, record and scene hold together: the record's values give the scene."""
    problem = read_problem(SCENES / "identify" / f"{unit}.toml")
    record = json.loads((SCENES / "identify" / f"{unit}.identification.json").read_text("utf-8"))
    assert record["met"]
    values = {p["name"]: p["value"] for p in record["parameters"]}
    for place, value in problem.numbers(values).items():
        # eleven digits are written, and from Python 3.12 on sum() rounds otherwise
        found = functools.reduce(lambda inside, step: inside[step], place.steps, problem.scene)
        assert found == pytest.approx(value, rel=1e-10), place.text
    wanted = {t.name: t.value for t in problem.spec.targets}
    assert list(wanted.values())[:4] == list(TABLE_4[unit][1])
    assert list(wanted.values())[4:] == (list(TABLE_6_HZ) if unit == "uhbr_lp" else [])
    assert not [p["name"] for p in record["parameters"] if p["at_bound"]]


@pytest.mark.parametrize("unit", UNITS)
def test_scene_refers_to_what_it_was_identified_from(unit):
    """Pages of runs compare with the published values; so does that of the whole engine."""
    problem = read_problem(SCENES / "identify" / f"{unit}.toml")
    written = read_scene(SCENES / f"{unit}.toml").references
    fitted = [r for r in written if r.source.endswith("identified from it")]
    assert [r.model_dump(exclude_defaults=True) for r in fitted] == with_references(
        {}, problem.spec
    )["references"]
    body = TABLE_4[unit][0]
    engine = read_scene(SCENES / "uhbr_engine.toml").references
    ours = [r for r in engine if r.quantity.startswith(f"bodies.{body}.")]
    assert tuple(r.value for r in ours) == TABLE_4[unit][1]


def test_page_tells_what_the_records_say():
    """What docs/identify.md sums up of the three records, to which it links."""
    page = (SCENES.parent / "docs" / "identify.md").read_text(encoding="utf-8")
    records = {}
    for unit in ("uhbr_fan", "uhbr_lp", "uhbr_hp"):
        path = SCENES / "identify" / f"{unit}.identification.json"
        records[unit] = json.loads(path.read_text(encoding="utf-8"))
        assert f"(../scenes/identify/{path.name})" in page
        assert f"{len(records[unit]['parameters'])} numbers" in page
    targets = [t for record in records.values() for t in record["targets"]]
    assert f"all {len(targets)} targets" in page
    spent = [abs(t["deviation_percent"]) / t["tolerance_percent"] for t in targets]
    assert max(spent) < 0.01
    assert "within 0.01 of its tolerance" in page
    free = records["uhbr_lp"]["identifiability"]
    values = [d["singular_value"] for d in free["directions"] if d["singular_value"] > 0.0]
    assert f"{max(values):.0f} to {min(values):.0f} for the eight" in page
    assert (len(values), free["undetermined_directions"]) == (8, 7)


def test_units_have_the_nodes_of_the_source(bodies):
    expected = {
        "uhbr_fan": {"A", "B", *(f"n{k}" for k in range(1, 9))},
        "uhbr_lp": {"C", "D", *(f"n{k}" for k in range(1, 17))},
        "uhbr_hp": {"E", "F", *(f"n{k}" for k in range(1, 9))},
    }
    for unit, names in expected.items():
        assert names <= {i.name for i in bodies[unit].interfaces}, unit
    places = {i.name: i.position_m[2] for i in bodies["uhbr_lp"].interfaces}
    middle = [places[f"n{k}"] for k in range(1, 13)]
    assert middle == sorted(middle)
    assert places["C"] < middle[0] < middle[-1] < places["D"]
    assert places["n13"] == pytest.approx(places["D"], abs=0.01)
    assert places["n16"] < places["n15"] < places["n14"] < places["C"]
    # the gear joins n8 of the fan to n16 of the low pressure unit
    fan = {i.name: i.position_m[2] for i in bodies["uhbr_fan"].interfaces}
    assert max(fan.values()) == fan["n8"] < places["n16"]


def extent(body, prefix=""):
    found = [s for s in body.sections if s.name.startswith(prefix)]
    return min(s.start_m for s in found), max(s.end_m for s in found)


def test_units_are_in_the_order_of_the_engine(bodies):
    """Fan, compressor, high pressure unit, turbine, along the axis."""
    low, high = bodies["uhbr_lp"], bodies["uhbr_hp"]
    assert extent(bodies["uhbr_fan"])[1] < extent(low)[0]
    assert extent(low, "lpc")[1] < extent(high)[0]
    assert extent(high)[1] < extent(low, "lpt")[0]
    # ring of the hub and bearing C too
    assert extent(low, "hub")[1] < extent(high)[0]


def test_low_pressure_shaft_clears_the_high_pressure_unit(bodies):
    """At least 1 mm between the shaft and the bore around it, everywhere."""
    low, high = bodies["uhbr_lp"], bodies["uhbr_hp"]
    gaps = []
    for z in np.linspace(*extent(high), 4001):
        outer = [s.radii_at(z)[1] for s in low.sections if s.start_m <= z <= s.end_m]
        bore = [s.radii_at(z)[0] for s in high.sections if s.start_m <= z <= s.end_m]
        gaps.append(min(bore) - max(outer))
    assert min(gaps) > 1e-3
