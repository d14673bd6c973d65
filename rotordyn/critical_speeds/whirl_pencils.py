"""The undamped problem of critical speeds, split by whirl direction where a system allows it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.law_pieces import LawPieces
from solidwhirl.rotordyn.assembly.system import AssembledSystem, LawJoint
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.dense import Scaled, scale_by_stiffness, uncoupled
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.complex_form import ComplexForm, complex_form
from solidwhirl.rotordyn.modes.split_spectrum import planes_apart

_Law = Callable[[float], FloatArray]
#: Stands for the whirl of axial motion and torsion.
ALONG_AXIS = "along the axis"


class PencilLaw(NamedTuple):
    """Relative motion of a bearing, shape (2, m), its 2×2 stiffness at a speed Ω, and its pieces.

    `pieces` are polynomials of Ω; None of a law that does not tell them.
    """

    bearing: str
    motion: Matrix
    stiffness: _Law
    pieces: LawPieces | None


class Pencil(NamedTuple):
    """Hold D(Ω) = K + Σ Jᴴ k(Ω) J − Ω² N, N = α²M − iαG − K2, on m coordinates x.

    `whirl`: "forward" or "backward"; `ALONG_AXIS` for axial motion and torsion; "" for all motions
    of a system that cannot be split. `stiffness`, `mass`, `inertia`: K without the bearings that
    depend on the speed, M and N; Hermitian, real where the system allows it, shape (m, m). `laws`:
    the bearings that depend on the speed: J and k(Ω). `first`, `second`: coordinates of the system
    to which x belongs: q[first] = phase x, and q[second] = turn x. `phase`: i for the second of two
    planes which only the spin couples, so that the problem is real, else 1. `turn`: −i forward, +i
    backward, as q e^{iωt} is taken with ω > 0, times the sign of each s in the complex form, one
    for each second; `size`: number of coordinates of the system.
    """

    whirl: str
    stiffness: Matrix
    mass: Matrix
    inertia: Matrix
    laws: tuple[PencilLaw, ...]
    first: IntArray
    second: IntArray
    phase: ComplexArray
    turn: ComplexArray
    size: int

    def expand(self, shapes: Matrix) -> ComplexArray:
        """Return shapes (m, k) in the coordinates of the system, (n, k)."""
        full = np.zeros((self.size, shapes.shape[1]), dtype=complex)
        full[self.first] = self.phase[:, None] * shapes
        full[self.second] = self.turn[:, None] * shapes[: self.second.size]
        return full

    def reduced(self, shapes: ComplexArray) -> ComplexArray:
        """Return x (m, k) of shapes in the coordinates of the system, (n, k)."""
        return np.asarray(self.phase.conj()[:, None] * shapes[self.first])

    def stiffness_at(self, speed_rad_s: float) -> Matrix:
        """Return K + Σ Jᴴ k(Ω) J."""
        stiffness = self.stiffness
        for law in self.laws:
            k = law.stiffness(speed_rad_s)
            stiffness = stiffness + law.motion.conj().T @ (0.5 * (k + k.T)) @ law.motion
        return stiffness

    def apart(self) -> list[Pencil]:
        """Return the pencils of coordinates that nothing joins, if laws act on each of them."""
        motions = [law.motion for law in self.laws]
        groups = uncoupled(self.stiffness, self.mass, self.inertia, motions=motions)
        if len(groups) > 1 and all(any(m[:, at].any() for m in motions) for at in groups):
            return [self._part(at) for at in groups]
        return [self]

    def _part(self, at: IntArray) -> Pencil:
        block = np.ix_(at, at)
        laws = (law._replace(motion=law.motion[:, at]) for law in self.laws)
        has_second = self.second.size > 0
        return self._replace(
            stiffness=self.stiffness[block],
            mass=self.mass[block],
            inertia=self.inertia[block],
            laws=tuple(law for law in laws if law.motion.any()),
            first=self.first[at],
            second=self.second[at] if has_second else self.second,
            phase=self.phase[at],
            turn=self.turn[at] if has_second else self.turn,
        )


def whirl_pencils(assembled: AssembledSystem, excitation_ratio: float) -> tuple[Pencil, ...]:
    """Return the problem D(Ω) φ = 0 of the critical speeds of a system, damping left out.

    `assembled`: the system. Damping and the skew part of the stiffness are not looked at.
    `excitation_ratio`: α > 0. For an isotropic system one for forward and one for backward
    whirl of half the size (z = z₀ e^{±iαΩt} in the complex form), real if that is, and one for
    axial motion and torsion if there are such coordinates; else a single Hermitian one, real where
    only the spin couples two planes.
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
        pencils.append(_whole(assembled, excitation_ratio, form.rest, ALONG_AXIS, laws))
    return tuple(pencils)


