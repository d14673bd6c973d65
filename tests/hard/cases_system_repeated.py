"""Hard cases of assembled systems: equal and nearly equal modes, and more modes than there are."""

from __future__ import annotations

import numpy as np
from builders_system import engine, ground, shaft

from solidwhirl.rotordyn import campbell, modes_at_speed

SPEEDS = (0.0, 1e-3, 1.0, 100.0, 3000.0)
SPRING = 5e7


def _held(element, name="rotor", factor=1.0):
    tilt = 1e4 * np.eye(2)
    return [ground(name, at, factor * SPRING, tilt_stiffness_n_m_per_rad=tilt) for at in "ab"]


def _one(element):
    return engine({"rotor": element}, _held(element))


def _two_units(detuning=0.0):
    """Two equal shafts side by side, the second on supports stiffer by `detuning`."""
    unit = shaft()
    bearings = _held(unit, "left") + _held(unit, "right", 1.0 + detuning)
    return engine({"left": unit, "right": unit}, bearings)


def _pair_split(element) -> float:
    """Largest relative split of the pairs of an isotropic engine at rest, as far as modes go."""
    omega = modes_at_speed(_one(element), 0.0).eigenvalues.imag
    highest = 2.0 * np.pi * element.fixed_interface_frequencies_hz.max()
    omega = omega[: 2 * int(np.count_nonzero(omega < highest) // 2)]
    return float(np.abs(omega[1::2] / omega[::2] - 1.0).max())


def _split_of_four() -> float:
    """Largest spread of the four frequencies that two equal units share at rest."""
    omega = modes_at_speed(_two_units(), 0.0).eigenvalues.imag.reshape(-1, 4)
    return float((np.ptp(omega, axis=1) / omega[:, 0]).max())


def _missing_copies() -> float:
    """Modes that two equal units lack, or have too many, beside twice those of one."""
    wrong = 0
    for speed in SPEEDS:
        one = np.repeat(modes_at_speed(_one(shaft()), speed).eigenvalues.imag, 2)
        two = modes_at_speed(_two_units(), speed).eigenvalues.imag
        wrong += abs(two.size - one.size)
        size = min(two.size, one.size)
        wrong += int(np.count_nonzero(np.abs(two[:size] / one[:size] - 1.0) > 1e-9))
    return float(wrong)


def _orthogonality(detuning: float) -> float:
    """Largest product of two modes at rest and at speed in the energy of their states."""
    system, worst = _two_units(detuning), 0.0
    for speed in SPEEDS:
        modes = modes_at_speed(system, speed)
        rates = np.multiply.outer(modes.eigenvalues.conj(), modes.eigenvalues)
        shapes = modes.shapes
        product = shapes.conj().T @ system.stiffness @ shapes
        product = product + rates * (shapes.conj().T @ system.mass @ shapes)
        size = np.sqrt(np.diag(product).real)
        product = np.abs(product / np.outer(size, size))
        np.fill_diagonal(product, 0.0)
        worst = max(worst, float(product.max()))
    return worst


def _detuned_frequencies() -> float:
    """Error of the split of two units 1e-10 apart against that at 1e-4, scaled down."""
    omega = modes_at_speed(_two_units(1e-10), 0.0).eigenvalues.imag.reshape(-1, 4)[:3]
    wide = modes_at_speed(_two_units(1e-4), 0.0).eigenvalues.imag.reshape(-1, 4)[:3]
    split = (omega[:, 2:].mean(axis=1) - omega[:, :2].mean(axis=1)) / omega[:, 0]
    expected = 1e-6 * (wide[:, 2:].mean(axis=1) - wide[:, :2].mean(axis=1)) / wide[:, 0]
    return float(np.abs(split - expected).max())


def _too_many() -> float:
    """Difference of 10 000 modes and branches asked of a small system from all it has."""
    system = _one(shaft())
    error = 0.0
    for speed in (0.0, 500.0):
        all_modes, many = modes_at_speed(system, speed), modes_at_speed(system, speed, 10_000)
        if many.eigenvalues.size != system.size:
            return np.inf
        error = max(error, float(np.abs(many.eigenvalues / all_modes.eigenvalues - 1.0).max()))
    diagram = campbell(system, [0.0, 500.0], branch_count=10_000)
    if diagram.frequency_hz.shape[0] != system.size:
        return np.inf
    at_rest = modes_at_speed(system, 0.0).frequency_hz
    return max(error, float(np.abs(np.sort(diagram.frequency_hz[:, 0]) / at_rest - 1.0).max()))
