"""Bodies without modes and rigid bodies against statics, closed forms and projections."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, hub, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import body_rows, interface_row
from solidwhirl.rotordyn.modes.modal_truncation import project_system
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up import complexity
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold


def shaft(modulus=2e11, components=("ux", "uy", "rx", "ry")):
    disks = [(0.5, 20.0, 0.6, 0.35), (1.0, 8.0, 0.2, 0.1)]
    seats = {"left": 0.0, "middle": 0.5, "right": 0.9}
    own = {"material": (modulus, 0.3, 7800.0), "components": components}
    return steel_shaft("shaft", np.linspace(0.0, 1.0, 7), 0.03, seats, disks, **own)


def engine(element=None):
    ends = {"left": 0.0, "right": 0.9}
    light = {"inner": 0.29, "material": (7e10, 0.3, 2700.0)}
    casing = steel_shaft("casing", np.linspace(0.0, 1.0, 5), 0.3, ends, **light)
    bearings = []
    for at in ends:
        inner = (f"shaft.{at}", f"casing.{at}", (4e7, 3.2e7), 300.0)
        bearings.append(connect(f"bearing {at}", *inner))
        bearings.append(connect(f"mount {at}", f"casing.{at}", None, (5e6, 4e6), 300.0))
    rotors = {"shaft": turning(element or shaft()), "casing": turning(casing, 0.0)}
    return rd.assemble(rotors, tuple(bearings), "shaft")


def test_without_modes_keeps_statics_and_rigid_motion():
    element = shaft()
    reduced = complexity.without_modes(element)
    assert reduced.size == 12 and element.size > 20
    assert all(result.passed for result in rd.check_superelement(reduced))
    full, small = engine(), engine(reduced)
    sag = []
    for system in (full, small):
        load = interface_row(system, "shaft", "middle", "ux")
        place = la.solve(system.stiffness, load)
        rows = [interface_row(system, "shaft", at, "ux") for at in ("left", "middle")]
        sag.append(np.array(rows) @ place)
    # statics is exact: what is dropped has no static part
    np.testing.assert_allclose(sag[1], sag[0], rtol=1e-9)


def test_without_modes_frequencies_lie_above_those_of_the_full_model():
    bodies = (shaft(), complexity.without_modes(shaft()), complexity.as_rigid_body(shaft()))
    found = [rd.modes_at_speed(engine(b), 0.0, count=10).frequency_hz for b in bodies]
    # each holds the motion further: Rayleigh's principle (damping of 1e-3 shifts less than 1e-5)
    assert (found[1] >= found[0] * (1 - 1e-5)).all()
    assert (found[2] >= found[1] * (1 - 1e-5)).all()
    assert found[1][-1] > found[0][-1] * 1.001 and found[2][-1] > found[1][-1] * 1.01


def test_rigid_bodies_are_a_projection_on_undeformed_motion():
    full = engine()
    rows = body_rows(full, "shaft")
    motions = full.system.rotors["shaft"].element.rigid_body_modes[:, [0, 1, 3, 4]]
    deformed = rows - motions @ np.linalg.pinv(motions) @ rows
    scale = 1.0 / np.sqrt(np.diag(full.mass))
    basis = scale[:, None] * la.null_space(deformed * scale, rcond=1e-9)
    projected = project_system(full, basis)
    rigid = complexity.rigid_bodies_system(full, ["shaft"])
    assert rigid.size == projected.size < full.size
    for speed in (0.0, 500.0):
        found = rd.modes_at_speed(rigid, speed, count=8).eigenvalues
        expected = rd.modes_at_speed(projected, speed, count=8).eigenvalues
        np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_gears_survive_the_exchange_of_a_body():
    parts = ("ux", "uy", "rx", "ry", "rz")
    fan = steel_shaft("fan", [0.0, 0.4], 0.05, {"seat": 0.4}, components=parts)
    places = ("shaft.left", "shaft.right", "fan.seat")
    held = [connect(at, at, stiffness=1e7, tilt=1e5) for at in places]
    first, second = rd.End(body="shaft", interface="left"), rd.End(body="fan", interface="seat")
    gear = rd.Gear(name="gear", first=first, second=second, ratio=0.3)
    rotors = {"shaft": turning(shaft(components=parts)), "fan": turning(fan, 0.3)}
    system = rd.assemble(rotors, tuple(held), "shaft", (gear,))
    rigid = complexity.rigid_bodies_system(system, ["shaft", "fan"])
    # two rigid bodies of five motions each, one gear between their torsions
    assert rigid.size == 9
    turn = np.linalg.pinv(rigid.transformation) @ np.concatenate(
        [r.element.rigid_body_modes[:, 5] * r.speed_ratio for r in rotors.values()]
    )
    polar = [r.element.inertia_kg_m2[2, 2] * r.speed_ratio**2 for r in rotors.values()]
    assert turn @ rigid.mass @ turn == pytest.approx(sum(polar), rel=1e-9)


UNBALANCE = [Unbalance(body="shaft", interface="middle", moment_kg_m=1e-3)]


def test_comparison_measures_what_flexibility_is_worth():
    # 500 rad/s are 79.6 Hz: a band beyond it has nothing to compare, one across it has a part
    options = {
        "bearing": "mount left", "step_s": 2e-4, "band_hz": 2.0,
        "bands_hz": [(10.0, 35.0), (35.0, 75.0), (35.0, 300.0), (100.0, 300.0)],
    }  # fmt: skip
    profile = ramp_and_hold(500.0, 1.0)
    full = engine()
    models = {
        "full": full,
        "no modes": complexity.system_with(full, {"shaft": complexity.without_modes(shaft())}),
        "rigid": complexity.rigid_bodies_system(full, ["shaft"]),
    }
    found = complexity.compare_complexity(models, profile, UNBALANCE, **options)
    assert found.names == ("full", "no modes", "rigid")
    assert found.sizes[0] == full.size and list(found.sizes) == sorted(found.sizes, reverse=True)
    assert not found.peak_error[0].any() and not found.band_error[0, :3].any()
    # less flexibility, larger errors, first of all at the bending resonance in the upper band
    assert (np.diff(found.band_error[1:, :2], axis=0) > 0).all()
    assert found.band_error[2, 1] > 0.1 > found.band_error[1, 0]
    assert (found.wall_time_s > 0).all() and (found.peak_force_n > 0).all()
    assert np.isfinite(found.band_error[:, 2]).all() and np.isnan(found.band_error[:, 3]).all()

    # a shaft 1e3 times as stiff is a rigid one
    stiff = engine(shaft(2e14))
    variants = {"stiff": stiff, "rigid": complexity.rigid_bodies_system(stiff, ["shaft"])}
    near = complexity.compare_complexity(variants, profile, UNBALANCE, **options)
    assert near.band_error[1, :2].max() < 0.02 and abs(near.peak_error[1]) < 0.01


def test_what_makes_no_sense_is_refused():
    element = shaft()
    modal = [i for i, c in enumerate(element.coordinates) if c.kind == "modal"]
    with pytest.raises(rd.AnalysisError, match=r"\['nose'\]; there are \['shaft', 'casing'\]"):
        complexity.rigid_bodies_system(engine(), ["nose"])
    with pytest.raises(rd.AnalysisError, match=r"no bodies \['nose'\]"):
        complexity.system_with(engine(), {"nose": element})
    with pytest.raises(rd.SuperelementError, match="has no rigid motion"):
        complexity.as_rigid_body(hub(stiffness=np.eye(4)))
    names = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    parts = {name: getattr(element, name)[np.ix_(modal, modal)] for name in names}
    nothing = dataclasses.replace(
        element, coordinates=tuple(element.coordinates[i] for i in modal), **parts,
        rigid_body_modes=element.rigid_body_modes[modal], spin_generator=None, moments=None,
        recovery_modes=element.recovery_modes[:, :, modal], error_forms=(),
    )  # fmt: skip
    with pytest.raises(rd.SuperelementError, match="has no interface coordinates"):
        complexity.without_modes(nothing)
    arguments = (ramp_and_hold(100.0, 0.1), UNBALANCE)
    options = {"bearing": "mount left", "step_s": 1e-3}
    for models, band, text in (
        ({}, (0, 1), "no models to compare"),
        ({"full": engine()}, (5.0, 1.0), "each needs 0 <= low < high"),
        ({"full": engine()}, (900.0, 950.0), "no response between 900 and 950 Hz"),
    ):
        with pytest.raises(rd.AnalysisError, match=text):
            complexity.compare_complexity(models, *arguments, bands_hz=[band], **options)
