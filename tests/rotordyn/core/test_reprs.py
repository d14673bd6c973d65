"""What records of rotordyn print: a few lines, the right numbers, units, no arrays."""

from __future__ import annotations

import re

import numpy as np
import pytest
from rotors import connect, one_rotor, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.core.reprs import row
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold

RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def system():
    wheel, seats = (0.2, 12, 0.12, 0.065), {"a": 0.0, "b": 0.6}
    shaft = steel_shaft("shaft", np.linspace(0, 0.6, 4), 0.02, seats, [wheel])
    return one_rotor(shaft, [connect(n, f"rotor.{n}", None, (5e7, 4e7), 800) for n in seats])


@pytest.fixture(scope="module")
def records(system):
    placed = [Unbalance(body="rotor", interface="a", moment_kg_m=1e-4)]
    response = unbalance_response(system, placed, np.linspace(0, 900, 31))
    rotor = system.system.rotors["rotor"]
    recorded = {"outputs": [rd.End(body="rotor", interface="a")], "bearings": ["a"]}
    run = run_up(system, ramp_and_hold(200.0, 0.05, 0.0), placed, step_s=1e-4, **recorded)
    return {
        "system": system,
        "parts": system.system,
        "rotor": rotor,
        "element": rotor.element,
        "bearing": system.system.bearings[0],
        "modes": rd.modes_at_speed(system, 100.0),
        "diagram": rd.campbell(system, np.linspace(0, 900, 7), branch_count=4),
        "critical": rd.critical_speeds(system, speed_max_rad_s=2000.0)[0],
        "map": critical_speed_map(
            system, ["a", "b"], [1e6, 1e8], branch_count=2, speed_max_rad_s=2000.0
        ),
        "response": response,
        "exciter": response.exciters[0],
        "run": run,
    }


def test_all_are_short_and_hold_no_arrays(records):
    for name, record in records.items():
        shown = repr(record)
        assert "array(" not in shown, name
        assert " object at 0x" not in shown, name
        assert len(shown.splitlines()) <= 10, name
        assert len(shown) < 700, name
        assert type(record).__name__ in shown.split("\n")[0], name


def test_numbers_are_those_of_the_records(records):
    diagram, critical = records["diagram"], records["critical"]
    lines = repr(diagram).split("\n")
    assert lines[0].startswith("Campbell: 4 branches, 7 speeds from 0 to 8594.37 rpm")
    for line, frequency in zip(lines[1:], diagram.frequency_hz, strict=True):
        ends = [float(text) for text in re.findall(r"([\d.]+) Hz", line)]
        # printed to two decimals
        np.testing.assert_allclose(ends, frequency[[0, -1]], atol=0.0051)
    rpm, hertz = re.findall(r"([\d.]+) (?:rpm|Hz)", repr(critical))
    # synchronous excitation: the frequency is the speed in turns per second
    assert float(hertz) == pytest.approx(float(rpm) / 60.0, abs=0.006)
    assert f"{critical.speed_rad_s / RPM:.2f} rpm" in repr(critical)


def test_mass_of_the_body_is_told(records):
    # shaft π r² L ρ and the disk
    mass = np.pi * 0.02**2 * 0.6 * 7800.0 + 12.0
    assert f"{mass:.5g} kg" in repr(records["element"])
    assert f"{mass:.5g} kg" in repr(records["system"])
    assert "a 0, b 0.6 m" in repr(records["element"])


def test_a_bearing_tells_what_is_not_zero(records):
    assert repr(records["bearing"]) == (
        "Bearing 'a', rotor.a to ground: k 5e+07 in x, 4e+07 in y N/m; c 800 N s/m"
    )
    end = rd.End(body="r", interface="a")
    cross = connect("s", end, end, [[1, 2], [-2, 1.0]])
    assert repr(cross) == "Bearing 's', r.a to r.a: k [1 2; -2 1] N/m"
    assert repr(connect("n", end)).endswith("to ground: nothing")
    assert "rigid ux uy" in repr(connect("n", end, rigid=("ux", "uy")))


def test_the_largest_orbit_is_told(records):
    response = records["response"]
    major = np.nan_to_num(response.exciters[0].orbits().major_m)
    at = np.unravel_index(major.argmax(), major.shape)[0]
    assert f"largest orbit {major.max():.4g} m" in repr(response)
    assert f"{response.speeds_rad_s[at] / RPM:.6g} rpm" in repr(response).split("\n")[1]


def test_the_force_of_a_run_up_is_told(records):
    force = np.linalg.norm(records["run"].force_n[0, :2], axis=0).max()
    assert f"a: largest force {force:.4g} N" in repr(records["run"])


def test_many_are_counted(system):
    assert row("abc") == "a, b, c"
    assert row("abcdefghi") == "a, b, c, d, e, f, and 3 more"
    rotor = system.system.rotors["rotor"]
    many = rd.assemble({f"r{k}": turning(rotor.element) for k in range(30)}, ())
    assert len(repr(many).splitlines()) <= 10
    assert "more bodies" in repr(many)
    first, second = (rd.End(body=name, interface="a") for name in ("r0", "r1"))
    gear = rd.Gear(name="g", first=first, second=second, ratio=1.0)
    geared = rd.System(rotors={f"r{k}": rotor for k in range(2)}, bearings=(), gears=(gear,))
    assert repr(geared).endswith("\n  no bearings\n  1 gear: g")
