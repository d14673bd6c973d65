"""Units a thousand times off are questioned; what rotors really have is not."""

from __future__ import annotations

import copy
import math
import re
from pathlib import Path
from random import Random

import pytest

from solidwhirl.build import beam, bearing, body, cylinder
from solidwhirl.geometry import MATERIALS, GeometryError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.system_parts import engine_of, simple_elements
from solidwhirl.plausibility.units import implausible, refuse_bursting
from solidwhirl.rotordyn.modes.free_motions import free_lateral_motions
from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.scene_reading.weight import free_lateral_groups

SCENES = Path(__file__).resolve().parents[3] / "scenes"


def doubts(data):
    scene = parse_scene(data, folder=SCENES)
    return implausible(scene, build_bodies(scene))


def refuse(data):
    scene = parse_scene(data, folder=SCENES)
    refuse_bursting(scene, build_bodies(scene))


def scaled(value, factor):
    if isinstance(value, list):
        return [scaled(v, factor) for v in value]
    return value * factor


def scale_keys(node, chosen, factor):
    """All numbers below a node whose key is chosen."""
    for key, value in list(node.items() if isinstance(node, dict) else enumerate(node)):
        if isinstance(value, dict) or (
            isinstance(value, list) and any(isinstance(v, dict) for v in value)
        ):
            scale_keys(value, chosen, factor)
        elif isinstance(node, dict) and chosen(key):
            node[key] = scaled(value, factor)


INERTIAS = ("polar_inertia_kg_m2", "diametral_inertia_kg_m2")
GROUPS = {
    "lengths": lambda k: k.endswith("_m"),
    "modulus": lambda k: k == "youngs_modulus_pa",
    "density": lambda k: k == "density_kg_per_m3",
    "stiffness": lambda k: k == "stiffness_n_per_m",
    "disk masses": lambda k: k == "mass_kg",
    "disk inertias": lambda k: k in INERTIAS,
    "disk masses and inertias": lambda k: k == "mass_kg" or k in INERTIAS,
    "speeds": lambda k: k in ("from_rpm", "to_rpm"),
}
# Not told from the numbers alone: (scene, group, factor) and why.
SILENT = {
    ("ferraris", "stiffness", 1e-3): "1e7 N/m is a usual bearing; the shaft would sag by 7 µm",
    ("laval", "density", 1e3): "1000 kg/m³ is a usual density of a composite",
    ("laval", "density", 1e-3): "the shaft was made massless on purpose, and still is",
    ("uhbr_lp", "stiffness", 1e3): "4.5e10 N/m is stiff, but a scene may have that",
    ("uhbr_lp", "disk masses and inertias", 1e-3): "thin rings may weigh as little as one likes",
    ("ferraris", "speeds", 1e-3): "a rotor may turn slowly",
    ("laval", "speeds", 1e-3): "a rotor may turn slowly",
}


MATERIAL = ("density_kg_per_m3", "youngs_modulus_pa", "poissons_ratio")


def with_own_materials(data):
    """The scene with the materials of the program written out."""
    data = copy.deepcopy(data)
    own = {name: {key: getattr(m, key) for key in MATERIAL} for name, m in MATERIALS.items()}
    data["materials"] = own | data.get("materials", {})
    return data


CASES = [
    (scene, group, factor)
    for scene in ("ferraris", "laval", "uhbr_lp")
    for group in GROUPS
    for factor in (1e3, 1e-3)
    if (scene, group) != ("laval", "stiffness")  # its bearings are rigid
    and not (scene == "ferraris" and group.startswith("disk"))  # it has no rigid disks
]


@pytest.mark.parametrize(("scene", "group", "factor"), CASES)
def test_unit_a_thousand_times_off(scene_data, scene, group, factor):
    data = with_own_materials(scene_data(scene))
    assert doubts(data) == ()
    where = {"lengths": "bodies", "speeds": None}.get(group, "all")
    for node in (data if where != "bodies" else data["bodies"],):
        scale_keys(node, GROUPS[group], factor)
    try:
        found = doubts(data)
    except GeometryError:  # stages of a table keep their size, and nothing fits any more
        assert (scene, group) == ("uhbr_lp", "lengths")
        return
    assert bool(found) != ((scene, group, factor) in SILENT), [d.message for d in found]
    for doubt in found:
        assert "expected" in doubt.mistake
        assert doubt.message.startswith(doubt.key)


