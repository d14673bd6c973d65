"""API 617 on the compressor, every figure again by hand from plain samples of its matrices."""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.analyses.api617 import bearing_cases
from solidwhirl.analyses.api617.clauses import clause_rows, verdict_of
from solidwhirl.core.plain_data import plain_data
from solidwhirl.model.bodies import scene_materials
from solidwhirl.model.drawn_masses import masses_beyond_kg
from solidwhirl.model.system_parts import with_speed_laws
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.rotordyn import FrequencyTableLaw, assemble, matrices_at_speed
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.lateral.unbalance_cases import unbalance_cases
from solidwhirl.scene_reading.reader import parse_scene, read_scene

pytestmark = pytest.mark.solver

COMPRESSOR = Path(__file__).parents[3] / "scenes" / "compressor.toml"
RPM = np.pi / 30.0
LOW, HIGH, TRIP = 9700.0, 11500.0, 1.05 * 11500.0


@cache
def scene_and_system():
    data = read_scene(COMPRESSOR).model_dump(mode="json", by_alias=True, exclude_unset=True)
    data["analyses"] = [a for a in data["analyses"] if a["kind"] == "api617"]
    scene = parse_scene(data | {"model": {"level": "beam", "estimates": "off"}})
    return scene, reduce_scene(scene).system


def run(system=None, **changes):
    """The analysis alone, without a diagram of the engine; with the laws of the scene alone."""
    scene, own = scene_and_system()
    asked = scene.analyses[0].model_dump() | {"cases": ()} | changes
    engine = SimpleNamespace(
        system=system or own,
        running=lambda _: (),
        speed_ratios={"rotor": 1.0},
        with_laws=with_laws,
        masses_beyond=partial(masses_beyond_kg, scene),
    )
    return type(scene.analyses[0]).model_validate(asked).run(engine)


def with_laws(laws):
    scene, _ = scene_and_system()
    return reduce_scene(with_speed_laws(scene, laws)).system


SOFT = {"drive_end": "pads_most_clearance", "free_end": "pads_most_clearance"}


@cache
def soft_system():
    return with_laws(SOFT)


@cache
def whole():
    """The laws of the scene, and those of the most clearance."""
    case = {"name": "most clearance", "laws": SOFT}
    return plain_data(run(cases=[case]).document)


@cache
def compressor():
    _, system = scene_and_system()
    return system, whole()["bearing_cases"]["as in the scene"]


def rows(document, subject, bearings="as in the scene"):
    return [
        row
        for row in document["clauses"]
        if row["subject"] == subject and row["bearings"] == bearings
    ]


@cache
def plain_motions(laws=None):
    """Speeds, and ux, uy of the interfaces by name for 1 kg m at each, speed by speed."""
    system = soft_system() if laws else compressor()[0]
    names = [node.name for node in system.system.rotors["rotor"].element.interfaces]
    at = {n: [interface_row(system, "rotor", n, c) for c in ("ux", "uy")] for n in names}
    rpm = np.arange(2000.0, 23_001.0, 12.5)
    # a vector that turns with the shaft, of every place
    loads = np.array([at[name][0] - 1j * at[name][1] for name in names]).T
    rows = np.array([row for name in names for row in at[name]])
    found = np.zeros((rpm.size, len(rows), len(names)), dtype=complex)
    for k, omega in enumerate(rpm * RPM):
        mass, damping, gyroscopic, stiffness = matrices_at_speed(system, omega)
        dynamic = stiffness - omega**2 * mass + 1j * omega * (damping + gyroscopic)
        found[k] = rows @ la.solve(dynamic, omega**2 * loads)
    return rpm, names, found


def plain_response(unbalances, laws=None):
    """Speeds, and ux, uy of the interfaces by name, with no refinement."""
    rpm, names, motions = plain_motions(laws)
    size = np.zeros(len(names), dtype=complex)
    for name, moment, phase in unbalances:
        size[names.index(name)] += moment * np.exp(1j * phase)
    found = (motions @ size).reshape(rpm.size, len(names), 2)
    return rpm, {name: found[:, k] for k, name in enumerate(names)}


def of_case(case, laws=None):
    own = ((u["at"].partition(".")[2], u["moment_kg_m"], np.radians(u["phase_deg"]))
           for u in case["unbalances"])  # fmt: skip
    return plain_response(tuple(own), laws)


SETS = [("as in the scene", None), ("most clearance", "soft")]