def separate_pencils(assembled: AssembledSystem, excitation_ratio: float) -> tuple[Pencil, ...]:
    """Return the pencils of `whirl_pencils`, of each the coordinates that nothing joins apart.

    Shafts on bearings with laws that only meet in a casing that is held are smaller problems.
    """
    pencils = whirl_pencils(assembled, excitation_ratio)
    return tuple(part for pencil in pencils for part in pencil.apart())


def _whole(
    assembled: AssembledSystem,
    ratio: float,
    kept: IntArray,
    whirl: str,
    laws: tuple[_Law, ...],
) -> Pencil:
    """Return the pencil of some coordinates as they are."""
    block = np.ix_(kept, kept)
    planes = None if whirl else planes_apart(assembled)
    phase = np.ones(kept.size, dtype=complex)
    stiffness, mass = assembled.stiffness[block], assembled.mass[block]
    inertia = ratio**2 * mass - assembled.centrifugal_stiffness[block]
    gyroscopic = ratio * assembled.gyroscopic[block]
    if planes is not None:
        phase[planes[1]] = 1j
        # what else couples the planes is rounding
        within = np.equal.outer(phase, phase)
        stiffness, mass, inertia = (np.where(within, m, 0.0) for m in (stiffness, mass, inertia))
        across = np.where(within | (phase == 1j)[:, None], 0.0, gyroscopic)
        inertia = inertia + across + across.T
    elif gyroscopic.any():
        inertia = inertia - 1j * gyroscopic
    return Pencil(
        whirl=whirl,
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=mass,
        inertia=inertia,
        # each row of a joint lies in one plane, and its phase is of no consequence
        laws=tuple(
            PencilLaw(joint.bearing, joint.motion[:, kept], law, joint.pieces)
            for joint, law in zip(assembled.law_joints, laws, strict=True)
            if joint.motion[:, kept].any()
        ),
        first=kept,
        second=np.empty(0, dtype=int),
        phase=phase,
        turn=np.zeros(0, dtype=complex),
        size=assembled.size,
    )


def _turning(
    form: ComplexForm, ratio: float, sign: float, whirl: str, laws: tuple[_Law, ...]
) -> Pencil:
    """Return the pencil of circular whirl: −ν²A + νΩg + k + Ω²k2 with ν = ±αΩ.

    x is the amplitude of e^{iαΩt}, so that backward, in z = x* e^{−iαΩt}, it is the conjugate.
    """
    joints = form.assembled.law_joints
    inertia = ratio**2 * form.mass - sign * ratio * form.gyroscopic - form.centrifugal_stiffness

    def seen(matrix: Matrix) -> Matrix:
        return matrix if sign > 0 else matrix.conj()

    return Pencil(
        whirl=whirl,
        stiffness=seen(form.stiffness),
        mass=seen(form.mass),
        inertia=seen(inertia),
        # Two equal rows over √2: x and y carry one half each of k = k_xx = k_yy.
        laws=tuple(
            PencilLaw(
                joints[law.place].bearing,
                seen(np.vstack((law.motion, law.motion))) / np.sqrt(2.0),
                laws[law.place],
                joints[law.place].pieces,
            )
            for law in form.laws
        ),
        first=form.first,
        second=form.second,
        phase=np.ones(form.first.size, dtype=complex),
        turn=-1j * sign * form.second_sign,
        size=form.assembled.size,
    )


def _stiffness_of(joint: LawJoint) -> _Law:
    """Return the stiffness of a bearing over the speed, computed once for each."""

    @cache
    def stiffness(speed_rad_s: float) -> FloatArray:
        return joint.coefficients(speed_rad_s)[0]

    return stiffness


# A motion without stiffness whose inertia N is below this fraction of the largest has none.
_NO_INERTIA = 1e-10


class DirectSpeeds(NamedTuple):
    """Critical speeds in rad/s, rising, shape (k,), and their shapes x, (m, k)."""

    speeds_rad_s: FloatArray
    shapes: Matrix


