"""How strongly a root is damped, and whether it counts as a resonance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.standards.api617_lateral import CRITICALLY_DAMPED

# Re λ below this fraction of |λ| is rounding of the eigensolver: there is no damping to speak of.
ROUNDING = 1e-11
# Growth below this fraction of |λ| counts as neutral: it takes 1e7 periods to be seen.
NEUTRAL = 1e-8
# Above this damping ratio no forced response has a maximum: the motion does not resonate.
PEAKLESS = float(np.sqrt(0.5))
# Above this damping ratio a motion creeps: which of many it is at the next speed is no matter.
CREEPING = 0.995


@dataclass(frozen=True, kw_only=True, slots=True)
class DampingRule:
    """Say which roots are resonances.

    `amplification_min`: a root counts from this amplification factor 1 / 2ζ on. Below it the root
    is critically damped in the words of API 617, whose limit is 2.5: neither a critical speed nor
    looked at for margins and accuracy. Roots that grow always count. Raises AnalysisError if the
    limit is below 0 or not finite.
    """

    amplification_min: float = CRITICALLY_DAMPED

    def __post_init__(self) -> None:
        if not (np.isfinite(self.amplification_min) and self.amplification_min >= 0):
            raise AnalysisError(
                f"amplification_min is {self.amplification_min}; it must be 0 or more, and finite"
            )

    def counts(self, eigenvalues: ComplexArray) -> BoolArray:
        """Tell which eigenvalues are resonances.

        `eigenvalues`: λ in 1/s, any shape; nan does not count. Returns same shape: λ oscillates,
        and its amplification factor reaches the limit, or it grows.
        """
        values = np.asarray(eigenvalues)
        ratio = damping_ratio(values)
        allowed = 0.5 / self.amplification_min if self.amplification_min > 0 else np.inf
        return np.asarray((np.abs(values.imag) > 0) & (ratio <= allowed))


DEFAULT_RULE = DampingRule()


def damping_ratio(eigenvalues: ComplexArray) -> FloatArray:
    """Return ζ = −Re λ / |λ|, exactly 0 where the real part is rounding.

    `eigenvalues`: λ in 1/s, any shape; 0 for λ = 0.
    """
    values = np.asarray(eigenvalues)
    size = np.where(values == 0.0, 1.0, np.abs(values))
    return np.where(np.abs(values.real) <= ROUNDING * size, 0.0, -values.real / size)


def log_decrement(eigenvalues: ComplexArray) -> FloatArray:
    """Return the logarithmic decrement of oscillatory eigenvalues.

    `eigenvalues`: λ in 1/s, any shape, Im λ ≠ 0. Returns −2π Re λ / |Im λ|, same shape; exactly 0
    where the real part is rounding.
    """
    values = np.asarray(eigenvalues)
    still = np.abs(values.real) <= ROUNDING * np.abs(values)
    return np.where(still, 0.0, -2.0 * np.pi * values.real / np.abs(values.imag)) + 0.0


def amplification_factor(log_decrement: float) -> float:
    """Return the amplification factor of a mode with a logarithmic decrement.

    `log_decrement`: δ = 2πζ / √(1 − ζ²). Returns 1 / 2ζ, which is π/δ for light damping; inf for δ
    = 0, negative for δ < 0 (unstable).
    """
    if log_decrement == 0:
        return float("inf")
    ratio = log_decrement / float(np.hypot(2.0 * np.pi, log_decrement))
    return 0.5 / ratio
