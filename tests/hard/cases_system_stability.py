"""Hard cases of assembled systems: no damping, too much of it, and motions that grow."""

from __future__ import annotations

import numpy as np
from builders_system import (
    engine,
    first_window,
    ground,
    hub,
    pinned,
    reduced_body,
    shaft,
    sprung_hub,
)

from solidwhirl.rotordyn import (
    Bearing,
    End,
    InternalDamping,
    Rotor,
    TableLaw,
    assemble,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.stability.intervals import stability_chart

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


def _two_per_cent(body) -> float:
    """Relative error of 2 % modal damping of a free body at rest."""
    damped = Rotor(
        element=body, speed_ratio=1.0, internal_damping=InternalDamping(modal_ratio=0.02)
    )
    modes = modes_at_speed(assemble({"body": damped}, ()), 0.0)
    if modes.eigenvalues.size != body.size - 4:
        return np.inf
    return float(np.abs(modes.damping_ratio / 0.02 - 1.0).max())


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


def _film_threshold() -> float:
    """Speed at which q(Ω) = c Ω/2 reaches c ω: half-speed whirl at Ω = 2 ω."""
    damping, speeds = 80.0, np.array([0.0, 2000.0])
    cross = np.multiply.outer(0.5 * damping * speeds, [[0.0, 1.0], [-1.0, 0.0]])
    law = TableLaw(
        name="film",
        speeds_rad_s=speeds,
        stiffness_n_per_m=cross + STIFFNESS * np.eye(2),
        damping_n_s_per_m=np.repeat(damping * np.eye(2)[None], 2, axis=0),
        interpolation="linear",
    )
    film = Bearing(name="film", first=HUB, speed_law=law, **TILT)
    found = first_window(engine({"disk": hub(MASS)}, [film]), 1500.0)
    return np.inf if found is None else float(abs(found.low_rad_s / (2.0 * OMEGA) - 1.0))


def _damped_inside(inside, outside):
    """A disk on a shaft of its own with damping inside, and damping to the ground."""
    beta = InternalDamping(stiffness_coefficient_s=inside / STIFFNESS)
    element = sprung_hub(STIFFNESS, 1e8, polar_kg_m2=0.01)
    rotor = Rotor(element=element, speed_ratio=1.0, internal_damping=beta)
    outer = 1e-3 * outside * np.eye(2)
    bearing = ground("disk", "hub", 0.0, cx=outside, tilt_damping_n_m_s_per_rad=outer)
    return assemble({"disk": rotor}, (bearing,))


def _internal_threshold() -> float:
    """Largest error of the threshold Ω = ω (1 + outside/inside)."""
    worst = 0.0
    for inside, outside in ((50.0, 5.0), (50.0, 50.0), (20.0, 100.0), (1e-3, 1e-3)):
        expected = OMEGA * (1.0 + outside / inside)
        found = first_window(_damped_inside(inside, outside), 2.0 * expected)
        if found is None or found.whirl != "forward":
            return np.inf
        worst = max(worst, abs(found.low_rad_s / expected - 1.0))
    return worst


def _internal_growth() -> float:
    """Error of the growth rate, m λ² + (ci + ce) λ + k − iΩ ci = 0, to 20 times the threshold."""
    inside, outside, worst = 50.0, 5.0, 0.0
    system = _damped_inside(inside, outside)
    for factor in (1.001, 1.5, 5.0, 20.0):
        speed = factor * OMEGA * (1.0 + outside / inside)
        total = inside + outside
        root = np.sqrt(total**2 - 4.0 * MASS * (STIFFNESS - 1j * speed * inside) + 0j)
        growth = max(((-total + s * root) / (2.0 * MASS)).real for s in (1, -1))
        found = stability_chart(system, [speed]).growth_rate_1_s[0]
        worst = max(worst, abs(found / growth - 1.0))
    return float(worst)


def _at_its_critical_speed(body) -> float:
    """Threshold of a shaft damped inside alone against its first forward critical speed.

    Without damping outside the forward whirl grows as soon as the material sees it turn backward:
    where Ω = ω_forward(Ω), the critical speed, which another eigenproblem finds. Damping is so
    weak that it leaves the frequency alone to its square, 1e-8.
    """
    beta = InternalDamping(stiffness_coefficient_s=1e-8)
    supports = tuple(pinned("rotor", at) for at in "ab")
    damped = Rotor(element=body, speed_ratio=1.0, internal_damping=beta)
    found = first_window(assemble({"rotor": damped}, supports), 3000.0)
    forward = [
        c.speed_rad_s
        for c in critical_speeds(engine({"rotor": body}, supports), 1.0, 3000.0)
        if c.whirl == "forward"
    ]
    return np.inf if found is None else float(abs(found.low_rad_s / forward[0] - 1.0))