def half_power(rpm, size, top):
    """Amplification factor of a peak by linear interpolation; nan without both points."""
    level, ends = np.sqrt(0.5) * size[top], []
    for side in (-1, 1):
        k = top
        while 0 < k < len(rpm) - 1 and size[k] > level and size[k + side] <= size[k]:
            k += side
        if size[k] > level:
            return np.nan
        part = (size[k - side] - level) / (size[k - side] - size[k])
        ends.append(rpm[k - side] + part * (rpm[k] - rpm[k - side]))
    return rpm[top] / (ends[1] - ends[0])


def test_loads_and_unbalances():
    """Loads by moments about a journal, U = 2 · 6350 W/N of each antinode."""
    system, document = compressor()[0], whole()
    element = system.system.rotors["rotor"].element
    first, second = document["journals"]
    arm = element.center_of_gravity_m[2] - first["axial_m"]
    load = element.mass_kg * arm / (second["axial_m"] - first["axial_m"])
    assert first["bearing"] == "drive_end"
    assert second["load_kg"] == pytest.approx(load, rel=1e-9)
    assert first["load_kg"] == pytest.approx(element.mass_kg - load, rel=1e-9)
    kinds = {case["kind"]: case for case in compressor()[1]["cases"].values()}
    (static,) = kinds["static"]["unbalances"]
    assert static["moment_kg_m"] == pytest.approx(2 * 6350e-6 * element.mass_kg / HIGH)
    couple = kinds["couple"]["unbalances"]
    assert [u["phase_deg"] for u in couple] == [0.0, 180.0]
    wanted = [2 * 6350e-6 * journal["load_kg"] / HIGH for journal in (first, second)]
    assert [u["moment_kg_m"] for u in couple] == pytest.approx(wanted)
    # beyond the middles of the journals: cylinders, collar and coupling
    cylinders = np.array(
        [
            [0.036**2 * 0.14 + 0.040**2 * 0.04, 0.0],
            [0.040**2 * 0.04 + 0.034**2 * 0.06 + (0.085**2 - 0.034**2) * 0.025, 0.0],
        ]
    )
    steel = element_density()
    below, above = np.pi * steel * cylinders.sum(axis=1) + [7.0, 0.0]
    assert document["overhung_kg"] == pytest.approx([below, above], rel=1e-12)
    (overhung,) = kinds["overhung"]["unbalances"]
    assert overhung["moment_kg_m"] == pytest.approx(2 * 6350e-6 * below / HIGH)


def element_density():
    return scene_materials(scene_and_system()[0])["steel"].density_kg_per_m3


@pytest.mark.parametrize(("name", "laws"), SETS)
def test_peaks_and_margins(name, laws):
    compared = 0
    for case in whole()["bearing_cases"][name]["cases"].values():
        rpm, found = of_case(case, laws)
        for own in case["probes"].values():
            x, y = found[own["at"].partition(".")[2]].T
            angle = np.radians(own["angle_deg"])
            size = 2.0 * np.abs(np.cos(angle) * x + np.sin(angle) * y)
            inner = size[1:-1]
            tops = np.flatnonzero((inner > size[:-2]) & (inner > size[2:])) + 1
            tops = [t for t in tops if rpm[t] <= 1.5 * HIGH]
            for peak in own["peaks"]:
                top = min(tops, key=lambda t: abs(rpm[t] - peak["speed_rpm"]))
                assert peak["speed_rpm"] == pytest.approx(rpm[top], abs=12.5)
                assert peak["peak_to_peak_m"] == pytest.approx(size[top], rel=1e-4)
                factor = half_power(rpm, size, top)
                if np.isnan(factor):
                    assert peak["amplification_factor"] is None
                    continue
                assert peak["amplification_factor"] == pytest.approx(factor, rel=5e-3)
                below = rpm[top] < LOW
                margin = (LOW - rpm[top]) / LOW if below else (rpm[top] - HIGH) / HIGH
                assert abs(peak["margin"]) == pytest.approx(margin, abs=12.5 / LOW)
                if factor < 2.5:
                    assert peak["verdict"] == "not applicable"
                    continue
                asked = min(0.16, 0.17 * (1.0 - 1.0 / (factor - 1.5))) + (0.0 if below else 0.1)
                compared += 1
                assert peak["required_margin"] == pytest.approx(asked, abs=2e-3)
                assert peak["verdict"] == ("pass" if margin >= asked else "fail")
    assert compared >= (2 if laws else 3)


