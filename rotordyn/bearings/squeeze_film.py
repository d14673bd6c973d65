"""A squeeze film damper: coefficients on a centred circular orbit, and where they hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.bearings.validity import Exceeded
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError

Ends = Literal["open", "sealed"]
# Length over diameter, orbit over clearance and squeeze Reynolds number up to which it holds.
_LONGEST, _WIDEST, _SLOWEST = 0.5, 0.4, 1.0
_AMBIENT_PA = 101325.0


class OrbitCoefficients(NamedTuple):
    """Direct stiffness (N/m) and damping (N s/m) of a damper on its orbit."""

    stiffness_n_per_m: float
    damping_n_s_per_m: float


@dataclass(frozen=True, kw_only=True)
class SqueezeFilmDamper:
    """A squeeze film damper on a centred circular orbit.

    `film`: its dimensions; `length_m` is that of a land; `orbit_ratio`: radius of the orbit over
    the radial clearance, below 1; `ends`: "open" is the short film, "sealed" a film without flow
    along the axis; `whirl_ratio`: speed of the whirl over that of the spin, 1 for unbalance.
    `film.force` is the force at any place and velocity, with open ends.
    """

    film: ShortFilm
    orbit_ratio: float
    ends: Ends = "open"
    whirl_ratio: float = 1.0

    def __post_init__(self) -> None:
        problems = []
        if not 0 <= self.orbit_ratio < 1:
            problems.append(f"orbit_ratio is {self.orbit_ratio:g}; allowed is 0 to below 1")
        if self.ends not in ("open", "sealed"):
            problems.append(f"ends is {self.ends!r}; use 'open' or 'sealed'")
        if not np.isfinite(self.whirl_ratio):
            problems.append(f"whirl_ratio is {self.whirl_ratio}; it must be finite")
        if problems:
            raise AnalysisError("squeeze film: " + "; ".join(problems))

    def coefficients(self, whirl_rad_s: float) -> OrbitCoefficients:
        """Return stiffness and damping on a circular orbit run through at a speed, rad/s.

        The force is −K e inward and −C e |ω| against the motion. Open ends: Ocvirk; sealed ends:
        Sommerfeld's long film (Vance 1988, Rotordynamics of Turbomachinery).
        """
        ratio, left = self.orbit_ratio, 1.0 - self.orbit_ratio**2
        if self.ends == "open":
            scale = self.film.scale_n_s_per_m
            damping, stiffness = np.pi * scale / (2.0 * left**1.5), 2.0 * ratio / left**2
        else:
            cubed = (0.5 * self.film.diameter_m / self.film.radial_clearance_m) ** 3
            scale = self.film.lands * self.film.viscosity_pa_s * self.film.length_m * cubed
            damping = 12.0 * np.pi * scale / ((2.0 + ratio**2) * np.sqrt(left))
            stiffness = 24.0 * ratio / ((2.0 + ratio**2) * left)
        if self.film.film == "2pi":
            return OrbitCoefficients(0.0, float(2.0 * damping))
        return OrbitCoefficients(float(stiffness * scale * abs(whirl_rad_s)), float(damping))

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z, shape (2, 2), of the orbit run through at `whirl_ratio` times the spin."""
        found = self.coefficients(self.whirl_ratio * speed_rad_s)
        value = found.stiffness_n_per_m + rate * found.damping_n_s_per_m
        return np.asarray(value * np.eye(2), dtype=complex)

    def suction_pa(self, whirl_rad_s: float) -> float:
        """Return the peak of the negative film pressure of open ends, all around full of oil, Pa.

        Amid a land, 3/2 µ ω (L/c)² ε sin θ / (1 + ε cos θ)³ at its largest.
        """
        ratio = self.orbit_ratio
        if ratio == 0.0:
            return 0.0
        cosine = (1.0 - np.sqrt(1.0 + 24.0 * ratio**2)) / (4.0 * ratio)
        shape = ratio * np.sqrt(1.0 - cosine**2) / (1.0 + ratio * cosine) ** 3
        slender = (self.film.length_m / self.film.radial_clearance_m) ** 2
        return float(1.5 * self.film.viscosity_pa_s * abs(whirl_rad_s) * slender * shape)

    def exceeded(
        self,
        whirl_rad_s: float,
        density_kg_per_m3: float | None = None,
        supply_pressure_pa: float | None = None,
    ) -> tuple[Exceeded, ...]:
        """Return where the coefficients are doubtful at a speed of the whirl.

        `density_kg_per_m3`: of the oil, for the squeeze Reynolds number; `supply_pressure_pa`:
        above ambient, for cavitation. What is None is not looked at, but that a 2π film without a
        supply pressure has none.
        """
        found, film = [], self.film
        slender = film.length_m / film.diameter_m
        if self.ends == "open" and slender > _LONGEST:
            found.append(
                Exceeded("L/D of a land", slender, _LONGEST, "the short film forces too much")
            )
        if self.orbit_ratio > _WIDEST:
            why = "coefficients of a circle say little of other orbits"
            found.append(Exceeded("orbit over clearance", self.orbit_ratio, _WIDEST, why))
        reynolds = (density_kg_per_m3 or 0.0) * abs(whirl_rad_s) * film.radial_clearance_m**2
        reynolds /= film.viscosity_pa_s
        if reynolds > _SLOWEST:
            why = "the inertia of the oil, which is left out, begins to count"
            found.append(Exceeded("squeeze Reynolds number", reynolds, _SLOWEST, why))
        return (*found, *self._cavitation(whirl_rad_s, supply_pressure_pa))

    def _cavitation(self, whirl_rad_s: float, supply_pa: float | None) -> Iterator[Exceeded]:
        """Yield whether the film cavitates where it should not, or does not where it should."""
        if self.ends == "sealed" or (supply_pa is None and self.film.film == "pi"):
            return
        suction, held = self.suction_pa(whirl_rad_s), _AMBIENT_PA + (supply_pa or 0.0)
        name = "peak of the negative film pressure [Pa]"
        if self.film.film == "2pi" and suction > held:
            why = "above ambient and supply pressure the oil cavitates, a 2π film does not"
            yield Exceeded(name, suction, held, why)
        if self.film.film == "pi" and 0.0 < suction < held:
            why = "below ambient and supply pressure the oil fills the gap, a π film does not"
            yield Exceeded(name, suction, held, why)
