"""Steady response of bodies of revolution on bearings that are not the same in all directions.

The system is split into one that is, solved in circles with half of the coordinates, and a coupling
of low rank by what the bearings have beside it (Sherman, Morrison and Woodbury).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import BoolArray, ComplexArray, FloatArray
from solidwhirl.rotordyn.complex_form import ComplexForm, matrix_form
from solidwhirl.rotordyn.coordinates import joint_motion
from solidwhirl.rotordyn.harmonic_response_solver import (
    CHUNK_BYTES,
    MatrixTriple,
    ScaledMatrices,
    column_norms,
    fill_dynamic_stiffness,
)
from solidwhirl.rotordyn.system import AssembledSystem, LawJoint

# A point is left to the full equations above this |f − D q| / |f| or this |D| |q| / |f|.
_POOR = 1e-10
_LARGE = 1e9
# A coupling of more rows than this fraction of the half coordinates saves no time.
_MOST_ROWS = 0.5


class _Part(NamedTuple):
    """What one bearing adds: relative motion (2, n), k and c beside the isotropic mean, its law."""

    motion: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    law: LawJoint | None


class SplitSystem(NamedTuple):
    """A system that is the same in all directions, and what bearings add on the motions U q (r,).

    `turned` is V = U_p − i U_s, so that U q = V z₊ + V* w for the circles z₊ and w = z₋*.
    """

    form: ComplexForm
    turned: ComplexArray
    stiffness: FloatArray
    damping: FloatArray
    laws: tuple[tuple[slice, LawJoint], ...]

    def coupling(self, speed_rad_s: float) -> tuple[FloatArray, FloatArray]:
        """Return k and c on U q, each (r, r)."""
        if not self.laws:
            return self.stiffness, self.damping
        stiffness, damping = self.stiffness.copy(), self.damping.copy()
        for rows, law in self.laws:
            more = law.coefficients(speed_rad_s)
            stiffness[rows, rows] += more[0]
            damping[rows, rows] += more[1]
        return stiffness, damping


class SplitSolved(NamedTuple):
    """q (p, n, r), the relative residual (p,), and the points that were left unsolved (p,)."""

    displacement: ComplexArray
    relative_residual: FloatArray
    unsolved: BoolArray


def split_system(assembled: AssembledSystem, speed_rad_s: float) -> SplitSystem | None:
    """Split a system into one that is the same in all directions and a coupling by bearings.

    Parameters
    ----------
    assembled
        The system.
    speed_rad_s
        Ω at which bearings with a speed law give the isotropic part its share.

    Returns
    -------
    SplitSystem or None
        None where the bodies do not know how they turn, joints hold x other than y, or the
        coupling has too many rows to save time.
    """
    if assembled.spin_generator is None:
        return None
    parts = tuple(_parts(assembled, speed_rad_s))
    if not parts or 2 * len(parts) > 0.5 * _MOST_ROWS * assembled.size:
        return None
    stiffness, damping = np.array(assembled.stiffness), np.array(assembled.damping)
    for part in parts:
        stiffness -= part.motion.T @ part.stiffness @ part.motion
        damping -= part.motion.T @ part.damping @ part.motion
    even = dataclasses.replace(assembled, stiffness=stiffness, damping=damping, law_joints=())
    form = matrix_form(even)
    rows = np.concatenate([part.motion for part in parts])
    if form is None or rows[:, form.rest].any():
        return None
    turned = rows[:, form.first] - 1j * form.second_sign * rows[:, form.second]
    places = [slice(2 * at, 2 * at + 2) for at in range(len(parts))]
    return SplitSystem(
        form=form,
        turned=turned,
        stiffness=la.block_diag(*[part.stiffness for part in parts]),
        damping=la.block_diag(*[part.damping for part in parts]),
        laws=tuple((rows, part.law) for rows, part in zip(places, parts, strict=True) if part.law),
    )


def _parts(assembled: AssembledSystem, speed: float) -> Iterator[_Part]:
    """Yield what bearings have beside k̄ I and c̄ I; with a law, less those at a speed."""
    laws = {joint.bearing: joint for joint in assembled.law_joints}
    for bearing in assembled.system.bearings:
        motion, (k, c) = joint_motion(assembled, bearing), bearing.matrices()
        for plane in (slice(0, 2), slice(3, 5)):
            law = laws.get(bearing.name) if plane.start == 0 else None
            if law is None:
                odd = _odd(k[plane, plane]), _odd(c[plane, plane])
            else:
                here = law.coefficients(speed)
                odd = -_mean(here[0]), -_mean(here[1])
            if law is not None or odd[0].any() or odd[1].any():
                yield _Part(motion[plane], odd[0], odd[1], law)


def _odd(matrix: FloatArray) -> FloatArray:
    return np.asarray(matrix - _mean(matrix))


def _mean(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.trace(matrix) * np.eye(2))


def solve_split(
    split: SplitSystem, speeds: FloatArray, frequencies: FloatArray, force: ComplexArray
) -> SplitSolved:
    """Solve for the lateral response at each point; one without load is not solved.

    Parameters
    ----------
    split
        The system.
    speeds, frequencies
        Ω and ω ≥ 0 of the points, shape (p,), rad/s.
    force
        Loads on all coordinates, shape (p, n, r); those that a turn does not move are left out.

    Returns
    -------
    SplitSolved
        Points near a resonance of the isotropic part or of the system are left unsolved.
    """
    form, size = split.form, split.form.size
    by_coordinate = force.swapaxes(0, 1)
    loads = np.stack((form.to_complex(by_coordinate), form.to_complex(by_coordinate.conj()).conj()))
    loads = 0.5 * loads.transpose(2, 0, 1, 3)
    circles = np.zeros(loads.shape, dtype=complex)
    residual, unsolved = np.zeros(speeds.size), np.zeros(speeds.size, dtype=bool)
    loaded = np.flatnonzero(loads.any(axis=(1, 2, 3)))
    if loaded.size:
        matrices = ScaledMatrices(form.at_speed, float(speeds[loaded[0]]), float(frequencies.max()))
        chunk = max(1, CHUNK_BYTES // (32 * size * size))
        dynamic = np.empty((min(chunk, loaded.size), 2, size, size), dtype=complex)
        for start in range(0, loaded.size, chunk):
            points = loaded[start : start + chunk]
            stack = dynamic[: points.size]
            for place, point in zip(stack, points, strict=True):
                _fill_both(place, matrices.at(float(speeds[point])), float(frequencies[point]))
            solved = _solve_chunk(
                stack,
                _couplings(split, speeds[points], frequencies[points]),
                split.turned * matrices.scale,
                loads[points] * matrices.scale[:, None],
            )
            circles[points] = solved[0] * matrices.scale[:, None]
            residual[points], unsolved[points] = solved[1:]
    forward, mirrored = circles.transpose(1, 2, 0, 3)
    displacement = form.whirl_shapes(forward, mirrored.conj()).swapaxes(0, 1)
    return SplitSolved(np.ascontiguousarray(displacement), residual, unsolved)


def _couplings(split: SplitSystem, speeds: FloatArray, frequencies: FloatArray) -> ComplexArray:
    """Return k + iωc of the coupling at some points, shape (c, r, r)."""
    known, which = np.unique(speeds, return_inverse=True)
    found = np.array([split.coupling(float(speed)) for speed in known])[which]
    return np.asarray(found[:, 0] + 1j * frequencies[:, None, None] * found[:, 1])


def _fill_both(place: ComplexArray, triple: MatrixTriple, omega: float) -> None:
    """Write D(ω) of the forward circle and D(−ω)* of the mirrored backward one."""
    mass, velocity, stiffness = triple
    work = np.empty(mass.shape)
    fill_dynamic_stiffness(place[0], triple, omega, work)
    fill_dynamic_stiffness(place[1], (mass, velocity.conj(), stiffness.conj()), omega, work)


def _solve_chunk(
    stack: ComplexArray, coupling: ComplexArray, turned: ComplexArray, loads: ComplexArray
) -> tuple[ComplexArray, FloatArray, BoolArray]:
    """Return the circles (c, 2, m, r), their residuals, and what is better solved otherwise."""
    sides = np.stack((turned, turned.conj()))
    # Load of a unit force on U q in either circle.
    unit = 0.5 * sides.conj().swapaxes(1, 2)
    right = np.concatenate((loads, np.broadcast_to(unit, (*loads.shape[:2], *unit.shape[1:]))), 3)
    try:
        solution = np.linalg.solve(stack, right)
        alone, per_unit = solution[..., : loads.shape[3]], solution[..., loads.shape[3] :]
        small = np.eye(coupling.shape[1]) + coupling @ (sides @ per_unit).sum(axis=1)
        pull = np.linalg.solve(small, coupling @ (sides @ alone).sum(axis=1))
    except np.linalg.LinAlgError:
        count = loads.shape[0]
        return np.zeros_like(loads), np.zeros(count), np.ones(count, dtype=bool)
    circles = alone - per_unit @ pull[:, None]
    pulled = coupling @ (sides @ circles).sum(axis=1)
    error = loads - stack @ circles - unit @ pulled[:, None]
    flat = stack.view(float).reshape(stack.shape[0], -1)
    stiffness = np.sqrt(np.einsum("pi,pi->p", flat, flat))[:, None]
    force, motion, left = (column_norms(_both(part)) for part in (loads, circles, error))
    force = np.where(force > 0, force, np.inf)
    residual = (left / force).max(axis=1)
    growth = (stiffness * motion / force).max(axis=1)
    return circles, residual, ~((residual <= _POOR) & (growth <= _LARGE))


def _both(circles: ComplexArray) -> ComplexArray:
    """Return both circles as one column, (c, 2m, r)."""
    return circles.reshape(circles.shape[0], -1, circles.shape[3])
