"""What a scene with beams, rigid bodies, gears, speed laws and analyses may not say."""

from __future__ import annotations

import copy
import json
import re
import tomllib

import pytest
from engine_of_all_kinds import ENGINE, KINDS
from toml_text import toml
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.scene_reading.reader import parse_scene

# path = value, null takes a key away; then what the message must say
WRONG = """
gears.0.first = "lp.x" | gears[0].first: no interface 'lp.x' | 'lp.m'? | casing.d
gears.0.second = "ground" | gears[0].second: no interface 'ground' | allowed are lp.a
gears.0.second = "lp.a" | gears[0].second: 'lp.a' is the first end too
gears.0.second = "lp.b" | gears[0].second: both seats are on body 'lp'
gears.0.second = "casing.a" | gears[0].ratio: -1.5, but 'lp' has speed_ratio 1 | 'casing' 0
gears.0.ratio = 1.5 | gears[0].ratio: 1.5, but 'lp' | which is -1.5
gears.0.ratio = -1.50000001 | gears[0].ratio: -1.50000001, but 'lp'
gears.0.ratio = 0 | gears[0]: ratio is 0
gears.0.mesh_stiffness_n_per_m = 1e8 | gears[0]: base_radius_first_m is needed
gears.0.mesh_damping_n_s_per_m = 5 | gears[0]: a rigid mesh has no damping
bearings.0.speed_law = "rsing" | bearings[0].speed_law: no speed law 'rsing' | 'rising'?
speed_laws = null; bearings.2.speed_law = null | bearings[0].speed_law | has no [speed_laws]
bearings.2.stiffness_n_per_m = 1e7 | bearings[2].speed_law: 'table' is a table of absolute values
bearings.2.damping_n_s_per_m = 1e2 | bearings[2].speed_law | leave out stiffness_n_per_m and dam
bearings.0.stiffness_n_per_m = [[1e7, 1], [1, 1e7]] | bearings[0].speed_law | cross terms must be 0
bearings.0.damping_n_s_per_m = [[1, 0], [1, 1]] | bearings[0].speed_law: 'rising' | cross terms
bearings.0.speed_law = "printed"; bearings.0.damping_n_s_per_m = [[1, 0], [1, 1]] | cross terms
bearings.0.first = "casing.a"; bearings.0.second = "lp.a" | 'casing' does not turn | law
bearings.2.rigid = ["uy"] | bearings[2].speed_law: ux or uy is rigid
speed_laws.table.damping_n_s_per_m = [5] | damping_n_s_per_m has 1 entries for 2 speeds
speed_laws.table.speed_rpm = [0] | speed_rpm | at least 2 items | found [0]
speed_laws.table.speed_rpm = [5, 5] | speed_laws.table | speed_rpm must be increasing
speed_laws.table.speed_rpm = [-5, 5] | speed_rpm[0] | greater than or equal to 0 | found -5
speed_laws.table.interpolation = "cubic" | 'linear' or 'monotone' | found 'cubic'
speed_laws.rising.kind = "spline" | speed_laws.rising | 'spline' | 'polynomial', 'table'
speed_laws.printed.preset = "lee" | preset | 'lee_isotropic' or 'lee_anisotropic' | found 'lee'
beams.lp.stations_m = [0, 1, 0.5] | beams.lp: stations_m must be increasing
beams.lp.outer_radius_m = [1, 1, 1] | beams.lp: outer_radius_m has 3 values; 1 or 2, one per sec
beams.lp.inner_radius_m = [] | beams.lp: inner_radius_m has 0 values; 1 or 2
beams.lp.interfaces = {} | beams.lp.interfaces | at least 1 item
beams.lp.interfaces = {"a.b": 0} | beams.lp.interfaces.'a.b' | match pattern
beams.lp.material = null | beams.lp.material: missing
rigid_bodies.casing.mass_kg = 0 | rigid_bodies.casing.mass_kg | greater than 0 | found 0
rigid_bodies.casing.inertia_kg_m2 = [1, 1, -1] | rigid_bodies.casing.inertia_kg_m2[2] | found -1
rigid_bodies.casing.internal_damping = {} | internal_damping: unknown key | speed_ratio, mass_kg
beams.lp.internal_damping.modal_ratio = 1.0 | modal_ratio | less than 1 | found 1.0
beams.lp.internal_damping.beta = 1.0 | beta: unknown key | stiffness_coefficient_s, modal_ratio
bodies = {"hp": {"material": "steel"}} | more than one body is named hp
"""