UNUSUAL = {
    "silicon": (2330.0, 1.6e11, 0.2),
    "carbon_fibre": (1550.0, 1.4e11, 0.3),
    "tungsten_alloy": (18_500.0, 3.6e11, 0.28),
    "polyamide": (1150.0, 2.5e9, 0.4),
}


def rotor(length, radius, disk_radius, width, rpm, stiffness, material="steel", **extra):
    """A shaft with a disk in the middle on two bearings."""
    middle = 0.5 * length
    sections = [cylinder("shaft", 0.0, length, radius)]
    if disk_radius > radius:
        ends = (middle - 0.5 * width, middle + 0.5 * width)
        sections.append(cylinder("disk", *ends, disk_radius, inner_radius_m=radius))
    places = {"a": 0.0, "b": length}
    return {
        "name": "rotor",
        "speeds": {"list_rpm": [0.0, rpm]},
        "bodies": {"rotor": body(*sections, interfaces=places, material=material, **extra)},
        "bearings": [bearing(n, f"rotor.{n}", stiffness_n_per_m=stiffness) for n in places],
        "materials": {n: dict(zip(MATERIAL, own, strict=True)) for n, own in UNUSUAL.items()},
    }


REAL = {
    # length, shaft radius, disk radius, width, rpm, N/m of a bearing
    "dental drill of 1 mm": (0.012, 5e-4, 1.5e-3, 2e-3, 4.5e5, 1e5),
    "micro turbine of 4 mm": (1e-3, 1e-3, 2e-3, 3e-4, 1.2e6, 1e4, "silicon"),
    "watch balance": (3e-3, 1e-4, 4.5e-3, 2e-4, 120.0, 1e4),
    "turbocharger": (0.12, 4e-3, 0.03, 0.02, 2.2e5, 5e6),
    "machine tool spindle": (0.4, 0.03, 0.06, 0.05, 24_000.0, 2e8),
    "vacuum pump": (0.25, 0.015, 0.06, 0.1, 60_000.0, 2e5),
    "composite flywheel": (0.8, 0.05, 0.3, 0.2, 30_000.0, 1e7, "carbon_fibre"),
    "gyroscope": (0.05, 0.002, 0.02, 0.01, 24_000.0, 1e7, "tungsten_alloy"),
    "plastic fan": (0.03, 0.0015, 0.04, 0.02, 3000.0, 1e6, "polyamide"),
    "aero engine low pressure shaft": (2.5, 0.05, 0.9, 0.1, 5000.0, 5e7),
    "pump with a long shaft": (12.0, 0.04, 0.2, 0.1, 1500.0, 1e8),
    "hydro generator": (8.0, 0.6, 4.0, 1.0, 100.0, 2e9),
    "steam turbine train of 60 m, 300 t": (60.0, 0.4, 1.0, 2.0, 3000.0, 4e9),
    "ship propeller shaft": (40.0, 0.4, 2.0, 0.5, 80.0, 1e9),
}


@pytest.mark.parametrize("name", REAL)
def test_real_rotors_are_not_questioned_but_in_millimetres(name):
    length, radius, disk, width, rpm, stiffness, *material = REAL[name]
    sizes = [length, radius, disk, width]
    assert doubts(rotor(*sizes, rpm, stiffness, *material)) == ()
    assert doubts(rotor(*(1e3 * size for size in sizes), rpm, stiffness, *material))


@pytest.mark.parametrize("name", REAL)
def test_radii_in_millimetres_are_refused_before_the_mesh(name):
    """Lengths in metres and radii in millimetres, at speeds that burst a disk of that radius."""
    length, radius, disk, width, rpm, stiffness, *material = REAL[name]
    refuse(rotor(length, radius, disk, width, rpm, stiffness, *material))
    data = rotor(length, 1e3 * radius, 1e3 * disk, width, rpm, stiffness, *material)
    # rim of a free disk strained by 5 %: u/r = (1 - nu)/4 rho v^2/E
    density, modulus, poisson = UNUSUAL.get(*material or [""], (7800.0, 2e11, 0.3))
    limit = math.sqrt(0.05 * 4.0 / (1.0 - poisson) * modulus / density)
    fast = [r for r in (1e3 * radius, 1e3 * disk) if r >= 1.0 and r * rpm * math.pi / 30 > limit]
    if name == "watch balance":  # so slow that even metres hold
        assert not fast
        refuse(data)
        assert any("millimetres" in doubt.message for doubt in doubts(data))
        return
    with pytest.raises(GeometryError) as caught:
        refuse(data)
    said = re.fullmatch(
        r"bodies\.rotor\.sections\[\d\]\.outer_radius_m: (\S+) m, .* more than (\S+) m/s\. "
        r"Radii are in metres \((\S+) mm is (\S+)\); .*",
        str(caught.value),
    )
    assert said and float(said[1]) == float(said[3]) == pytest.approx(1e3 * float(said[4]))
    assert float(said[1]) == pytest.approx(fast[0])
    assert float(said[2]) == pytest.approx(limit, rel=2e-2)  # three digits, and the grade of steel


