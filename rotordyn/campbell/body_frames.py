"""A Campbell diagram in the frame of one body, with the shares measured on that body's motion."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components

from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.campbell.frames import RotatingCampbell, signed_frequency
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, StringArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.centreline import centreline_motion
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.superelement.circumferential_orders import body_turns

# Eigenvalues closer than this (relative) share a subspace; any basis of it is one of modes.
_SAME = 1e-6
# A branch must be found among the modes of the system to this (relative) accuracy.
_FOUND = 1e-6


def campbell_seen_by_body(
    assembled: AssembledSystem, campbell: Campbell, body: str
) -> RotatingCampbell:
    """Transform a Campbell diagram to the frame of a body, with the shares of its components.

    Parameters
    ----------
    campbell
        In the inertial frame.

    Returns
    -------
    RotatingCampbell
        Components in the order 1, −1, 0, 2, −2, ... as far as the body has them. Shares are those
        of the body's own kinetic energy (modes of equal frequency are parted by their labels); of
        the squared circles of its axis, orders 1 and −1 only, where the body does not know its
        spin generator.

    Raises
    ------
    AnalysisError
        If the diagram does not belong to the system.
    AssemblyError
        If there is no such body.
    """
    parts = _parts(assembled, body)
    orders = np.array(sorted(set(parts.orders.tolist()), key=lambda m: (abs(abs(m) - 1), -m)))
    shape = campbell.frequency_hz.shape
    share, body_share = np.full((orders.size, *shape), np.nan), np.full(shape, np.nan)
    for place in range(shape[1]):
        alive = np.flatnonzero(np.isfinite(campbell.frequency_hz[:, place]))
        energies = _energies(assembled, campbell, parts, place, alive)
        per_order = (parts.orders == orders[:, None]) @ energies.parts
        size = per_order.sum(axis=0)
        moving = size > np.finfo(float).tiny
        share[:, alive[moving], place] = per_order[:, moving] / size[moving]
        body_share[alive, place] = energies.body / energies.system
    ratio = assembled.system.rotors[body].speed_ratio
    return RotatingCampbell(
        body=body,
        speed_ratio=ratio,
        speeds_rad_s=campbell.speeds_rad_s,
        orders=orders,
        signed_hz=signed_frequency(campbell, ratio, orders),
        share=share,
        body_share=body_share,
        growth_rate_1_s=campbell.eigenvalues.real,
        share_source=parts.source,
    )


class _Parts(NamedTuple):
    """Motion of a body as rows per independent coordinate whose squares are its size.

    orders (k,) belong to amplitudes (k, n); momentum (n_body, n) squares to the kinetic energy.
    """

    orders: IntArray
    amplitudes: ComplexArray
    momentum: FloatArray
    source: Literal["kinetic energy", "orbits"]


class _Energies(NamedTuple):
    """Squared parts (k, b), and kinetic energies of body and system (b,) in the same unit."""

    parts: FloatArray
    body: FloatArray
    system: FloatArray


def _parts(assembled: AssembledSystem, body: str) -> _Parts:
    rows = body_rows(assembled, body)
    element = assembled.system.rotors[body].element
    # A rigid body with several interfaces has a mass matrix that is only semidefinite.
    values, vectors = la.eigh(element.mass)
    momentum = np.sqrt(np.maximum(values, 0.0))[:, None] * (vectors.T @ rows)
    turns = body_turns(element)
    if turns is not None:
        return _Parts(turns.orders, turns.amplitudes @ rows, momentum, "kinetic energy")
    axis = centreline_motion(element).modes @ rows
    forward, backward = axis[:, 0] + 1j * axis[:, 1], axis[:, 0] - 1j * axis[:, 1]
    orders = np.repeat([1, -1], len(axis))
    return _Parts(orders, np.vstack((forward, backward)), momentum, "orbits")


def _energies(
    assembled: AssembledSystem, campbell: Campbell, parts: _Parts, place: int, alive: IntArray
) -> _Energies:
    """Return the sizes of the branches at one speed, modes of equal frequency parted by whirl."""
    speed = float(campbell.speeds_rad_s[place])
    modes = modes_at_speed(assembled, speed)
    columns = branch_columns(campbell.eigenvalues[alive, place], modes.eigenvalues, speed)
    values, shapes = modes.eigenvalues[columns], modes.shapes[:, columns].copy()
    sense = _sense(campbell.whirl[alive, place], speed)
    clusters = _clusters(values)
    for cluster in clusters:
        ordered = cluster[np.argsort(sense[cluster], kind="stable")]
        shapes[:, ordered] = _parted(assembled, parts, shapes[:, cluster])
    found = np.vstack(
        (
            np.abs(parts.amplitudes @ shapes) ** 2,
            (np.abs(parts.momentum @ shapes) ** 2).sum(axis=0),
            np.einsum("im,ij,jm->m", shapes.conj(), assembled.mass, shapes).real,
        )
    )
    for cluster in clusters:
        for same in (cluster[sense[cluster] == s] for s in (-1, 0, 1)):
            # Nothing tells modes of equal frequency and label apart: each gets the mean.
            if same.size:
                found[:, same] = found[:, same].mean(axis=1, keepdims=True)
    return _Energies(found[:-2], found[-2], found[-1])


def branch_columns(wanted: ComplexArray, values: ComplexArray, speed_rad_s: float) -> IntArray:
    """Return the mode of each branch by its eigenvalue, one to one.

    `wanted`: eigenvalues of the branches at a speed, none of them nan, shape (b,); `values`:
    eigenvalues of all modes there, shape (m,). Returns index into `values`, shape (b,). Raises
    AnalysisError if a branch is not among the modes.
    """
    distance = np.abs(wanted[:, None] - values) / np.abs(wanted)[:, None]
    rows, columns = linear_sum_assignment(np.minimum(distance, 1.0))
    if rows.size < wanted.size or (distance[rows, columns] > _FOUND).any():
        raise AnalysisError(
            f"the diagram has a branch at {speed_rad_s:.6g} rad/s that is no mode of this system; "
            "give the system it was computed from"
        )
    return np.asarray(columns)


def _sense(whirl: StringArray, speed: float) -> IntArray:
    """Return 1 for whirl about +z, −1 for −z, 0 for other."""
    forward = -1 if speed < 0 else 1
    return np.select([whirl == "forward", whirl == "backward"], [forward, -forward], 0)


def _clusters(values: ComplexArray) -> list[IntArray]:
    """Return groups of two and more equal eigenvalues."""
    near = np.abs(values[:, None] - values) <= _SAME * np.abs(values)
    count, label = connected_components(near, directed=False)
    groups = [np.flatnonzero(label == k) for k in range(count)]
    return [group for group in groups if group.size > 1]


def _parted(assembled: AssembledSystem, parts: _Parts, shapes: ComplexArray) -> ComplexArray:
    """Return the modes of one frequency that whirl most backward to most forward on the body."""
    amplitudes = parts.amplitudes @ shapes
    turning = amplitudes.conj().T @ (np.sign(parts.orders)[:, None] * amplitudes)
    mass = shapes.conj().T @ assembled.mass @ shapes
    return np.asarray(shapes @ la.eigh(turning, mass)[1])
