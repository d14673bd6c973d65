"""Roots, critical speeds and unstable ranges with laws over the frequency and controllers.

A rigid rotor of 10 kg on two bearings; what is expected was found by Newton's method on det D(s)
and by dense counts, outside of this project.
"""

from __future__ import annotations

import numpy as np
import pytest
from rotors import one_rotor

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyTableLaw
from solidwhirl.rotordyn.assembly.magnetic_laws import MagneticLaw
from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.bearings.controllers import pid, side_by_side
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing
from solidwhirl.rotordyn.core.spectrum import spectrum
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.paths.frequency_roots import frequency_roots
from solidwhirl.rotordyn.stability.intervals import unstable_intervals
from solidwhirl.rotordyn.superelement.rigid_body import rigid_superelement

HZ = 2.0 * np.pi


def _rotor(laws):
    """10 kg at 0.1 m of a length of 0.3 m on a law at 0 and one, or springs, at 0.3 m."""
    element = rigid_superelement(
        "rotor",
        10.0,
        (0.0, 0.0, 0.1),
        (0.1, 0.1, 0.15),
        {"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 0.3)},
        ("ux", "uy", "rx", "ry"),
    )
    bearings = []
    for name, law in zip("ab", laws, strict=True):
        own = (
            {"speed_law": law}
            if law is not None
            else {
                "stiffness_n_per_m": 2e6 * np.eye(2),
                "damping_n_s_per_m": 100.0 * np.eye(2),
            }
        )
        bearings.append(rd.Bearing(name=name, first=rd.End(body="rotor", interface=name), **own))
    return one_rotor(element, bearings)


def _table(frequencies_hz, stiffness, damping=100.0):
    matrices = np.array([np.array(k) * np.eye(2) if np.ndim(k) == 0 else k for k in stiffness])
    shape = (2, len(frequencies_hz), 2, 2)
    return FrequencyTableLaw(
        name="table",
        speeds_rad_s=np.array([0.0, 1000.0]),
        frequencies_rad_s=HZ * np.array(frequencies_hz),
        stiffness_n_per_m=np.broadcast_to(matrices, shape),
        damping_n_s_per_m=np.broadcast_to(damping * np.eye(2), shape),
        mass_kg=np.zeros(shape),
        interpolation="linear",
    )


def test_a_pair_born_at_a_fold_opens_the_unstable_range():
    """Cross-coupling in a window of 0.2 Hz: unstable from 8305.4207 rpm, where the pair is born."""
    cross = np.array([[1e6, 3e5], [-3e5, 1e6]])
    system = _rotor(
        [_table([0, 76.8, 77.0, 77.2, 77.4, 300.0], [1e6, 1e6, cross, cross, 1e6, 1e6]), None]
    )
    (found,) = unstable_intervals(system, 8300.0 * RAD_S_PER_RPM, 8310.0 * RAD_S_PER_RPM)
    assert found.low_rad_s == pytest.approx(8305.4207 * RAD_S_PER_RPM, rel=1e-7)
    assert found.opens
    assert not found.closes
    assert found.eigenvalue == pytest.approx(38.657 + 77.0j * HZ, rel=1e-4)
    roots = frequency_roots(operator_of(system), 8600.0 * RAD_S_PER_RPM)
    assert [root.sign for root in roots] == [1, 1, -1, 1, 1, 1]
    assert max(root.residual for root in roots) < 1e-11
    # the fold's other root is shown, marked, and told of once
    speeds = np.array([8310.0, 8600.0, 9000.0]) * RAD_S_PER_RPM
    diagram = rd.campbell(system, speeds, frequency_max_hz=200.0)
    (note,) = (note for note in diagram.notes if note.kind == "steep law")
    marked = diagram.eigenvalues[note.branches[0]]
    assert np.nanmin(np.abs(marked - roots[2].value)) < 1e-6 * abs(roots[2].value)


def test_controllers_are_states():
    """A PID of both axes: as many roots as states, each one of det D(s) with H(s) written out."""
    gains = 20_000.0, 400_000.0, 60.0
    one = pid(*gains, roll_off_rad_s=5e4)
    law = MagneticLaw(
        name="magnet",
        bearing=MagneticBearing(
            current_stiffness_n_per_a=100.0,
            negative_stiffness_n_per_m=4e5,
            controller=side_by_side(one, one),
        ),
    )
    system, speed = _rotor([law, law]), 300.0
    operator = operator_of(system)
    found = spectrum(operator, speed)
    assert found.values.size == operator.root_count == 2 * system.size + operator.states
    for value in found.values[found.values.imag > 1.0]:
        p, i, d = gains
        own = 100.0 * (p + i / value + d * value / (1.0 + value / 5e4)) - 4e5
        dynamic = system.stiffness + value * speed * system.gyroscopic + value**2 * system.mass
        for joint in system.law_joints:
            dynamic = dynamic + own * joint.motion[:2].T @ joint.motion[:2]
        scale = 1.0 / np.sqrt(np.abs(np.diag(dynamic)))
        singular = np.linalg.svd(scale[:, None] * dynamic * scale, compute_uv=False)
        assert singular[-1] < 1e-8 * singular[0]
    # an integrator alone had such critical speeds "lost"
    speeds = rd.critical_speeds(system, 1.0, 3000.0)
    for critical in speeds:
        assert critical.eigenvalue.imag == pytest.approx(critical.speed_rad_s, rel=1e-9)
