"""Speeds beyond linear prestress, beyond the loss of stiffness, and above the first torsion."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import scipy.linalg
from builders_body import STEEL, even, meshed, plane, reduced, section, tube

from solidwhirl.geometry import Body, Interface
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction import ReductionError
from solidwhirl.rotordyn import Rotor, assemble, modes_at_speed

RPM = 30.0 / np.pi
# A thin soft disk in a stiff light hoop: spinning presses it together, and it buckles.
PRESSED = replace(STEEL, name="disk", youngs_modulus_pa=5e7, density_kg_per_m3=2000.0)
HOOP = replace(STEEL, name="hoop", youngs_modulus_pa=4e11, density_kg_per_m3=1000.0)
SPIN = {"centrifugal": True, "gyroscopic": True}


def _pressed_disk(interfaces: tuple[Interface, ...]) -> Body:
    return Body(
        name="pressed",
        sections=(
            section("disk", 0.0, 0.0035, 0.02, 0.1, PRESSED),
            section("hoop", 0.0, 0.0035, 0.1, 0.12, HOOP),
        ),
        interfaces=interfaces,
    )


def _rim() -> Interface:
    return Interface(name="rim", kind="outer", coupling="rigid", start_m=0.0, end_m=0.0035)


_SIZES = {
    "harmonic": even(0.01),
    "solid": MeshSize(size_m=0.04, corner_size_m=0.04, through_thickness=0.13, around=8),
}


@cache
def _lost_speed(body: Body, level: str, order: int, components: tuple[str, ...]) -> float:
    """Speed without stiffness, by dense eigenvalues of the held body [rad/s]."""
    from mpi4py import MPI

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.vectors import apply

    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=True,
        components={i.name: components for i in body.interfaces},
        lateral_only=order == 1,
    )
    body_order = order if level == "harmonic" else None
    mesh = meshed(body, level, _SIZES[level])
    operators = build_operators(
        body, mesh, MPI.COMM_SELF, order=body_order, degree=2, effects=effects
    )
    rows = np.hstack([operators.coupling.rows, operators.coupling.anchors])
    motions = np.column_stack([*operators.rigid_motions.values()])
    one = np.eye(len(rows))
    k = apply(operators.stiffness, one)
    change = apply(operators.stress_stiffening, one) - apply(operators.spin_softening, one)
    if rows.shape[1]:
        held = scipy.linalg.null_space(rows.T)
    else:
        held = scipy.linalg.null_space(apply(operators.mass, motions).T)
    k, change = held.T @ k @ held, held.T @ change @ held
    lowest = scipy.linalg.eigh(
        0.5 * (change + change.T), 0.5 * (k + k.T), eigvals_only=True, subset_by_index=[0, 0]
    )[0]
    return float(np.sqrt(-1.0 / lowest))


def _reported(body: Body, level: str, speed: float, **request: object) -> float:
    """Speed of the refusal's message [rad/s]; inf if nothing was refused."""
    try:
        reduced(body, level, _SIZES[level], maximum_speed_rad_s=speed, modes=2, **SPIN, **request)
    except ReductionError as error:
        found = re.search(r"from ([0-9.e+]+) rpm on", str(error))
        return float(found.group(1)) / RPM if found else np.inf
    return np.inf


def _overspeed(level: str, order: int, held: bool) -> float:
    components = {0: ("uz", "rz"), 1: ("ux", "uy", "rx", "ry")}[order] if held else ()
    body = _pressed_disk((_rim(),) if held else ())
    exact = _lost_speed(body, level, order, components)
    request = {"orders": (order,), "components": components}
    return abs(_reported(body, level, 1.1 * exact, **request) / exact - 1.0)


def _just_below(level: str) -> float:
    """Refusals at 0.999 of the speed without stiffness, and passes at 1.001 of it."""
    components = ("ux", "uy", "rx", "ry")
    body = _pressed_disk((_rim(),))
    exact = _lost_speed(body, level, 1, components)
    wrong = 0
    for part, refused in ((0.999, False), (1.001, True)):
        try:
            request = {"components": components, "modes": 2, "maximum_speed_rad_s": part * exact}
            reduced(body, level, _SIZES[level], **request, **SPIN)
            wrong += refused
        except ReductionError as error:
            wrong += not refused or "lost its stiffness" not in str(error)
    return float(wrong)


def _hoop_limit(level: str) -> float:
    """The allowed speed against σ = (3+ν)/4 ρΩ² (b² + (1-ν)/(3+ν) a²) = 0.05 E at the bore."""
    a, b = 0.05, 0.2
    factor = 7800.0 / 4.0 * (3.3 * b**2 + 0.7 * a**2)
    exact = np.sqrt(0.05 * 2e11 / factor)
    size = even(0.005) if level == "harmonic" else _SIZES["solid"]
    try:
        reduced(tube(0.002, a, b), level, size, maximum_speed_rad_s=2.0 * exact, **SPIN)
    except ReductionError as error:
        found = re.search(r"that is to ([0-9.e+]+) rpm", str(error))
        return abs(float(found.group(1)) / RPM / exact - 1.0) if found else np.inf
    return np.inf


# Torsion of this shaft with a disk at either end is at 92 Hz, 5500 rpm.
_SLOW = MeshSize(size_m=0.1, corner_size_m=0.03, growth=1.0, around=8)


def _twisting_rotor(*interfaces: Interface) -> Body:
    return Body(
        name="twisting",
        sections=(
            section("left", -0.03, 0.0, 0.0, 0.15, STEEL),
            section("shaft", 0.0, 0.4, 0.0, 0.02, STEEL),
            section("right", 0.4, 0.43, 0.0, 0.15, STEEL),
        ),
        interfaces=interfaces,
    )


def _above_torsion(level: str) -> float:
    """Growth rate over |ω| of the free rotor at five times its torsional frequency."""
    speed = 3000.0
    size = even(0.02) if level == "harmonic" else _SLOW
    request = {"orders": (0, 1), "components": ("ux", "uy", "rz"), "modes": 3}
    body = _twisting_rotor(plane("middle", 0.2))
    if level == "solid":
        request |= {"modes": 1}
    element = reduced(body, level, size, maximum_speed_rad_s=speed, **request, **SPIN)[0]
    system = assemble({"rotor": Rotor(element=element, speed_ratio=1.0)}, ())
    modes = modes_at_speed(system, speed)
    values = np.asarray(modes.eigenvalues)
    return float(values.real.max(initial=0.0) / (2.0 * np.pi * modes.frequency_hz.max()))


def _rigid_at_speed(level: str) -> float:
    """Largest |K + Ω²(Kσ-S)| of a rigid motion over the lowest elastic eigenvalue at that speed."""
    speed = 3000.0
    size = even(0.02) if level == "harmonic" else _SLOW
    request = {"components": (), "modes": 3, "maximum_speed_rad_s": speed}
    element = reduced(_twisting_rotor(), level, size, **request, **SPIN)[0]
    k = element.stiffness + speed**2 * (element.stress_stiffening - element.spin_softening)
    rigid = element.rigid_body_modes[:, element.rigid_body_present]
    rigid = rigid / np.sqrt(np.diag(rigid.T @ element.mass @ rigid))
    elastic = np.sort(np.abs(scipy.linalg.eigvalsh(k, element.mass)))[rigid.shape[1]]
    return float(np.abs(rigid.T @ k @ rigid).max() / elastic)
