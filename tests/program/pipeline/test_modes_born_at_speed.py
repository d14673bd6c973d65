"""Scenes with modes that do not oscillate at the first speed: the diagram holds them all the same.

Sizes are chosen so that the rigid limit (Ip/It) Ω of the precession has the frequency named.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

VERIFY = Path(__file__).parents[2] / "verify"
RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def general():
    """The solver of rigid bodies by numpy and scipy alone."""
    sys.path.insert(0, str(VERIFY))
    import general_solver

    yield general_solver
    sys.path.remove(str(VERIFY))


def tube():
    """Free hollow titanium rotor: Ip/It = 6 s / (3 s + L²), s = R² + r²; 55.29 Hz at 250 Hz."""
    squares = 0.05**2 + 0.04**2
    length = np.sqrt(squares * (6.0 / (55.29 / 250.0) - 3.0))
    section = {
        **{"name": "tube", "start_m": 0.0, "end_m": float(length)},
        **{"outer_radius_m": 0.05, "inner_radius_m": 0.04},
    }
    middle = {"name": "m", "kind": "outer", "start_m": 0.14, "end_m": 0.16}
    body = {"material": "titanium", "sections": [section], "interfaces": [middle]}
    return {"bodies": {"rotor": body}, "model": {"level": "beam"}}


def disk():
    """Free steel beam with a disk at its middle: 101.97 Hz at 100 Hz."""
    radius, length, diametral = 0.01, 0.2, 0.02
    mass = 7850.0 * np.pi * radius**2 * length
    tilt = diametral + mass * (length**2 / 12.0 + radius**2 / 4.0)
    wheel = {
        **{"name": "disk", "at_m": 0.1, "mass_kg": 8.0, "diametral_inertia_kg_m2": diametral},
        "polar_inertia_kg_m2": float(1.0197 * tilt - mass * radius**2 / 2.0),
    }
    beam = {
        **{"material": "iron", "stations_m": np.linspace(0.0, length, 9).tolist()},
        **{"outer_radius_m": [radius], "disks": [wheel], "interfaces": {"m": 0.1}},
    }
    iron = {"density_kg_per_m3": 7850.0, "youngs_modulus_pa": 2.1e11, "poissons_ratio": 0.3}
    return {"materials": {"iron": iron}, "beams": {"rotor": beam}}


def solved(content, rpm, first=0.0):
    """Frequencies [Hz] and whirl of the diagram at the last speed, and all results."""
    results = run_scene(
        parse_scene(
            {
                "name": "free",
                "speeds": {"from_rpm": first, "to_rpm": rpm, "count": 5},
                "campbell": {"frequency_max_hz": 600.0},
                "analyses": [{"kind": "mode_shapes", "speeds_rpm": [rpm], "modes": 8}],
                **content,
            }
        )
    )
    assert not [check for check in results.checks if check.passed is False]
    diagram = results.campbell
    there = np.isfinite(diagram.frequency_hz[:, -1])
    order = np.argsort(diagram.frequency_hz[there, -1])
    return diagram.frequency_hz[there, -1][order], diagram.whirl[there, -1][order], results


@pytest.mark.parametrize(
    ("content", "rpm", "wanted"), [(tube, 15000.0, 55.29), (disk, 6000.0, 101.97)]
)
def test_a_free_rotor_has_its_precession(content, rpm, wanted):
    frequency, whirl, results = solved(content(), rpm)
    # bending gives way a little
    assert (1.0 - 5e-4) * wanted < frequency[0] < wanted
    assert whirl[0] == "forward"
    # it is born: nothing oscillates so slowly at rest
    assert not (results.campbell.frequency_hz[:, 0] < 2.0 * wanted).any()
    later, _, _ = solved(content(), rpm, 0.5 * rpm)
    np.testing.assert_allclose(later, frequency, rtol=1e-9)
    (shapes,) = results.analyses["mode_shapes"].document["speeds"]
    listed = np.array(shapes["frequency_hz"])
    np.testing.assert_allclose(listed[listed < 600.0], frequency, rtol=1e-9)


def spools():
    """Spool on two bearings, and one of opposite speed that hangs on it at one place alone."""

    def spool(ratio, mass, tilt, polar):
        return {
            **{"speed_ratio": ratio, "mass_kg": mass, "center_of_gravity_m": [0.0, 0.0, 0.13]},
            **{"inertia_kg_m2": [tilt, tilt, polar], "interfaces": {"a": 0.0, "b": 0.3}},
        }

    return {
        "rigid_bodies": {"lp": spool(1.0, 12.0, 0.3, 0.1), "hp": spool(-1.6, 7.0, 0.1, 0.14)},
        "bearings": [
            {"name": "front", "first": "lp.a", "stiffness_n_per_m": [[3e6, 0.0], [0.0, 3e6]]},
            {"name": "rear", "first": "lp.b", "stiffness_n_per_m": [[2e6, 0.0], [0.0, 2e6]]},
            {
                "name": "between",
                "first": "lp.b",
                "second": "hp.b",
                "stiffness_n_per_m": [[1e6, 0.0], [0.0, 1e6]],
            },
        ],
    }


def test_two_coupled_spools_have_seven_branches(general):
    content = spools()
    frequency, _, results = solved(content, 9000.0)
    assert np.isfinite(results.campbell.frequency_hz[:, 0]).sum() == 6
    assert frequency.size == 7
    system = general.general(content)
    for column, speed in zip(
        results.campbell.frequency_hz.T, results.campbell.speeds_rad_s, strict=True
    ):
        found = general.spectrum(system, speed)
        values = found.values[general.motions(found)].imag
        wanted = np.sort(values[(values > 0.0) & (values < 1200.0 * np.pi)]) / (2.0 * np.pi)
        np.testing.assert_allclose(np.sort(column[np.isfinite(column)]), wanted, rtol=1e-9)
    later, _, _ = solved(content, 9000.0, 4000.0)
    np.testing.assert_allclose(later, frequency, rtol=1e-9)
