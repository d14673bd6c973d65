"""Stability: where a motion grows by itself, and the damping that matters over the speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.law_pieces import LawPieces
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
)
from solidwhirl.rotordyn.core.dense import scale_by_stiffness
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.modes.kinds import energy_shares, moves_laterally
from solidwhirl.rotordyn.modes.whirl import whirl_direction
from solidwhirl.rotordyn.stability.eigenvalue_paths import blocks_of
from solidwhirl.rotordyn.stability.unstable_windows import Window, unstable_windows
from solidwhirl.rotordyn.stability.whirl_decrements import (
    FirstMode,
    barely_turning,
    checked_speeds,
    first_modes,
    whirl_record,
)
from solidwhirl.rotordyn.stability.windows_with_laws import windows_with_laws

# |Im λ| below this fraction of |λ| is real.
_REAL_FRACTION = 1e-6
# A matrix with a unit diagonal may have eigenvalues this far below zero by rounding.
_SEMIDEFINITE = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class UnstableInterval(ReadOnlyArrays):
    """Hold a range of speeds in which some motion grows at every speed.

    `low_rad_s`, `high_rad_s`: its ends Ω, rad/s. `opens`, `closes`: whether growth begins at the
    lower end and ceases at the upper one; False where the range that was searched begins or ends
    with growth. `kind`: at the lower end: "flutter" (an oscillation grows) or "divergence" (a
    motion grows without oscillating). `growth_1_s`: largest Re λ in the interval, 1/s.
    `speed_rad_s`: Ω of that. `eigenvalue`: λ at the lower end, 1/s; Re λ = 0 to rounding if the
    interval opens. `frequency_hz`, `frequency_end_hz`: |Im λ| / 2π at the lower and at the upper
    end, Hz; 0 for a divergence. `whirl`: at the lower end, of lateral motion "forward", "backward",
    "mixed" or "straight", else the kind of motion; empty for a divergence. `shape`: mode there in
    the independent coordinates, shape (n,), largest entry 1; empty for a divergence.
    """

    low_rad_s: float
    high_rad_s: float
    opens: bool
    closes: bool
    kind: Literal["flutter", "divergence"]
    growth_1_s: float
    speed_rad_s: float
    eigenvalue: complex
    frequency_hz: float
    frequency_end_hz: float
    whirl: str
    shape: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StabilityChart(ReadOnlyArrays):
    """Hold the least damped motion of a system over the speed.

    `speeds_rad_s`: Ω, shape (s,). `log_decrement`: smallest of the lateral modes looked at, shape
    (s,); exactly 0 where it is rounding, nan where there is none. `frequency_hz`: of that mode,
    shape (s,), Hz. `growth_rate_1_s`: largest Re λ of all motions, oscillating or not, shape (s,);
    zeros of rigid motion aside. `unstable_count`: number of eigenvalues that grow, an oscillation
    counting once, shape (s,). `first_forward`, `first_backward`: the first mode of either whirl,
    see `whirl_decrements`.
    """

    speeds_rad_s: FloatArray
    log_decrement: FloatArray
    frequency_hz: FloatArray
    growth_rate_1_s: FloatArray
    unstable_count: IntArray
    first_forward: FirstMode
    first_backward: FirstMode


def stability_chart(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequency_max_hz: float = np.inf,
) -> StabilityChart:
    """Compute the least damped motion of a system over a range of speeds.

    `speeds_rad_s`: Ω, shape (s,), in any order; `frequency_max_hz`: leave oscillatory modes above
    this out of `log_decrement`, and those above the highest mode that every reduced body has kept:
    they are no modes of the machine. All count for `unstable_count`. For the damping of each branch
    use `campbell`. Raises AnalysisError if a speed is not finite or there is none.
    """
    speeds = checked_speeds(speeds_rad_s)
    limit_hz = min(frequency_max_hz, represented_hz(assembled))
    rows, firsts = [], []
    for speed, turning in zip(speeds, barely_turning(speeds), strict=True):
        modes = modes_at_speed(assembled, float(speed))
        whirling = modes if turning == speed else modes_at_speed(assembled, turning)
        firsts.append(first_modes(assembled, whirling))
        rows.append(_least_damped(assembled, modes, limit_hz))
    columns = np.array(rows, dtype=float).T
    whirl = whirl_record(speeds, firsts)
    return StabilityChart(
        speeds_rad_s=speeds,
        log_decrement=columns[0],
        frequency_hz=columns[1],
        growth_rate_1_s=columns[2],
        unstable_count=columns[3].astype(int),
        first_forward=whirl.first_forward,
        first_backward=whirl.first_backward,
    )


def _least_damped(
    assembled: AssembledSystem, modes: Modes, limit_hz: float
) -> tuple[float, float, float, int]:
    """Return decrement and frequency of the least damped mode, largest growth, growing motions."""
    decrement, frequency = np.nan, np.nan
    # torsion and axial motion, which bearings seldom damp, would hide all others
    lateral = moves_laterally(energy_shares(assembled, modes.shapes))
    low = np.flatnonzero((modes.frequency_hz <= limit_hz) & lateral)
    if low.size:
        at = int(low[modes.log_decrement[low].argmin()])
        decrement, frequency = modes.log_decrement[at], modes.frequency_hz[at]
    rates = _rates(modes)
    largest = float(rates.rates.max()) if rates.rates.size else np.nan
    return decrement, frequency, largest, int(rates.growing.sum())


def represented_hz(assembled: AssembledSystem) -> float:
    """Return the frequency up to which the modes of all bodies are kept, Hz.

    Returns lowest over the bodies of the highest mode that each has kept; inf if none is reduced to
    modes. What oscillates above is left over by the truncation.
    """
    kept = [
        max(modal)
        for rotor in assembled.system.rotors.values()
        if (modal := [c.frequency_hz for c in rotor.element.coordinates if c.kind == "modal"])
    ]
    return min(kept, default=np.inf)


class _Rates(NamedTuple):
    """All eigenvalues that are not zero, oscillating first, with their growth."""

    values: ComplexArray
    rates: FloatArray
    growing: BoolArray


def _rates(modes: Modes) -> _Rates:
    values = np.concatenate((modes.eigenvalues, modes.real_eigenvalues.astype(complex)))
    return _Rates(values, values.real, values.real > NEUTRAL * np.abs(values))


def unstable_intervals(
    assembled: AssembledSystem, speed_low_rad_s: float, speed_high_rad_s: float
) -> tuple[UnstableInterval, ...]:
    """Find all ranges of speed in which some motion grows.

    `speed_low_rad_s`, `speed_high_rad_s`: range of Ω that is searched, rad/s. Intervals rise and
    lie apart from each other. Growth below 1e-8 of the eigenvalue counts as neutral, and so do
    motions of free bodies. Raises AnalysisError if the speeds are not finite, or the second is not
    above the first.

    A system without cross-coupling whose damping takes energy from every motion and whose
    stiffness is not negative has no such range, which is known without a search. Else all
    eigenvalues are followed between the knots of the speed laws, see `unstable_windows`, and where
    bearings depend on the frequency `windows_with_laws`.
    """
    if not (np.isfinite([speed_low_rad_s, speed_high_rad_s]).all()):
        raise AnalysisError(f"speeds are {speed_low_rad_s} and {speed_high_rad_s}; both are finite")
    if speed_high_rad_s <= speed_low_rad_s:
        raise AnalysisError(
            f"speed_high_rad_s is {speed_high_rad_s}; it must be above {speed_low_rad_s}"
        )
    low, high = float(speed_low_rad_s), float(speed_high_rad_s)
    if _never_grows(assembled, low, high):
        return ()
    if assembled.depends_on_frequency:
        windows = windows_with_laws(assembled, low, high)
    else:
        windows = [
            window
            for block in blocks_of(assembled, low, high)
            for window in unstable_windows(block, assembled.knots_rad_s, low, high)
        ]
    return tuple(_interval(assembled, window) for window in _united(windows))


def _united(windows: list[Window]) -> list[Window]:
    """Join windows of several blocks that overlap."""
    united: list[Window] = []
    for window in sorted(windows, key=lambda one: one[:2]):
        if not united or window.low > united[-1].high:
            united.append(window)
            continue
        last = united[-1]
        later = window if window.high > last.high else last
        higher = window if window.top.real > last.top.real else last
        united[-1] = last._replace(
            high=later.high,
            closes=later.closes,
            end=later.end,
            top=higher.top,
            top_speed=higher.top_speed,
        )
    return united


def _interval(assembled: AssembledSystem, window: Window) -> UnstableInterval:
    """Return the record of a window, with the mode at its lower end."""
    kind: Literal["flutter", "divergence"] = "divergence"
    onset, whirl, shape = window.onset, "", np.empty(0, dtype=complex)
    if _oscillates(onset):
        kind, onset = "flutter", complex(onset.real, abs(onset.imag))
        modes = modes_at_speed(assembled, window.low)
        shape = modes.shapes[:, int(np.abs(modes.eigenvalues - onset).argmin())]
        whirl = str(whirl_direction(assembled, shape[:, None])[0])
        shape = shape / shape[np.abs(shape).argmax()]
    else:
        onset = complex(onset.real)
    return UnstableInterval(
        low_rad_s=window.low,
        high_rad_s=window.high,
        opens=window.opens,
        closes=window.closes,
        kind=kind,
        growth_1_s=window.top.real,
        speed_rad_s=window.top_speed,
        eigenvalue=onset,
        frequency_hz=onset.imag / (2.0 * np.pi),
        frequency_end_hz=abs(window.end.imag) / (2.0 * np.pi) if _oscillates(window.end) else 0.0,
        whirl=whirl,
        shape=shape,
    )


def _oscillates(value: complex) -> bool:
    return abs(value.imag) > _REAL_FRACTION * abs(value)


def _never_grows(assembled: AssembledSystem, low: float, high: float) -> bool:
    """Whether the energy of every motion is positive and never rises, known without a search.

    Without the laws the stiffness is linear in Ω², so that it is nowhere more negative than at the
    ends; a law that is nowhere negative adds to it.
    """
    if assembled.circulatory_stiffness.any() or not assembled.has_symmetric_joints:
        return False
    if not np.array_equal(assembled.stiffness, assembled.stiffness.T):
        return False
    least, most = 0.0 if low < 0 < high else min(abs(low), abs(high)), max(abs(low), abs(high))
    if not _is_semidefinite(assembled.damping):
        return False
    if not all(_resists(joint.pieces, least, most) for joint in assembled.law_joints):
        return False
    ends = (assembled.stiffness + v**2 * assembled.centrifugal_stiffness for v in (least, most))
    return all(
        scale_by_stiffness(k, assembled.mass, assembled.body_rate).negative_count == 0 for k in ends
    )


def _resists(pieces: LawPieces | None, least: float, most: float) -> bool:
    """Whether stiffness and damping of a law are symmetric and nowhere negative in a range.

    Between the speeds at which an entry turns or the determinant vanishes the signs stay.
    """
    if pieces is None or not pieces.is_symmetric:
        return False
    turns = np.concatenate(([least], pieces.turning_speeds(least, most), [most]))
    looked = np.concatenate((turns, 0.5 * (turns[1:] + turns[:-1])))
    return all(_is_semidefinite(m) for v in looked for m in pieces.at(float(v)))


def _is_semidefinite(matrix: FloatArray) -> bool:
    """Whether a matrix is symmetric and no motion has a negative energy in it, to rounding."""
    if not matrix.any():
        return True
    if not np.array_equal(matrix, matrix.T):
        return False
    diagonal = np.diag(matrix)
    if (diagonal < 0).any():
        return False
    active = diagonal > 0
    if matrix[~active].any():
        return False
    scale = 1.0 / np.sqrt(diagonal[active])
    values = la.eigvalsh(scale[:, None] * matrix[np.ix_(active, active)] * scale)
    return bool(values[0] >= -_SEMIDEFINITE)
