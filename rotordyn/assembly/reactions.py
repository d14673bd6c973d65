"""Forces that bearings and gears transmit, for any motion of a system.

Flexible joints follow from their stiffness and damping. Exact ones leave what the equations of the
bodies miss at the coordinates that they join.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import Rows, body_rows, joint_motion, tooth_motion
from solidwhirl.rotordyn.assembly.internal_damping import body_damping
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices
from solidwhirl.rotordyn.superelement.validation import MOTIONS

# Exact joints whose equations depend on each other to this fraction cannot be told apart.
_DEPENDENT = 1e-9


# Components that are none of a bearing: teeth of a gear, motion that a tied body cannot make.
_TEETH, _WITHIN = -1, -2


class JointForces(NamedTuple):
    """Forces by name: of bearings (..., 6), of gears (...)."""

    bearings: dict[str, Matrix]
    gears: dict[str, Matrix]


class _Motion(NamedTuple):
    """Ω and Ω' (p, 1), and q, q', q'' (p, n)."""

    speed: FloatArray
    rate: FloatArray
    displacement: Matrix
    velocity: Matrix
    acceleration: Matrix


class _ExactJoint(NamedTuple):
    """One eliminated motion: its joint, its component (or one of the two above), its row (N,)."""

    name: str
    component: int
    row: FloatArray


def joint_forces(
    assembled: AssembledSystem,
    speed_rad_s: npt.ArrayLike,
    displacement: npt.ArrayLike,
    velocity: npt.ArrayLike,
    acceleration: npt.ArrayLike,
    body_loads: Mapping[str, npt.ArrayLike] | None = None,
    speed_rate_rad_s2: npt.ArrayLike = 0.0,
) -> JointForces:
    """Return the force that the first side of each bearing exerts on its second, and of each gear.

    `speed_rad_s`, `speed_rate_rad_s2`: Ω and Ω', numbers or of the shape (...) of the motion.
    `displacement`, `velocity`, `acceleration`: q, q', q'' in the independent coordinates, shape
    (..., n): time histories, or complex amplitudes (q, iωq, −ω²q). `body_loads`: external forces on
    the coordinates of each body by name, shape (..., n_body); needed where exact joints are near.

    That of a bearing is along x, y, z in N and moments about them in N m, shape (..., 6), on the
    ground where there is no second side; zero for components that the bearing leaves free. That of
    a gear acts along the relative motion of its teeth, shape (...): in N, or in N m on the first
    wheel where the gear has no base radius. Raises AnalysisError if shapes do not fit, or exact
    joints hold a motion more than once, so that the share of each is undetermined.
    """
    shape, motion = _flat_motion(
        assembled.size,
        {"speed_rad_s": speed_rad_s, "speed_rate_rad_s2": speed_rate_rad_s2},
        {"displacement": displacement, "velocity": velocity, "acceleration": acceleration},
    )
    loads = {
        body: _flat(f"body_loads[{body!r}]", load, (*shape, len(body_rows(assembled, body))))
        for body, load in (body_loads or {}).items()
    }
    system = assembled.system
    bearings = {b.name: _flexible_force(assembled, b, motion) for b in system.bearings}
    gears = {}
    for gear in system.gears:
        teeth = tooth_motion(assembled, gear)
        gears[gear.name] = (gear.mesh_stiffness_n_per_m or 0.0) * (motion.displacement @ teeth)
        gears[gear.name] += gear.mesh_damping_n_s_per_m * (motion.velocity @ teeth)
    joints, shares = _shares(assembled)
    if joints:
        every = _every_row(assembled)
        solution = _body_forces(assembled, shares, motion, loads)
        for bearing in system.bearings:
            solution += bearings[bearing.name] @ (joint_motion(every, bearing) @ shares.T)
        for gear in system.gears:
            solution += np.multiply.outer(gears[gear.name], shares @ tooth_motion(every, gear))
        for joint, force in zip(joints, solution.T, strict=True):
            if joint.component == _TEETH:
                gears[joint.name] = gears[joint.name] + force
            else:
                bearings[joint.name][:, joint.component] += force
    return JointForces(
        bearings={name: force.reshape(*shape, 6) for name, force in bearings.items()},
        gears={name: force.reshape(shape) for name, force in gears.items()},
    )


def _flat_motion(
    size: int, speeds: Mapping[str, npt.ArrayLike], q: Mapping[str, npt.ArrayLike]
) -> tuple[tuple[int, ...], _Motion]:
    """Return the leading shape and the motion with one leading axis."""
    kind = np.result_type(*(np.asarray(part) for part in q.values()), float)
    shape = np.shape(q["displacement"])[:-1]
    columns = {name: np.asarray(value, dtype=float)[..., None] for name, value in speeds.items()}
    for name, column in columns.items():
        if not np.isfinite(column).all():
            raise AnalysisError(f"{name} has numbers that are not finite")
    numbers = [_flat(name, column, (*shape, 1)) for name, column in columns.items()]
    motion = [_flat(name, part, (*shape, size)).astype(kind) for name, part in q.items()]
    return shape, _Motion(*numbers, *motion)


def _flat(name: str, given: npt.ArrayLike, shape: tuple[int, ...]) -> Matrix:
    """Return an array of a shape, or of its last length for all, with one leading axis."""
    array = np.asarray(given)
    if array.shape not in (shape, shape[-1:]):
        raise AnalysisError(f"{name} has shape {array.shape}; allowed are {shape} and {shape[-1:]}")
    return np.broadcast_to(array, shape).reshape(-1, shape[-1])


def _flexible_force(assembled: AssembledSystem, bearing: Bearing, motion: _Motion) -> Matrix:
    """Return the force of stiffness and damping, shape (p, 6)."""
    relative = joint_motion(assembled, bearing)
    if not relative.any():  # what moves is elsewhere
        return np.zeros((len(motion.speed), 6), motion.displacement.dtype)
    place, speed = motion.displacement @ relative.T, motion.velocity @ relative.T
    stiffness, damping = bearing.matrices()
    if bearing.speed_law is None:
        return np.asarray(place @ stiffness.T + speed @ damping.T)
    stiffness[:2, :2] = damping[:2, :2] = 0.0
    force = place @ stiffness.T + speed @ damping.T
    parts = (motion.displacement, motion.velocity)
    for joint in (joint for joint in assembled.law_joints if joint.bearing == bearing.name):
        for matrix, part in zip(joint.coefficients_along(motion.speed[:, 0]), parts, strict=True):
            own = np.einsum("pij,pj->pi", matrix[:, : len(joint.rows)], part @ joint.motion.T)
            force += own @ joint.rows
    return np.asarray(force)


def _every_row(assembled: AssembledSystem) -> Rows:
    """Return the coordinates of all bodies by themselves."""
    return Rows(assembled.system, assembled.body_slices, np.eye(len(assembled.transformation)))


# a system is a record that never changes; a run-up asks many times
@lru_cache(maxsize=8)
def _shares(assembled: AssembledSystem) -> tuple[list[_ExactJoint], FloatArray]:
    """Return the k exact joints that transmit forces, and what makes these, shape (k, N).

    What the equations of the bodies miss at all coordinates, times that, are the forces.
    """
    joints = _exact_joints(assembled)
    rows = np.array([joint.row for joint in joints]).reshape(
        len(joints), len(assembled.transformation)
    )
    touched = rows.any(axis=0)
    seen = [k for k, joint in enumerate(joints) if joint.component != _WITHIN]
    shares = np.zeros((len(seen), touched.size))
    if joints:
        shares[:, touched] = -_inverse(joints, rows[:, touched])[seen]
    return [joints[k] for k in seen], shares


def _exact_joints(assembled: AssembledSystem) -> list[_ExactJoint]:
    """Return the eliminated motions as rows over the coordinates of all bodies."""
    joints, every = [], _every_row(assembled)
    for bearing in (b for b in assembled.system.bearings if b.rigid):
        rows = joint_motion(every, bearing)
        places = [MOTIONS.index(c) for c in MOTIONS if c in bearing.rigid]
        joints += [_ExactJoint(bearing.name, at, rows[at]) for at in places]
    joints += [
        _ExactJoint(gear.name, _TEETH, tooth_motion(every, gear))
        for gear in assembled.system.gears
        if gear.mesh_stiffness_n_per_m is None
    ]
    return joints + _within_bodies(assembled, joints)


def _within_bodies(assembled: AssembledSystem, joints: list[_ExactJoint]) -> list[_ExactJoint]:
    """Return the motions that tied bodies cannot make, held by forces inside them."""
    inside = []
    for name, rotor in assembled.system.rotors.items():
        at = assembled.body_slices[name]
        if rotor.element.constraint is None or not any(j.row[at].any() for j in joints):
            continue
        for direction in la.null_space(rotor.element.constraint.T, rcond=_DEPENDENT).T:
            row = np.zeros(assembled.transformation.shape[0])
            row[at] = direction
            inside.append(_ExactJoint(name, _WITHIN, row))
    return inside


def _body_forces(
    assembled: AssembledSystem,
    shares: FloatArray,
    motion: _Motion,
    loads: Mapping[str, Matrix],
) -> Matrix:
    """Return inertia, damping and stiffness forces less loads, in shares of all coordinates.

    `shares`: shape (k, N). Returns shape (p, k).
    """
    total = np.zeros((motion.displacement.shape[0], len(shares)), motion.displacement.dtype)
    for name, rotor in assembled.system.rotors.items():
        own = shares[:, assembled.body_slices[name]]
        if not own.any():
            continue
        if name in loads:
            total = total - loads[name] @ own.T
        moved = _Moved(own, assembled.transformation[assembled.body_slices[name]])
        if not moved.rows.any():  # what moves is elsewhere
            continue
        body, ratio = free_body_matrices(rotor.element), rotor.speed_ratio
        rotating = body_damping(rotor, body)
        q, v, spin = motion.displacement, motion.velocity, ratio * motion.speed
        force = moved.force(body.mass, motion.acceleration) + moved.force(rotating.damping, v)
        force = force + moved.force(body.stiffness, q)
        force = force + spin**2 * moved.force(body.centrifugal_stiffness, q)
        force = force + spin * moved.force(body.gyroscopic, v)
        force = force + spin * moved.force(rotating.circulatory, q)
        force = force + 0.5 * ratio * motion.rate * moved.force(body.gyroscopic, q)
        total = total + force
    return np.asarray(total)


class _Moved(NamedTuple):
    """Shares of the coordinates of a body (k, n_body), and all of them per independent one."""

    shares: FloatArray
    rows: FloatArray

    def force(self, matrix: FloatArray, motion: Matrix) -> Matrix:
        """Return the shares of a matrix of the body times a motion (p, n), (p, k)."""
        return np.asarray(motion @ (self.shares @ matrix @ self.rows).T)


def _inverse(joints: list[_ExactJoint], rows: FloatArray) -> FloatArray:
    """Return the left inverse of Bᵀ for the rows B (c, t) of exact joints."""
    free = la.null_space(rows.T, rcond=_DEPENDENT)
    if free.size:
        shares = np.abs(free).max(axis=1)
        names = {j.name for j, share in zip(joints, shares, strict=True) if share > _DEPENDENT}
        raise AnalysisError(
            f"the exact joints {sorted(names)} hold the same motion more than once, so the share "
            "of each is undetermined; make one of them flexible"
        )
    return np.asarray(la.pinv(rows.T))
