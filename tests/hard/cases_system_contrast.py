"""Hard cases of assembled systems: unlike bodies, long chains, gears and kinks of bearing laws."""

from __future__ import annotations

import numpy as np
from builders_system import LATERAL, STEEL, engine, ground, hub, joint

from solidwhirl.rotordyn import (
    Bearing,
    Disk,
    End,
    Gear,
    Rotor,
    TableLaw,
    assemble,
    beam_superelement,
    critical_speeds,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds


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


def _chain_of_forty(speed_rad_s: float) -> float:
    """Forty short shafts joined exactly against one shaft with the same forty elements."""
    count, length = 40, 1.2
    stations = np.linspace(0.0, length, count + 1)
    disk = {"mass_kg": 12.0, "diametral_kg_m2": 0.07, "polar_kg_m2": 0.13}
    disks = [Disk(name="disk", position_m=float(stations[13]), **disk)]
    whole = beam_superelement("whole", stations, 0.02, 0.0, STEEL, {"a": 0.0, "b": length}, disks)
    single = engine({"whole": whole}, [ground("whole", at, 1e8) for at in "ab"])
    names = [f"body {i}" for i in range(count)]
    bodies = {
        name: beam_superelement(
            name, stations[i : i + 2], 0.02, 0.0, STEEL,
            {"a": float(stations[i]), "b": float(stations[i + 1])}, disks if i == 13 else (),
        )
        for i, name in enumerate(names)
    }  # fmt: skip
    bearings = [ground(names[0], "a", 1e8), ground(names[-1], "b", 1e8)]
    bearings += [
        joint((names[i], "b"), (names[i + 1], "a"), rigid=LATERAL) for i in range(count - 1)
    ]
    chain = modes_at_speed(engine(bodies, bearings), speed_rad_s, 12).eigenvalues.imag
    expected = modes_at_speed(single, speed_rad_s, 12).eigenvalues.imag
    return float(np.abs(chain / expected - 1.0).max())


def _wheel(name: str, polar: float):
    inertia = [polar, polar, polar]
    return rigid_superelement(name, 1.0, np.zeros(3), inertia, {"seat": 0.0}, ("rz",))


def _geared(ratio: float, mesh_n_per_m: float | None) -> float:
    """Relative error of the torsion of two geared wheels, the first on a torsion spring.

    Without mesh stiffness ω² = c/(J1 + ratio² J2); with it the two frequencies of
    [[c + k r², -k r s], [-k r s, k s²]], s = r/ratio.
    """
    first, second, spring, radius = 2.0, 0.03, 5e4, 0.1
    shaft = Bearing(
        name="shaft",
        first=End(body="first", interface="seat"),
        torsion_stiffness_n_m_per_rad=spring,
    )
    gear = Gear(
        name="gear",
        first=End(body="first", interface="seat"),
        second=End(body="second", interface="seat"),
        ratio=ratio,
        mesh_stiffness_n_per_m=mesh_n_per_m,
        base_radius_first_m=radius,
    )
    rotors = {
        "first": Rotor(element=_wheel("first", first), speed_ratio=1.0),
        "second": Rotor(element=_wheel("second", second), speed_ratio=ratio),
    }
    system = assemble(rotors, (shaft,), gears=(gear,))
    found = modes_at_speed(system, 100.0).eigenvalues.imag
    if mesh_n_per_m is None:
        squares = np.array([spring / (first + ratio**2 * second)])
    else:
        teeth = mesh_n_per_m * np.array([radius**2, (radius / ratio) ** 2])
        total = (spring + teeth[0]) / first + teeth[1] / second
        product = spring * teeth[1] / (first * second)
        upper = 0.5 * (total + np.sqrt(total**2 - 4.0 * product))
        squares = np.array([product / upper, upper])
    return float(np.abs(found / np.sqrt(squares) - 1.0).max()) if found.size else np.inf


def _gears(mesh_n_per_m: float | None) -> float:
    """Worst of ratios 1e-3 to 1e3, of either sign."""
    return max(
        _geared(sign * 10.0**power, mesh_n_per_m) for power in range(-3, 4) for sign in (1, -1)
    )


def _elastic_gears() -> float:
    return max(_gears(1e8), _gears(1e13))


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


def _touching() -> float:
    """Whirls that touch the excitation at a kink without being reported there."""
    system = _kinked(TOUCHING_N_PER_M)
    counted = count_critical_speeds(system, 1.0, 400.0)
    touched = sum(low - 1e-9 <= 100.0 <= high + 1e-9 for low, high in counted.unresolved_rad_s)
    listed = sum(abs(c.speed_rad_s - 100.0) < 1e-6 for c in critical_speeds(system, 1.0, 400.0))
    return float(max(0, 2 - touched - listed))


def _touching_with_damping() -> float:
    """Error of the number of meetings where damping of 1e-4 turns the touch into two crossings.

    Im λ = √(k/m − c²/4m²) is below Ω from just before the kink to just after it, and falls below
    it for good just before 200 rad/s: three meetings of each whirl.
    """
    system = _kinked(TOUCHING_N_PER_M, 0.2)
    found = [c.speed_rad_s for c in critical_speeds(system, 1.0, 400.0)]
    near = [sum(abs(f - place) < 0.1 for f in found) for place in (100.0, 200.0)]
    return float(abs(near[0] - 4) + abs(near[1] - 2) + abs(len(found) - 6))
