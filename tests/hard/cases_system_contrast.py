"""Hard cases of assembled systems: unlike bodies, and kinks of bearing laws."""

from __future__ import annotations

import numpy as np
from builders_system import LATERAL, engine, ground, hub, joint

from solidwhirl.rotordyn import Bearing, End, TableLaw, critical_speeds, modes_at_speed


def _light_on_heavy(rigid: bool) -> float:
    """A body of 1e-6 kg on one of 1e4 kg, that on a spring, against two bodies in closed form."""
    big, small, k_big, k_small = 1e4, 1e-6, 1e8, 1e2
    bodies = {
        "big": hub(big, 20.0, 15.0, name="big"),
        "small": hub(small, 1e-12, 1e-12, name="small"),
    }
    tilt = {"tilt_stiffness_n_m_per_rad": 1e6 * np.eye(2)}
    bearings = [ground("big", "hub", k_big, **tilt)]
    if rigid:
        bearings.append(joint(("small", "hub"), ("big", "hub"), rigid=LATERAL))
        squares = np.array([k_big / (big + small)])
    else:
        tilt = {"tilt_stiffness_n_m_per_rad": 1e-4 * np.eye(2)}
        bearings.append(joint(("small", "hub"), ("big", "hub"), k_small, **tilt))
        total = (k_big + k_small) / big + k_small / small
        product = k_big * k_small / (big * small)
        upper = 0.5 * (total + np.sqrt(total**2 - 4.0 * product))
        squares = np.array([product / upper, upper])
    found = modes_at_speed(engine(bodies, bearings), 0.0).eigenvalues.imag
    return float(max(np.abs(found / np.sqrt(s) - 1.0).min() for s in squares))


# 10 Ω² passes k(Ω) before the first kink, after it, and exactly at the second.
KINKS = (100.0, 200.0, 300.0)
KINKED_N_PER_M = np.array([2e5, 0.9e5, 4e5, 5e5])
# The same, but the dip below 10 Ω² at the first kink is 1e-4 deep.
NARROW_N_PER_M = np.array([2e5, 0.9999e5, 4e5, 5e5])
# It touches k(Ω) at the first kink.
TOUCHING_N_PER_M = np.array([2e5, 1e5, 4e5, 5e5])


def _kinked(stiffness_n_per_m, damping_n_s_per_m: float = 0.0):
    """A hub of 10 kg on a tabulated bearing, linear between 4 speeds, and on a tilt spring."""
    law = TableLaw(
        name="kinked",
        speeds_rad_s=np.array([0.0, *KINKS]),
        stiffness_n_per_m=np.multiply.outer(stiffness_n_per_m, np.eye(2)),
        damping_n_s_per_m=np.multiply.outer(np.full(4, damping_n_s_per_m), np.eye(2)),
        interpolation="linear",
    )
    bearing = Bearing(
        name="bearing",
        first=End(body="disk", interface="hub"),
        tilt_stiffness_n_m_per_rad=1e7 * np.eye(2),
        speed_law=law,
    )
    return engine({"disk": hub()}, [bearing])


def _kinked_speeds(k) -> list[float]:
    """Roots of k(Ω) = 10 Ω², by the quadratic of each piece."""
    roots: list[float] = []
    speeds = (0.0, *KINKS)
    for i in range(3):
        slope = (k[i + 1] - k[i]) / (speeds[i + 1] - speeds[i])
        found = np.roots([10.0, -slope, slope * speeds[i] - k[i]])
        inside = (found > speeds[i] * (1 + 1e-9)) & (found <= speeds[i + 1] * (1 + 1e-9))
        roots += found[inside].tolist()
    return sorted(roots)


def _kink_error(law: str, damping_n_s_per_m: float = 0.0) -> float:
    """Error of the critical speeds, a pair for each root; infinite for a wrong number of them."""
    stiffness_n_per_m = {"kinked": KINKED_N_PER_M, "narrow": NARROW_N_PER_M}[law]
    system = _kinked(stiffness_n_per_m, damping_n_s_per_m)
    found = [c.speed_rad_s for c in critical_speeds(system, 1.0, 400.0)]
    expected = np.repeat(_kinked_speeds(stiffness_n_per_m), 2)
    if len(found) != expected.size:
        return np.inf
    return float(np.abs(np.array(found) / expected - 1.0).max())


def _touching_with_damping() -> float:
    """Error of the number of meetings where damping of 1e-4 turns the touch into two crossings.

    Im λ = √(k/m − c²/4m²) is below Ω from just before the kink to just after it, and falls below
    it for good just before 200 rad/s: three meetings of each whirl.
    """
    system = _kinked(TOUCHING_N_PER_M, 0.2)
    found = [c.speed_rad_s for c in critical_speeds(system, 1.0, 400.0)]
    near = [sum(abs(f - place) < 0.1 for f in found) for place in (100.0, 200.0)]
    return float(abs(near[0] - 4) + abs(near[1] - 2) + abs(len(found) - 6))
