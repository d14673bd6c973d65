"""Highest response in the steps between the frequencies of a map, however sharp resonances are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.eigen import modes_at_speed
from solidwhirl.rotordyn.orbits import elliptic_orbits
from solidwhirl.rotordyn.resonance_samples import (
    SMOOTH,
    joined_samples,
    resolved_response,
    samples_around_modes,
)
from solidwhirl.rotordyn.response_maps import GroundMotionMap, StepPeaks, ground_motion_map
from solidwhirl.rotordyn.response_maps_stiffness import StiffnessMap, stiffness_row
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.unbalance_peaks import resonance_peaks


def ground_motion_peaks(assembled: AssembledSystem, ground_map: GroundMotionMap) -> StepPeaks:
    """Find the highest response to ground motion in the steps of a map.

    Parameters
    ----------
    assembled
        The system of the map.
    ground_map
        At rising frequencies.

    Returns
    -------
    StepPeaks
        For every speed of the map. Between speeds nothing is sought: along a resonance that moves
        with the speed heights change slowly.
    """
    known, direction = ground_map.frequencies_rad_s, ground_map.direction

    def row(at: int) -> tuple[FloatArray, ComplexArray]:
        speed = float(ground_map.speeds_rad_s[at])
        eigenvalues = modes_at_speed(assembled, speed).eigenvalues
        more = np.setdiff1d(samples_around_modes(known, eigenvalues), known)
        if not more.size:
            return known, ground_map.translation_m[at]
        found = ground_motion_map(
            assembled, ground_map.amplitude_m, direction, [speed], more, ground_map.node
        )
        return joined_samples(known, ground_map.translation_m[at], more, found.translation_m[0])

    return _step_peaks(known, ground_map.speeds_rad_s.size, row)


def stiffness_map_peaks(assembled: AssembledSystem, stiffness_map: StiffnessMap) -> StepPeaks:
    """Find the highest response to a turning force in the steps of a map.

    Parameters
    ----------
    assembled
        The system of the map.
    stiffness_map
        At rising frequencies.

    Returns
    -------
    StepPeaks
        For every stiffness of the map.
    """
    known, speeds = stiffness_map.frequencies_rad_s, stiffness_map.speeds_rad_s
    pieces = SMOOTH
    if speeds.size and speeds[0] != speeds[-1]:
        ratio = known[-1] / speeds[-1]
        pieces = SMOOTH._replace(knots=ratio * np.array(assembled.knots_rad_s))

    def row(at: int) -> tuple[FloatArray, ComplexArray]:
        def respond(frequencies: FloatArray) -> ComplexArray:
            # one speed, or one that is proportional to the frequency
            between = np.interp(frequencies, known, speeds)
            return stiffness_row(
                assembled,
                stiffness_map.bearings,
                float(stiffness_map.stiffness_n_per_m[at]),
                stiffness_map.unbalance,
                frequencies,
                between,
                stiffness_map.node,
            )

        return resolved_response(known, stiffness_map.translation_m[at], respond, pieces)

    return _step_peaks(known, stiffness_map.stiffness_n_per_m.size, row)


def _step_peaks(
    known: FloatArray, rows: int, resolved: Callable[[int], tuple[FloatArray, ComplexArray]]
) -> StepPeaks:
    """Peaks in the steps around known frequencies, of rows (f,), (f, 2) sampled more finely."""
    heights, places = np.empty((rows, known.size)), np.empty((rows, known.size))
    middles = 0.5 * (known[1:] + known[:-1])
    for at in range(rows):
        fine, motion = resolved(at)
        height = elliptic_orbits(motion[:, 0], motion[:, 1]).major_m
        if fine.size > 2:
            tops = resonance_peaks(fine, height)
            fine = np.append(fine, [top.position_rad_s for top in tops])
            height = np.append(height, [top.amplitude for top in tops])
        step = np.searchsorted(middles, fine)
        # the highest of each step comes last, and stays
        order = np.argsort(height, kind="stable")
        heights[at, step[order]], places[at, step[order]] = height[order], fine[order]
    return StepPeaks(height_m=heights, frequency_rad_s=places)
