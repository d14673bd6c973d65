"""Frequency response functions between places of a system that stands still or turns."""

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
    outputs: FloatArray,
    inputs: FloatArray,
    frequencies_rad_s: FloatArray,
    speed_rad_s: float = 0.0,
) -> ComplexArray:
    """Return displacement per force, shape (f, outputs, inputs), m/N.

    `outputs`, `inputs`: what they see of the coordinates, (o, n) and (i, n); `speed_rad_s`: of the
    reference shaft. Raises NoSteadyResponseError at an undamped resonance that is hit exactly.

    [K + iω (C + ΩG) − ω² M] q = f is solved at each frequency: no mode is cut off, and motions at
    0 Hz are among it. Ewins 2000, Modal Testing, chapter 2.
    """
    found = harmonic_response(system, speed_rad_s, frequencies_rad_s, inputs.T[None])
    return np.asarray(outputs @ found.displacement)


def with_modal_damping(system: AssembledSystem, families: ModeFamilies) -> AssembledSystem:
    """Return a system with the damping ratios of its modes at rest, beside its own damping.

    Adds Σ 2 ζ ωᵣ M φ φᵀ M, which stands still where the rotor turns.
    """
    momentum = system.mass @ families.shapes
    rate = 4.0 * np.pi * families.damping_ratio * families.frequency_hz
    return replace(system, damping=system.damping + np.asarray((momentum * rate) @ momentum.T))