def test_beam_in_millimetres_is_refused_where_it_turns_fast():
    shaft = beam([0.0, 0.4], 20.0, {"a": 0.0}, material="steel", speed_ratio=1.0)
    fast = {"name": "beam", "speeds": {"list_rpm": [0.0, 3000.0]}, "beams": {"b": shaft}}
    with pytest.raises(GeometryError, match=r"^beams\.b\.outer_radius_m: 20 m.*20 mm is 0\.02"):
        refuse(fast)
    refuse({**fast, "speeds": {"list_rpm": [0.0, 300.0]}})


def test_a_consistent_system_of_millimetres_is_questioned(scene_data):
    """mm, t, N, MPa, as finite element models have it: every group is said."""
    data = with_own_materials(scene_data("ferraris"))
    for group, factor in (("lengths", 1e3), ("density", 1e-12), ("modulus", 1e-6)):
        scale_keys(data["bodies"] if group == "lengths" else data, GROUPS[group], factor)
    keys = {doubt.key for doubt in doubts(data)}
    assert {"bodies.inner", "materials.steel.density_kg_per_m3"} <= keys
    assert "materials.steel.youngs_modulus_pa" in keys


def test_other_doubts(scene_data, small_scene):
    """Unbalance in g mm, a casing in tonnes, a beam in millimetres."""
    data = scene_data("ferraris")
    data["analyses"][0]["unbalances"][0]["moment_kg_m"] = 100.0
    (found,) = doubts(data)
    assert found.key == "analyses[0].unbalances[0].moment_kg_m"
    assert "g mm" in found.message
    data = scene_data("uhbr_engine")
    data["rigid_bodies"]["casing"]["mass_kg"] *= 1e-3
    assert any("rigid_bodies.casing" in doubt.key for doubt in doubts(data))
    metres = {"name": "beam", "beams": {"b": beam([0.0, 400.0], 20.0, {"a": 0.0})}}
    assert [doubt.key for doubt in doubts(metres)] == ["beams.b"]


def hung(random):
    """A scene of some beams on some bearings, many of which hold one direction or none."""
    count = random.randint(1, 3)
    interfaces = {"a": 0.0, "b": 0.3, "c": 1.0}
    shaft = {
        "material": "steel",
        "stations_m": [0.0, 0.3, 0.7, 1.0],
        "outer_radius_m": [0.02],
        "interfaces": interfaces,
    }
    places = [f"r{k}.{name}" for k in range(count) for name in interfaces]
    kinds = (
        {"stiffness_n_per_m": 1e7},
        {"stiffness_n_per_m": [1e7, 0.0]},
        {"stiffness_n_per_m": 1e6, "tilt_stiffness_n_m_per_rad": 1e5},
        {"rigid": ["ux", "uy"]},
        {"rigid": ["rx"]},
        {"axial_stiffness_n_per_m": 1e6},
    )
    bearings = []
    for number in range(random.randint(1, 2 * count + 1)):
        first = random.choice(places)
        others = [place for place in places if place[:2] != first[:2]]
        ends = {"first": first, "second": random.choice(["ground", "ground", "ground", *others])}
        bearings.append({"name": f"b{number}"} | ends | random.choice(kinds))
    return parse_scene(
        {"name": "hung", "beams": {f"r{k}": shaft for k in range(count)}, "bearings": bearings}
    )


@pytest.mark.parametrize("seed", range(12))
def test_what_a_plan_says_of_supports_is_what_the_run_finds(seed):
    """Rigid motions that no joint resists against zeros of the assembled stiffness of the beams."""
    scene = hung(Random(seed))
    plan = make_plan(scene, {}, "beam")
    system = engine_of(scene, plan, simple_elements(scene, plan))
    found = {(m.bodies, m.held_by, m.count) for m in free_lateral_motions(system)}
    assert set(free_lateral_groups(scene)) == found
