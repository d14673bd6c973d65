"""Cylindrical roller bearings: what the rollers do to the inner ring at a given motion of it.

Straight rollers in slices, each a line contact Q = c δ^(10/9) of steel, both races in series
(ISO/TS 16281). At speed a roller presses on the outer race also where it does not touch the inner
one; its own tilt between the races is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.bearings.elements import (
    ElementForces,
    centrifugal_load_n,
    element_problems,
)
from solidwhirl.rotordyn.bearings.hertz import BEARING_STEEL
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# c of a whole roller is this times length^(8/9): 35948 N/mm^(10/9) for a length of 1 mm
# (ISO/TS 16281), in N and m.
_LINE = 35948.0 * 1000.0 ** (10.0 / 9.0 + 8.0 / 9.0)
_POWER = 10.0 / 9.0
# Slices of a roller; the standard asks for 30.
_SLICES = 30
_STEPS = 60


@dataclass(frozen=True, kw_only=True)
class RollerBearing:
    """A cylindrical roller bearing of steel with a rotating inner ring; it carries no axial load.

    `effective_length_m`: of a roller's line contact; `radial_clearance_m`: play across, negative
    with interference. The first roller lies at +x. Raises AnalysisError, all faults at once.
    """

    roller_count: int
    roller_diameter_m: float
    effective_length_m: float
    pitch_diameter_m: float
    radial_clearance_m: float = 0.0

    def __post_init__(self) -> None:
        sizes = (self.roller_count, self.roller_diameter_m, self.pitch_diameter_m)
        problems = element_problems("roller", *sizes)
        if not 0 < self.effective_length_m < np.inf:
            problems.append(f"effective length {self.effective_length_m:g} m; it must be positive")
        if not abs(self.radial_clearance_m) < 0.1 * self.roller_diameter_m:
            problems.append(
                f"radial clearance {self.radial_clearance_m:g} m; allowed is below a tenth of the "
                "roller diameter"
            )
        if problems:
            raise AnalysisError("roller bearing: " + "; ".join(problems))

    @property
    def highest_pressure_pa(self) -> float:
        """Contact pressure at the basic static load rating, ISO 76."""
        return 4000e6

    @property
    def carried(self) -> tuple[int, ...]:
        """The motions, of ux, uy and uz, along which a load is carried."""
        return (0, 1)

    @property
    def element_count(self) -> int:
        """Number of rollers."""
        return self.roller_count

    @property
    def size_m(self) -> float:
        """Diameter of a roller, m."""
        return self.roller_diameter_m

    @property
    def stiffness_n_per_m109(self) -> float:
        """C of Q = c δ^(10/9) for a roller between both races, N/m^(10/9)."""
        return float(_LINE * self.effective_length_m ** (8.0 / 9.0))

    def centrifugal_n(self, speed_rad_s: float) -> float:
        """Return the load that presses a roller outward, N."""
        area = 0.25 * np.pi * self.roller_diameter_m**2
        mass = BEARING_STEEL.density_kg_per_m3 * area * self.effective_length_m
        ratio = self.roller_diameter_m / self.pitch_diameter_m
        return centrifugal_load_n(mass, self.pitch_diameter_m, ratio, speed_rad_s)

    def start(self, force: FloatArray, centrifugal_n: float) -> FloatArray:
        """Return a motion (5,) that loads the bearing rather too much, to begin a search from."""
        motion, radial = np.zeros(5), float(np.hypot(*force[:2]))
        if radial > 0:
            load = 5.0 * radial / self.roller_count + centrifugal_n
            deep = (load / self.stiffness_n_per_m109) ** 0.9
            play = max(0.5 * self.radial_clearance_m, 0.0)
            motion[:2] = force[:2] / radial * (deep + play)
        return motion

    def seen(self, angle: FloatArray) -> FloatArray:
        """Return the radial motion of the ring at each slice of rollers at angles (..., Z)."""
        place = ((np.arange(_SLICES) + 0.5) / _SLICES - 0.5) * self.effective_length_m
        cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
        moved = np.zeros((*angle.shape, _SLICES, 5))
        moved[..., 0], moved[..., 1] = cosine, sine
        moved[..., 3], moved[..., 4] = -sine * place, cosine * place
        return moved

    def contacts(
        self, moved: FloatArray, centrifugal_n: FloatArray, near: FloatArray | None = None
    ) -> ElementForces:
        """Return what the rollers do at motions (b, N, slices) of the ring."""
        approach = moved - 0.5 * self.radial_clearance_m
        c = 2.0**_POWER * self.stiffness_n_per_m109 / _SLICES
        own = (centrifugal_n / _SLICES)[:, None, None]
        inner = _inner_approach(approach, np.broadcast_to(own / c, approach.shape))
        load = c * inner**_POWER
        outer = ((load + own) / c) ** (1.0 / _POWER)
        total, zero = load.sum(axis=2), np.zeros(moved.shape[:2])
        return ElementForces(
            force=load,
            stiffness=_in_series(inner, outer) * _POWER * c,
            inner_load_n=total,
            outer_load_n=total + centrifugal_n[:, None],
            inner_angle_rad=zero,
            outer_angle_rad=zero,
            gap_m=(own[..., 0] / c) ** (1.0 / _POWER) - approach.max(axis=2),
            place=np.zeros((*zero.shape, 2)),
        )

    def pressure_pa(self, inner_load_n: float, outer_load_n: float) -> float:
        """Return the larger of the contact pressures at the races under two loads, Pa (Hertz)."""
        ratio = self.roller_diameter_m / self.pitch_diameter_m
        loads = ((inner_load_n, 1.0 - ratio), (outer_load_n, 1.0 + ratio))
        worst = max(load / share for load, share in loads)
        along = 2.0 / (self.roller_diameter_m * self.effective_length_m)
        return float(np.sqrt(worst * along / (2.0 * np.pi * BEARING_STEEL.compliance_per_pa)))

    def misplaced(self, found: ElementForces) -> str:
        """Tell why a load is not carried in an equilibrium, empty if it is."""
        return ""


def _inner_approach(approach: FloatArray, own: FloatArray) -> FloatArray:
    """Return δi ≥ 0 with δi + (δi^(10/9) + own)^(9/10) = δ, 0 where a slice does not touch."""
    touching = approach > own ** (1.0 / _POWER)
    inner = np.where(touching, np.maximum(0.5 * approach, 0.0), 0.0)
    if not own.any():
        return inner
    for _ in range(_STEPS):
        total = inner**_POWER + own
        # where nothing presses and nothing touches, any slope will do
        slope = 1.0 + np.where(total > 0, total, 1.0) ** (1.0 / _POWER - 1.0) * inner ** (
            _POWER - 1.0
        )
        step = (inner + total ** (1.0 / _POWER) - approach) / slope
        after = np.where(touching, np.maximum(inner - step, 0.0), 0.0)
        if np.abs(after - inner).max() <= 1e-15 * max(float(approach.max()), 0.0):
            return np.asarray(after)
        inner = after
    return inner


def _in_series(inner: FloatArray, outer: FloatArray) -> FloatArray:
    """Return ki ko / (ki + ko) of stiffnesses δ^(1/9), 0 where the inner race is free."""
    ki, ko = inner ** (_POWER - 1.0), outer ** (_POWER - 1.0)
    return np.divide(ki * ko, ki + ko, out=np.zeros_like(ki), where=ki > 0)
