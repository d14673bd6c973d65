"""Peaks of orbits over the frequency of an unbalance, their summits solved for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.response.harmonic_response import (
    TRANSLATIONS,
    harmonic_response,
    node_amplitudes,
)
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance import Unbalance, frequency_ratio, unbalance_loads
from solidwhirl.rotordyn.response.unbalance_peaks import (
    ResonancePeak,
    refined_peaks,
    resonance_peaks,
)


def orbit_peaks(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    frequencies_rad_s: npt.ArrayLike,
    major_m: npt.ArrayLike,
    least_m: npt.ArrayLike = 0.0,
) -> tuple[ResonancePeak, ...]:
    """Find the peaks of an orbit over the frequency, each where the response is highest.

    `unbalances`: all that turn at one frequency; `node`: interface whose orbit it is;
    `frequencies_rad_s`, `major_m`: sampled, rising ω > 0 and major half axes, shape (s,) each;
    `least_m`: peaks up to this height are rounding and left out, shape (s,) or a number. Without
    damping peaks have no height: they stay as they were sampled. Raises AnalysisError if the
    samples do not fit or do not rise.
    """
    omega, major = np.asarray(frequencies_rad_s, dtype=float), np.asarray(major_m, dtype=float)
    least = np.broadcast_to(np.asarray(least_m, dtype=float), omega.shape)
    peaks = [
        peak
        for peak in resonance_peaks(omega, major)
        if peak.amplitude > np.interp(peak.position_rad_s, omega, least)
    ]
    if assembled.is_conservative or not peaks:
        return tuple(peaks)
    ratio = frequency_ratio(assembled, unbalances[0])
    pattern = unbalance_loads(assembled, unbalances)

    def height(at: float) -> float:
        load = (at**2 * pattern)[None, :, None]
        solved = harmonic_response(assembled, [at / ratio], [at], load).displacement[:, :, 0]
        motion = node_amplitudes(assembled, [node], TRANSLATIONS, solved)[0, 0]
        return float(elliptic_orbits(motion[0], motion[1]).major_m)

    knots = ratio * np.array(assembled.knots_rad_s)
    return refined_peaks(peaks, omega, major, height, knots)
