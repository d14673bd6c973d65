"""Hard cases of assembled systems: no damping, too much of it, and motions that grow."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, hub, reduced_body, shaft

from solidwhirl.rotordyn import Bearing, End, modes_at_speed

MASS, STIFFNESS = 10.0, 1e6
OMEGA = np.sqrt(STIFFNESS / MASS)
HUB = End(body="disk", interface="hub")
TILT = {"tilt_stiffness_n_m_per_rad": 1e5 * np.eye(2)}


def _disk_on(cross_n_per_m=0.0, damping_n_s_per_m=0.0, k_yy=STIFFNESS, **disk):
    """A disk of 10 kg on one bearing with cross-coupling [[k, q], [-q, k]]."""
    bearing = Bearing(
        name="film",
        first=HUB,
        stiffness_n_per_m=np.array([[STIFFNESS, cross_n_per_m], [-cross_n_per_m, k_yy]]),
        damping_n_s_per_m=damping_n_s_per_m * np.eye(2),
        **TILT,
    )
    return engine({"disk": hub(MASS, **disk)}, [bearing])


def _largest_decrement() -> float:
    """Largest |log decrement| of engines without damping, at rest and at speed."""
    unlike = [ground("r", "a", 8e6, 1e10), ground("r", "b", 1e5, 3e4)]
    crossed = Bearing(
        name="crossed",
        first=End(body="r", interface="a"),
        stiffness_n_per_m=np.array([[2e7, 5e6], [5e6, 1e7]]),
    )
    sets = (unlike, [crossed, ground("r", "b", 1e7)], [ground("r", e, 1e6) for e in "ab"], [])
    largest = 0.0
    for body in (shaft(), reduced_body("harmonic"), reduced_body("solid")):
        for bearings in sets:
            system = engine({"r": body}, bearings)
            for speed in (0.0, 10.0, 3000.0):
                modes = modes_at_speed(system, speed)
                largest = max(largest, float(np.abs(modes.log_decrement).max()))
                largest += modes.real_eigenvalues.size
    return largest


def _overcritical() -> float:
    """Error of both real roots of m λ² + c λ + k from 1.0001 to 1e6 times critical damping."""
    critical, worst = 2.0 * np.sqrt(STIFFNESS * MASS), 0.0
    for factor in (1.0001, 2.0, 1e2, 1e4, 1e6):
        c = factor * critical
        fast = -(c + np.sqrt(c**2 - critical**2)) / (2.0 * MASS)
        slow = STIFFNESS / MASS / fast
        for speed in (0.0, 200.0):
            real = modes_at_speed(_disk_on(0.0, c), speed).real_eigenvalues
            if real.size != 4:
                return np.inf
            worst = max(worst, float(np.abs(real / [fast, fast, slow, slow] - 1.0).max()))
    return worst


def _critically_damped() -> float:
    """Distance of the eigenvalues from −ω at critical damping, where they are defective."""
    modes = modes_at_speed(_disk_on(0.0, 2.0 * np.sqrt(STIFFNESS * MASS)), 0.0)
    tilt = np.sqrt(1e5 / 0.05)
    own = modes.eigenvalues[np.abs(modes.eigenvalues.imag - tilt) > 1.0]
    values = np.concatenate((own, modes.real_eigenvalues.astype(complex)))
    return float(np.abs(values / -OMEGA - 1.0).max()) if values.size else np.inf


def _cross_coupled() -> float:
    """Error of both whirls of m z̈ + c ż + (k ∓ i q) z = 0 up to 100 times the limit q = c ω."""
    damping, worst = 50.0, 0.0
    for factor in (0.5, 1.0, 1.5, 10.0, 100.0):
        cross = factor * damping * OMEGA
        root = np.sqrt(damping**2 - 4.0 * MASS * (STIFFNESS - 1j * cross) + 0j)
        values = [(-damping + s * root) / (2.0 * MASS) for s in (1.0, -1.0)]
        # one root whirls with +z, the other against it; listed with Im λ > 0
        expected = [v if v.imag > 0 else v.conjugate() for v in values]
        for system in (_disk_on(cross, damping), _disk_on(cross, damping, STIFFNESS * (1 + 1e-13))):
            found = modes_at_speed(system, 100.0).eigenvalues
            worst = max(worst, *(float(np.abs(found / e - 1.0).min()) for e in expected))
    return worst


def _cross_coupled_unlike() -> float:
    """Growth in unlike supports: λ² = −a ± i √(q² − b²)/m, a, b mean and half difference of k."""
    worst = 0.0
    for k_yy in (1.02e6, 2e6):
        mean, half = 0.5 * (STIFFNESS + k_yy), 0.5 * (k_yy - STIFFNESS)
        for cross in (1.001 * half, 2.0 * half, 100.0 * half):
            root = np.sqrt(complex(-mean, np.sqrt(cross**2 - half**2)) / MASS)
            found = modes_at_speed(_disk_on(cross, 0.0, k_yy), 100.0).eigenvalues
            worst = max(worst, float(np.abs(found.real - abs(root.real)).min() / abs(root.real)))
    return worst