@pytest.mark.parametrize(("bearings", "laws"), SETS)
def test_vibration_and_clearances(bearings, laws):
    cases = whole()["bearing_cases"][bearings]["cases"]
    told = rows(whole(), "vibration", bearings)
    for (name, case), row in zip(cases.items(), told, strict=True):
        rpm, found = of_case(case, laws)
        inside = (rpm >= LOW) & (rpm <= HIGH)
        largest = 0.0
        for probe in ("drive_probe", "free_probe"):
            for angle in np.radians([45.0, 135.0]):
                along = found[probe] @ [np.cos(angle), np.sin(angle)]
                largest = max(largest, 2.0 * np.abs(along[inside]).max())
        assert row["where"].startswith(name) and row["verdict"] == "pass"
        assert row["value_m"] == case["largest_m"] == pytest.approx(largest, rel=1e-4)
        assert row["limit_m"] == 25.4e-6
        scale = min(25.4e-6 / largest, 6.0)
        assert case["scale_factor"] == pytest.approx(scale, rel=1e-4)
        for own, diametral in zip(case["clearances"], (0.4e-3, 0.5e-3), strict=True):
            x, y = found[own["at"].partition(".")[2]][rpm <= TRIP].T
            mean, half = (0.5 * (np.abs(x) ** 2 + s * np.abs(y) ** 2) for s in (1.0, -1.0))
            major = np.sqrt(mean + np.hypot(half, (x * y.conj()).real))
            assert own["scaled_m"] == pytest.approx(scale * 2.0 * major.max(), rel=2e-4)
            assert own["allowed_m"] == pytest.approx(0.75 * diametral)


def without_seal(cross_coupling, system=None):
    """All eigenvalues at the highest speed, the seal's matrices taken out by hand."""
    system = system or compressor()[0]
    seal = next(joint for joint in system.law_joints if joint.bearing == "labyrinth")
    return with_changes_by_hand(system, cross_coupling, seal)


def with_changes_by_hand(system, cross_coupling, left_out=None, at="seal"):
    """All eigenvalues at the highest speed with Q at one or several places."""
    speed = HIGH * RPM
    mass, damping, gyroscopic, stiffness = matrices_at_speed(system, speed)
    velocity = damping + gyroscopic
    if left_out is not None:
        k, c = left_out.coefficients(speed)
        stiffness = stiffness - left_out.motion.T @ k @ left_out.motion
        velocity = velocity - left_out.motion.T @ c @ left_out.motion
    for place, value in {at: cross_coupling}.items() if isinstance(at, str) else at:
        x, y = (interface_row(system, "rotor", place, c) for c in ("ux", "uy"))
        stiffness = stiffness + value * (np.outer(x, y) - np.outer(y, x))
    n = len(mass)
    lower = [-la.solve(mass, stiffness) / 500.0, -la.solve(mass, velocity)]
    return la.eigvals(np.block([[np.zeros((n, n)), 500.0 * np.eye(n)], lower]))


def decrement_at(values, hertz):
    own = values[np.abs(values.imag - 2 * np.pi * hertz).argmin()]
    assert own.imag == pytest.approx(2 * np.pi * hertz, rel=1e-8)
    return -2 * np.pi * own.real / own.imag


