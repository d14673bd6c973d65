"""Hard cases of assembled systems: supports from very soft to exactly rigid, and contrasts."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, pinned, shaft
from exact_system import exact_frequencies

from solidwhirl.rotordyn import critical_speeds, modes_at_speed

DECADES = tuple(10.0**d for d in range(2, 17))
SPIN = (0.0, 300.0, 3000.0)
ENDS = [(at, c) for at in "ab" for c in ("ux", "uy")]


def _digits_lost(element, first: int, last: int, step: int = 1) -> float:
    """Largest relative error of the lowest frequencies on supports of some decades of stiffness."""
    worst = 0.0
    speeds, count = (SPIN, 4) if step == 1 else ((0.0, 1000.0), 2)
    for k in DECADES[first:last:step]:
        system = engine({"rotor": element}, [ground("rotor", at, k) for at in "ab"])
        for speed in speeds:
            found = modes_at_speed(system, speed, count).eigenvalues.imag
            exact = exact_frequencies(element, dict.fromkeys(ENDS, k), speed, found)
            worst = max(worst, float(np.abs(found / exact - 1.0).max()))
    return worst


def _rigid_error(element) -> float:
    """Error of the lowest frequencies with both ends held exactly."""
    system = engine({"rotor": element}, [pinned("rotor", at) for at in "ab"])
    worst = 0.0
    for speed in SPIN:
        found = modes_at_speed(system, speed, 4).eigenvalues.imag
        exact = exact_frequencies(element, dict.fromkeys(ENDS), speed, found)
        worst = max(worst, float(np.abs(found / exact - 1.0).max()))
    return worst


def _unlike_error(stiffness: dict, speeds=(0.0, 300.0, 3000.0)) -> float:
    """Error of the lowest frequencies on supports that differ in x and y by orders."""
    element, worst = shaft(), 0.0
    bearings = [ground("rotor", at, *k) for at, k in stiffness.items()]
    supports = {
        (at, c): v for at, k in stiffness.items() for c, v in zip(("ux", "uy"), k, strict=True)
    }
    for speed in speeds:
        found = modes_at_speed(engine({"rotor": element}, bearings), speed, 5).eigenvalues.imag
        exact = exact_frequencies(element, supports, speed, found)
        worst = max(worst, float(np.abs(found / exact - 1.0).max()))
    return worst


def _towards_rigid(element) -> float:
    """Miss of f(k) by f_rigid − c/k, c from the reactions of the rigid supports, over f_rigid.

    A support that gives way by its reaction R over k takes R²/k from ω² of a mode of unit mass.
    The next term is of the order of (k_body / k)².
    """
    rigid = engine({"rotor": element}, [pinned("rotor", at) for at in "ab"])
    modes = modes_at_speed(rigid, 0.0, 1)
    omega = float(modes.eigenvalues[0].imag)
    motion = rigid.transformation @ modes.shapes[:, 0].real
    force = (element.stiffness - omega**2 * element.mass) @ motion
    reactions = np.array([force[element.interface_index(*end)] for end in ENDS])
    slope = float(reactions @ reactions) / (2.0 * omega)
    worst = 0.0
    for k in (1e13, 1e14, 1e15, 1e16):
        system = engine({"rotor": element}, [ground("rotor", at, k) for at in "ab"])
        found = float(modes_at_speed(system, 0.0, 1).eigenvalues[0].imag)
        worst = max(worst, abs(found - (omega - slope / k)) / omega)
    return worst


def _critical_digits() -> float:
    """Error of critical speeds on supports of each stiffness: ω = Ω in 50 digits."""
    element, worst = shaft(), 0.0
    for k in DECADES:
        system = engine({"rotor": element}, [ground("rotor", at, k) for at in "ab"])
        for critical in critical_speeds(system, 1.0, 4000.0):
            speed = critical.speed_rad_s
            exact = exact_frequencies(element, dict.fromkeys(ENDS, k), speed, [speed])[0]
            worst = max(worst, abs(exact / speed - 1.0))
    return float(worst)
