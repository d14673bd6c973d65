"""Speeds at which a body loses its stiffness, or only seems to."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.linalg
from builders_body import STEEL, even, plane, reduced, section, tube
from builders_more import last_rpm, material, refusal, speed_of_loss_rad_s

from solidwhirl.geometry import Body, Interface
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction import MAXIMUM_HOOP_STRAIN

RPM = 30.0 / np.pi
RIM = material(2000.0, 2e13, "rim")
SIZES = {
    "harmonic": even(0.003),
    "solid": MeshSize(size_m=0.03, corner_size_m=0.03, through_thickness=0.2, around=8),
}
CARRIED = {0: ("uz", "rz"), 1: ("ux", "uy", "rx", "ry")}
SPIN = {"centrifugal": True, "gyroscopic": True}
# Round bar of which torsion has its first frequency c π / L.
LENGTH, TWIST = 0.5, float(np.sqrt(STEEL.youngs_modulus_pa / 2.6 / STEEL.density_kg_per_m3))
TORSION_RAD_S = np.pi * TWIST / LENGTH
BAR = {
    "harmonic": even(0.02),
    "solid": MeshSize(size_m=0.05, corner_size_m=0.05, around=4),
}


def _plate_inside_a_rim(held: bool) -> Body:
    """A thin plate that hangs inwards from a stiff rim: rotation presses it until it buckles."""
    rim = Interface(name="rim", kind="outer", coupling="distributing", start_m=-0.005, end_m=0.005)
    return Body(
        name="plate",
        sections=(
            section("rim", -0.005, 0.005, 0.06, 0.07, RIM),
            section("plate", -0.001, 0.001, 0.02, 0.06, STEEL),
        ),
        interfaces=(rim,) if held else (),
    )


@lru_cache(maxsize=8)
def _exact(level: str, order: int, held: bool) -> float:
    return speed_of_loss_rad_s(_plate_inside_a_rim(held), level, SIZES[level], order)


def _answer(level: str, order: int, held: bool, part: float) -> str:
    """Message of the refusal at a part of the speed of loss."""
    request = {"components": CARRIED[order] if held else (), "orders": (order,), "modes": 3}
    speed = part * _exact(level, order, held)
    body = _plate_inside_a_rim(held)
    return refusal(
        lambda: reduced(body, level, SIZES[level], maximum_speed_rad_s=speed, **SPIN, **request)
    )


def _speed_error(level: str, held: bool, order: int) -> float:
    exact = _exact(level, order, held) * RPM
    error = abs(last_rpm(_answer(level, order, held, 1.2)) / exact - 1.0)
    return float(error) if np.isfinite(error) else np.inf


def _wrong_decisions(level: str, held: bool, order: int) -> float:
    """Speeds a millionth below that are refused, a millionth or half above that are not."""
    below = _answer(level, order, held, 1.0 - 1e-6)
    above = [_answer(level, order, held, part) for part in (1.0 + 1e-6, 1.5)]
    return float(bool(below) + sum("lost its stiffness" not in text for text in above))


def _hoop_limit(level: str, which: int) -> float:
    return _ring(level)[which]


@lru_cache(maxsize=2)
def _ring(level: str) -> tuple[float, float]:
    """Error of the allowed speed that is stated, and wrong decisions 0.2 % from the closed form."""
    a, b, nu = 0.0995, 0.1005, STEEL.poissons_ratio
    body, size = tube(0.001, a, b), even(0.0005)
    if level == "solid":
        size = MeshSize(size_m=0.02, corner_size_m=0.02, through_thickness=0.05, around=24)
    # bore of a flat ring in plane stress: ε = ρ Ω² ((3+ν) b² + (1-ν) a²) / 4E
    square = ((3.0 + nu) * b**2 + (1.0 - nu) * a**2) / 4.0
    strain = STEEL.density_kg_per_m3 * square / STEEL.youngs_modulus_pa
    exact = float(np.sqrt(MAXIMUM_HOOP_STRAIN / strain))

    def answer(part: float) -> str:
        request = {"components": (), "modes": 1, "centrifugal": True}
        return refusal(
            lambda: reduced(body, level, size, maximum_speed_rad_s=part * exact, **request)
        )

    far, near, below = answer(1.5), answer(1.002), answer(0.998)
    error = abs(last_rpm(far) / (exact * RPM) - 1.0)
    return error, float(bool(below) + ("hoop strain" not in near) + ("hoop strain" not in far))


@lru_cache(maxsize=4)
def _torsion(level: str, held: bool) -> tuple[int, int]:
    """Negative eigenvalues of reduced K + Ω²K2 at 2.5 times the first torsional frequency.

    With the stress stiffness, and without it.
    """
    body = tube(LENGTH, 0.0, 0.02, *((plane("end", 0.1),) if held else ()))
    speed = 2.5 * TORSION_RAD_S
    request = {"orders": (0,), "components": CARRIED[0], "modes": 5, "maximum_speed_rad_s": speed}
    element = reduced(body, level, BAR[level], **request, **SPIN)[0]
    counts = []
    for stiffening in (element.stress_stiffening, np.zeros_like(element.mass)):
        k = element.stiffness + speed**2 * (stiffening - element.spin_softening)
        values = scipy.linalg.eigh(k, element.mass, eigvals_only=True)
        counts.append(int(np.sum(values < -1e-9 * TORSION_RAD_S**2)))
    return counts[0], counts[1]


def _false_instabilities(level: str) -> float:
    return float(sum(_torsion(level, held)[0] for held in (False, True)))


def _not_shown(level: str) -> float:
    """Of three false instabilities (rz, first and second torsion) those that do not appear."""
    return float(sum(max(0, 3 - _torsion(level, held)[1]) for held in (False, True)))