# kind of analysis: path = value; then what the message must say
WRONG_ANALYSES = """
stability: kind = "stable" | analyses[0] | 'stable' | 'unbalance_response', 'place_map'
stability: to_rpm = null | analyses[0] | to_rpm: missing
stability: cuont = 5 | cuont: unknown key; did you mean 'count'?
stability: from_rpm = 7000 | analyses[0] | to_rpm = 6000 is not above from_rpm = 7000
stability: name = "../up" | name | match pattern | found '../up'
stability: name = "a\\n" | name | match pattern
unbalance_response: observe = ["lp.q"] | analyses[0].observe[0]: no interface 'lp.q' | 'lp.m'?
unbalance_response: unbalances.0.at = "casing.a" | analyses[0].unbalances[0].at: 'casing' does not
unbalance_response: unbalances.0.angle = 0 | unbalances[0].angle: unknown key
unbalance_response: orbits_at_rpm = [-1] | orbits_at_rpm[0] | found -1
unbalance_response: count = 3 | analyses[0].count | greater than or equal to 4, found 3
waterfall: observe = "lp" | observe | match pattern | found 'lp'
place_map: places = ["lp.m", "hp.z"] | analyses[0].places[1]: no interface 'hp.z'
state_space: outputs = ["lp.z"] | analyses[0].outputs[0]: no interface 'lp.z'
stiffness_study: excite = "lp.z" | analyses[0].excite: no interface 'lp.z'
stiffness_study: bearings = [] | bearings | at least 1 item
stiffness_study: margin = 1.0 | margin | less than 1 | found 1.0
stiffness_study: stiffness_to_n_per_m = 1e6 | stiffness_to_n_per_m is not above stiffness_from
critical_speed_map: bearings = ["B", "E"] | analyses[0].bearings[1]: no bearing 'E' | A, B, C, D
critical_speed_map: excited_by = "fan" | analyses[0].excited_by: no body 'fan'
critical_speed_map: excited_by = "casing" | analyses[0].excited_by: 'casing' does not turn
rotating_campbell: branches = [1] | analyses[0] | branches has 1 numbers for 2 bodies
rotating_campbell: bodies = ["lp", "hpp"] | analyses[0].bodies[1]: no body 'hpp' | 'hp'? | casing
mode_shapes: modes = 61 | modes | less than or equal to 60
separation_margins: operating.0.shaft = "fan" | analyses[0].operating[0].shaft: no body 'fan' | hp
separation_margins: operating.0.to_rpm = 2 | operating[0] | to_rpm = 2 is below from_rpm = 5000
run_up: mount = "mont" | analyses[0].mount: no bearing 'mont' | did you mean 'mount'?
run_up: unbalances.0.at = "ip.m" | analyses[0].unbalances[0].at: no interface 'ip.m' | 'lp.m'?
run_up: unbalances.0.at = "casing.a" | analyses[0].unbalances[0].at: 'casing' does not turn
run_up: drives = ["lp.z"] | analyses[0].drives[0]: no interface 'lp.z'
run_up: compare_flexible = [["lp"], ["lp", "fan"]] | analyses[0].compare_flexible[1][1]: no body
run_up: unbalances = [] | analyses[0] | compare_flexible needs unbalances
run_up: bands_hz = [] | analyses[0] | compare_flexible needs bands_hz
run_up: bands_hz = [[9, 9]] | analyses[0] | bands_hz has (9, 9)
run_up: record_hz = 6000 | analyses[0] | record_hz = 6000 is above sampling_hz = 5000
run_up: gravity_m_per_s2 = [0, 1] | gravity_m_per_s2[2]: missing
run_up: gravity_m_per_s2 = [0, -9.81, 0] | analyses[0].compare_flexible: models are compared without
run_up: gravity_m_per_s2 = [0, 0, 9.81] | gravity_m_per_s2: 9.81 along z, but nothing holds a body
run_up: drives = ["lp.m"] | analyses[0].compare_flexible: models are compared without weight
run_up: compare_flexible = [["lp"], ["lp"]] | compare_flexible[1] is the same as compare_flexible[0]
run_up: ramp_s = 1e9 | analyses[0] | (ramp_s + hold_s) * sampling_hz is 5e+12 steps; at most 5e+07
run_up: hold_s = 0.20001 | analyses[0] | hold_s * sampling_hz is 1000.05 | a whole number of steps
run_up: record_hz = 10 | analyses[0].record_hz: 10, but | at least 2.5 records per turn are needed
run_up: record_hz = 3000 | analyses[0] | is 1.66666667 and must be whole; the nearest record_hz are
separation_margins: operating.0.shaft = "casing" | analyses[0].operating[0].shaft | does not turn
place_map: places = ["casing.a"] | analyses[0].places[0]: 'casing' does not turn; an unbalance needs
place_map: frequency_count = 2 | analyses[0].frequency_count | greater than or equal to 3 | found 2
state_space: from_rpm = 7000 | analyses[0]: to_rpm = 6000 is not above from_rpm = 7000
stiffness_study: operating_speed_rpm = 9e4 | analyses[0]: the band of margin | 1200 to 1800 Hz
stiffness_study: excite = "casing.a" | analyses[0].excite: 'casing' does not turn; an unbalance
rotating_campbell: bodies = ["casing"] | analyses[0].bodies[0]: 'casing' does not turn; its frame is
rotating_campbell: name = "campbell" | analyses[0].name: 'campbell' is the name of a file of every
"""

# found out from the geometry: refused before anything is meshed all the same
MISFITS = """
beams.lp.material = "stel" | beams.lp | 'stel' | steel
beams.lp.inner_radius_m = [0.04] | 0.04 | 0.03
beams.lp.interfaces.a = -1 | 'a'
beams.lp.interfaces.m = 0.0 | 'a' | 'm'
beams.lp.disks.0.at_m = 2 | 'd'
speed_laws.rising.argument_range = [9, 1] | argument_range
"""


