"""Highest response in the steps between the frequencies of a map, however sharp resonances are."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import NoSteadyResponseError
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.response import resonance_samples as samples
from solidwhirl.rotordyn.response.maps import GroundMotionMap, StepPeaks, ground_motion_map
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.stiffness_maps import StiffnessMap, stiffness_row
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks

# Rounds in which peaks are sought between samples, and distance of points from each other there,
# in parts of the steps between them.
_ROUNDS, _APART = 3, 1e-3
# Largest rise of a logarithm, as that from nothing is.
_HIGHEST = 700.0


def ground_motion_peaks(assembled: AssembledSystem, ground_map: GroundMotionMap) -> StepPeaks:
    """Find the highest response to ground motion in the steps of a map.

    `ground_map`: at rising frequencies. The result is for every speed of the map. Between speeds
    nothing is sought: along a resonance that moves with the speed heights change slowly.
    """
    known, direction = ground_map.frequencies_rad_s, ground_map.direction

    def row(at: int) -> Row:
        speed = float(ground_map.speeds_rad_s[at])

        def respond(frequencies: FloatArray) -> ComplexArray:
            found = ground_motion_map(
                assembled, ground_map.amplitude_m, direction, [speed], frequencies, ground_map.node
            )
            return np.asarray(found.translation_m[0])

        eigenvalues = modes_at_speed(assembled, speed).eigenvalues
        return resolved_row(known, ground_map.translation_m[at], eigenvalues, respond)

    rows = (row(at) for at in range(ground_map.speeds_rad_s.size))
    return step_peaks(known, rows, sampled_peaks if assembled.is_conservative else summits)


def stiffness_map_peaks(assembled: AssembledSystem, stiffness_map: StiffnessMap) -> StepPeaks:
    """Find the highest response to a turning force in the steps of a map.

    `stiffness_map`: at rising frequencies. The result is for every stiffness of the map.
    """
    known, speeds = stiffness_map.frequencies_rad_s, stiffness_map.speeds_rad_s
    pieces = samples.SMOOTH
    if speeds.size and speeds[0] != speeds[-1]:
        ratio = known[-1] / speeds[-1]
        pieces = samples.SMOOTH._replace(knots=ratio * np.array(assembled.knots_rad_s))

    def row(at: int) -> Row:
        def respond(frequencies: FloatArray) -> ComplexArray:
            # one speed, or one that is proportional to the frequency
            between = np.interp(frequencies, known, speeds)
            value = float(stiffness_map.stiffness_n_per_m[at])
            return stiffness_row(assembled, stiffness_map, value, frequencies, between)

        fine, motion = samples.resolved_response(
            known, stiffness_map.translation_m[at], respond, pieces
        )
        return Row(fine, motion, respond)

    rows = (row(at) for at in range(stiffness_map.stiffness_n_per_m.size))
    return step_peaks(known, rows, sampled_peaks if assembled.is_conservative else summits)


class Row(NamedTuple):
    """A row of a map, sampled more finely, and the response at other frequencies.

    `frequencies`: (p,); `motion`: ux, uy, (p, 2), or those of k motions that have nothing to do
    with each other, (p, k, 2).
    """

    frequencies: FloatArray
    motion: ComplexArray
    respond: Callable[[FloatArray], ComplexArray]


#: Places, heights and relative errors of the heights, (k,) each, of the peaks of a row.
Summits = Callable[[Row, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


def resolved_row(
    known: FloatArray,
    motion: ComplexArray,
    eigenvalues: ComplexArray,
    respond: Callable[[FloatArray], ComplexArray],
) -> Row:
    """Return a row of a map with samples around its modes.

    `known`: frequencies, rising, (f,); `motion`: there; `eigenvalues`: λ at the speed of the row.
    """
    more = np.setdiff1d(samples.samples_around_modes(known, eigenvalues), known)
    if not more.size:
        return Row(known, motion, respond)
    return Row(*samples.joined_samples(known, motion, more, respond(more)), respond)


def step_peaks(known: FloatArray, rows: Iterable[Row], found_in: Summits) -> StepPeaks:
    """Return the highest response in the steps around known frequencies.

    `known`: rising, (f,); `rows`: sampled more finely; `found_in`: what finds the peaks of a row.
    """
    middles = 0.5 * (known[1:] + known[:-1])
    found = []
    for row in rows:
        fine = row.frequencies
        height = _heights(row.motion)
        error = np.zeros(fine.size)
        if fine.size > 2:
            place, top, rest = found_in(row, height)
            fine, height = np.append(fine, place), np.append(height, top)
            error = np.append(error, rest)
        step = np.searchsorted(middles, fine)
        # the highest of each step comes last, and stays
        order = np.argsort(height, kind="stable")
        values = np.empty((3, known.size))
        values[:, step[order]] = height[order], fine[order], error[order]
        found.append(values)
    heights, places, errors = np.stack(found, axis=1)
    return StepPeaks(height_m=heights, frequency_rad_s=places, sampling_error=errors)


def _heights(motion: ComplexArray) -> FloatArray:
    """Major semi-axes, (p,); of k motions the root of the sum of their squares."""
    major = elliptic_orbits(motion[..., 0], motion[..., 1]).major_m
    return major if major.ndim == 1 else np.asarray(np.linalg.norm(major, axis=1))


def sampled_peaks(row: Row, height: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Peaks as they are sampled: they have no height."""
    tops = resonance_peaks(row.frequencies, height)
    return (
        np.array([top.position_rad_s for top in tops]),
        np.array([top.amplitude for top in tops]),
        np.full(len(tops), np.inf),
    )


