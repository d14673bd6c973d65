"""Frequency response functions between places of a system that stands still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.modal_test.families import ModeFamilies
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response

#: Powers of iω that make of a receptance (displacement per force) the other functions.
ORDERS = {"receptance": 0, "mobility": 1, "accelerance": 2}


def receptances(
    system: AssembledSystem,
    families: ModeFamilies,
    rows: tuple[FloatArray, FloatArray],
    frequencies_rad_s: FloatArray,
    damping_ratio: FloatArray,
) -> ComplexArray:
    """Return displacement per force at rest, shape (f, outputs, inputs), m/N.

    `rows`: what outputs (o, n) and inputs (i, n) see of the coordinates. `damping_ratio`: of each
    mode of the families, (m,), beside the damping of bearings and bodies. Raises
    NoSteadyResponseError at an undamped resonance that is hit exactly.

    [K + iω (C + Σ 2 ζ ωᵣ M φ φᵀ M) − ω² M] q = f, solved at each frequency: no mode is cut off, and
    motions at 0 Hz are among it. Ewins 2000, Modal Testing, sections 2.3 and 2.4.
    """
    outputs, inputs = rows
    damping = system.damping + _modal_damping(system, families, damping_ratio)
    damped = replace(system, damping=damping)
    found = harmonic_response(damped, 0.0, frequencies_rad_s, inputs.T[None])
    return np.asarray(outputs @ found.displacement)


def _modal_damping(
    system: AssembledSystem, families: ModeFamilies, damping_ratio: FloatArray
) -> FloatArray:
    momentum = system.mass @ families.shapes
    rate = 4.0 * np.pi * damping_ratio * families.frequency_hz
    return np.asarray((momentum * rate) @ momentum.T)
