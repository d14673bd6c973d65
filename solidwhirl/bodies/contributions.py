"""Which body and which approximation an error of a system comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn import AssembledSystem, modes_at_speed
from solidwhirl.rotordyn.assembly.system import matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.estimates.eigenvalue_errors import error_scale
from solidwhirl.rotordyn.modes.damping import DEFAULT_RULE, DampingRule
from solidwhirl.rotordyn.perturbation.left_vectors import ModePairs, mode_pairs
from solidwhirl.rotordyn.superelement.residual_energy import form_products, form_weight


@dataclass(frozen=True, kw_only=True)
class AskedModes:
    """The lowest modes that are asked for: a number, or all up to a frequency."""

    #: One of them is None
    count: int | None
    frequency_max_hz: float | None
    #: Modes below this times the speed have had their critical speed, and are asked for too
    excitation_ratio: float = 0.0
    #: Which of these count: critically damped ones need no accuracy
    rule: DampingRule = DEFAULT_RULE

    def number_of(self, frequency_hz: FloatArray, speed_rad_s: float = 0.0) -> int:
        """How many of the leading modes with these rising frequencies are asked for."""
        passed = int(np.sum(2.0 * np.pi * frequency_hz <= self.excitation_ratio * speed_rad_s))
        if self.frequency_max_hz is not None:
            return max(passed, int(np.sum(frequency_hz <= self.frequency_max_hz)))
        count = len(frequency_hz) if self.count is None else min(self.count, len(frequency_hz))
        return max(passed, count)


@dataclass(frozen=True, kw_only=True, eq=False)
class Contributions:
    """Relative errors of the modes of a system at some speeds, by body and part."""

    #: (body, part) to (m,) estimates, modes of all speeds in a row
    shares: Mapping[tuple[str, str], FloatArray]
    speeds_rad_s: FloatArray  #: (m,) speed of the reference shaft of every mode
    rates: ComplexArray  #: (m,) eigenvalues s [1/s]
    motions: Mapping[str, ComplexArray]  #: Body to (n, m) its coordinates in the modes
    spin_rad_s: Mapping[str, FloatArray]  #: Body to (m,) its own speed

    @property
    def total(self) -> FloatArray:
        """Sum of all shares, (m,)."""
        return np.asarray(sum(self.shares.values(), np.zeros(len(self.rates))))

    def largest(self, part: str) -> float:
        """Largest error of a part, bodies added up."""
        own = [share for (_, p), share in self.shares.items() if p == part]
        return float(np.sum(own, axis=0).max()) if own and len(self.rates) else 0.0


def error_contributions(
    system: AssembledSystem, speeds_rad_s: Sequence[float], asked: AskedModes
) -> Contributions:
    """Estimate the errors of the lowest modes at some speeds, body by body."""
    shares: dict[tuple[str, str], list[FloatArray]] = {}
    motions: dict[str, list[ComplexArray]] = {}
    spins: dict[str, list[FloatArray]] = {}
    rates, speeds = [], []
    at_rest = modes_at_speed(system, 0.0).frequency_hz.size
    for speed in speeds_rad_s:
        modes = modes_at_speed(system, speed)
        # precession that the spin gives a frequency comes below the modes that begin at rest
        born = max(modes.frequency_hz.size - at_rest, 0)
        wanted = min(asked.number_of(modes.frequency_hz, speed) + born, modes.frequency_hz.size)
        pairs = mode_pairs(matrices_at_speed(system, speed), modes)
        chosen = np.flatnonzero(asked.rule.counts(pairs.rates[:wanted]))
        pairs = ModePairs(*(a[..., chosen] for a in pairs))
        scale = error_scale(system, pairs.rates)
        rates.append(pairs.rates)
        speeds.append(np.full(chosen.size, speed))
        for name, rotor in system.system.rotors.items():
            rows = system.transformation[system.body_slices[name]]
            left, right = rows @ pairs.left, rows @ pairs.right
            spin = rotor.speed_ratio * speed
            motions.setdefault(name, []).append(right)
            spins.setdefault(name, []).append(np.full(chosen.size, spin))
            for form in rotor.element.error_forms:
                change = np.abs(form_products(form, pairs.rates, spin, left, right))
                estimate = form_weight(form, pairs.rates) * change / scale
                shares.setdefault((name, form.part), []).append(estimate)
    return Contributions(
        shares={key: np.concatenate(parts) for key, parts in shares.items()},
        speeds_rad_s=np.concatenate(speeds),
        rates=np.concatenate(rates),
        motions={name: np.concatenate(parts, axis=1) for name, parts in motions.items()},
        spin_rad_s={name: np.concatenate(parts) for name, parts in spins.items()},
    )