def summits(row: Row, height: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places and heights of the peaks of a row, solved for, and the relative errors of these.

    Each is bracketed by three points, which draw nearer from round to round: to the vertex of the
    parabola through their logarithms and, as a corner has none, to the middles between them. Where
    that meets a mode that is hardly damped, so that there is no steady response, the peak has the
    height of the highest point that has one, with an infinite error.
    """
    y = np.maximum(height, np.finfo(float).tiny)
    at = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:])) + 1
    place, top = (values[at[:, None] + [-1, 0, 1]] for values in (row.frequencies, y))
    before, rise = top[:, 1], np.zeros(at.size)
    is_bounded = np.ones(at.size, dtype=bool)
    for _ in range(_ROUNDS if at.size else 0):
        before = top[:, 1]
        vertex, _ = _vertices(place, np.log(top))
        more = np.stack((vertex, *(0.5 * (place[:, k] + place[:, k + 1]) for k in (0, 1))), axis=1)
        solved = _steady_heights(row, more)
        is_bounded &= solved.all(axis=1)
        solved = np.maximum(solved, np.finfo(float).tiny)
        place, top = _bracket(np.hstack((place, more)), np.hstack((top, solved)))
    if at.size:
        _, rise = _vertices(place, np.log(top))
    error = np.expm1(rise) + 1.0 - before / top[:, 1]
    return place[:, 1], top[:, 1], np.where(is_bounded, error, np.inf)


def _steady_heights(row: Row, points: FloatArray) -> FloatArray:
    """Heights at some frequencies, their shape; 0 where there is no steady response."""
    asked, where = np.unique(points, return_inverse=True)
    height = np.zeros(asked.size)
    with suppress(NoSteadyResponseError):
        known, motion = samples.answered(row.respond, asked)
        height[np.isin(asked, known)] = _heights(motion)
    return height[where].reshape(points.shape)


def _bracket(place: FloatArray, top: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The highest of some points in each row with its neighbours, shapes (m, 3)."""
    order = np.argsort(place, axis=1)
    place, top = (np.take_along_axis(values, order, axis=1) for values in (place, top))
    middle = np.clip(top.argmax(axis=1), 1, top.shape[1] - 2)
    near = middle[:, None] + [-1, 0, 1]
    return np.take_along_axis(place, near, axis=1), np.take_along_axis(top, near, axis=1)


def _vertices(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vertices of the parabolas through three points each, (m, 3), and their rise above the middle.

    A vertex keeps a distance from the three points, so that all differ; where they are one to
    rounding, at a mode that is hardly damped, it is there, whatever their heights are.
    """
    rounding = np.spacing(np.abs(x).max(axis=1, keepdims=True))
    below, above = np.maximum(np.diff(x, axis=1), rounding).T
    left, right = (y[:, 1] - y[:, 0]) / below, (y[:, 2] - y[:, 1]) / above
    bend = np.minimum((right - left) / (below + above), -np.finfo(float).tiny)
    slope = left + bend * below
    step = -0.5 * slope / bend
    apart = np.where(step < 0.0, below, above)
    clipped = np.copysign(np.clip(np.abs(step), _APART * apart, (0.5 - _APART) * apart), step)
    return x[:, 1] + clipped, np.clip(0.5 * slope * step, 0.0, _HIGHEST)
