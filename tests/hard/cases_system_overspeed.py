"""Hard cases of assembled systems: past the loss of stiffness, and above torsional frequencies."""

from __future__ import annotations

import dataclasses

import numpy as np
from builders_system import (
    STEEL,
    engine,
    first_window,
    free_rad_s,
    ground,
    hub,
    pinned,
    reduced_rod,
)

from solidwhirl.rotordyn import PolynomialLaw, campbell, modes_at_speed

STIFFNESS, MASS = 1e6, 10.0
LEVELS = ("harmonic", "solid")
TILT = {"tilt_stiffness_n_m_per_rad": 1e5 * np.eye(2)}


def _softening_bearing(zero_rad_s: float):
    """Bearing k (1 − (Ω/Ω0)²) in x, constant in y."""
    one = (1.0,)
    law = PolynomialLaw(
        name="softening", argument_unit="rad/s", argument_range=(0.0, 5000.0),
        stiffness_x=(1.0, 0.0, -1.0 / zero_rad_s**2), stiffness_y=one, damping_x=one, damping_y=one,
    )  # fmt: skip
    return ground("disk", "hub", STIFFNESS, speed_law=law, **TILT)


def _lost_stiffness() -> float:
    """Speed at which a bearing k (1 − (Ω/Ω0)²) stops pushing back, against Ω0."""
    worst = 0.0
    for zero in (50.0, 333.3, 2000.0):
        system = engine({"disk": hub(MASS)}, [_softening_bearing(zero)])
        found = first_window(system, 2.7 * zero)
        if found is None or found.kind != "divergence":
            return np.inf
        worst = max(worst, abs(found.low_rad_s / zero - 1.0))
    return worst


def _softened(element, share: float):
    """A body whose elastic motion loses `share` of M per Ω²: K + Ω²K2 is singular at ω/√share."""
    rigid = element.rigid_body_modes[:, element.rigid_body_present]
    momentum = element.mass @ rigid
    projector = np.eye(element.size) - rigid @ np.linalg.solve(rigid.T @ momentum, momentum.T)
    elastic = projector.T @ element.mass @ projector
    return dataclasses.replace(
        element,
        stress_stiffening=element.mass,
        spin_softening=element.mass + share * 0.5 * (elastic + elastic.T),
    )


def _noted_speed(element, shares=(0.3, 1.0, 4.0)) -> float:
    """Error of the speed at which a diagram says that K + Ω²K2 gets negative eigenvalues."""
    lowest = free_rad_s(element)[0]
    worst = 0.0
    for share in shares:
        system = engine({"body": _softened(element, share)}, ())
        lost = lowest / np.sqrt(share)
        diagram = campbell(system, np.linspace(0.0, 1.3 * lost, 8), branch_count=4)
        notes = [note for note in diagram.notes if note.kind == "indefinite"]
        if len(notes) != 1:
            return np.inf
        worst = max(worst, abs(notes[0].speed_rad_s / lost - 1.0))
    return float(worst)


def _wrong_counts(element) -> float:
    """Speeds past each loss of stiffness at which it is not counted, a pair for each mode."""
    free = free_rad_s(element)[::2]
    system = engine({"body": _softened(element, 1.0)}, ())
    wrong = 0
    for k in range(3):
        for factor, expected in ((0.999, 2 * k), (1.001, 2 * (k + 1))):
            found = modes_at_speed(system, factor * free[k])
            wrong += int(found.negative_stiffness_count != expected)
    return float(wrong)


def _diverging(element) -> float:
    """Rate of divergence past the loss of stiffness without gyroscopic effects, √(Ω² − ω1²)."""
    still = dataclasses.replace(_softened(element, 1.0), gyroscopic=np.zeros_like(element.mass))
    system = engine({"body": still}, ())
    lowest = free_rad_s(element)[0]
    worst = 0.0
    for factor in (1.0001, 1.1, 1.5):
        expected = lowest * np.sqrt(factor**2 - 1.0)
        rates = modes_at_speed(system, factor * lowest).real_eigenvalues
        worst = max(worst, float(abs(rates.max(initial=0.0) / expected - 1.0)))
    return worst


def _negative_support() -> float:
    """Error of the frequency and growth of a disk between a spring and a negative one."""
    worst = 0.0
    for share in (0.5, 0.999999, 1.000001, 3.0):
        bearings = [
            ground("disk", "hub", STIFFNESS, **TILT),
            dataclasses.replace(ground("disk", "hub", -share * STIFFNESS), name="negative"),
        ]
        modes = modes_at_speed(engine({"disk": hub(MASS)}, bearings), 0.0)
        rate = np.sqrt(STIFFNESS * abs(1.0 - share) / MASS)
        if modes.negative_stiffness_count != (2 if share > 1 else 0):
            return np.inf
        found = modes.real_eigenvalues.max() if share > 1 else modes.eigenvalues.imag.min()
        worst = max(worst, float(abs(found / rate - 1.0)))
    return worst


def _false_instability(level: str) -> float:
    """Motions that grow, or negative stiffness, of a rod past its first torsional frequency."""
    rod = reduced_rod(level)
    wrong = 0
    held = [pinned("rod", "a", ("ux", "uy", "uz", "rz")), pinned("rod", "b")]
    for bearings in ([], held):
        system = engine({"rod": rod}, bearings)
        for speed in np.linspace(0.0, rod.maximum_speed_rad_s, 8):
            modes = modes_at_speed(system, float(speed))
            wrong += modes.negative_stiffness_count + modes.real_eigenvalues.size
            wrong += int(
                np.count_nonzero(modes.eigenvalues.real > 1e-9 * np.abs(modes.eigenvalues))
            )
    return float(wrong)


def _torsion_drift(level: str) -> float:
    """Relative change of the first torsional frequency up to 1.3 times that frequency."""
    rod = reduced_rod(level)
    system = engine({"rod": rod}, ())
    expected = np.pi * np.sqrt(STEEL[0] / (2.0 * (1.0 + STEEL[1])) / STEEL[2])
    turns = [rod.interface_index(at, "rz") for at in "ab"]
    found = []
    for speed in (0.0, rod.maximum_speed_rad_s):
        modes = modes_at_speed(system, speed)
        part = np.abs(modes.shapes[turns]).max(axis=0)
        lateral = [rod.interface_index(at, c) for at in "ab" for c in ("ux", "uy", "uz")]
        part = part / (part + 10.0 * np.abs(modes.shapes[lateral]).max(axis=0))
        found.append(modes.eigenvalues.imag[part > 0.9][0])
    if not expected < rod.maximum_speed_rad_s or abs(found[0] / expected - 1.0) > 0.01:
        return np.inf
    return float(abs(found[1] / found[0] - 1.0))
