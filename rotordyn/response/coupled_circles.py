"""Response of a system that is the same in all directions but for its bearings: coupled circles."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import joint_motion
from solidwhirl.rotordyn.assembly.system import AssembledSystem, LawJoint
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.complex_form import ComplexForm, matrix_form
from solidwhirl.rotordyn.response.points import (
    MatrixTriple,
    Solved,
    Stack,
    fill,
    loaded_stacks,
    measured,
)

# A point is left to the full equations above this |f − D q| / |f| or this |D| |q| / |f|.
_POOR = 1e-10
_LARGE = 1e9
# A coupling of more rows than this fraction of the half coordinates saves no time.
_MOST_ROWS = 0.5


# Damping below this fraction of the largest of the system is none.
_ROUNDING = 1e-12

# Isotropic part of k and c of a bearing that stays with the bodies.
_Share = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


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


def split_system(assembled: AssembledSystem, speed_rad_s: float) -> SplitSystem | None:
    """Split a system into one that is the same in all directions and a coupling by bearings.

    `speed_rad_s`: Ω at which bearings with a speed law give the isotropic part its share. Returns
    none where the bodies do not know how they turn, joints hold x other than y, or the coupling has
    too many rows to save time.
    """
    split = _split(assembled, speed_rad_s, lambda k, c: (_mean(k), _mean(c)))
    return None if split is None or not split.turned.size else split


def split_bodies(assembled: AssembledSystem, speed_rad_s: float) -> SplitSystem | None:
    """Split a system as `split_system`, with all damping of the bearings in the coupling.

    None as well where bodies are damped themselves.
    """
    split = _split(assembled, speed_rad_s, lambda k, c: (_mean(k), np.zeros((2, 2))))
    if split is None or split.form.circulatory.any():
        return None
    damping = np.abs(split.form.damping).max()
    # what is left of damping that was taken out is rounding
    if damping > _ROUNDING * np.abs(assembled.damping).max(initial=0.0):
        return None
    form = dataclasses.replace(split.form, damping=np.zeros_like(split.form.damping))
    return split._replace(form=form)


def _split(assembled: AssembledSystem, speed_rad_s: float, share: _Share) -> SplitSystem | None:
    """Split a system whose isotropic part has a share of the bearings."""
    joints = assembled.law_joints
    if assembled.spin_generator is None or any(len(j.motion) > 2 for j in joints):
        return None
    if len({joint.bearing for joint in joints}) < len(joints):  # laws made of several
        return None
    parts = tuple(_parts(assembled, speed_rad_s, share))
    if 2 * len(parts) > 0.5 * _MOST_ROWS * assembled.size:
        return None
    stiffness, damping = np.array(assembled.stiffness), np.array(assembled.damping)
    for part in parts:
        stiffness -= part.motion.T @ part.stiffness @ part.motion
        damping -= part.motion.T @ part.damping @ part.motion
    form = matrix_form(
        dataclasses.replace(assembled, stiffness=stiffness, damping=damping, law_joints=())
    )
    rows = np.concatenate([np.empty((0, assembled.size)), *(part.motion for part in parts)])
    if form is None or rows[:, form.rest].any():
        return None
    turned = rows[:, form.first] - 1j * form.second_sign * rows[:, form.second]
    none = np.empty((0, 0))
    places = [slice(2 * at, 2 * at + 2) for at in range(len(parts))]
    return SplitSystem(
        form=form,
        turned=turned,
        stiffness=la.block_diag(none, *[part.stiffness for part in parts]),
        damping=la.block_diag(none, *[part.damping for part in parts]),
        laws=tuple((rows, part.law) for rows, part in zip(places, parts, strict=True) if part.law),
    )


def _parts(assembled: AssembledSystem, speed: float, share: _Share) -> Iterator[_Part]:
    """Yield what bearings have beside the isotropic share; with a law, less that at a speed."""
    laws = {joint.bearing: joint for joint in assembled.law_joints}
    for bearing in assembled.system.bearings:
        motion, (k, c) = joint_motion(assembled, bearing), bearing.matrices()
        for plane in (slice(0, 2), slice(3, 5)):
            law = laws.get(bearing.name) if plane.start == 0 else None
            if law is None:
                own = (k[plane, plane], c[plane, plane])
                stiffness, damping = (a - b for a, b in zip(own, share(*own), strict=True))
            else:
                stiffness, damping = (-a for a in share(*law.coefficients(speed)))
            if law is not None or stiffness.any() or damping.any():
                yield _Part(motion[plane], stiffness, damping, law)


def _mean(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.trace(matrix) * np.eye(2))


def solve_split(
    split: SplitSystem, speeds: FloatArray, frequencies: FloatArray, force: ComplexArray
) -> tuple[Solved, BoolArray]:
    """Solve for the lateral response at each point, and say which were left unsolved (p,).

    `speeds`, `frequencies`: Ω and ω ≥ 0 of the points, shape (p,), rad/s. `force`: loads on all
    coordinates, shape (p, n, r); those that a turn does not move are left out. One without load is
    not solved; points near a resonance of the isotropic part or of the system are left unsolved.
    """
    form, loads = split.form, circle_loads(split.form, force)
    circles = np.zeros(loads.shape, dtype=complex)
    residual, unsolved = np.zeros(speeds.size), np.zeros(speeds.size, dtype=bool)
    every = (form.at_speed, speeds, frequencies, loads)
    for chunk in loaded_stacks(*every, _fill_both):
        points, scale = chunk.points, chunk.scale
        coupling = couplings(split, speeds[points], frequencies[points])
        turned = split.turned * scale[:, 0]
        found, residual[points], unsolved[points] = _solve_chunk(
            chunk, coupling, turned, loads[points] * scale
        )
        circles[points] = found * scale
    forward, mirrored = circles.transpose(1, 2, 0, 3)
    displacement = form.whirl_shapes(forward, mirrored.conj()).swapaxes(0, 1)
    return Solved(np.ascontiguousarray(displacement), residual), unsolved


def circle_loads(form: ComplexForm, force: ComplexArray) -> ComplexArray:
    """Return forward and mirrored backward circle of loads (p, n, r), shape (p, 2, m, r)."""
    by_coordinate = force.swapaxes(0, 1)
    loads = np.stack((form.to_complex(by_coordinate), form.to_complex(by_coordinate.conj()).conj()))
    return np.asarray(0.5 * loads.transpose(2, 0, 1, 3))


def couplings(split: SplitSystem, speeds: FloatArray, frequencies: FloatArray) -> ComplexArray:
    """Return k + iωc of the coupling at some points, shape (c, r, r)."""
    known, which = np.unique(speeds, return_inverse=True)
    found = np.array([split.coupling(float(speed)) for speed in known])[which]
    return np.asarray(found[:, 0] + 1j * frequencies[:, None, None] * found[:, 1])


def is_poor(residual: FloatArray, growth: FloatArray) -> BoolArray:
    """Tell which points are better solved by the full equations, from what `measured` returns."""
    return np.asarray(~((residual <= _POOR) & (growth <= _LARGE)))


def _fill_both(place: ComplexArray, triple: MatrixTriple, omega: float) -> None:
    """Write D(ω) of the forward circle and D(−ω)* of the mirrored backward one."""
    mass, velocity, stiffness = triple
    fill(place[0], triple, omega)
    fill(place[1], (mass.conj(), velocity.conj(), stiffness.conj()), omega)


def _solve_chunk(
    chunk: Stack, coupling: ComplexArray, turned: ComplexArray, loads: ComplexArray
) -> tuple[ComplexArray, FloatArray, BoolArray]:
    """Return the circles (c, 2, m, r), their residuals, and what is better solved otherwise."""
    stack = chunk.matrices
    solved("responses", len(stack))
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
    residual, growth = measured(chunk.terms, loads, circles, error)
    return circles, residual, is_poor(residual, growth)
