"""Mistuned blades by the fundamental mistuning model.

One family of modes that is apart from all others, its blades alike in shape: with the tuned
frequencies ω_p of all N waves p = 0 ... N - 1 and the relative deviations Δ_s of the frequencies of
the sectors (Feiner and Griffin, J. Turbomach. 124 (2002) 597-605)

    A = Ω0² + 2 Ω0 D Ω0,   Ω0 = diag(ω_p),   D_pq = 1/N Σ_s Δ_s e^{i(q - p)sα},

whose eigenvalues are the squared frequencies. Amplitudes of the sectors are x_s = Σ_p β_p e^{ipsα}.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.nodal_diameters.interference import excited_index
from solidwhirl.rotordyn.nodal_diameters.matrices import CyclicBody
from solidwhirl.rotordyn.nodal_diameters.modes import HZ_PER_RAD_S, index_spectrum

# Frequencies per half width of a resonance, and widths beyond the ends of the spectrum.
_PER_WIDTH, _BEYOND = 4.0, 6.0
_MOST_FREQUENCIES = 50_000
# Amplitudes on that grid that may still hold the highest peak, over the highest of them.
_CANDIDATE = 0.97
_QUANTILES = (0.05, 0.5, 0.95, 0.99)


@dataclass(frozen=True, kw_only=True, eq=False)
class MistunedModes(ReadOnlyArrays):
    """Modes of one pattern."""

    #: (N,) rising
    frequency_hz: FloatArray
    #: (N, N) amplitudes of the sectors by mode, columns of unit length
    sectors: ComplexArray
    #: (N, N) the same as parts of the waves p
    waves: ComplexArray


class ForcedPattern(NamedTuple):
    """Largest response of one pattern to an engine order."""

    #: (N,) largest amplitude of every blade over the frequency, over that of the tuned ones
    amplification: FloatArray
    #: (N,) where it has it
    frequency_hz: FloatArray

    @property
    def factor(self) -> float:
        """Amplification factor: the largest of all blades."""
        return float(self.amplification.max())


@dataclass(frozen=True, kw_only=True, eq=False)
class AmplificationStatistics(ReadOnlyArrays):
    """Amplification factors of random patterns."""

    #: (samples,) rising
    factors: FloatArray
    #: (N,) deviations of the worst pattern
    worst_deviations: FloatArray
    #: By probability
    quantiles: dict[float, float]
    #: (1 + √N) / 2 (Whitehead, J. Mech. Eng. Sci. 8 (1966) 15-21)
    bound: float


def whitehead_bound(sectors: int) -> float:
    """Return the largest amplification factor that mistuning can bring, (1 + √N) / 2."""
    return 0.5 * (1.0 + float(np.sqrt(sectors)))


def tuned_frequencies(body: CyclicBody, speed_rad_s: float, mode: int) -> FloatArray:
    """Return the frequencies [Hz] of all waves p = 0 ... N - 1 of a mode at a speed, (N,).

    `mode`: from 0 by rising frequency. Raises AnalysisError: a body of revolution, or one of which
    not all indices are known.
    """
    if body.sectors is None:
        raise AnalysisError(f"{body.name!r} is of revolution; it has no blades to be mistuned")
    known = {m.index: m for m in body.indices}
    found = np.empty(body.sectors)
    for wave in range(body.sectors):
        index, direction = excited_index(wave, body.sectors)
        if index not in known:
            raise AnalysisError(
                f"mistuning needs all nodal diameters from 0 to {body.sectors // 2}; {index} is "
                "missing"
            )
        rates = index_spectrum(known[index], speed_rad_s, direction).rates_rad_s
        found[wave] = abs(float(rates[mode])) * HZ_PER_RAD_S
    return found


def mistuned_modes(tuned_hz: FloatArray, deviations: FloatArray) -> MistunedModes:
    """Return the modes of a pattern.

    `tuned_hz`: (N,) of the waves p = 0 ... N - 1; those beyond N/2 run forward. `deviations`: (N,)
    of the frequencies of the sectors, relative. Raises AnalysisError: lengths that differ.
    """
    if np.shape(deviations) != np.shape(tuned_hz):
        raise AnalysisError(
            f"{np.size(deviations)} deviations of blades for {np.size(tuned_hz)} sectors"
        )
    count = len(tuned_hz)
    turn = np.exp(2j * np.pi / count * np.outer(np.arange(count), np.arange(count)))
    turn /= np.sqrt(count)  # sectors from waves, unitary
    coupling = turn.conj().T @ (deviations[:, None] * turn)
    squared = np.diag(tuned_hz**2) + 2.0 * tuned_hz[:, None] * coupling * tuned_hz
    values, waves = np.linalg.eigh(squared)
    if values[0] <= 0.0:
        raise AnalysisError("the deviations leave a blade without stiffness")
    return MistunedModes(frequency_hz=np.sqrt(values), sectors=turn @ waves, waves=waves)


def forced_response(
    tuned_hz: FloatArray, modes: MistunedModes, engine_order: int, damping_ratio: float
) -> ForcedPattern:
    """Return the largest response of every blade to an engine order, over that of tuned ones.

    All modes have the same damping ratio, below 1/√2; the force has the same size at every speed.
    """
    count = len(tuned_hz)
    wave = engine_order % count
    tuned = 0.5 / (damping_ratio * np.sqrt(1.0 - damping_ratio**2) * tuned_hz[wave] ** 2)
    parts = np.sqrt(count) * modes.sectors * modes.waves[wave].conj()
    grid = _frequencies(modes.frequency_hz, damping_ratio)
    blades = np.abs(parts @ _receptances(modes.frequency_hz, grid, damping_ratio))
    peak, at = blades.max(axis=1), grid[blades.argmax(axis=1)]
    # the highest blade alone decides; the others are as good as the grid
    for blade in np.flatnonzero(peak > _CANDIDATE * peak.max()):
        width = 1.5 * damping_ratio * at[blade] / _PER_WIDTH

        def lost(hertz: float, own: ComplexArray = parts[blade]) -> float:
            return -float(np.abs(own @ _receptances(modes.frequency_hz, hertz, damping_ratio)))

        best = scipy.optimize.minimize_scalar(
            lost, bounds=(at[blade] - width, at[blade] + width), method="bounded"
        )
        if -best.fun > peak[blade]:
            peak[blade], at[blade] = -best.fun, best.x
    return ForcedPattern(amplification=peak / tuned, frequency_hz=at)


def _receptances(own_hz: FloatArray, hertz: FloatArray | float, ratio: float) -> ComplexArray:
    """1 / (ω_j² - ω² + 2iζ ω_j ω) in units of Hz, (N, ...)."""
    own = own_hz.reshape(-1, *(1,) * np.ndim(hertz))
    return np.asarray(1.0 / (own**2 - np.square(hertz) + 2j * ratio * own * hertz))


def _frequencies(own_hz: FloatArray, ratio: float) -> FloatArray:
    """Frequencies around all resonances."""
    low, high = own_hz[0] * (1.0 - _BEYOND * ratio), own_hz[-1] * (1.0 + _BEYOND * ratio)
    step = ratio * own_hz[0] / _PER_WIDTH
    wanted = int((high - low) / step) + 2
    if wanted <= _MOST_FREQUENCIES:
        return np.asarray(np.linspace(max(low, 0.5 * own_hz[0]), high, wanted))
    # lightly damped and far apart: near the resonances alone
    near = np.arange(-_BEYOND, _BEYOND, 1.0 / _PER_WIDTH)
    return np.asarray(np.unique(own_hz[:, None] * (1.0 + ratio * near)))


def random_deviations(
    sectors: int, standard_deviation: float, samples: int, seed: int
) -> FloatArray:
    """Return normally distributed deviations of the blades' frequencies, (samples, N)."""
    generator = np.random.default_rng(seed)
    return np.asarray(standard_deviation * generator.standard_normal((samples, sectors)))


def amplification_statistics(
    tuned_hz: FloatArray, patterns: FloatArray, engine_order: int, damping_ratio: float
) -> AmplificationStatistics:
    """Return the amplification factors of many patterns, (samples, N)."""
    factors = np.array(
        [
            forced_response(
                tuned_hz, mistuned_modes(tuned_hz, own), engine_order, damping_ratio
            ).factor
            for own in patterns
        ]
    )
    return AmplificationStatistics(
        factors=np.sort(factors),
        worst_deviations=patterns[int(factors.argmax())],
        quantiles={q: float(np.quantile(factors, q)) for q in _QUANTILES},
        bound=whitehead_bound(patterns.shape[1]),
    )
