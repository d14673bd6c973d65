"""Every check of bodies and systems finds what it is for, names it, and passes what is good."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.rotordyn import (
    InternalDamping,
    Rotor,
    assemble,
    beam_superelement,
    campbell,
    check_superelement,
    critical_speeds,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.checks.mode_checks import check_modes_at_rest
from solidwhirl.rotordyn.checks.mode_counts import (
    full_spectrum,
    is_counted_by_signs,
    modes_below,
)
from solidwhirl.rotordyn.checks.plain_checks import ROOTS, check_campbell
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.checks.system_checks import (
    check_critical_speeds,
    check_matrices,
    check_system,
)

RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def inner(twin_bodies):
    return twin_bodies()[0]


def bad(checks):
    return {check.name for check in checks if check.passed is False}


def changed(array, index, factor):
    copy = np.array(array)
    copy[index] *= factor
    return copy


# Bodies: one damage, one check.


def _pair(element, factor):
    """K with the last pair of modes changed alike in both planes."""
    matrix = np.array(element.stiffness)
    for k in (-1, -2):
        matrix[k, k] *= factor
    return matrix


ALL = "all frequencies and responses of the body"
DAMAGES = [
    (lambda e: {"mass_kg": 1.001 * e.mass_kg}, "mass properties", ALL),
    (lambda e: {"gyroscopic": -e.gyroscopic}, "polar inertia of the tilts", "splitting of forward"),
    (lambda e: {"stiffness": _pair(e, 1.0 + 1e-6)}, "modal frequencies", "frequencies that modes"),
    (
        lambda e: {"spin_softening": 1e-3 * e.mass},
        "stress stiffening and spin softening cancel in rigid motion",
        "low frequencies of the body at speed",
    ),
    (
        lambda e: {"recovery_modes": 1.000001 * e.recovery_modes},
        "rigid motion in pictures",
        "pictures of mode shapes",
    ),
    (
        lambda e: {"mass": changed(e.mass, (-1, -1), -1.0)},
        "mass positive definite",
        ALL,
    ),
    (
        lambda e: {"spin_generator": -e.spin_generator},
        "the same after a turn about the axis",
        "sense of the whirl",
    ),
]


@pytest.mark.parametrize(("damage", "name", "concerns"), DAMAGES)
def test_one_damage_fails_its_own_check(inner, damage, name, concerns):
    # moments would see most of these too
    damaged = dataclasses.replace(inner, moments=None, **damage(inner))
    found = [c for c in check_superelement(damaged) if c.passed is False]
    assert [c.name for c in found] == [name]
    assert found[0].where == inner.name
    assert found[0].concerns.startswith(concerns)


def _moment(element, name, index, factor):
    moments = element.moments
    parts = {f.name: getattr(moments, f.name) for f in dataclasses.fields(moments)}
    array = changed(parts[name], index, factor)
    if name == "second_kg":  # the same product seen from the other side
        a, b, j, k = index
        array[b, a, k, j] = array[a, b, j, k]
    return dataclasses.replace(moments, **{**parts, name: array})


@pytest.mark.parametrize(
    ("name", "index", "names"),
    [
        ("displacement_kg", (0, 0), {"moments of rigid motion"}),
        ("first_kg_m", (2, 1, -1), {"moments of rigid motion"}),
        ("second_kg", (2, 2, -1, -1), {"moments against the mass"}),
        ("second_kg", (0, 1, -2, -1), {"moments against G"}),
    ],
)
def test_damaged_moments_are_found(inner, name, index, names):
    assert not bad(check_superelement(inner))
    damaged = dataclasses.replace(inner, moments=_moment(inner, name, index, 1.0 + 1e-6))
    assert bad(check_superelement(damaged)) == names


def test_moments_tell_the_sign_of_spin(inner):
    """G and L of the other sense agree with each other, and not with the moments."""
    other = dataclasses.replace(
        inner, gyroscopic=-inner.gyroscopic, spin_generator=-inner.spin_generator
    )
    assert "moments against G" in bad(check_superelement(other))


@pytest.mark.parametrize(("mode", "found"), [(0, True), (-1, False)])
def test_a_solid_may_mix_orders_in_the_modes_that_its_mesh_does_not_resolve(inner, mode, found):
    """G off by a tenth of the inertia in the lowest or the highest pair of modes of the basis."""
    modal = np.flatnonzero([c.kind == "modal" for c in inner.coordinates])
    stiff = np.diag(inner.stiffness)[modal] / np.diag(inner.mass)[modal]
    pair = np.sort(modal[np.argsort(stiff)][[0, 1] if mode == 0 else [-2, -1]])
    i, j = pair
    gyroscopic = np.array(inner.gyroscopic)
    gyroscopic[i, j] += 0.1 * inner.mass[i, i]
    gyroscopic[j, i] -= 0.1 * inner.mass[i, i]
    solid = dataclasses.replace(inner, level="solid", gyroscopic=gyroscopic)
    assert ("moments against G" in bad(check_superelement(solid))) == found


def test_lost_torsional_inertia_is_named(with_axial_and_torsion, inner):
    """A disk whose interface lacks rz: its polar inertia takes no part in torsion."""
    element = beam_superelement(
        "s", [0.0, 0.5], 0.02, 0.0, (2e11, 0.3, 7800.0), {"a": 0.0, "b": 0.5}
    )
    whole = with_axial_and_torsion(element, 0.5, 0.02, "a", "b")
    assert not bad(check_superelement(whole))
    tensor = whole.inertia_kg_m2 + 0.1 * np.eye(3)
    lost = dataclasses.replace(whole, inertia_kg_m2=tensor)
    check = next(c for c in check_superelement(lost) if c.name == "mass properties")
    assert check.passed is False
    assert check.concerns == "torsional frequencies"
    assert "inertia of rz" in check.reason


def test_loss_of_stiffness_comes_with_its_speed(inner, with_stress):
    """K2 = −f M on elastic motion: the lowest free mode ω loses its stiffness at ω/√f.

    By stress alone: what the spin takes of lateral motion is held by Coriolis forces.
    """
    stressed = with_stress(inner, -0.5)
    pressed, still = stressed.stress_stiffening - stressed.spin_softening, np.zeros_like(inner.mass)
    softened = dataclasses.replace(
        stressed, stress_stiffening=pressed, spin_softening=still, maximum_speed_rad_s=1.0
    )
    spun = dataclasses.replace(softened, stress_stiffening=still, spin_softening=-pressed)
    assert "takes 0.0e+00 of" in _stiffness_left(spun).reason
    modes = inner.rigid_body_modes[:, inner.rigid_body_present]
    out = np.eye(inner.size) - modes @ la.pinv(modes)
    even = 0.5 * out.T @ inner.mass @ out
    change = -0.5 * (even + even.T)
    momentum = inner.mass @ modes
    projector = np.eye(inner.size) - modes @ la.solve(modes.T @ momentum, momentum.T)
    values, vectors = la.eigh(inner.stiffness, inner.mass)
    elastic = vectors[:, 4:] / np.sqrt(values[4:])
    theta = la.eigvalsh(elastic.T @ projector.T @ change @ projector @ elastic)[0]
    speed = 1.0 / np.sqrt(-theta)
    for factor, passed in ((0.99, True), (1.01, False)):
        element = dataclasses.replace(softened, maximum_speed_rad_s=factor * speed)
        check = _stiffness_left(element)
        assert check.passed is passed
        # value is a part of the stiffness, so the square of the speed ratio
        assert check.value == pytest.approx(factor**2, rel=1e-9)
    assert f"{speed:.6g} rad/s" in check.reason


def _stiffness_left(element):
    return next(
        c for c in check_superelement(element) if c.name == "stiffness left at the top speed"
    )


def test_good_bodies_pass(hub, inner, twin_bodies, three_disk_element):
    casing = rigid_superelement(
        "casing", 10.0, [0.1, 0.2, 0.3], [1.0, 2.0, 2.5], {"a": 0.0, "b": [0.0, 0.3, 1.0]}
    )
    held = hub(stiffness=np.diag([1e6, 1e6, 1e4, 1e4]), name="held")
    for element in (casing, held, hub(), *twin_bodies(), three_disk_element(2)):
        assert not bad(check_superelement(element)), element.name


# Systems.


@pytest.fixture(scope="module")
def systems(twin, three_disk, one_rotor, ground, twin_bodies, with_stress):
    """Conservative and damped, isotropic or not, free bodies, stiff and soft supports."""
    free = twin_bodies()[0]
    return {
        "two planes": twin(),
        "stiff": twin(support=1e16),
        "soft": twin(support=1e2),
        "pinned": twin(support=None),
        "isotropic": one_rotor(free, [ground("rotor", at, 1e7) for at in ("A", "B")]),
        "free": assemble({"rotor": Rotor(element=free, speed_ratio=1.0)}, ()),
        "half free": one_rotor(with_stress(free, 0.1), [ground("rotor", "A", 1e7)]),
        "damped": three_disk(),
        "damped isotropic": one_rotor(free, [ground("rotor", at, 1e7, cx=1e3) for at in "AB"]),
    }


CONSERVATIVE = ("two planes", "stiff", "soft", "pinned", "isotropic", "free", "half free")
DAMPED = ("damped", "damped isotropic")


@pytest.fixture(scope="module")
def results(systems):
    """Modes at rest, diagram and critical speeds of every system."""
    speeds = np.linspace(0.0, 3000.0, 7)
    return {
        name: (
            modes_at_speed(system, 0.0),
            campbell(system, speeds, branch_count=6),
            critical_speeds(system, 1.0, 3000.0) if name != "free" else (),
        )
        for name, system in systems.items()
    }


@pytest.mark.parametrize("name", CONSERVATIVE + DAMPED)
def test_good_systems_pass(systems, results, name):
    at_rest, diagram, critical = results[name]
    checks = check_system(
        systems[name], at_rest, diagram, {1.0: critical} if critical else {}, speed_max_rad_s=3000.0
    )
    assert not bad(checks)
    open_ = {c.name for c in checks if c.passed is None}
    if name in DAMPED:
        assert open_ == {
            "orthogonality of the modes",
            "elastic energy equals kinetic",
        }
        assert all("damping" in c.reason for c in checks if c.passed is None)
    else:
        assert not open_


@pytest.mark.parametrize("name", CONSERVATIVE + DAMPED)
def test_a_wrong_eigenvalue_fails(systems, results, name):
    """1e-6 on the lowest eigenvalue at rest, and on one point of the diagram."""
    at_rest, diagram, _ = results[name]
    values = changed(at_rest.eigenvalues, 0, 1.0 + 1e-6)
    wrong = dataclasses.replace(at_rest, eigenvalues=values)
    found = bad(check_modes_at_rest(systems[name], wrong))
    energy = set() if name in DAMPED else {"elastic energy equals kinetic"}
    assert found == {"residual of every eigenpair", ROOTS} | energy
    values = changed(diagram.eigenvalues, (1, 4), 1.0 + 1e-6)
    wrong = dataclasses.replace(diagram, eigenvalues=values)
    checks = check_campbell(systems[name], wrong)
    assert ROOTS in bad(checks) <= {ROOTS, "no mode is missing"}
    assert "Campbell" in checks[0].concerns
    assert f"{2000.0 / RPM:.6g} rpm" in checks[0].reason


def test_modes_that_are_not_orthogonal_fail(systems, results):
    """Two modes of one frequency may be mixed, but not made oblique."""
    at_rest = results["isotropic"][0]
    shapes = np.array(at_rest.shapes)
    shapes[:, 1] += 1e-3 * shapes[:, 0]
    oblique = dataclasses.replace(at_rest, shapes=shapes)
    assert bad(check_modes_at_rest(systems["isotropic"], oblique)) == {"orthogonality of the modes"}


def branches(diagram, rows):
    """The diagram with some of its branches."""
    fields = ("eigenvalues", "frequency_hz", "log_decrement", "whirl", "overlap")
    return dataclasses.replace(diagram, **{f: getattr(diagram, f)[rows] for f in fields})


@pytest.mark.parametrize("name", CONSERVATIVE)
def test_a_dropped_mode_is_missed(systems, results, name):
    at_rest, diagram, _ = results[name]
    kept = np.arange(at_rest.eigenvalues.size) != 2
    fewer = dataclasses.replace(
        at_rest,
        eigenvalues=at_rest.eigenvalues[kept],
        shapes=at_rest.shapes[:, kept],
    )
    assert bad(check_modes_at_rest(systems[name], fewer)) == {"no mode is missing"}
    # a branch that is lost
    less = branches(diagram, [0, 2, 3, 4, 5])
    assert bad(check_campbell(systems[name], less)) == {"no mode is missing"}
    # two branches on one mode
    twice = branches(diagram, [0, 0, 2, 3, 4, 5])
    if abs(diagram.eigenvalues[1, -1] / diagram.eigenvalues[0, -1] - 1.0) > 1e-3:
        assert bad(check_campbell(systems[name], twice)) == {"no mode is missing"}


def test_a_mode_missing_at_one_speed_is_found(systems, results):
    """One branch stops short: the speed and the frequency of what is missing are said."""
    system, diagram = systems["two planes"], results["two planes"][1]
    eigenvalues = diagram.eigenvalues.copy()
    eigenvalues[2, 4] = np.nan
    less = dataclasses.replace(diagram, eigenvalues=eigenvalues)
    checks = check_campbell(system, less, branch_count=6)
    assert bad(checks) == {"no mode is missing"}
    rpm = diagram.speeds_rad_s[4] * 30.0 / np.pi
    assert checks[-1].reason == f"missing: at {rpm:.6g} rpm {diagram.frequency_hz[2, 4]:.6g} Hz"


def test_all_modes_below_a_frequency_are_demanded(systems):
    """With a frequency limit the branches are all modes below it, at every speed."""
    system = systems["two planes"]
    diagram = campbell(system, np.linspace(0.0, 3000.0, 7), frequency_max_hz=900.0)
    assert not bad(check_campbell(system, diagram, 900.0))
    less = branches(diagram, slice(1, None))
    assert bad(check_campbell(system, less, 900.0)) == {"no mode is missing"}


@pytest.mark.parametrize("name", CONSERVATIVE + DAMPED)
def test_signs_count_what_the_full_spectrum_has(systems, name):
    """Modes below frequencies between those of the spectrum; damped and free systems have none."""
    plain = PlainSystem.of(systems[name])
    for speed in (0.0, 700.0, 3000.0):
        matrices = plain.at(speed)
        counts = is_counted_by_signs(matrices)
        assert counts == (name in CONSERVATIVE and "free" not in name), speed
        rising = np.sort(full_spectrum(matrices, 500.0).imag)
        rising = rising[rising > 0.0]
        apart = np.flatnonzero(np.diff(rising) > 1e-6 * rising[1:])
        for k in apart if counts else ():
            assert modes_below(matrices, 0.5 * (rising[k] + rising[k + 1])) == k + 1


@pytest.mark.parametrize("name", [n for n in CONSERVATIVE if n != "free"])
def test_a_lost_or_wrong_critical_speed_fails(systems, results, name):
    critical = results[name][2]
    assert critical
    found = check_critical_speeds(systems[name], critical[1:], 1.0, 3000.0)
    assert bad(found) == {"no critical speed is missing"}
    first = critical[0]
    wrong = dataclasses.replace(first, speed_rad_s=first.speed_rad_s * (1.0 + 1e-6))
    found = check_critical_speeds(systems[name], (wrong, *critical[1:]), 1.0, 3000.0)
    assert bad(found) == {ROOTS}
    assert all(c.concerns == "critical speeds" for c in found)


@pytest.mark.parametrize("name", DAMPED)
def test_a_wrong_damped_critical_speed_fails(systems, results, name):
    first, *others = results[name][2]
    wrong = dataclasses.replace(first, log_decrement=first.log_decrement + 1e-4)
    found = check_critical_speeds(systems[name], (wrong, *others), 1.0, 3000.0)
    assert bad(found) == {ROOTS}


def test_a_critical_speed_at_the_end_is_on_neither_side(systems, results):
    critical = results["two planes"][2]
    limit = critical[-1].speed_rad_s
    found = check_critical_speeds(systems["two planes"], critical, 1.0, limit)
    assert not bad(found)
    assert bad(check_critical_speeds(systems["two planes"], critical[1:], 1.0, limit))


def test_matrices_of_a_system(systems):
    system = systems["two planes"]
    assert not bad(check_matrices(system))
    wrong = dataclasses.replace(system, gyroscopic=changed(system.gyroscopic, (2, 3), 1 + 1e-6))
    assert bad(check_matrices(wrong)) == {"gyroscopic skew"}
    index = np.unravel_index(np.abs(np.triu(system.mass, 1)).argmax(), system.mass.shape)
    wrong = dataclasses.replace(system, mass=changed(system.mass, index, 1 + 1e-6))
    assert "mass symmetric" in bad(check_matrices(wrong))
    wrong = dataclasses.replace(system, mass=changed(system.mass, (-1, -1), -1.0))
    assert bad(check_matrices(wrong)) == {"mass positive definite"}


def test_cross_coupled_bearings_have_no_symmetry(one_rotor, ground, inner):
    seal = dataclasses.replace(
        ground("rotor", "A", 1e7),
        stiffness_n_per_m=np.array([[1e7, 1e5], [-1e5, 1e7]]),
    )
    checks = check_matrices(one_rotor(inner, [seal]))
    assert [c.name for c in checks if c.passed is None] == ["stiffness symmetric"]


def test_internal_damping_is_checked_by_residuals(ground, inner):
    rotor = Rotor(
        element=inner,
        speed_ratio=1.0,
        internal_damping=InternalDamping(stiffness_coefficient_s=1e-6),
    )
    system = assemble({"rotor": rotor}, tuple(ground("rotor", at, 1e7) for at in "AB"))
    diagram = campbell(system, [0.0, 1000.0, 2000.0], branch_count=4)
    checks = check_campbell(system, diagram)
    assert not bad(checks) and checks[1].passed


def test_a_check_that_can_not_be_made_does_not_end_the_run(systems, results, monkeypatch):
    from solidwhirl.rotordyn import AnalysisError
    from solidwhirl.rotordyn.checks import plain_checks

    def fails(*_):
        raise AnalysisError("no")

    monkeypatch.setattr(plain_checks, "check_campbell", fails)
    at_rest, diagram, _ = results["two planes"]
    checks = check_system(systems["two planes"], at_rest, diagram, {})
    assert [(c.where, c.reason) for c in checks if c.passed is None] == [("Campbell diagram", "no")]


def test_rigid_motion_of_a_body_is_not_damped_from_within(inner):
    """C R = 0, to the roundings of C and not to their root."""
    material = InternalDamping(modal_ratio=1e-2)
    rotor = Rotor(element=inner, speed_ratio=1.0, internal_damping=material)
    plain = PlainSystem.of(assemble({"rotor": rotor}, ()))
    damping = plain.at(0.0).velocity
    rigid = inner.rigid_body_modes[:, inner.rigid_body_present]
    force, size = np.abs(damping @ rigid), np.abs(damping) @ np.abs(rigid)
    assert damping.any()
    assert (force <= 1e-12 * size).all()