def direct_speeds(
    pencil: Pencil, stiffness: Matrix, body_rate: float, limit_rad_s: float
) -> DirectSpeeds:
    """Solve K x = Ω² N x with K positive (semi)definite.

    `pencil`: gives M and N; `stiffness`: K with all bearings, shape (m, m). `limit_rad_s`: speeds
    above are left out; may be infinite. An eigenvalue Ω² that is negative or infinite
    belongs to no speed. Raises AnalysisError if K has a negative eigenvalue, or a free body whirls
    without force at every speed.

    Motions without stiffness (kernel of K) follow from the rest: N_kk a + N_kc c = 0.
    """
    scaled = scale_by_stiffness(stiffness, pencil.mass, body_rate)
    if scaled.negative_count:
        raise AnalysisError(
            f"the stiffness has {scaled.negative_count} negative eigenvalues; critical speeds are "
            "found directly for supports that resist every motion or let it be"
        )
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    # Cholesky of the scaled K keeps more digits than its eigenvectors where it exists.
    if scaled.is_definite:
        lower = la.cholesky(scaled.stiffness, lower=True)
        basis = la.solve_triangular(lower, np.eye(scaled.scale.size), lower=True, trans="C")
    else:
        stiff = slice(scaled.zero_count, None)
        elastic = scaled.vectors[:, stiff] / np.sqrt(scaled.eigenvalues[stiff])
        kernel = _kernel(scaled)
        free = _kernel_inertia(inertia, kernel)
        if not elastic.size:
            return DirectSpeeds(np.empty(0), elastic)
        basis = elastic - kernel @ la.solve(free, kernel.conj().T @ inertia @ elastic)
    reduced = basis.conj().T @ inertia @ basis
    solved("eigenproblems")
    values, vectors = la.eigh(0.5 * (reduced + reduced.conj().T))
    smallest = 64.0 * values.size * np.finfo(float).eps * np.abs(values).max(initial=0.0)
    kept = np.flatnonzero(values > max(smallest, 1.0 / limit_rad_s**2))[::-1]
    shapes = scaled.scale[:, None] * (basis @ vectors[:, kept])
    return DirectSpeeds(1.0 / np.sqrt(values[kept]), shapes)


def scaled_at(pencil: Pencil, speed_rad_s: float, body_rate: float) -> Scaled:
    """Return K(Ω) and M as `scale_by_stiffness` has them."""
    return scale_by_stiffness(pencil.stiffness_at(speed_rad_s), pencil.mass, body_rate)


def negative_count_at_rest(pencil: Pencil, scaled: Scaled) -> int:
    """Return how many eigenvalues of D(Ω) are negative as Ω goes to zero.

    `scaled`: K(0) and M, of `scaled_at`. Returns those of K(0), and on its kernel those of −N.
    Raises AnalysisError if a free body whirls without force at every speed.
    """
    if not scaled.zero_count:
        return scaled.negative_count
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    free = _kernel_inertia(inertia, _kernel(scaled))
    return scaled.negative_count + int(np.count_nonzero(la.eigvalsh(free) > 0))


def negative_count(pencil: Pencil, speed_rad_s: float, body_rate: float) -> int:
    """Return how many eigenvalues of D(Ω) are negative at a speed.

    `speed_rad_s`: Ω > 0. Returns number of modes below the excitation.
    """
    scaled = scaled_at(pencil, speed_rad_s, body_rate)
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    return int(np.count_nonzero(la.eigvalsh(scaled.stiffness - speed_rad_s**2 * inertia) < 0))


def _kernel(scaled: Scaled) -> Matrix:
    """Return the motions without stiffness, which follow those of negative stiffness."""
    return scaled.vectors[:, scaled.negative_count : scaled.negative_count + scaled.zero_count]


def _kernel_inertia(inertia: Matrix, kernel: Matrix) -> Matrix:
    """Return N of the motions without stiffness, refusing one that is singular."""
    free = kernel.conj().T @ inertia @ kernel
    size = np.abs(la.eigvalsh(free))
    if size.min() < _NO_INERTIA * size.max():
        raise AnalysisError(
            "a free body whirls at this excitation ratio without any force (polar over diametral "
            "inertia equals the ratio), so every speed is critical; support its tilt"
        )
    return np.asarray(free)