def lines(text):
    return [line for line in text.splitlines() if line]


def changed(data, changes):
    """A copy with the changes of one line above."""
    data = copy.deepcopy(data)
    for change in filter(None, changes.split("; ")):
        path, _, text = change.partition(" = ")
        *keys, last = [int(part) if part.isdigit() else part for part in path.strip().split(".")]
        holder = data
        for key in keys:
            holder = holder[key]
        value = json.loads(text)
        if value is None:
            del holder[last]
        else:
            holder[last] = value
    return data


def scene_of(case):
    """The engine, changed; after the kind of an analysis with that one alone, changed."""
    kind, _, changes = case.partition(": ")
    if kind not in KINDS:
        return changed(ENGINE, case)
    return {**ENGINE, "analyses": [changed({"kind": kind, **KINDS[kind]}, changes)]}


# The file, and line and column of what belongs to a key that is there.
PLACE = re.compile(r"bad\.toml(?::\d+:\d+)?: ([^:]*)")


def key_in(line):
    """The key that a line of a message is about."""
    return PLACE.search(line)[1]


@pytest.fixture
def refused(invoke, refusal):
    """Function: the message of a scene that is refused before anything is done."""

    def check(data):
        done, written = invoke(toml(data))
        message = refusal(done, "bad.toml")
        assert all(PLACE.search(line) for line in lines(message)), "something was begun"
        assert not written
        return message

    return check


@pytest.mark.parametrize(
    "case", lines(WRONG + WRONG_ANALYSES + MISFITS), ids=lambda case: case.split(" | ")[0]
)
def test_wrong_entry_is_refused_before_the_work(refused, case):
    changes, *said = case.split(" | ")
    message = refused(scene_of(changes))
    for text in said:
        assert text in message, (text, message)


def test_keys_are_those_of_the_file_and_of_the_kind(refused):
    """No part of a key that the file does not have, such as the kind of the record."""
    assert key_in(refused(scene_of("stability: count = 1"))) == "analyses[0].count"
    message = refused(scene_of("speed_laws.rising.stiffness_x = []"))
    assert key_in(message) == "speed_laws.rising.stiffness_x"
    message = refused(scene_of("stability: zzz = 1"))
    assert "allowed are" in message
    assert "unbalances" not in message
    message = refused(scene_of("speed_laws.table.zzz = 1"))
    assert "interpolation" in message
    assert "argument_unit" not in message
    assert "'waterfall'" in refused(scene_of("stability: kind = null"))
    assert "'polynomial'" in refused(scene_of("speed_laws.table.kind = null"))


@pytest.mark.solver
def test_an_analysis_refused_late_is_named_and_leaves_no_results(invoke, refusal):
    done, written = invoke(toml(scene_of("run_up: ramp_s = 0.02; hold_s = 0")), "--quiet")
    assert "analyses[0] (run_up): step_s is 0.0002" in refusal(done, "bad.toml")
    assert not written


@pytest.mark.parametrize("name", [None, "twice"])
def test_entries_of_one_name(refused, name):
    """Without a name the kind is the name; with names two of a kind are fine."""
    data = {**ENGINE, "gears": [ENGINE["gears"][0], {**ENGINE["gears"][0], "second": "hp.b"}]}
    assert "gears[1].name: 'box' is the name of gears[0] too" in refused(data)
    response, places = ({"kind": k, **KINDS[k]} for k in ("unbalance_response", "place_map"))
    response |= {"name": "a", "orbits_at_rpm": [3e3]}
    data = {**ENGINE, "analyses": [response, places | {"name": "a_orbits"}]}
    assert "analyses[1].name: 'a_orbits' would write a_orbits.png, as 'a' does" in refused(data)
    first = {"kind": "stability", **KINDS["stability"], **({"name": name} if name else {})}
    message = refused({**ENGINE, "analyses": [first, first]})
    assert f"analyses[1].name: {name or 'stability'!r} is the name of analyses[0] too" in message
    scene = parse_scene({**ENGINE, "analyses": [first, {**first, "name": "other"}]})
    assert [a.label for a in scene.analyses] == [name or "stability", "other"]


def test_all_problems_of_joints_and_analyses_at_once(refused):
    message = refused(
        changed(ENGINE, 'gears.0.ratio = 2; bearings.0.speed_law = "x"; analyses.11.mount = "M"')
    )
    keys = [key_in(line) for line in lines(message)]
    assert keys == ["bearings[0].speed_law", "gears[0].ratio", "analyses[11].mount"]


def test_engine_is_accepted(tmp_path):
    """What the cases above start from has no fault of its own."""
    path = tmp_path / "good.toml"
    path.write_text(toml(ENGINE), encoding="utf-8")
    done = CliRunner().invoke(app, ["plan", str(path)])
    assert done.exit_code == 0, done.stderr
    assert "speed_dependent_bearings" in done.stdout
    assert parse_scene(ENGINE).model_dump() == parse_scene(tomllib.loads(toml(ENGINE))).model_dump()