@pytest.mark.parametrize(("name", "laws"), SETS)
def test_levels_of_stability(name, laws):
    system = soft_system() if laws else compressor()[0]
    document = whole()
    found = document["bearing_cases"][name]
    level = found["level_1"]
    # q = 3 · 9.55 P/N · density ratio / (D H), both ratios 1.5
    each = [3 * 9.55 * 2e6 / HIGH * 1.5 / (0.4 * h) for h in (0.012, 0.009)]
    wanted = sum(each)
    assert level["expected_n_per_m"] == pytest.approx(wanted, rel=1e-12)
    assert list(level["applied_at"]) == ["rotor.seal"]
    # the mode whose frequency is told has the decrement that is told
    for value, decrement, hertz in zip(
        level["applied_n_per_m"], level["log_decrement"], level["frequency_hz"], strict=True
    ):
        if value in (0.0, wanted) or value == level["applied_n_per_m"][10]:
            by_hand = decrement_at(without_seal(value, system), hertz)
            assert decrement == pytest.approx(by_hand, rel=1e-7)
    lost = level["lost_at_n_per_m"]
    below, above = (without_seal(part * lost, system).real.max() for part in (0.9999, 1.0001))
    assert below < 0.0 < above
    assert level["times_expected"] == pytest.approx(lost / wanted)
    critical = HIGH / document["first_critical_on_rigid_supports_rpm"]
    assert level["critical_speed_ratio"] == pytest.approx(critical)
    assert level["mean_density_kg_per_m3"] == 22.5
    (row,) = rows(document, "level 1", name)
    # between 2 and 10 times QA, and in region A
    assert 2.0 < level["times_expected"] < 10.0 and level["region_b"] is False
    assert row["verdict"] == "pass" and row["value"] == level["log_decrement_at_expected"]
    base, seal, impellers, complete = found["level_2"]["rows"]
    assert base["log_decrement"] == pytest.approx(level["log_decrement"][0], rel=1e-9)
    assert impellers["cross_coupling_n_per_m"] == pytest.approx(wanted)
    places = list(zip(("impeller_1", "impeller_2"), each, strict=True))
    joint = next(joint for joint in system.law_joints if joint.bearing == "labyrinth")
    for told, by_hand in (
        (seal, with_changes_by_hand(system, 0.0)),
        (impellers, with_changes_by_hand(system, 0.0, joint, at=places)),
        (complete, with_changes_by_hand(system, 0.0, at=places)),
    ):
        decrement = decrement_at(by_hand, told["frequency_rpm"] / 60.0)
        assert told["log_decrement"] == pytest.approx(decrement, rel=1e-7)
    (row,) = rows(document, "level 2", name)
    assert row["value"] == complete["log_decrement"]


def test_the_worst_of_all_bearings_decides():
    document = whole()
    spare = {
        row["to_spare"]: row["bearings"]
        for row in document["clauses"]
        if row["to_spare"] is not None and row["verdict"] == "pass"
    }
    assert document["verdict"]["verdict"] == "pass"
    assert document["verdict"]["worst_to_spare"] == min(spare)
    assert f"bearings {spare[min(spare)]}" in document["verdict"]["why"]
    # what fails with one set fails
    tight = copy.deepcopy(document)
    for case in tight["bearing_cases"]["as in the scene"]["cases"].values():
        case["clearances"][0]["allowed_m"] = 0.5 * case["clearances"][0]["scaled_m"]
    found = {"clauses": clause_rows(tight)}
    verdicts = [{r["verdict"] for r in rows(found, "clearance", name)} for name, _ in SETS]
    assert verdicts == [{"fail", "pass"}, {"pass"}]
    assert verdict_of(found["clauses"])["verdict"] == "fail"


@pytest.fixture
def respond_to(monkeypatch):
    """Function: how many unbalances are responded to, where responses are not what is looked at."""

    def few(count):
        monkeypatch.setattr(
            bearing_cases, "unbalance_cases", lambda *asked: unbalance_cases(*asked)[:count]
        )

    return few


def test_level_1_takes_bearings_at_the_synchronous_frequency_unless_told(respond_to):
    """A film that depends on the frequency: by hand, frozen at N or at the mode."""
    respond_to(0)
    _, own = scene_and_system()
    omegas, ks, cs = [0.0, 600.0, 1200.0, 2400.0], [3e7, 4e7, 5e7, 8e7], [9e4, 7e4, 5e4, 2e4]
    stiffness, damping = (
        np.tile(np.array(row)[:, None, None] * np.eye(2), (2, 1, 1, 1)) for row in (ks, cs)
    )
    film = FrequencyTableLaw(
        name="film",
        speeds_rad_s=np.array([0.0, 2e3]),
        frequencies_rad_s=np.array(omegas),
        stiffness_n_per_m=stiffness,
        damping_n_s_per_m=damping,
        mass_kg=np.zeros((2, 4, 2, 2)),
        interpolation="linear",
    )
    parts = own.system
    bearings = tuple(
        replace(b, speed_law=film) if b.name != "labyrinth" else b for b in parts.bearings
    )
    system = assemble(parts.rotors, bearings, parts.reference)
    # no level 2, which takes every bearing at its own frequency: then level 1 has the seal as well
    places = ["rotor.impeller_1", "rotor.impeller_2"]
    decrements = {}
    for kind in ("synchronous", "own_frequency"):
        found = run(system, level_1_coefficients=kind, level_2=[], applied_at=places).document
        level = found["bearing_cases"]["as in the scene"]["level_1"]
        assert level["coefficients"] == kind
        assert any(f'"{kind}"' in line for line in found["assumptions"])
        hertz = level["frequency_hz"][0]
        omega = HIGH * RPM if kind == "synchronous" else 2 * np.pi * hertz
        frozen = with_pads(system, *(np.interp(omega, omegas, row) for row in (ks, cs)))
        decrements[kind] = level["log_decrement"][0]
        by_hand = decrement_at(with_changes_by_hand(frozen, 0.0), hertz)
        assert by_hand == pytest.approx(decrements[kind], rel=1e-6)
        # places of cross-coupling share as their stages do
        assert level["applied_at"] == pytest.approx({places[0]: 3 / 7, places[1]: 4 / 7})
    assert abs(decrements["synchronous"] / decrements["own_frequency"] - 1.0) > 0.01


