"""Critical speeds of a lightly damped system, refined from those without damping and counted."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.critical_speeds.refined import Meeting, Root, refined_root
from solidwhirl.rotordyn.critical_speeds.undamped import (
    undamped_critical_speeds,
    undamped_places,
)
from solidwhirl.rotordyn.modes.damping import damping_ratio
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed

# A mode below this damping ratio is lightly damped.
_LIGHT = 0.1
# Intervals between the speeds at which modes are counted, beside the knots of speed laws.
_INTERVALS = 6
# How far (relative) a critical speed may lie from the one without damping.
_FARTHEST = 0.1
# Roots closer than this (relative) whose shapes are as close are one.
_SAME = 1e-8


def lightly_damped(assembled: AssembledSystem, ratio: float, limit: float) -> list[Meeting] | None:
    """Return where modes meet the excitation, if all are lightly damped and none can be missing.

    `ratio`, `limit`: |α| and the largest Ω. Each is refined from one without damping. At several
    speeds the modes with Im λ < αΩ are counted: their number changes by the roots in between and by
    modes that begin or end, at zero frequency. None if a mode below α times the limit is damped by
    a tenth or more, a bearing's stiffness is negative or unknown between its points, or the count
    disagrees; then branches have to be followed.
    """
    knots = [knot for knot in assembled.knots_rad_s if 0.0 < knot < limit]
    speeds = np.unique(np.concatenate((np.linspace(0.0, limit, _INTERVALS + 1), knots)))
    spectra: list[Modes] = []
    for speed in speeds[::-1].tolist():
        spectra.insert(0, modes_at_speed(assembled, speed))
        if not _is_light(spectra[0], ratio * limit):
            return None
    places = undamped_places(assembled, ratio, limit)
    if not places.size:
        return None
    start, shapes = undamped_critical_speeds(assembled, ratio, limit)
    if start.size != places.size:
        return None
    roots = []
    for speed, shape in zip(start, shapes.T, strict=True):
        root = _refined(assembled, ratio, float(speed), shape)
        if root is None:
            return None
        roots.append(root)
    inside = [root for root in roots if root.meeting.speed <= limit]
    told = _are_distinct(inside) and _agrees(spectra, inside, ratio)
    return [root.meeting for root in inside] if told else None


def _is_light(modes: Modes, frequency_rad_s: float) -> bool:
    """Whether no motion below a frequency is damped much, and none creeps or diverges."""
    low = modes.eigenvalues[modes.eigenvalues.imag <= frequency_rad_s]
    return not modes.real_eigenvalues.size and not (np.abs(damping_ratio(low)) > _LIGHT).any()


def _refined(
    assembled: AssembledSystem, ratio: float, start: float, shape: ComplexArray
) -> Root | None:
    """Return the root next to a critical speed without damping."""
    value = _of_energies(matrices_at_speed(assembled, start), shape, 1j * ratio * start)
    return refined_root(assembled, ratio, Meeting(start, value, shape), _FARTHEST)


def _of_energies(matrices: SpeedMatrices, shape: ComplexArray, near: complex) -> complex:
    """Return the root of φᴴ D(λ) φ next to a number: damping to first order."""
    mass, damping, gyroscopic, stiffness = (shape.conj() @ (m @ shape) for m in matrices)
    roots = np.roots([mass, damping + gyroscopic, stiffness])
    return complex(roots[np.abs(roots - near).argmin()])


def _are_distinct(roots: Sequence[Root]) -> bool:
    """Whether no two roots are one: near in speed and eigenvalue, and of one shape."""
    ordered = sorted((root.meeting for root in roots), key=lambda meeting: meeting.speed)
    for k, one in enumerate(ordered):
        for other in ordered[k + 1 :]:
            if other.speed - one.speed > _SAME * one.speed:
                break
            product = np.abs(np.vdot(one.shape, other.shape)) ** 2
            sizes = np.vdot(one.shape, one.shape).real * np.vdot(other.shape, other.shape).real
            if abs(one.value - other.value) <= _SAME * abs(one.value) and product > 0.9 * sizes:
                return False
    return True


def _agrees(spectra: Sequence[Modes], roots: Sequence[Root], ratio: float) -> bool:
    """Whether the modes above the excitation change by the roots between the speeds."""
    speeds = np.array([root.meeting.speed for root in roots])
    signs = np.array([1 if root.falls else -1 for root in roots])
    above = [_above(modes, ratio) for modes in spectra]
    for (low, many), (high, fewer) in pairwise(
        (modes.speed_rad_s, count) for modes, count in zip(spectra, above, strict=True)
    ):
        if many - fewer != signs[(speeds > low) & (speeds <= high)].sum():
            return False
    return True


def _above(modes: Modes, ratio: float) -> int:
    frequencies: FloatArray = modes.eigenvalues.imag
    return int(np.count_nonzero(frequencies > ratio * modes.speed_rad_s))
