"""Lowest modes of damped systems at a speed near one whose whole spectrum is known.

Systems that are the same in all directions are followed in z = p + i s, with half of the
coordinates; axial motion and torsion are solved beside it. See `near_subspace`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.linalg as nla
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix, real_times
from solidwhirl.rotordyn.core.dense import are_real
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.complex_form import ComplexForm, complex_form
from solidwhirl.rotordyn.modes.eigen import Modes, normalised
from solidwhirl.rotordyn.modes.split_spectrum import unturned_modes, whirl_in_the_round
from solidwhirl.rotordyn.modes.whirl import separated_whirl
from solidwhirl.rotordyn.perturbation.left_vectors import dynamic_stiffness
from solidwhirl.rotordyn.perturbation.near_subspace import (
    Followed,
    Known,
    Problem,
    RealBasis,
    WhirlBasis,
    followed,
    known_subspaces,
    matrix_at,
)

# Modes beyond the needed ones among which the widest gap of frequency is looked for.
_FEWEST_MORE, _MOST_MORE = 5, 12
# A part of the modes beyond this saves no time.
_MOST = 0.5
# Places that P is expected from at most, no nearer than this part of the way from the known speed.
_MOST_PLACES, _SIDE_BY_SIDE = 10, 1e-2
# Inverse iterations for the vector of a real eigenvalue, and how far beside it.
_REAL_STEPS, _BESIDE = 3, 1e-11


def known_spectrum(assembled: AssembledSystem, modes: Modes, needed: int) -> Known | None:
    """Return what modes at other speeds are found from.

    `modes`: all of a system at a speed; `needed`: of how many lowest ones. None if the system has
    motions without stiffness, its modes are no basis, or few would be left out; and if one that is
    the same in all directions has overdamped lateral motion.
    """
    if (
        modes.zero_count
        or modes.negative_stiffness_count
        or assembled.depends_on_frequency
        or assembled.is_conservative
    ):
        return None
    if modes.family is not None:
        form = complex_form(assembled)
        return None if form is None else _known_whirl(form, modes, needed)
    return _known_pairs(assembled, modes, needed)


def _known_pairs(assembled: AssembledSystem, modes: Modes, needed: int) -> Known | None:
    """Return what modes in real coordinates are found from."""
    n, count, reals = assembled.size, modes.eigenvalues.size, modes.real_eigenvalues
    kept = _cut(modes.eigenvalues.imag, needed)
    if 2 * count + reals.size != 2 * n or kept is None or 2 * kept + reals.size > _MOST * 2 * n:
        return None
    matrices = matrices_at_speed(assembled, modes.speed_rad_s)
    real_shapes = np.empty((n, reals.size))
    for at, value in enumerate(reals):
        real_shapes[:, at] = _real_shape(matrices, float(value))
    none = np.empty(0), np.empty((n, 0))
    bases = (
        _real_basis(matrices, modes, np.arange(kept), reals, real_shapes),
        _real_basis(matrices, modes, np.arange(kept, count), *none),
    )
    problem = Problem(
        mass=matrices.mass,
        velocity=matrices.damping + matrices.gyroscopic,
        stiffness=matrices.stiffness,
        turning=assembled.gyroscopic,
        circulating=assembled.circulatory_stiffness,
        centrifugal=assembled.centrifugal_stiffness,
    )
    joints = [(joint, joint.motion) for joint in assembled.law_joints]
    return known_subspaces(modes.speed_rad_s, problem, bases, joints)


def _known_whirl(form: ComplexForm, modes: Modes, needed: int) -> Known | None:
    """Return what whirl in z is found from: of λ with Im λ < 0 it is the mode against +z."""
    assert modes.family is not None
    lateral = np.flatnonzero(modes.family)
    family, values = modes.family[lateral], modes.eigenvalues[lateral]
    kept = _cut(values.imag, int(np.count_nonzero(modes.family[:needed])))
    if values.size != 2 * form.size or kept is None or kept > _MOST * values.size:
        return None
    rates = np.where(family > 0, values, values.conj())
    # a circle against +z is the conjugate of what the independent coordinates hold of it
    shapes = modes.shapes[np.ix_(form.first, lateral)]
    shapes = np.where(family > 0, shapes, shapes.conj()) / np.abs(rates)
    low, rest = (
        WhirlBasis(rates[at], shapes[:, at], rates[at] * shapes[:, at])
        for at in (slice(kept), slice(kept, None))
    )
    here = form.at_speed(modes.speed_rad_s)
    problem = Problem(
        mass=here.mass,
        velocity=here.velocity,
        stiffness=here.stiffness,
        turning=-1j * form.gyroscopic,
        circulating=-1j * form.circulatory,
        centrifugal=form.centrifugal_stiffness,
    )
    joints = [(form.assembled.law_joints[law.place], law.motion[None]) for law in form.laws]
    return known_subspaces(modes.speed_rad_s, problem, (low, rest), joints)


def _cut(frequencies: FloatArray, needed: int) -> int | None:
    """Return how many modes to keep: the needed ones and those up to the widest gap beyond."""
    first, last = needed + _FEWEST_MORE, min(needed + _MOST_MORE, frequencies.size - 1)
    if first > last:
        return None
    ratios = frequencies[first : last + 1] / frequencies[first - 1 : last]
    return first + int(ratios.argmax())


def _real_shape(matrices: SpeedMatrices, value: float) -> FloatArray:
    """Return the vector of a real eigenvalue by inverse iteration."""
    factors = la.lu_factor(dynamic_stiffness(matrices, value * (1.0 + _BESIDE)).real)
    shape = np.ones(len(matrices.mass))
    for _ in range(_REAL_STEPS):
        shape = la.lu_solve(factors, shape)
        shape = shape / la.norm(shape)
    return np.asarray(shape)


def _real_basis(
    matrices: SpeedMatrices,
    modes: Modes,
    at: IntArray,
    reals: FloatArray,
    real_shapes: FloatArray,
) -> RealBasis:
    """Return the states of some modes at unit kinetic energy, so that entries of E compare."""
    rates, shapes = modes.eigenvalues[at], modes.shapes[:, at]
    shapes = shapes / np.abs(rates)
    inertia = np.sqrt((real_shapes * (matrices.mass @ real_shapes)).sum(axis=0))
    real_shapes = real_shapes / (inertia * np.abs(reals))
    moving = rates * shapes
    return RealBasis(
        rates=rates,
        reals=reals,
        shapes=np.hstack((shapes.real, shapes.imag, real_shapes)),
        moving=np.hstack((moving.real, moving.imag, reals * real_shapes)),
    )


class NearModes:
    """Find the lowest modes at speeds around a known one, each from those before."""

    def __init__(self, assembled: AssembledSystem, known: Known) -> None:
        self.assembled, self.known = assembled, known
        none = np.zeros((known.others.shapes.shape[1], known.lowest.shapes.shape[1]))
        self._places: dict[float, Matrix] = {known.speed_rad_s: none}
        self._stiffness = matrices_at_speed(assembled, known.speed_rad_s).stiffness

    def at(self, speed_rad_s: float) -> Modes | None:
        """Return the lowest modes at a speed, and all real eigenvalues.

        As `modes_at_speed` returns them, but those alone that lie below all others for certain.
        None where the subspace does not come to rest, the others may be as low, or K is not
        positive definite.
        """
        known = self.known
        matrices = matrices_at_speed(self.assembled, speed_rad_s)
        # K of the known speed is positive definite
        same = np.array_equal(matrices.stiffness, self._stiffness)
        if not same and not _is_definite(matrices.stiffness):
            return None
        found = followed(known, matrix_at(known, speed_rad_s), self._expected(speed_rad_s))
        if found is None:
            return None
        # a polynomial through places side by side magnifies their rounding
        nearest = min(abs(speed_rad_s - place) for place in self._places)
        if nearest > _SIDE_BY_SIDE * abs(speed_rad_s - known.speed_rad_s):
            self._places[speed_rad_s] = found.part
        modes = _pairs if isinstance(known.lowest, RealBasis) else _whirl
        return modes(self.assembled, matrices, speed_rad_s, _lowest(known, found))

    def _expected(self, speed_rad_s: float) -> Matrix:
        """Return P as a polynomial through the nearest places."""
        places = np.array(sorted(self._places, key=lambda at: abs(at - speed_rad_s))[:_MOST_PLACES])
        apart = places[:, None] - places
        ratios = (speed_rad_s - places) / np.where(apart == 0, 1.0, apart)
        np.fill_diagonal(ratios, 1.0)
        weights = ratios.prod(axis=1)
        expected: Matrix = np.zeros_like(self._places[self.known.speed_rad_s])
        for place, weight in zip(places, weights, strict=True):
            expected = expected + weight * self._places[float(place)]
        return expected


class _Low(NamedTuple):
    """Eigenvalues and states of the lowest modes' subspace, and what lies below all others."""

    values: ComplexArray
    shapes: ComplexArray
    bound: float


