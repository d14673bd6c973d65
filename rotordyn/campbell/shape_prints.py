"""Shapes of modes in a few numbers, by which the same mode is found again in another case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.modes.centreline import interface_rows
from solidwhirl.rotordyn.modes.eigen import modes_at_speed

ComplexArray = NDArray[np.complex128]
# Interfaces whose motion is kept; of more, so many evenly spread ones.
_MOST = 16
_DIGITS = 4


def shape_print(system: AssembledSystem, shape: ComplexArray) -> list[float]:
    """Return the lateral motion of interfaces in a mode, of unit length.

    `shape`: the mode in its independent coordinates, complex (n,). Returns real and imaginary part
    of ux and uy of each interface in turn, four numbers each; zeros for a mode without lateral
    motion there (axial, torsion, disks alone).
    """
    motions = [
        np.tensordot(interface_rows(rotor.element).modes, body_rows(system, name) @ shape, axes=1)
        for name, rotor in system.system.rotors.items()
    ]
    places = np.concatenate(motions)
    kept = np.unique(np.linspace(0, len(places) - 1, min(_MOST, len(places))).round().astype(int))
    motion = places[kept].ravel() if len(places) else np.zeros(0, dtype=complex)
    length = float(np.linalg.norm(motion))
    # a motion that is rounding beside that of the whole mode has no shape
    if length <= 1e-9 * float(np.linalg.norm(shape)):
        motion = np.zeros_like(motion)
    else:
        motion = motion / length
    return [round(float(v), _DIGITS) for v in motion.view(float)]


def branch_prints(system: AssembledSystem, diagram: Campbell) -> list[list[float]]:
    """Return the print of each branch of a diagram, at the last speed at which it exists.

    The result is from `shape_print`; zeros for a branch whose mode is not found there. At rest
    equal modes have no shapes of their own: empty for a diagram without a speed above 0.
    """
    alive = np.isfinite(diagram.frequency_hz)
    last = alive.shape[1] - 1 - alive[:, ::-1].argmax(axis=1)
    if not diagram.speeds_rad_s[last].all():
        return []
    found: dict[int, list[float]] = {}
    for at in np.unique(last):
        modes = modes_at_speed(system, float(diagram.speeds_rad_s[at]))
        numbers = branch_numbers(system, diagram, modes)
        for branch in np.flatnonzero((last == at) & np.isin(np.arange(1, last.size + 1), numbers)):
            own = int(np.flatnonzero(numbers == branch + 1)[0])
            found[int(branch)] = shape_print(system, modes.shapes[:, own])
    length = max(map(len, found.values()), default=0)
    return [found.get(branch, [0.0] * length) for branch in range(last.size)]


def likeness(first: ComplexArray, second: ComplexArray) -> NDArray[np.float64]:
    """Return the modal assurance criterion of all pairs of shapes, (first, second).

    `first`, `second`: shapes in rows. Those that are zero are like each other and unlike all
    others. Returns |a^H b|² / (a^H a · b^H b): 1 for the same shape whatever its scale and phase, 0
    for orthogonal ones such as forward and backward whirl.
    """
    product = np.abs(first.conj() @ second.T) ** 2
    norms = (np.linalg.norm(first, axis=1) ** 2)[:, None] * np.linalg.norm(second, axis=1) ** 2
    still = ~first.any(axis=1)[:, None] & ~second.any(axis=1)
    return np.where(norms > 0.0, product / np.where(norms > 0.0, norms, 1.0), still.astype(float))
