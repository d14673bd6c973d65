"""Forces of a short oil film on a journal, at any place and velocity of it.

Short bearing theory (Ocvirk): the pressure is parabolic along the bearing, and the force per angle
of the film is −µ R L³ h' / h³ with h' its total rate, the spin included. Integrals over the angle
after Sommerfeld's substitution (Booker 1965) are closed, also over the half of the film that is
squeezed, which alone carries where oil cavitates (π film).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

Film = Literal["pi", "2pi"]
_QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


class FilmForce(NamedTuple):
    """Force of a film on the journal and what it changes by.

    `force_n`: shape (2,); `stiffness_n_per_m`, `damping_n_s_per_m`: −dF/du and −dF/du' on
    (ux, uy), exact, shape (2, 2).
    """

    force_n: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray


@dataclass(frozen=True, kw_only=True)
class ShortFilm:
    """A plain cylindrical film, short beside its diameter, with open ends.

    `length_m`: of one land; `radial_clearance_m`: half the difference of the diameters; `film`:
    "pi" carries where it is squeezed, "2pi" all around; `lands`: equal ones beside each other, two
    where a groove parts them. Raises AnalysisError, all faults at once.
    """

    diameter_m: float
    length_m: float
    radial_clearance_m: float
    viscosity_pa_s: float
    film: Film = "pi"
    lands: int = 1

    def __post_init__(self) -> None:
        names = ("diameter_m", "length_m", "radial_clearance_m", "viscosity_pa_s", "lands")
        problems = [
            f"{name} is {getattr(self, name):g}; it must be positive"
            for name in names
            if not 0 < getattr(self, name) < np.inf
        ]
        if not problems and self.radial_clearance_m >= 0.1 * self.diameter_m:
            problems.append(
                f"radial_clearance_m is {self.radial_clearance_m:g}; allowed is below a tenth of "
                "the diameter"
            )
        if self.film not in ("pi", "2pi"):
            problems.append(f"film is {self.film!r}; use 'pi' or '2pi'")
        if problems:
            raise AnalysisError("short film: " + "; ".join(problems))

    @property
    def scale_n_s_per_m(self) -> float:
        """B₀ = µ R L³ / c³ of all lands, N s/m."""
        land = 0.5 * self.diameter_m * self.length_m**3 / self.radial_clearance_m**3
        return float(self.lands * self.viscosity_pa_s * land)

    def force(
        self, place_m: FloatArray, velocity_m_per_s: FloatArray, speed_rad_s: float = 0.0
    ) -> FilmForce:
        """Return the force on the journal, its stiffness and its damping.

        `place_m`, `velocity_m_per_s`: of its centre from that of the bearing, shape (2,);
        `speed_rad_s`: spin from x to y, 0 for a squeeze film. Raises AnalysisError if the journal
        touches.
        """
        place = np.asarray(place_m, dtype=float)
        away = place / self.radial_clearance_m
        ratio = float(np.hypot(*away))
        if ratio >= 1.0:
            raise AnalysisError(
                f"the journal is {ratio:.6g} radial clearances off the middle; it touches at 1"
            )
        # in axes turning with half the spin the film is only squeezed
        turning = 0.5 * speed_rad_s * _QUARTER
        rate = np.asarray(velocity_m_per_s, dtype=float) - turning @ place
        second, third = self._integrals(away, ratio, rate)
        damping = self.scale_n_s_per_m * second
        along = 3.0 * self.scale_n_s_per_m / self.radial_clearance_m * (third @ rate)
        return FilmForce(
            force_n=-damping @ rate,
            stiffness_n_per_m=along - damping @ turning,
            damping_n_s_per_m=damping,
        )

    def _integrals(
        self, away: FloatArray, ratio: float, rate: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return ∫ n n / h³ and ∫ n n n / h⁴ over the film, in clearances, shapes (2, 2), (2,)*3.

        The second times a velocity is symmetric in its first two indices.
        """
        first = away / ratio if ratio > 0 else np.array([1.0, 0.0])
        axes = np.column_stack((first, _QUARTER @ first))
        root = np.sqrt((1.0 - ratio) * (1.0 + ratio))
        ends = np.array([-np.pi, np.pi])
        if self.film == "pi":
            middle = np.arctan2(*(axes.T @ rate)[::-1])
            angle = middle + np.array([-0.5, 0.5]) * np.pi
            ends = np.arctan2(root * np.sin(angle), np.cos(angle) - ratio)
            ends[1] += 2.0 * np.pi * (ends[1] <= ends[0])
        powers = _moments(ends, ratio, root)
        second = np.array([[powers[2, 0], powers[1, 1]], [powers[1, 1], powers[0, 2]]]) / root**5
        third = np.zeros((2, 2, 2))
        for index in np.ndindex(2, 2, 2):
            third[index] = powers[3 - sum(index), sum(index)] / root**7
        return (
            axes @ second @ axes.T,
            np.einsum("ai,bj,ck,ijk->abc", axes, axes, axes, third),
        )


def _moments(ends: FloatArray, ratio: float, root: float) -> FloatArray:
    """Return ∫ (cos γ + ε)^i (√(1 − ε²) sin γ)^j dγ between two ends, i + j ≤ 3, as [i, j]."""
    c, s = np.cos(ends), np.sin(ends)
    cos = [ends, s, 0.5 * (ends + s * c), s - s**3 / 3.0]
    one, sin = -c, 0.5 * (ends - s * c)
    e, q = ratio, root
    whole = np.zeros((4, 4))
    whole[2, 0] = np.diff(cos[2] + 2.0 * e * cos[1] + e**2 * ends)[0]
    whole[1, 1] = q * np.diff(0.5 * s**2 + e * one)[0]
    whole[0, 2] = q**2 * np.diff(sin)[0]
    whole[3, 0] = np.diff(cos[3] + 3 * e * cos[2] + 3 * e**2 * cos[1] + e**3 * ends)[0]
    whole[2, 1] = q * np.diff(-((c + e) ** 3) / 3.0)[0]
    whole[1, 2] = q**2 * np.diff(s**3 / 3.0 + e * sin)[0]
    whole[0, 3] = q**3 * np.diff(c**3 / 3.0 - c)[0]
    return whole
