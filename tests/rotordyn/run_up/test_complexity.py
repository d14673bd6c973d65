"""Bodies without modes and rigid bodies against statics, closed forms and projections."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.rotordyn import (
    AnalysisError,
    Bearing,
    End,
    Gear,
    Rotor,
    SuperelementError,
    assemble,
    beam_superelement,
    check_superelement,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.coordinates import body_rows, interface_row
from solidwhirl.rotordyn.beams.shafts import Disk
from solidwhirl.rotordyn.modes.modal_truncation import project_system
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.complexity import (
    as_rigid_body,
    compare_complexity,
    rigid_bodies_system,
    system_with,
    without_modes,
)
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold


def shaft(modulus=2e11, components=("ux", "uy", "rx", "ry")):
    disks = [
        Disk(name="d", position_m=0.5, mass_kg=20.0, polar_kg_m2=0.6, diametral_kg_m2=0.35),
        Disk(name="e", position_m=1.0, mass_kg=8.0, polar_kg_m2=0.2, diametral_kg_m2=0.1),
    ]
    return beam_superelement(
        "shaft", np.linspace(0.0, 1.0, 7), 0.03, 0.0, (modulus, 0.3, 7800.0),
        {"left": 0.0, "middle": 0.5, "right": 0.9}, disks, components,
    )  # fmt: skip


def casing():
    return beam_superelement(
        "casing",
        np.linspace(0.0, 1.0, 5),
        0.3,
        0.29,
        (7e10, 0.3, 2700.0),
        {"left": 0.0, "right": 0.9},
    )


def engine(element=None, damping=300.0):
    def spring(name, first, second, k):
        return Bearing(
            name=name,
            first=first,
            second=second,
            stiffness_n_per_m=k * np.diag([1.0, 0.8]),
            damping_n_s_per_m=damping * np.eye(2),
        )

    ends = [(End(body="shaft", interface=at), End(body="casing", interface=at))
            for at in ("left", "right")]  # fmt: skip
    bearings = [spring(f"bearing {a.interface}", a, b, 4e7) for a, b in ends]
    bearings += [spring(f"mount {b.interface}", b, None, 5e6) for _, b in ends]
    rotors = {
        "shaft": Rotor(element=element or shaft(), speed_ratio=1.0),
        "casing": Rotor(element=casing(), speed_ratio=0.0),
    }
    return assemble(rotors, tuple(bearings), "shaft")


def test_without_modes_keeps_statics_and_rigid_motion():
    element = shaft()
    reduced = without_modes(element)
    assert reduced.size == 12 and element.size > 20
    assert all(result.passed for result in check_superelement(reduced))
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
    full, small, rigid = engine(), engine(without_modes(shaft())), engine(as_rigid_body(shaft()))
    found = [modes_at_speed(s, 0.0, count=10).frequency_hz for s in (full, small, rigid)]
    # each holds the motion further: Rayleigh's principle (damping of 1e-3 shifts less than 1e-5)
    assert (found[1] >= found[0] * (1 - 1e-5)).all()
    assert (found[2] >= found[1] * (1 - 1e-5)).all()
    assert found[1][-1] > found[0][-1] * 1.001 and found[2][-1] > found[1][-1] * 1.01


@pytest.mark.parametrize("speed", [0.0, 600.0])
def test_rigid_body_is_the_one_made_from_mass_and_inertia(speed):
    element = shaft()
    other = rigid_superelement(
        "shaft", element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2,
        {node.name: node.position_m for node in element.interfaces}, ("ux", "uy", "rx", "ry"),
    )  # fmt: skip
    found = modes_at_speed(rigid_bodies_system(engine(), ["shaft"]), speed)
    expected = modes_at_speed(engine(other), speed)
    np.testing.assert_allclose(found.eigenvalues[:12], expected.eigenvalues[:12], rtol=1e-7)


def test_rigid_bodies_are_a_projection_on_undeformed_motion():
    full = engine()
    rows = body_rows(full, "shaft")
    motions = full.system.rotors["shaft"].element.rigid_body_modes[:, [0, 1, 3, 4]]
    deformed = rows - motions @ np.linalg.pinv(motions) @ rows
    scale = 1.0 / np.sqrt(np.diag(full.mass))
    basis = scale[:, None] * la.null_space(deformed * scale, rcond=1e-9)
    projected = project_system(full, basis)
    rigid = rigid_bodies_system(full, ["shaft"])
    assert rigid.size == projected.size < full.size
    for speed in (0.0, 500.0):
        found = modes_at_speed(rigid, speed, count=8).eigenvalues
        expected = modes_at_speed(projected, speed, count=8).eigenvalues
        np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_rigid_rotor_on_two_springs_has_closed_form_frequencies(ground):
    element = shaft()
    k1, k2 = 3e6, 5e6
    system = assemble(
        {"shaft": Rotor(element=element, speed_ratio=1.0)},
        (ground("shaft", "left", k1), ground("shaft", "right", k2)),
    )
    z = element.center_of_gravity_m[2]
    a, b = 0.0 - z, 0.9 - z
    stiffness = np.array([[k1 + k2, k1 * a + k2 * b], [k1 * a + k2 * b, k1 * a**2 + k2 * b**2]])
    mass = np.diag([element.mass_kg, element.inertia_kg_m2[0, 0]])
    expected = np.sqrt(la.eigh(stiffness, mass, eigvals_only=True)) / (2 * np.pi)
    rigid = rigid_bodies_system(system, ["shaft"])
    assert rigid.size == 4
    found = modes_at_speed(rigid, 0.0).frequency_hz
    np.testing.assert_allclose(found, np.repeat(expected, 2), rtol=1e-10)


def test_gears_survive_the_exchange_of_a_body():
    parts = ("ux", "uy", "rx", "ry", "rz")
    fan = beam_superelement("fan", [0.0, 0.4], 0.05, 0.0, (2e11, 0.3, 7800.0), {"seat": 0.4},
                            components=parts)  # fmt: skip
    held = [
        Bearing(name=f"{body} {at}", first=End(body=body, interface=at),
                stiffness_n_per_m=1e7 * np.eye(2), tilt_stiffness_n_m_per_rad=1e5 * np.eye(2))
        for body, at in (("shaft", "left"), ("shaft", "right"), ("fan", "seat"))
    ]  # fmt: skip
    gear = Gear(name="gear", first=End(body="shaft", interface="left"),
                second=End(body="fan", interface="seat"), ratio=0.3)  # fmt: skip
    rotors = {
        "shaft": Rotor(element=shaft(components=parts), speed_ratio=1.0),
        "fan": Rotor(element=fan, speed_ratio=0.3),
    }
    system = assemble(rotors, tuple(held), "shaft", (gear,))
    rigid = rigid_bodies_system(system, ["shaft", "fan"])
    # two rigid bodies of five motions each, one gear between their torsions
    assert rigid.size == 9
    turn = np.linalg.pinv(rigid.transformation) @ np.concatenate(
        [r.element.rigid_body_modes[:, 5] * r.speed_ratio for r in rotors.values()]
    )
    polar = [r.element.inertia_kg_m2[2, 2] * r.speed_ratio**2 for r in rotors.values()]
    assert turn @ rigid.mass @ turn == pytest.approx(sum(polar), rel=1e-9)


UNBALANCE = [Unbalance(body="shaft", interface="middle", moment_kg_m=1e-3)]


def test_comparison_measures_what_flexibility_is_worth():
    options = {
        "bearing": "mount left",
        "step_s": 2e-4,
        "bands_hz": [(10.0, 35.0), (35.0, 75.0)],
        "band_hz": 2.0,
    }
    profile = ramp_and_hold(500.0, 1.0)
    full = engine()
    found = compare_complexity(
        {
            "full": full,
            "again": engine(),
            "no modes": system_with(full, {"shaft": without_modes(shaft())}),
            "rigid": rigid_bodies_system(full, ["shaft"]),
        },
        profile,
        UNBALANCE,
        **options,
    )
    assert found.names == ("full", "again", "no modes", "rigid")
    assert found.sizes[0] == full.size and list(found.sizes) == sorted(found.sizes, reverse=True)
    assert not found.peak_error[:2].any() and not found.band_error[:2].any()
    # less flexibility, larger errors, first of all at the bending resonance in the upper band
    assert (np.diff(found.band_error[1:], axis=0) > 0).all()
    assert found.band_error[3, 1] > 0.1 > found.band_error[2, 0]
    assert (found.wall_time_s > 0).all() and (found.peak_force_n > 0).all()

    # 500 rad/s are 79.6 Hz: a band beyond it has nothing to compare, one across it has a part
    beyond = {**options, "bands_hz": [(10.0, 35.0), (35.0, 300.0), (100.0, 300.0)]}
    some = {"full": full, "rigid": rigid_bodies_system(full, ["shaft"])}
    cut = compare_complexity(some, profile, UNBALANCE, **beyond)
    assert cut.band_error[1, 0] == found.band_error[3, 0]
    assert np.isfinite(cut.band_error[:, 1]).all() and np.isnan(cut.band_error[:, 2]).all()

    # a shaft 1e3 times as stiff is a rigid one
    stiff = engine(shaft(2e14))
    variants = {"stiff": stiff, "rigid": rigid_bodies_system(stiff, ["shaft"])}
    near = compare_complexity(variants, profile, UNBALANCE, **options)
    assert near.band_error[1].max() < 0.02 and abs(near.peak_error[1]) < 0.01


def test_what_makes_no_sense_is_refused(hub):
    element = shaft()
    modal = [i for i, c in enumerate(element.coordinates) if c.kind == "modal"]
    with pytest.raises(AnalysisError, match=r"\['nose'\]; there are \['shaft', 'casing'\]"):
        rigid_bodies_system(engine(), ["nose"])
    with pytest.raises(AnalysisError, match=r"no bodies \['nose'\]"):
        system_with(engine(), {"nose": element})
    with pytest.raises(SuperelementError, match="has no rigid motion"):
        as_rigid_body(hub(stiffness=np.eye(4)))
    nothing = dataclasses.replace(
        element,
        coordinates=tuple(element.coordinates[i] for i in modal),
        **{
            name: getattr(element, name)[np.ix_(modal, modal)]
            for name in ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
        },
        rigid_body_modes=element.rigid_body_modes[modal],
        recovery_modes=element.recovery_modes[:, :, modal],
        spin_generator=None,
        moments=None,
    )
    with pytest.raises(SuperelementError, match="has no interface coordinates"):
        without_modes(nothing)
    arguments = (ramp_and_hold(100.0, 0.1), UNBALANCE)
    options = {"bearing": "mount left", "step_s": 1e-3}
    with pytest.raises(AnalysisError, match="no models to compare"):
        compare_complexity({}, *arguments, bands_hz=[(0, 1)], **options)
    with pytest.raises(AnalysisError, match="each needs 0 <= low < high"):
        compare_complexity({"full": engine()}, *arguments, bands_hz=[(5.0, 1.0)], **options)
    with pytest.raises(AnalysisError, match="no response between 900 and 950 Hz"):
        compare_complexity({"full": engine()}, *arguments, bands_hz=[(900.0, 950.0)], **options)
