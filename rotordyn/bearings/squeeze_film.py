"""A squeeze film damper: coefficients on a centred circular orbit, and where they hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError

Ends = Literal["open", "sealed"]


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
        Sommerfeld's long film (Vance 1988, Rotordynamics of Turbomachinery, chapter 6).
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

    def notes(self, whirl_rad_s: float, density_kg_per_m3: float) -> tuple[str, ...]:
        """Return where the coefficients are doubtful at a speed of the whirl, a line each."""
        found, film = [], self.film
        slender = film.length_m / film.diameter_m
        if self.ends == "open" and slender > 0.5:
            found.append(f"L/D of a land is {slender:.3g}; the short film is for 0.5 and less")
        if self.orbit_ratio > 0.4:
            found.append(
                f"orbit of {self.orbit_ratio:.3g} clearances; above 0.4 coefficients of a circle "
                "say little"
            )
        reynolds = density_kg_per_m3 * abs(whirl_rad_s) * film.radial_clearance_m**2
        reynolds /= film.viscosity_pa_s
        if reynolds > 1.0:
            found.append(
                f"squeeze Reynolds number {reynolds:.3g}; above 1 the inertia of the oil, which "
                "is left out, begins to count"
            )
        if film.film == "2pi":
            found.append("2π film: holds while the supply pressure exceeds the negative peak")
        return tuple(found)
