"""Maps of the steady response over frequency and support stiffness, and the choice from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import joint_motion
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem, with_bearing_stiffness
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError, NoSteadyResponseError
from solidwhirl.rotordyn.response import harmonic_response as harmonic
from solidwhirl.rotordyn.response.maps import StepPeaks
from solidwhirl.rotordyn.response.orbits import OrbitRecord
from solidwhirl.rotordyn.response.unbalance import Unbalance, frequency_ratio, unbalance_loads

# Residual over the force, and loss of digits, beyond which a response is solved by itself.
_LOST, _CANCELLED = 1e-11, 1e4
# Samples of a map that a band around the operating point must hold.
_FEWEST_SAMPLES = 5


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StiffnessMap(OrbitRecord):
    """Hold the response to a turning force over its frequency and the stiffness of supports.

    `unbalance`: gives the force u ω², its place and its sense; `bearings`: names of the bearings
    that have the stiffness; `stiffness_n_per_m`: k of k·I on (ux, uy), shape (k,);
    `frequencies_rad_s`: ω of the force, shape (f,); `speeds_rad_s`: Ω of the reference shaft at
    each frequency, shape (f,); `node`: where the response is taken; `translation_m`: complex
    amplitudes of its ux, uy, shape (k, f, 2).
    """

    unbalance: Unbalance
    bearings: tuple[str, ...]
    stiffness_n_per_m: FloatArray
    frequencies_rad_s: FloatArray
    speeds_rad_s: FloatArray
    node: End
    translation_m: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StiffnessChoice(ReadOnlyArrays):
    """Hold the stiffness with the smallest response around an operating point.

    `stiffness_n_per_m`: the best of the map; `amplitude_m`: its largest major semi-axis within the
    band, m; `band_rad_s`: lowest and highest frequency of the band; `candidates_m`: largest major
    semi-axis within the band for each stiffness of the map, shape (k,), m; `is_at_end`: whether
    the best is the smallest or largest stiffness of the map, so that a better one may lie beyond
    it.
    """

    stiffness_n_per_m: float
    amplitude_m: float
    band_rad_s: tuple[float, float]
    candidates_m: FloatArray
    is_at_end: bool


def synchronous_stiffness_map(
    assembled: AssembledSystem,
    bearings: Sequence[str],
    stiffness_n_per_m: npt.ArrayLike,
    unbalance: Unbalance,
    frequencies_rad_s: npt.ArrayLike,
    node: End,
) -> StiffnessMap:
    """Compute the response to an unbalance for a range of support stiffness.

    `bearings`: names of the bearings that get the stiffness, all the same; `stiffness_n_per_m`:
    values to try, rising, shape (k,). `unbalance`: on a body that turns; the frequency is that of
    its spin, so Ω = ω / |speed ratio|. `frequencies_rad_s`: ω ≥ 0, shape (f,); `node`: an
    interface with ux and uy, where the response is taken. Design of experiments as in Müller and
    Hennings, section 5.4 and figure 10. Raises AnalysisError if an argument has no meaning, or a
    point lies at an undamped resonance.
    """
    frequencies = harmonic.non_negative("frequencies_rad_s", frequencies_rad_s)
    speeds = frequencies / frequency_ratio(assembled, unbalance)
    return _map(assembled, bearings, stiffness_n_per_m, unbalance, frequencies, speeds, node)


def stiffness_map_at_speed(
    assembled: AssembledSystem,
    bearings: Sequence[str],
    stiffness_n_per_m: npt.ArrayLike,
    unbalance: Unbalance,
    frequencies_rad_s: npt.ArrayLike,
    node: End,
    speed_rad_s: float,
) -> StiffnessMap:
    """Compute the response to a turning force at one speed for a range of support stiffness.

    `unbalance`: gives the amplitude u ω², the place and the sense of a force whose frequency ω is
    not that of the spin; `speed_rad_s`: Ω ≥ 0 of the reference shaft. All is at the one speed.
    Raises AnalysisError: see `synchronous_stiffness_map`.
    """
    frequencies = harmonic.non_negative("frequencies_rad_s", frequencies_rad_s)
    frequency_ratio(assembled, unbalance)
    if not (np.isfinite(speed_rad_s) and speed_rad_s >= 0):
        raise AnalysisError(f"speed_rad_s is {speed_rad_s}; finite and 0 or more is allowed")
    speeds = np.full(frequencies.size, float(speed_rad_s))
    return _map(assembled, bearings, stiffness_n_per_m, unbalance, frequencies, speeds, node)


def choose_stiffness(
    stiffness_map: StiffnessMap,
    operating_frequency_rad_s: float,
    margin: float = 0.2,
    peaks: StepPeaks | None = None,
) -> StiffnessChoice:
    """Choose the stiffness with the smallest response in a band around the operating point.

    `stiffness_map`: the map; its frequencies must rise and reach over the band.
    `operating_frequency_rad_s`: frequency of the force in operation, rad/s. `margin`: half width
    of the band as a fraction of that; 0.15 to 0.2 are the usual separation margins (Yoon, Lin and
    Allaire 2013, Control of Surge in Centrifugal Compressors). `peaks`: of `stiffness_map_peaks`,
    for resonances that are sharper than the steps of the map; None takes the responses at its
    frequencies alone. Müller and Hennings, section 5.4, chose the values of table 5 so. The
    largest response in the band counts, so that no resonance lies in it unless all values have
    one. Raises AnalysisError if the band is not inside the map, or fewer than 5 of its frequencies
    lie in it.
    """
    center, frequencies = float(operating_frequency_rad_s), stiffness_map.frequencies_rad_s
    if not (np.isfinite(center) and center > 0 and 0 < margin < 1):
        raise AnalysisError(
            f"operating_frequency_rad_s is {center} and margin {margin}; needed are a positive "
            "number and one between 0 and 1"
        )
    band = ((1.0 - margin) * center, (1.0 + margin) * center)
    inside = (frequencies >= band[0]) & (frequencies <= band[1])
    covered = frequencies.min() <= band[0] and frequencies.max() >= band[1]
    if not covered or inside.sum() < _FEWEST_SAMPLES:
        raise AnalysisError(
            f"the band {band[0]:.6g} to {band[1]:.6g} rad/s needs {_FEWEST_SAMPLES} frequencies of "
            f"the map in it and must lie within {frequencies.min():.6g} to "
            f"{frequencies.max():.6g} rad/s; found {int(inside.sum())}"
        )
    largest = stiffness_map.major_m()[:, inside].max(axis=1)
    if peaks is not None:
        there = (peaks.frequency_rad_s >= band[0]) & (peaks.frequency_rad_s <= band[1])
        largest = np.maximum(largest, np.where(there, peaks.height_m, 0.0).max(axis=1))
    best = int(largest.argmin())
    return StiffnessChoice(
        stiffness_n_per_m=float(stiffness_map.stiffness_n_per_m[best]),
        amplitude_m=float(largest[best]),
        band_rad_s=band,
        candidates_m=largest,
        is_at_end=best in (0, largest.size - 1),
    )


def _map(
    assembled: AssembledSystem,
    bearings: Sequence[str],
    stiffness_n_per_m: npt.ArrayLike,
    unbalance: Unbalance,
    frequencies: FloatArray,
    speeds: FloatArray,
    node: End,
) -> StiffnessMap:
    """Return the response at points (Ω, ω) of the system with each stiffness."""
    values = np.asarray(stiffness_n_per_m, dtype=float)
    if values.ndim != 1 or not values.size or not (np.diff(values) > 0).all():
        raise AnalysisError(
            f"stiffness_n_per_m needs a rising list of numbers; found shape {values.shape}"
        )
    harmonic.check_lateral(assembled, node, "node of the response")
    found = StiffnessMap(
        unbalance=unbalance,
        bearings=tuple(bearings),
        stiffness_n_per_m=values,
        frequencies_rad_s=frequencies,
        speeds_rad_s=speeds,
        node=node,
        translation_m=np.empty((0, frequencies.size, 2), dtype=complex),
    )
    rows, left = _rows_of_one(assembled, found)
    for at in np.flatnonzero(left.any(axis=1)):
        points = (frequencies[left[at]], speeds[left[at]])
        rows[at, left[at]] = stiffness_row(assembled, found, float(values[at]), *points)
    return replace(found, translation_m=rows)


def _rows_of_one(
    assembled: AssembledSystem, wanted: StiffnessMap
) -> tuple[ComplexArray, BoolArray]:
    """Return the responses of a map from those with one stiffness, (k, f, 2), and what is left.

    Another stiffness is a change of low rank: with the receptances H of the motions J q of the
    bearings, J q = (1 + Δk H)⁻¹ J q₀ (Woodbury; Hager 1989, SIAM Review 31). Where that loses
    digits, a bearing has a law of its own, or the one stiffness has no steady response, the
    response is left to be solved by itself, (k, f).
    """
    values, frequencies = wanted.stiffness_n_per_m, wanted.frequencies_rad_s
    rows = np.zeros((values.size, frequencies.size, 2), dtype=complex)
    every = np.ones(rows.shape[:2], dtype=bool)
    middle = float(values[values.size // 2])
    base = with_bearing_stiffness(assembled, wanted.bearings, middle)
    named = [b for b in base.system.bearings if b.name in wanted.bearings]
    if any(bearing.speed_law is not None for bearing in named):
        return rows, every
    motion = np.concatenate([joint_motion(base, bearing)[:2] for bearing in named])
    pattern = unbalance_loads(base, [wanted.unbalance])
    force = (frequencies**2)[:, None, None] * pattern[:, None]
    # where nothing pushes nothing moves, and a system may be free to drift
    units = np.where(frequencies[:, None, None] > 0, motion.T.astype(complex), 0.0)
    try:
        solved = harmonic.harmonic_response(
            base, wanted.speeds_rad_s, frequencies, np.concatenate((force, units), axis=2)
        )
    except NoSteadyResponseError:
        return rows, every
    seen = solved.displacement.swapaxes(1, 2)
    at_node = harmonic.node_amplitudes(
        base, (wanted.node,), harmonic.TRANSLATIONS, seen.reshape(-1, base.size)
    ).reshape(*seen.shape[:2], 2)
    moved = seen @ motion.T
    left = ~every
    size = la.norm(pattern) * frequencies**2
    for at, change in enumerate(values - middle):
        small = np.eye(len(motion)) + change * moved[:, 1:].swapaxes(1, 2)
        try:
            pull = change * np.linalg.solve(small, moved[:, 0, :, None])[..., 0]
        except np.linalg.LinAlgError:
            left[at] = True
            continue
        rows[at] = at_node[:, 0] - (pull[:, None] @ at_node[:, 1:])[:, 0]
        # residual of the parts over the force, and digits that their sum loses
        reach = size + np.abs(pull) @ la.norm(motion, axis=1)
        parts = np.abs(at_node[:, 0]) + (np.abs(pull)[:, None] @ np.abs(at_node[:, 1:]))[:, 0]
        is_cancelled = la.norm(parts, axis=1) > _CANCELLED * la.norm(rows[at], axis=1)
        left[at] = (solved.relative_residual * reach > _LOST * size) | is_cancelled
    return rows, left


def stiffness_row(
    assembled: AssembledSystem,
    stiffness_map: StiffnessMap,
    stiffness_n_per_m: float,
    frequencies_rad_s: FloatArray,
    speeds_rad_s: FloatArray,
) -> ComplexArray:
    """Compute the response of a map with one stiffness of the supports.

    `frequencies_rad_s`, `speeds_rad_s`: points (ω, Ω), shape (f,) each. Returns complex amplitudes
    of ux, uy, shape (f, 2), m.
    """
    changed = with_bearing_stiffness(assembled, stiffness_map.bearings, stiffness_n_per_m)
    pattern = unbalance_loads(changed, [stiffness_map.unbalance])
    loads = (frequencies_rad_s**2)[:, None, None] * pattern[:, None]
    points = (speeds_rad_s, frequencies_rad_s)
    return harmonic.node_response(changed, (stiffness_map.node,), *points, loads)[:, 0]
