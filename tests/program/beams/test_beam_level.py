"""The beam level: closed forms, invariants, refusals, and the harmonic level as judge."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
import shapes

from solidwhirl.beams.body import beam_element_of, beam_variants
from solidwhirl.beams.error import VARIANTS
from solidwhirl.beams.profile import BeamLevelError, skeleton_of
from solidwhirl.beams.sections import weighted
from solidwhirl.geometry import MATERIALS, Interface, RigidDisk, mass_properties
from solidwhirl.model.bodies import build_bodies
from solidwhirl.rotordyn import Rotor, assemble, check_superelement, modes_at_speed
from solidwhirl.scene_reading.reader import read_scene

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")


def seated(body, **changes):
    """The body with other first interface."""
    first = dataclasses.replace(body.interfaces[0], **changes)
    return dataclasses.replace(body, interfaces=(first, *body.interfaces[1:]))


def mixed(bodies):
    """Two materials, fillets, a rigid disk off its interface."""
    body = bodies["rim"]
    sections = (
        body.sections[0],
        *(dataclasses.replace(s, material=MATERIALS["titanium"]) for s in body.sections[1:]),
    )
    disk = RigidDisk(
        name="blades",
        interface="p1",
        mass_kg=2.0,
        polar_inertia_kg_m2=0.02,
        diametral_inertia_kg_m2=0.011,
        offset_m=0.03,
    )
    return dataclasses.replace(body, sections=sections, rigid_disks=(disk,), fillet_radius_m=2e-3)


@pytest.mark.verify
def test_mass_properties_and_invariants(beam_bodies, root):
    bodies = {**beam_bodies, "mixed": mixed(beam_bodies)}
    for scene in ("uhbr_lp", "uhbr_hp", "uhbr_fan", "ferraris_paper"):
        built = build_bodies(read_scene(root / "scenes" / f"{scene}.toml"))
        bodies |= {f"{scene}.{name}": body for name, body in built.items()}
    for name, body in bodies.items():
        element = beam_element_of(body, components=ALL)
        assert [node.name for node in element.interfaces] == [i.name for i in body.interfaces]
        exact = mass_properties(body)
        assert element.mass_kg == pytest.approx(exact.mass_kg, rel=1e-12), name
        centre = element.center_of_gravity_m[2]
        assert centre == pytest.approx(exact.center_of_gravity_m[2], rel=1e-12), name
        inertia = [exact.diametral_inertia_kg_m2] * 2 + [exact.polar_inertia_kg_m2]
        assert np.diag(element.inertia_kg_m2) == pytest.approx(inertia, rel=1e-12), name
        for check in check_superelement(element):
            assert check.passed, (name, check)
            exact_checks = ("mass properties", "polar inertia of the tilts")
            if name in beam_bodies and check.name in exact_checks:
                # of the matrices: quadrature and rigid motion are exact
                assert check.value < 1e-13, (name, check)


def pinned_timoshenko(radius, length, count):
    """Exact angular frequencies of a pinned shaft (Timoshenko 1921), lower branch."""
    steel = MATERIALS["steel"]
    e, nu, rho = steel.youngs_modulus_pa, steel.poissons_ratio, steel.density_kg_per_m3
    area, second = np.pi * radius**2, np.pi * radius**4 / 4
    shear = weighted(nu, 0.0) * e / (2 * (1 + nu)) * area
    out = []
    for n in range(1, count + 1):
        k = n * np.pi / length
        a = (rho * second) * (rho * area) / shear
        b = -(rho * area + rho * second * k**2 + e * second * k**2 * rho * area / shear)
        out.append(np.sqrt((-b - np.sqrt(b**2 - 4 * a * e * second * k**4)) / (2 * a)))
    return np.array(out)


def pinned(element):
    """Angular frequencies in the plane of x with ux held at both ends."""
    plane = [
        k
        for k, c in enumerate(element.coordinates)
        if (c.kind == "modal" and k % 2 == 0) or c.component == "ry"
    ]
    at = np.ix_(plane, plane)
    return np.sqrt(la.eigh(element.stiffness[at], element.mass[at], eigvals_only=True))


def test_uniform_shaft_is_that_of_timoshenko(beam_bodies):
    exact = pinned_timoshenko(0.02, 0.6, 5)
    coarse, fine = (
        pinned(beam_element_of(beam_bodies["uniform"], element_length_m=h, modes=None))[:5]
        for h in (0.01, 0.005)
    )
    # second order in the element length, below 5e-4 with the 60 elements of the default
    assert coarse == pytest.approx(exact, rel=5e-4)
    # extrapolated, what is left is of fourth order: (5/120)^4 = 3e-6
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(exact, rel=5e-6)
    # statically exact shapes leave out the shear of the distributed inertia within an element
    longer = [
        pinned(beam_element_of(beam_bodies["uniform"], element_length_m=h, modes=None))[3]
        for h in (0.06, 0.03, 0.015)
    ]
    errors = np.array(longer) / exact[3] - 1.0
    rates = np.log2(errors[:-1] / errors[1:])
    assert np.all((rates > 1.9) & (rates < 2.5)), rates


def test_rods_of_a_uniform_shaft(beam_bodies):
    steel = MATERIALS["steel"]
    element = beam_element_of(beam_bodies["uniform"], components=ALL, modes=None)
    for motion, modulus in (
        ("uz", steel.youngs_modulus_pa),
        ("rz", steel.youngs_modulus_pa / (2 * (1 + steel.poissons_ratio))),
    ):
        start = [element.interface_index(name, motion) for name in ("p0", "p1")]
        own = [k for k in range(element.size) if np.abs(element.mass[start, k]).max() > 0]
        at = np.ix_(own, own)
        omega = np.sqrt(np.abs(la.eigh(element.stiffness[at], element.mass[at], eigvals_only=True)))
        exact = np.pi / 0.6 * np.sqrt(modulus / steel.density_kg_per_m3)
        # linear elements: (π/60)²/24 = 1.2e-4
        assert omega[1] == pytest.approx(exact, rel=1.5e-4)


def test_thin_cone_loaded_at_its_apex_is_free_of_shear(body_of):
    # membrane theory: a force F at the apex bends the cone with M = F z and shears nothing, so
    # the work is that of ∫ M²/(E I cos⁴α) with E I = E π r³ t, t in radial direction
    slope, wall, near, far = 0.5, 1e-5, 0.2, 0.4
    body = body_of(
        ("cone", near, far, (slope * near, slope * far), (slope * near + wall, slope * far + wall)),
        planes=[(near,), (far,)],
    )
    element = beam_element_of(body, modes=None)
    free = [element.interface_index("p0", c) for c in ("ux", "ry")]
    held = element.stiffness[np.ix_(free, free)]
    load = np.array([1.0, -near])  # a force at z = 0, carried to the end
    work = load @ np.linalg.solve(held, load)
    steel = MATERIALS["steel"]
    radius = lambda z: slope * z + 0.5 * wall  # noqa: E731
    points, weights = np.polynomial.legendre.leggauss(20)
    z = near + 0.5 * (far - near) * (points + 1.0)
    bending = steel.youngs_modulus_pa * np.pi * radius(z) ** 3 * wall / (1 + slope**2) ** 2
    exact = 0.5 * (far - near) * float(weights @ (z**2 / bending))
    # the apex of the middle surface is off by half a wall: 1e-5/0.1
    assert work == pytest.approx(exact, rel=3e-4)


def test_disk_splits_into_plate_and_shaft(beam_bodies):
    skeleton = skeleton_of(beam_bodies["reference"])
    (plate,) = skeleton.plates
    assert (plate.cells[0].inner_m, plate.cells[0].outer_m) == (0.02, 0.15)
    assert plate.inner is not None and plate.outer is None
    assert all(c.outer_m(c.start_m) == 0.02 for c in skeleton.columns)
    drum = skeleton_of(beam_bodies["drum"])
    assert [p.inner is not None and p.outer is not None for p in drum.plates] == [True, True]
    collar = skeleton_of(beam_bodies["collar"])  # wider than high: part of the shaft
    assert not collar.plates and collar.columns[1].outer_m(0.16) == 0.06


def test_interfaces_at_one_place_move_as_one(beam_bodies):
    body = beam_bodies["reference"]
    both = (
        *body.interfaces,
        Interface(name="seat", kind="outer", coupling="distributing", start_m=0.35, end_m=0.37),
        Interface(name="plane", kind="section", coupling="distributing", start_m=0.36, end_m=0.36),
    )
    element = beam_element_of(dataclasses.replace(body, interfaces=both))
    assert element.constraint is not None
    assert all(check.passed for check in check_superelement(element))
    plain = beam_element_of(dataclasses.replace(body, interfaces=both[:3]))
    speed = 1000.0
    found, expected = (
        modes_at_speed(assemble({"rotor": Rotor(element=e, speed_ratio=1.0)}, ()), speed, 8)
        for e in (element, plain)
    )
    # the plane cuts the seat: five rings stand for it, not three, and the modes left out differ
    assert found.frequency_hz == pytest.approx(expected.frequency_hz, rel=1e-5, abs=1e-6)
    assert expected.frequency_hz.max() > 400.0


def test_rigid_slab_is_rigid(beam_bodies):
    slab = Interface(name="slab", kind="slab", coupling="rigid", start_m=0.25, end_m=0.35)
    body = dataclasses.replace(
        beam_bodies["uniform"], interfaces=(*beam_bodies["uniform"].interfaces, slab)
    )
    element = beam_element_of(body, modes=None)
    inside = np.abs(element.recovery_points_m[:, 2] - 0.3) < 0.0501
    assert inside.sum() > 5
    x = element.recovery_modes[inside, 0]
    lever = element.recovery_points_m[inside, 2] - 0.3
    expected = np.outer(
        np.ones_like(lever), np.eye(element.size)[element.interface_index("slab", "ux")]
    )
    expected += np.outer(lever, np.eye(element.size)[element.interface_index("slab", "ry")])
    assert np.abs(x - expected).max() < 1e-12


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda b: seated(b["drum"], start_m=0.3, end_m=0.3), "parts that bend apart"),
        (
            lambda b: seated(
                b["reference"], kind="face", start_m=0.145, end_m=0.145, radius_m=(0.05, 0.1)
            ),
            "flat of a disk",
        ),
        (
            lambda b: seated(
                shapes.body(
                    shapes.section("shaft", 0.0, 0.4, 0.005, 0.02),
                    interfaces=[shapes.plane("p0", 0.0)],
                ),
                kind="inner",
                start_m=0.1,
                end_m=0.12,
            ),
            "bore of 0.005 m in a shaft of 0.02 m",
        ),
        (lambda b: dataclasses.replace(b["drum"], interfaces=()), "at least one interface"),
    ],
)
def test_refusals_name_the_place(beam_bodies, change, message):
    with pytest.raises(BeamLevelError, match=message):
        beam_element_of(change(beam_bodies))


def test_steep_cones_and_bad_arguments_are_refused(body_of, beam_bodies):
    steep = body_of(
        ("a", 0.0, 0.1, 0.0, 0.02), ("b", 0.1, 0.11, (0.005, 0.105), (0.02, 0.12)), planes=[(0.0,)]
    )
    with pytest.raises(BeamLevelError, match="'b' is a cone of slope 10"):
        beam_element_of(steep)
    with pytest.raises(BeamLevelError, match="components"):
        beam_element_of(beam_bodies["step"], components=("ux", "uy"))
    with pytest.raises(BeamLevelError, match="element_length_m is 0"):
        beam_element_of(beam_bodies["step"], element_length_m=0.0)


def test_variants_have_the_same_coordinates_and_rules_order_the_stiffness(beam_bodies):
    variants = [*beam_variants(beam_bodies["reference"])]
    nominal = beam_element_of(beam_bodies["reference"])
    assert np.array_equal(variants[0].stiffness, nominal.stiffness)
    for variant in variants[1:]:
        labels = [(c.kind, c.interface, c.component) for c in variant.coordinates]
        assert labels == [(c.kind, c.interface, c.component) for c in nominal.coordinates]
    found = [v.free_frequencies_hz[0] for v in variants]
    first = dict(zip((v.name for v in VARIANTS), found, strict=True))
    assert first["soft"] < first["nominal"] < first["stiff"]
    assert first["nominal"] < first["rigid roots"]
    assert first["nominal"] < first["shear doubled"]


@pytest.mark.solver
@pytest.mark.parametrize(
    ("name", "limits"),
    [
        # measured: below these; what a beam can do, in per cent, modes 1 to 3
        ("uniform", (0.03, 0.03, 0.06)),
        ("taper", (0.03, 0.05, 0.05)),
        ("thin disk", (0.3, 0.4, 0.4)),
        ("reference", (0.4, 0.7, 1.8)),
        ("step", (0.8, 1.0, 0.6)),
        ("drum", (0.5, 0.4, 1.2)),
        ("rim", (1.3, 1.2, 0.5)),
    ],
)
def test_free_frequencies_are_those_of_the_harmonic_level(harmonic, beam_bodies, name, limits):
    found = beam_element_of(beam_bodies[name]).free_frequencies_hz[:6:2]
    exact = harmonic(name).free_frequencies_hz[:6:2]
    assert np.all(100.0 * np.abs(found / exact - 1.0) < limits)


@pytest.mark.solver
def test_whirl_of_a_thin_disk_at_speed(harmonic, beam_bodies):
    speed = 2.0 * np.pi * 200.0
    exact, found = (
        modes_at_speed(
            assemble({"rotor": Rotor(element=e, speed_ratio=1.0)}, ()), speed, 10
        ).frequency_hz
        for e in (harmonic("thin disk", speed), beam_element_of(beam_bodies["thin disk"]))
    )
    elastic = exact > 1.0
    assert elastic.sum() >= 5
    # without stiffening the second, the backward mode of the disk, is more than 4 % off
    assert found[elastic][:5] == pytest.approx(exact[elastic][:5], rel=1e-2)


def test_torsion_of_a_disk_on_a_light_shaft(body_of):
    # two disks on a shaft without weight: ω² = (G J/l)(1/I1 + 1/I2), rigid in torsion to 1e-3
    light = dataclasses.replace(MATERIALS["steel"], name="light", density_kg_per_m3=1.0)
    body = body_of(
        ("shaft", 0.0, 1.0, 0.0, 0.01, light),
        ("one", 0.1, 0.12, 0.01, 0.08),
        ("two", 0.88, 0.9, 0.01, 0.1),
        planes=[(0.0,), (1.0,)],
    )
    element = beam_element_of(body, components=ALL, modes=None)
    start = element.interface_index("p0", "rz")
    own = [k for k in range(element.size) if element.mass[start, k] != 0.0]
    at = np.ix_(own, own)
    values = la.eigh(element.stiffness[at], element.mass[at], eigvals_only=True)
    polar = [0.5 * np.pi * 7800.0 * 0.02 * (radius**4 - 0.01**4) for radius in (0.08, 0.1)]
    spring = 2e11 / 2.6 * 0.5 * np.pi * 0.01**4 / 0.78
    exact = np.sqrt(spring * sum(1.0 / value for value in polar))
    found = np.sqrt(values[values > 1.0][0])
    # the disks stiffen the shaft over a part of their width: at most 0.02/0.78 in ω²
    assert exact < found < exact * (1.0 + 0.5 * 0.02 / 0.78)