def with_pads(system, stiffness, damping):
    """The same with constant bearings in place of pads."""
    parts = system.system
    bearings = tuple(
        replace(
            b, speed_law=None, stiffness_n_per_m=stiffness * np.eye(2),
            damping_n_s_per_m=damping * np.eye(2),
        )
        if b.name != "labyrinth"
        else b
        for b in parts.bearings
    )  # fmt: skip
    return assemble(parts.rotors, bearings, parts.reference)


def test_iso():
    system, document = compressor()[0], whole()
    iso, mass = document["iso"], system.system.rotors["rotor"].element.mass_kg
    borders = np.array([4800.0, 9000.0, 13200.0]) / np.sqrt(HIGH) * 1e-6
    assert iso["zone_borders_m"] == pytest.approx(borders)
    assert iso["zone"] == "A"
    whole_kg_m = 2.5e-3 * mass / (HIGH * RPM)
    shares = [journal["load_kg"] / mass for journal in document["journals"]]
    assert iso["in_planes_kg_m"] == pytest.approx([whole_kg_m * s for s in shares])
    # a quarter of B/C; how far vectors of the same unbalance move when pads are worn
    assert iso["significant_change_m"] == pytest.approx(0.25 * borders[1])
    change = iso["largest_change"]
    case = compressor()[1]["cases"][change["unbalance"]]
    rpm, stiff = of_case(case)
    _, soft = of_case(case, "soft")
    inside = (rpm >= LOW) & (rpm <= HIGH)
    largest = 0.0
    for probe in ("drive_probe", "free_probe"):
        for angle in np.radians([45.0, 135.0]):
            along = (soft[probe] - stiff[probe])[inside] @ [np.cos(angle), np.sin(angle)]
            largest = max(largest, 2.0 * np.abs(along).max())
    assert change["bearings"] == "most clearance"
    assert change["change_m"] == pytest.approx(largest, rel=2e-2)
    assert iso["change_is_significant"] == (largest > iso["significant_change_m"])


def test_verdicts(respond_to):
    """What fails, what is not told, and what old editions ask."""
    document_of_all, (_, document) = whole(), compressor()
    respond_to(1)
    strict = run(
        edition="legacy", minimum_speed_rpm=7500.0, level_2=[], unbalance_factor=4.0,
        overhangs=[{"bearing": "free_end", "mass_kg": 3.0}],
        clearances=[{"at": "rotor.seal", "diametral_m": 5e-5},
                    {"at": "rotor.seal", "diametral_m": 5e-5, "floating_ring": True}],
        stages=[{"at": "rotor.seal", "power_w": 2e7, "diameter_m": 0.4, "height_m": 0.01,
                 "density_ratio": 1.5}],
    )  # fmt: skip
    found = plain_data(strict.document)
    assert found["overhung_kg"] == pytest.approx([document_of_all["overhung_kg"][0], 3.0])
    assert strict.headline.startswith("FAIL by API 617, 6th edition")
    inside = [r for r in rows(found, "margin") if "inside" in r["note"]]
    assert any(r["verdict"] == "fail" for r in inside)
    kinds = [(r["verdict"], r["note"].partition(",")[0]) for r in rows(found, "clearance")]
    assert kinds[0][0] == "fail" and kinds[1] == ("not applicable", "floating ring")
    (level,) = rows(found, "level 1")
    assert level["verdict"] == "undecided" and "level_2 is not given" in level["note"]
    # twice the unbalance is twice the vibration, and clearances stay as they were while scaled
    for name, case in found["bearing_cases"]["as in the scene"]["cases"].items():
        if name in document["cases"]:
            before = document["cases"][name]["unbalances"][0]["moment_kg_m"]
            assert case["unbalances"][0]["moment_kg_m"] == pytest.approx(2.0 * before)
