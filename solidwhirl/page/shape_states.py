"""Which modes a page shows: at rest, at the speeds of the scene, at the critical speeds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.page.traces import hertz_text
from solidwhirl.pipeline import Results
from solidwhirl.rotordyn import AssembledSystem, Campbell, Modes, modes_at_speed
from solidwhirl.rotordyn.branch_numbers import branch_numbers
from solidwhirl.rotordyn.picture_frame import mode_name
from solidwhirl.rotordyn.whirl import whirl_at_speed

_RPM = 30.0 / np.pi
# Speeds, modes at each, and critical speeds that a page shows.
_SPEEDS, MODES, _CRITICAL = 4, 8, 12


@dataclass(frozen=True, kw_only=True, eq=False)
class ShownModes:
    """Modes that are chosen together.

    Attributes
    ----------
    label
        What a list says.
    modes
        Of the system, by rising frequency; those at critical speeds each at its own speed.
    rpm
        Speed of the reference shaft at each mode, shape (m,).
    whirl
        Of each mode.
    texts
        What a list says of each mode.
    numbers
        Their branches of the Campbell diagram from 1, 0 for none; None where they are no list.
    """

    label: str
    modes: Modes
    rpm: NDArray[np.float64]
    whirl: tuple[str, ...]
    texts: tuple[str, ...]
    numbers: tuple[int, ...] | None = None


def shown_modes(results: Results) -> tuple[ShownModes, ...]:
    """Return the modes of a run that its page shows.

    Those at the speeds of its mode shape analyses, or at rest and at its top speed where it has
    none, then those at its critical speeds.

    Parameters
    ----------
    results
        The run.
    """
    system = results.system
    found = []
    for rpm in _speeds(results):
        modes = (
            _lowest(results.at_rest) if rpm == 0.0 else modes_at_speed(system, rpm / _RPM, MODES)
        )
        modes = _lowest(modes)
        if modes.eigenvalues.size:
            found.append(_at_speed(system, results.campbell, rpm, modes))
    critical = _critical(results)
    return (*found, critical) if critical is not None else tuple(found)


def _speeds(results: Results) -> list[float]:
    """Speeds, rpm, rising."""
    asked = [
        float(rpm)
        for spec in results.scene.analyses
        if spec.kind == "mode_shapes"
        for rpm in spec.speeds_rpm
    ]
    top = float(results.campbell.speeds_rad_s.max()) * _RPM
    return sorted({round(rpm, 9) for rpm in asked or [0.0, top]})[:_SPEEDS]


def _lowest(modes: Modes) -> Modes:
    # equal frequencies may be more than a list should hold
    kept = min(modes.eigenvalues.size, MODES)
    family = None if modes.family is None else modes.family[:kept]
    return replace(
        modes, eigenvalues=modes.eigenvalues[:kept], shapes=modes.shapes[:, :kept], family=family
    )


def _at_speed(system: AssembledSystem, diagram: Campbell, rpm: float, modes: Modes) -> ShownModes:
    whirl = whirl_at_speed(system, modes.shapes, modes.eigenvalues, modes.speed_rad_s)
    numbers = tuple(int(k) for k in branch_numbers(system, diagram, modes))
    hertz = modes.eigenvalues.imag / (2.0 * np.pi)
    return ShownModes(
        label="at rest" if rpm == 0.0 else f"at {rpm:.0f} rpm",
        modes=modes,
        rpm=np.full(hertz.size, rpm),
        whirl=tuple(str(w) for w in whirl),
        numbers=numbers,
        texts=tuple(
            f"mode {mode_name(numbers, k)}, {hertz_text(f)}, {w}"
            for k, (f, w) in enumerate(zip(hertz, whirl, strict=True))
        ),
    )


def _critical(results: Results) -> ShownModes | None:
    """The modes at the critical speeds; equal ones of several exciters once."""
    entries: dict[tuple[float, float, str], Any] = {}
    rule = results.scene.criteria.rule
    for c in results.critical_speeds:
        found = c.critical
        if not found.counts(rule):
            continue
        # a pair of backward and forward whirl may be at one speed
        place = round(float(found.speed_rad_s), 6), round(float(found.frequency_hz), 6)
        key = (*place, str(found.whirl))
        entries.setdefault(key, c)
    chosen = list(entries.values())[:_CRITICAL]
    if not chosen:
        return None
    critical = [c.critical for c in chosen]
    rpm = np.array([c.speed_rad_s * _RPM for c in critical])
    omega = np.array([2.0 * np.pi * c.frequency_hz for c in critical])
    decrement = np.array([c.log_decrement for c in critical])
    modes = Modes(
        speed_rad_s=float(critical[0].speed_rad_s),
        eigenvalues=omega * (1j - decrement / (2.0 * np.pi)),
        shapes=np.column_stack([c.shape for c in critical]).astype(complex),
        real_eigenvalues=np.empty(0),
        zero_count=0,
        negative_stiffness_count=0,
    )
    return ShownModes(
        label="at the critical speeds",
        modes=modes,
        rpm=rpm,
        whirl=tuple(str(c.whirl) for c in critical),
        texts=tuple(
            f"{c.speed_rad_s * _RPM:.1f} rpm, {hertz_text(c.frequency_hz)}, {c.whirl}"
            for c in critical
        ),
    )