def _lowest(known: Known, found: Followed) -> _Low:
    """Return the eigenvalues of the subspace of the lowest modes, and their shapes."""
    solved("continued")
    values, vectors = (np.asarray(one, dtype=complex) for one in nla.eig(found.low))
    shapes = np.asarray(known.lowest.shapes + known.others.shapes @ found.part)
    moving = real_times(shapes, vectors) if np.isrealobj(shapes) else shapes @ vectors
    return _Low(values, moving, found.bound)


def _pairs(
    assembled: AssembledSystem, matrices: SpeedMatrices, speed_rad_s: float, low: _Low
) -> Modes:
    """Return the modes of a subspace of real states that lie below a bound."""
    values = low.values
    is_real = are_real(values)
    at = np.flatnonzero(~is_real & (values.imag > 0) & (values.imag < low.bound))
    at = at[np.argsort(values.imag[at], kind="stable")]
    rates, shapes = values[at], low.shapes[:, at]
    if speed_rad_s != 0:
        shapes = separated_whirl(assembled, rates, shapes)
    return Modes(
        speed_rad_s=speed_rad_s,
        eigenvalues=rates,
        shapes=normalised(shapes, matrices.mass),
        real_eigenvalues=np.sort(values.real[is_real]),
        zero_count=0,
        negative_stiffness_count=0,
    )


def _whirl(
    assembled: AssembledSystem, matrices: SpeedMatrices, speed_rad_s: float, low: _Low
) -> Modes | None:
    """Return the whirl of a subspace, axial motion and torsion below a bound.

    None if a whirl no longer oscillates.
    """
    form = complex_form(assembled)
    if form is None or are_real(low.values).any():
        return None
    rest = unturned_modes(assembled, matrices, form)
    lateral = whirl_in_the_round(form, low.values, low.shapes)
    values = np.concatenate((lateral.values, rest.values))
    order = np.argsort(values.imag, kind="stable")
    order = order[values.imag[order] < low.bound]
    return Modes(
        speed_rad_s=speed_rad_s,
        eigenvalues=values[order],
        shapes=normalised(np.hstack((lateral.shapes, rest.shapes))[:, order], matrices.mass),
        real_eigenvalues=np.sort(rest.real),
        zero_count=rest.zeros,
        negative_stiffness_count=0,
        family=np.concatenate((lateral.family, rest.family))[order],
    )


def _is_definite(stiffness: FloatArray) -> bool:
    try:
        la.cholesky(0.5 * (stiffness + stiffness.T), check_finite=False)
    except la.LinAlgError:
        return False
    return True
