"""A Campbell diagram in the frame of one body, with the shares measured on that body's motion.

A motion z = x + iy = f e^{iωt} + b e^{−iωt} of the axis, ω > 0, has a forward and a backward
circle. Seen from a body that turns at nΩ about +z it is f e^{i(ω − nΩ)t} + b e^{−i(ω + nΩ)t}: two
frequencies with a sign, positive where the motion turns about +z in that frame. A forward circle
slower than the body turns backward there: its frequency is mirrored at zero, its sign negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
    StringArray,
    together,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.superelement.centreline import centreline_motion
from solidwhirl.rotordyn.superelement.circumferential_orders import body_turns

# Eigenvalues closer than this (relative) share a subspace; any basis of it is one of modes.
_SAME = 1e-6
# A branch must be found among the modes of the system to this (relative) accuracy.
_FOUND = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingCampbell(ReadOnlyArrays):
    """Hold the branches of a Campbell diagram as a turning body sees them.

    Each branch has c components, patterns of |μ| waves round the axis that turn about +z (μ > 0)
    or −z (μ < 0): μ = ±1 the two circles of an orbit, 0 axial motion and torsion.

    `body`: name of the body. `speed_ratio`: n: the frame turns at nΩ. `speeds_rad_s`: Ω of the
    reference shaft, shape (s,). `orders`: μ of the components, shape (c,). `signed_hz`: sign(μ) f −
    |μ| nΩ/2π with the inertial frequency f, shape (c, b, s), Hz; positive where the pattern turns
    about +z in the frame of the body. f itself for μ = 0; nan where a branch has ended. `share`:
    part of each component in the branch, 0 to 1 and 1 in all, shape (c, b, s); nan where the body
    stands still. `body_share`: part of the body in the kinetic energy of the branch, shape (b, s).
    `growth_rate_1_s`: re λ, 1/s, the same in all frames, shape (b, s). `share_source`: where the
    shares come from: "kinetic energy" of the body's motion, or "orbits" of its axis.
    """

    body: str
    speed_ratio: float
    speeds_rad_s: FloatArray
    orders: IntArray
    signed_hz: FloatArray
    share: FloatArray
    body_share: FloatArray
    growth_rate_1_s: FloatArray
    share_source: Literal["kinetic energy", "orbits"]

    @property
    def spin_rad_s(self) -> FloatArray:
        """Spin speed of the body nΩ, rad/s, shape (s,)."""
        return self.speed_ratio * self.speeds_rad_s

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequencies the body sees, Hz, not negative, shape (c, b, s)."""
        return np.asarray(np.abs(self.signed_hz))

    @property
    def is_mirrored(self) -> BoolArray:
        """Whether a component turns the other way in the frame of the body, shape (c, b, s)."""
        return np.asarray(self.signed_hz * np.sign(self.orders)[:, None, None] < 0)


def campbell_seen_by_body(
    assembled: AssembledSystem, campbell: Campbell, body: str
) -> RotatingCampbell:
    """Transform a Campbell diagram to the frame of a body, with the shares of its components.

    Components come in the order 1, −1, 0, 2, −2, ... as far as the body has them. Shares are those
    of the body's own kinetic energy (modes of equal frequency are parted by their labels); of the
    squared circles of its axis, orders 1 and −1 only, where the body does not know its spin
    generator. Raises AnalysisError if the diagram does not belong to the system, AssemblyError if
    there is no such body.
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
        signed_hz=_signed_frequency(campbell, ratio, orders),
        share=share,
        body_share=body_share,
        growth_rate_1_s=campbell.eigenvalues.real,
        share_source=parts.source,
    )


def _signed_frequency(campbell: Campbell, speed_ratio: float, orders: IntArray) -> FloatArray:
    """Return sign(μ) f − |μ| nΩ/2π of components μ (c,), f for μ = 0, shape (c, b, s), Hz.

    Müller and Hennings, appendix B, equations 15 to 17, from the other side: |f − Ω/2π| backward,
    f + Ω/2π forward, −f + Ω/2π mirrored are the inertial frequencies of what a body sees at f.
    """
    turn = speed_ratio * campbell.speeds_rad_s / (2.0 * np.pi)
    sign = np.where(orders == 0, 1, np.sign(orders))[:, None, None]
    return np.asarray(sign * campbell.frequency_hz - np.abs(orders)[:, None, None] * turn)


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
    rows, columns = scipy.optimize.linear_sum_assignment(np.minimum(distance, 1.0))
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
    return [group for group in together(near) if group.size > 1]


def _parted(assembled: AssembledSystem, parts: _Parts, shapes: ComplexArray) -> ComplexArray:
    """Return the modes of one frequency that whirl most backward to most forward on the body."""
    amplitudes = parts.amplitudes @ shapes
    turning = amplitudes.conj().T @ (np.sign(parts.orders)[:, None] * amplitudes)
    mass = shapes.conj().T @ assembled.mass @ shapes
    return np.asarray(shapes @ la.eigh(turning, mass)[1])
