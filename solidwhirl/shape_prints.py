"""Shapes of modes in a few numbers, by which the same mode is found again in another case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.centreline import interface_rows
from solidwhirl.rotordyn.coordinates import body_rows

ComplexArray = NDArray[np.complex128]
# Interfaces whose motion is kept; of more, so many evenly spread ones.
_MOST = 16
_DIGITS = 4


def shape_print(system: AssembledSystem, shape: ComplexArray) -> list[float]:
    """Return the lateral motion of interfaces in a mode, of unit length.

    Parameters
    ----------
    system
        The system.
    shape
        The mode in its independent coordinates, complex (n,).

    Returns
    -------
    list of float
        Real and imaginary part of ux and uy of each interface in turn, four numbers each; zeros
        for a mode without lateral motion there (axial, torsion, disks alone).
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


def likeness(first: ComplexArray, second: ComplexArray) -> NDArray[np.float64]:
    """Return the modal assurance criterion of all pairs of shapes, (first, second).

    Parameters
    ----------
    first, second
        Shapes in rows. Those that are zero are like each other and unlike all others.

    Returns
    -------
    ndarray
        |a^H b|² / (a^H a · b^H b): 1 for the same shape whatever its scale and phase, 0 for
        orthogonal ones such as forward and backward whirl.
    """
    product = np.abs(first.conj() @ second.T) ** 2
    norms = (np.linalg.norm(first, axis=1) ** 2)[:, None] * np.linalg.norm(second, axis=1) ** 2
    still = ~first.any(axis=1)[:, None] & ~second.any(axis=1)
    return np.where(norms > 0.0, product / np.where(norms > 0.0, norms, 1.0), still.astype(float))
