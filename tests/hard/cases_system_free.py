"""Hard cases of assembled systems: rigid motions at any speed, bodies without support."""

from __future__ import annotations

import numpy as np
from builders_system import engine, free_rad_s, hub, joint, shaft

from solidwhirl.rotordyn import critical_speeds, modes_at_speed

SPEEDS = (0.0, 0.01, 1.0, 30.0, 1000.0, 3000.0)


def _wrong_zeros(system, trains: int, axial: int = 0) -> float:
    """Zeros too many or too few, and motions that grow or die, over the speeds.

    Free lateral motion of a train that turns has 6 zeros and a nutation, at rest 8 zeros; free
    axial motion and torsion have 2 zeros each.
    """
    wrong = 0
    for speed in SPEEDS:
        modes = modes_at_speed(system, speed)
        expected = trains * ((8 if speed == 0.0 else 6) + axial)
        wrong += abs(modes.zero_count - expected) + modes.real_eigenvalues.size
        wrong += int(np.count_nonzero(modes.eigenvalues.real))
    return float(wrong)


def _free_zeros(element, axial: int) -> float:
    return _wrong_zeros(_free(element), 1, axial)


def _train_zeros(element) -> float:
    return _wrong_zeros(_two_free(element), 2)


def _rigid_nutation() -> float:
    """Nutation of a free rigid disk against Ω Ip/It, from a turn in 2 hours to 1e5 rad/s."""
    errors = []
    for polar in (0.09, 0.0999, 0.005):
        system = engine({"disk": hub(polar_kg_m2=polar)}, ())
        for speed in (1e-3, 1.0, 100.0, 1e5):
            found = modes_at_speed(system, speed).eigenvalues
            if found.size != 1:
                return np.inf
            errors.append(abs(found[0] / (1j * speed * polar / 0.05) - 1.0))
    return float(max(errors))


def _slow_nutation(element) -> float:
    """Nutation of a free flexible body at low speed against Ω Ip/It about its centre of mass.

    Bending lowers it by a part of (Ω/ω1)², 1e-8 here.
    """
    system = engine({"body": element}, ())
    speed = 1e-4 * free_rad_s(element)[0]
    polar, diametral = element.inertia_kg_m2[2, 2], element.inertia_kg_m2[0, 0]
    found = modes_at_speed(system, speed).eigenvalues[0]
    return float(abs(found / (1j * speed * polar / diametral) - 1.0))


def _shaken() -> float:
    """Frequencies of two free bodies on one soft spring against the two-body closed form.

    Rigid hubs m1, m2 joined by k: ω² = k (1/m1 + 1/m2) and six zeros of the common motion more.
    """
    errors = []
    for spring in (1e-3, 1.0, 1e6):
        bodies = {"first": hub(10.0, name="first"), "second": hub(1e-2, name="second")}
        system = engine(bodies, [joint(("first", "hub"), ("second", "hub"), spring)])
        modes = modes_at_speed(system, 0.0)
        expected = np.sqrt(spring * (1 / 10.0 + 1 / 1e-2))
        if modes.eigenvalues.size != 2:
            return np.inf
        errors.append(np.abs(modes.eigenvalues / (1j * expected) - 1.0).max())
    return float(max(errors))


def _free_critical_speeds() -> float:
    """Critical speeds of a free shaft that are no zeros of det(K + Ω²(iG − M)), and back.

    Backward whirl frequencies fall with the speed; each must meet ω = Ω at a critical speed.
    """
    element = shaft()
    system = engine({"shaft": element}, ())
    error = 0.0
    for critical in critical_speeds(system, 1.0, 3e4):
        omega = modes_at_speed(system, critical.speed_rad_s).eigenvalues.imag
        error = max(error, float(np.abs(omega / critical.speed_rad_s - 1.0).min()))
    return error if critical_speeds(system, 1.0, 3e4) else np.inf


def _free(element):
    return engine({"body": element}, ())


def _two_free(element):
    return engine({"one": element, "two": element}, (), {"two": -0.5})
