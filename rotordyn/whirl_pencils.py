"""The undamped problem of critical speeds, split by whirl direction where a system allows it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.complex_form import ComplexForm, complex_form
from solidwhirl.rotordyn.law_pieces import LawPieces
from solidwhirl.rotordyn.system import AssembledSystem, LawJoint
from solidwhirl.rotordyn.whirl import interface_orbits

# Critical speeds closer than this (relative) share a subspace.
_SAME_SPEED = 1e-8
# Shapes of equal critical speeds nearer to dependent than this (squared) are one shape.
_DEPENDENT = 1e-8

IndexArray = npt.NDArray[np.int_]
_Law = Callable[[float], FloatArray]


class PencilLaw(NamedTuple):
    """Relative motion of a bearing, shape (2, m), its 2×2 stiffness at a speed Ω, and its pieces.

    `pieces` are polynomials of Ω; None of a law that does not tell them.
    """

    bearing: str
    motion: FloatArray
    stiffness: _Law
    pieces: LawPieces | None


class Pencil(NamedTuple):
    """Hold D(Ω) = K + Σ Jᵀ k(Ω) J − Ω² N, N = α²M − iαG − K2, on m coordinates x.

    Attributes
    ----------
    whirl
        "forward" or "backward"; "planar" for axial motion and torsion; "" for all motions of a
        system that cannot be split.
    stiffness, mass
        K without the bearings that depend on the speed, and M; real, symmetric, shape (m, m).
    inertia
        N, Hermitian, shape (m, m).
    laws
        The bearings that depend on the speed: J and k(Ω).
    first, second
        Coordinates of the system to which x belongs: q[first] = x, and q[second] = turn x.
    turn
        −i forward, +i backward, as q e^{iωt} is taken with ω > 0, times the sign of each s in the
        complex form, one for each second.
    size
        Number of coordinates of the system.
    """

    whirl: str
    stiffness: FloatArray
    mass: FloatArray
    inertia: FloatArray | ComplexArray
    laws: tuple[PencilLaw, ...]
    first: IndexArray
    second: IndexArray
    turn: ComplexArray
    size: int

    def expand(self, shapes: FloatArray | ComplexArray) -> ComplexArray:
        """Return shapes (m, k) in the coordinates of the system, (n, k)."""
        full = np.zeros((self.size, shapes.shape[1]), dtype=complex)
        full[self.first] = shapes
        full[self.second] = self.turn[:, None] * shapes[: self.second.size]
        return full

    def stiffness_at(self, speed_rad_s: float) -> FloatArray:
        """Return K + Σ Jᵀ k(Ω) J."""
        stiffness = self.stiffness
        for law in self.laws:
            k = law.stiffness(speed_rad_s)
            stiffness = stiffness + law.motion.T @ (0.5 * (k + k.T)) @ law.motion
        return stiffness


def whirl_pencils(assembled: AssembledSystem, excitation_ratio: float) -> tuple[Pencil, ...]:
    """Return the problem D(Ω) φ = 0 of the critical speeds of a system, damping left out.

    Parameters
    ----------
    assembled
        The system. Damping and the skew part of the stiffness are not looked at.
    excitation_ratio
        α > 0.

    Returns
    -------
    tuple of Pencil
        For an isotropic system one for forward and one for backward whirl, real and of half the
        size (z = z₀ e^{±iαΩt} in the complex form), and one for axial motion and torsion if there
        are such coordinates; else a single Hermitian one.
    """
    form = complex_form(assembled)
    # Shared by the pencils, which look at the same speeds.
    laws = tuple(_stiffness_of(joint) for joint in assembled.law_joints)
    if form is None:
        return (_whole(assembled, excitation_ratio, np.arange(assembled.size), "", laws),)
    pencils = [
        _turning(form, excitation_ratio, sign, whirl, laws)
        for sign, whirl in ((-1.0, "backward"), (1.0, "forward"))
    ]
    if form.rest.size:
        # Isotropic bearings do not act on axial motion and torsion through their law.
        pencils.append(_whole(assembled, excitation_ratio, form.rest, "planar", ()))
    return tuple(pencils)


def _whole(
    assembled: AssembledSystem,
    ratio: float,
    kept: IndexArray,
    whirl: str,
    laws: tuple[_Law, ...],
) -> Pencil:
    """Return the pencil of some coordinates as they are."""
    block = np.ix_(kept, kept)
    inertia = ratio**2 * assembled.mass[block] - assembled.centrifugal_stiffness[block]
    gyroscopic = assembled.gyroscopic[block]
    stiffness = assembled.stiffness[block]
    return Pencil(
        whirl=whirl,
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=assembled.mass[block],
        inertia=inertia - 1j * ratio * gyroscopic if gyroscopic.any() else inertia,
        laws=tuple(
            PencilLaw(joint.bearing, joint.motion[:, kept], law, joint.pieces)
            for joint, law in zip(assembled.law_joints, laws, strict=bool(laws))
        ),
        first=kept,
        second=np.empty(0, dtype=int),
        turn=np.zeros(0, dtype=complex),
        size=assembled.size,
    )


def _turning(
    form: ComplexForm, ratio: float, sign: float, whirl: str, laws: tuple[_Law, ...]
) -> Pencil:
    """Return the pencil of circular whirl: −ν²A + νΩg + k + Ω²k2 with ν = ±αΩ."""
    joints = form.assembled.law_joints
    inertia = ratio**2 * form.mass - sign * ratio * form.gyroscopic - form.centrifugal_stiffness
    return Pencil(
        whirl=whirl,
        stiffness=form.stiffness,
        mass=form.mass,
        inertia=inertia,
        # Two equal rows over √2: x and y carry one half each of k = k_xx = k_yy.
        laws=tuple(
            PencilLaw(
                joints[law.place].bearing,
                np.vstack((law.motion, law.motion)) / np.sqrt(2.0),
                laws[law.place],
                joints[law.place].pieces,
            )
            for law in form.laws
        ),
        first=form.first,
        second=form.second,
        turn=-1j * sign * form.second_sign,
        size=form.assembled.size,
    )


def _stiffness_of(joint: LawJoint) -> _Law:
    """Return the stiffness of a bearing over the speed, computed once for each."""

    @cache
    def stiffness(speed_rad_s: float) -> FloatArray:
        return joint.coefficients(speed_rad_s)[0]

    return stiffness


def separated_whirl(
    assembled: AssembledSystem, speeds: FloatArray, shapes: ComplexArray
) -> ComplexArray:
    """Turn the modes of equal critical speeds into the most backward and most forward ones.

    Parameters
    ----------
    assembled
        The system.
    speeds
        Rising, shape (k,).
    shapes
        In its independent coordinates, shape (n, k).

    Returns
    -------
    ndarray
        Shape (n, k); in a group of equal speeds the most backward first.
    """
    result = shapes.astype(complex)
    start = 0
    for stop in range(1, speeds.size + 1):
        if stop < speeds.size and speeds[stop] - speeds[stop - 1] <= _SAME_SPEED * speeds[stop]:
            continue
        if stop - start > 1:
            group = result[:, start:stop] / la.norm(result[:, start:stop], axis=0)
            if la.eigvalsh(group.conj().T @ group)[0] < _DEPENDENT:
                # A mode that touches the excitation without crossing it is there twice.
                start = stop
                continue
            orbits = interface_orbits(assembled, group)
            forward, backward = orbits.x + 1j * orbits.y, orbits.x - 1j * orbits.y
            turning: ComplexArray = forward.conj().T @ forward - backward.conj().T @ backward
            result[:, start:stop] = group @ la.eigh(turning)[1]
        start = stop
    return result
