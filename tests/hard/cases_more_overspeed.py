"""Speeds at which a body loses its stiffness, or only seems to."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from builders_body import even, reduced, tube
from builders_more import last_rpm, material, refusal, speed_of_loss_rad_s
from shapes import STEEL, section

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
    """Speeds a millionth below that are refused, a millionth or 0.4 above that are not."""
    below = _answer(level, order, held, 1.0 - 1e-6)
    above = [_answer(level, order, held, part) for part in (1.0 + 1e-6, 1.4)]
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
