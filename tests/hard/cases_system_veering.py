"""Hard cases of assembled systems: branches that come close, followed in both directions."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, joint, shaft
from scipy.optimize import linear_sum_assignment, minimize_scalar

from solidwhirl.rotordyn import campbell, modes_at_speed

TOP = 600.0
COMMON = np.linspace(0.0, TOP, 9)


def _veering(coupling_n_per_m: float, unlike: float = 1.0, element=None):
    """A turning shaft whose forward mode meets that of a standing one, weakly joined to it.

    `unlike` is k_yy over k_xx of the supports.
    """
    turning = shaft() if element is None else element
    standing = turning
    tilt = {"tilt_stiffness_n_m_per_rad": 1e4 * np.eye(2)}
    bearings = [ground("left", at, 5e7, 5e7 * unlike, **tilt) for at in "ab"]
    bearings += [ground("right", at, 5.8e7, 5.8e7 * unlike, **tilt) for at in "ab"]
    bearings.append(joint(("left", "a"), ("right", "a"), coupling_n_per_m))
    return engine({"left": turning, "right": standing}, bearings, {"right": 0.0})


def _difference(first, second) -> float:
    """Largest relative difference of two sets of branches (b, s), paired as a whole."""
    if first.shape != second.shape or not np.isfinite(first).all():
        return np.inf
    apart = np.abs(first[:, None] / second[None] - 1.0).max(axis=2)
    rows, columns = linear_sum_assignment(apart)
    return float(apart[rows, columns].max())


def _there_and_back(coupling_n_per_m: float, unlike: float = 1.0, element=None) -> float:
    """Difference of 8 branches over 200 steps followed forwards and backwards."""
    system = _veering(coupling_n_per_m, unlike, element)
    speeds = np.linspace(0.0, TOP, 201)
    there = campbell(system, speeds, branch_count=8).frequency_hz
    back = campbell(system, speeds[::-1], branch_count=8).frequency_hz[:, ::-1]
    return _difference(there, back)


def _refined(coupling_n_per_m: float) -> float:
    """Largest difference of 8 branches at 9 speeds with 0, 40 and 150 random ones between."""
    system = _veering(coupling_n_per_m)
    random = np.random.default_rng(3)
    plain = campbell(system, COMMON, branch_count=8).frequency_hz
    worst = 0.0
    for count in (1, 40, 150):
        speeds = np.union1d(COMMON, random.uniform(0.0, TOP, count))
        found = campbell(system, speeds, branch_count=8).frequency_hz
        worst = max(worst, _difference(plain, found[:, np.searchsorted(speeds, COMMON)]))
    return worst


def _gap_error() -> float:
    """Closest distance of the branches against perturbation theory of two modes.

    Two modes of equal frequency ω whose ends a move by φ1, φ2 at unit modal mass part by
    |φ1 φ2| k/ω rad/s when a spring k joins them.
    """
    coupling = 1e4
    system, apart = _veering(coupling), _veering(0.0)
    found = minimize_scalar(
        lambda speed: _forward_gap(system, speed),
        bounds=(100.0, 180.0),
        method="bounded",
        options={"xatol": 1e-4},
    )
    closest, meeting = float(found.fun), float(found.x)
    modes = modes_at_speed(apart, meeting)
    chosen = [k for k in range(modes.eigenvalues.size) if modes.family[k] == 1][:2]
    moved = []
    for name in ("left", "right"):
        rows = apart.transformation[apart.body_slices[name]]
        element = apart.system.rotors[name].element
        ends = [rows[element.interface_index("a", c)] for c in ("ux", "uy")]
        # whirling modes are scaled by 2ω M − iG, the derivative of the dynamic stiffness
        inertia = [_modal_rate(apart, modes, k, meeting) for k in chosen]
        size = [sum(abs(row @ modes.shapes[:, k]) ** 2 for row in ends) for k in chosen]
        moved.append(max(np.sqrt(s / i) for s, i in zip(size, inertia, strict=True)))
    expected = 2.0 * coupling * moved[0] * moved[1]
    return float(abs(closest / expected - 1.0))


def _modal_rate(system, modes, k, speed_rad_s):
    omega, shape = modes.eigenvalues[k].imag, modes.shapes[:, k]
    rate = 2.0 * omega * system.mass - 1j * speed_rad_s * system.gyroscopic
    return (shape.conj() @ rate @ shape).real


def _forward_gap(system, speed_rad_s):
    """Distance of the two lowest forward frequencies, rad/s."""
    modes = modes_at_speed(system, speed_rad_s)
    below, above = modes.eigenvalues.imag[modes.family == 1][:2]
    return above - below
