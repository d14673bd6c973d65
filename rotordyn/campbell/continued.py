"""Branches at a speed between two at which they are known: some modes, not the whole spectrum."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.campbell.matching import (
    GOOD_OVERLAP,
    POOR_OVERLAP,
    SAME_FREQUENCY,
    match_modes,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, together
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed
from solidwhirl.rotordyn.modes.nearby import modes_near, nearby_modes

# Eigenvalues closer than this (relative) are sought as one group.
_NEAR = 2e-3
# Places looked at for a meeting, and for the speed at which a motion begins to oscillate.
_PLACES = 24
# The first of the latter lies this part of the way from where it oscillates,
_BESIDE = 1.0 / 16.0
# and this (relative) is how closely it is placed. One of a pair is sought without the other where
# they are so far apart.
_PLACED, _APART = 1e-8, 0.2
# What is left of the discriminant there, as a part of what it was.
_VANISHED = 1e-3
# The shift is off the mean of a pair by this part, as D is singular there in the end.
_OFF = 1e-2


# Modes at a speed, all that matter; None if they are not at hand without the whole spectrum.
AtHand = Callable[[float], Modes | None]


def continued(
    assembled: AssembledSystem,
    low: Modes,
    high: Modes,
    speed_rad_s: float,
    at_hand: AtHand | None = None,
) -> Modes | None:
    """Return branches at a speed between two.

    `low`, `high`: the same branches at two speeds, column by column. Returns them at the speed;
    None if one can't be told from others without the whole spectrum: its MAC to the nearer of the
    two is below 0.8, or other modes are as near.
    """
    near, expected = _expected(low, high, speed_rad_s)
    known = None if at_hand is None else at_hand(speed_rad_s)
    if known is not None:
        match = match_modes(assembled, near, known)
        if match.mac.min(initial=1.0) >= GOOD_OVERLAP:
            return mode_columns(match.second, match.partner)
    find = modes_near(assembled, speed_rad_s)
    values, shapes = np.empty_like(expected), np.empty(near.shapes.shape, dtype=complex)
    for group in together(np.abs(expected[:, None] - expected) <= _NEAR * np.abs(expected)):
        rate = complex(expected[group].mean())
        found = find(rate, near.shapes[:, group]) if rate else None
        if found is None:
            return None
        values[group], shapes[:, group] = found
    modes = dataclasses.replace(near, speed_rad_s=speed_rad_s, eigenvalues=values, shapes=shapes)
    match = match_modes(assembled, near, modes)
    if match.mac.min(initial=1.0) < GOOD_OVERLAP or (values.imag <= 0).any():
        return None
    order = match.partner
    return dataclasses.replace(
        modes, eigenvalues=values[order], shapes=match.second.shapes[:, order]
    )


def alone_at(
    assembled: AssembledSystem, low: Modes, high: Modes, speed_rad_s: float
) -> ComplexArray | None:
    """Return the eigenvalues of branches at a speed between two, each the nearest to expectation.

    As `continued`, but of branches that may pass through each other: shapes are not compared.
    """
    near, expected = _expected(low, high, speed_rad_s)
    find = modes_near(assembled, speed_rad_s)
    found = [find(complex(rate), near.shapes[:, [k]]) for k, rate in enumerate(expected)]
    values = [one[0][0] for one in found if one is not None]
    return np.array(values) if len(values) == len(expected) else None


def _expected(low: Modes, high: Modes, speed_rad_s: float) -> tuple[Modes, ComplexArray]:
    """Return the nearer of two sets of the same branches, and eigenvalues between them."""
    begin, end = low.speed_rad_s, high.speed_rad_s
    part = (speed_rad_s - begin) / (end - begin) if end != begin else 0.0
    return (low if part <= 0.5 else high), (1.0 - part) * low.eigenvalues + part * high.eigenvalues


def meeting_of(
    assembled: AssembledSystem, low: Modes, high: Modes, at_hand: AtHand
) -> tuple[float, bool]:
    """Return where two branches have one frequency, and whether they pass through each other there.

    `low`, `high`: two branches at two speeds, whose frequencies change their order in between.
    Returns Ω, and whether their frequencies are one to 1e-4 there; false if they veer, or only the
    whole spectrum tells.
    """
    speed = low.speed_rad_s
    for _ in range(_PLACES):
        gaps = [float(np.diff(modes.eigenvalues.imag)[0]) for modes in (low, high)]
        part = float(np.clip(abs(gaps[0]) / (abs(gaps[0]) + abs(gaps[1])), 0.02, 0.98))
        speed = low.speed_rad_s + part * (high.speed_rad_s - low.speed_rad_s)
        here = continued(assembled, low, high, speed, at_hand)
        if here is None:
            return speed, False
        first, second = here.eigenvalues.imag
        if abs(second - first) <= SAME_FREQUENCY * first:
            return speed, True
        low, high = (here, high) if (second - first) * gaps[0] > 0 else (low, here)
    return speed, False


def turning_point(assembled: AssembledSystem, mode: Modes, still_rad_s: float) -> Modes:
    """Return a motion where its oscillation begins or ends: two real eigenvalues become a pair.

    `mode`: the motion alone, at a speed at which it oscillates; `still_rad_s`: a speed at which it
    does not. Halves the way between them by the whole spectrum until it is found from the nearer.
    """
    for _ in range(_PLACES):
        found = _turning_near(assembled, mode, still_rad_s)
        if found is not None:
            return found
        middle = 0.5 * (mode.speed_rad_s + still_rad_s)
        match = match_modes(assembled, mode, modes_at_speed(assembled, middle))
        if match.mac[0] > POOR_OVERLAP:
            mode = mode_columns(match.second, match.partner)
        else:
            still_rad_s = middle
    return mode


def _turning_near(assembled: AssembledSystem, mode: Modes, still_rad_s: float) -> Modes | None:
    """Return the turning point of a motion by some modes alone, if they come to rest there.

    With λ = s ± √d the discriminant d is as smooth as the system where it is zero, and the two
    states span one subspace on both sides: d is followed to its zero by the secant method.
    """
    if assembled.depends_on_frequency:  # of two motions that meet each has its own bearings
        return None
    value, shapes = complex(mode.eigenvalues[0]), np.hstack((mode.shapes, mode.shapes.conj()))
    limits = sorted((mode.speed_rad_s, still_rad_s))
    before, above, beside = mode.speed_rad_s, -(value.imag**2), _OFF * abs(value)
    speed, mean, expected = before + _BESIDE * (still_rad_s - before), value.real, above
    for _ in range(_PLACES):
        matrices = matrices_at_speed(assembled, speed)
        if expected < -((_APART * mean) ** 2):
            alone = nearby_modes(matrices, complex(mean, np.sqrt(-expected)), shapes[:, :1])
            if alone is None:
                return None
            one, other = complex(alone[0][0]), complex(alone[0][0]).conjugate()
            shapes = np.hstack((alone[1], alone[1].conj()))
        else:
            pair = nearby_modes(matrices, complex(mean, beside), shapes)
            if pair is None:
                return None
            (one, other), shapes = pair
        mean, discriminant = 0.5 * (one + other).real, 0.25 * ((one - other) ** 2).real
        if abs(speed - before) <= _PLACED * abs(speed) or discriminant == above:
            if abs(discriminant) > _VANISHED * value.imag**2:
                return None
            at = np.array([complex(mean)])
            return dataclasses.replace(
                mode, speed_rad_s=speed, eigenvalues=at, shapes=shapes[:, :1].astype(complex)
            )
        slope = (discriminant - above) / (speed - before)
        before, above = speed, discriminant
        speed = min(max(speed - discriminant / slope, limits[0]), limits[1])
        expected = discriminant + slope * (speed - before)
    return None
