"""A short plain journal bearing: equilibrium under its load, stiffness and damping there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.bearings.validity import Exceeded
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# A film thinner than this fraction of the clearance is none.
_THINNEST = 1e-3
# Length over diameter and eccentricity ratio up to which the theory is for.
_LONGEST, _FARTHEST = 0.5, 0.7


class JournalState(NamedTuple):
    """A journal in equilibrium.

    `eccentricity_ratio`: distance from the middle over the radial clearance; `attitude_rad`: from
    the load to the eccentricity, in the sense of the spin; `place_m`: of the journal, shape (2,);
    `stiffness_n_per_m`, `damping_n_s_per_m`: on (ux, uy), shape (2, 2).
    """

    eccentricity_ratio: float
    attitude_rad: float
    place_m: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray


def journal_state(film: ShortFilm, load_n: tuple[float, float], speed_rad_s: float) -> JournalState:
    """Return the equilibrium of a journal under a load, with its coefficients.

    `load_n`: on the journal along x and y, such as its weight; `speed_rad_s`: from x to y,
    negative the other way. Raises AnalysisError without a load or speed, or if the film would be
    thinner than a thousandth of the clearance.

    Ocvirk (1952); Friswell, Penny, Garvey and Lees (2010), Dynamics of Rotating Machines, p. 177.
    """
    load = float(np.hypot(*load_n))
    if not (load > 0 and np.isfinite(load)):
        raise AnalysisError(f"load {list(load_n)} N: a journal bearing needs one that is not 0")
    if speed_rad_s == 0 or not np.isfinite(speed_rad_s):
        raise AnalysisError("a journal that does not turn has no film that carries")
    unit = 0.5 * film.scale_n_s_per_m * film.radial_clearance_m * abs(speed_rad_s)
    ratio = _eccentricity(film, load / unit)
    if ratio > 1.0 - _THINNEST:
        raise AnalysisError(
            f"a load of {load:.6g} N cannot be carried at {abs(speed_rad_s):.6g} rad/s: the film "
            f"would be thinner than {_THINNEST:g} of the clearance"
        )
    attitude = 0.5 * np.pi
    if film.film == "pi":
        attitude = np.arctan2(np.pi * np.sqrt(1.0 - ratio**2), 4.0 * ratio)
    angle = np.arctan2(load_n[1], load_n[0]) + np.sign(speed_rad_s) * attitude
    place = ratio * film.radial_clearance_m * np.array([np.cos(angle), np.sin(angle)])
    found = film.force(place, np.zeros(2), speed_rad_s)
    return JournalState(
        eccentricity_ratio=ratio,
        attitude_rad=float(attitude),
        place_m=place,
        stiffness_n_per_m=found.stiffness_n_per_m,
        damping_n_s_per_m=found.damping_n_s_per_m,
    )


def _eccentricity(film: ShortFilm, load: float) -> float:
    """Return ε for a load in units of ½ B₀ c Ω; it rises with the load."""

    def carried(log_slope: float) -> float:
        # ε as a sine, so that 1 − ε² keeps its digits near 1
        tangent = np.exp(log_slope)
        left = 1.0 / (1.0 + tangent**2)
        ratio = tangent * np.sqrt(left)
        if film.film == "2pi":
            return float(np.pi * ratio / left**1.5)
        return float(0.5 * ratio / left**2 * np.sqrt(16.0 * ratio**2 + np.pi**2 * left))

    found = scipy.optimize.brentq(
        lambda y: np.log(carried(y) / load), -80.0, 40.0, xtol=1e-14, rtol=1e-14
    )
    return float(np.sin(np.arctan(np.exp(found))))


def exceeded(film: ShortFilm, state: JournalState) -> tuple[Exceeded, ...]:
    """Return where a journal is beyond short bearing theory: length and eccentricity."""
    found = []
    slender = film.length_m / film.diameter_m
    if slender > _LONGEST:
        found.append(
            Exceeded("L/D of a land", slender, _LONGEST, "the short film carries too much")
        )
    if state.eccentricity_ratio > _FARTHEST:
        why = "the short film carries too much"
        found.append(Exceeded("eccentricity ratio", state.eccentricity_ratio, _FARTHEST, why))
    return tuple(found)
