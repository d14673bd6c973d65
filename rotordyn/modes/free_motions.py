"""Motions that nothing holds: rigid motions at 0 Hz that lists of modes leave out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.bearing_notes import coefficients_at_speed
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    SpeedMatrices,
    gravity_load,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.modes.eigen import scaled_stiffness

# ux, uy, rx, ry among the rigid motions of a body.
_LATERAL = np.array([0, 1, 3, 4])
_LATERAL_NAMES = frozenset({"ux", "uy", "rx", "ry"})
# Share of the kinetic energy, as its root, below which a motion is none. Rigid motions of reduced
# bodies are exact to 1e-9 and better.
_SOME = 1e-4


@dataclass(frozen=True, kw_only=True)
class FreeMotion:
    """Bodies that can move laterally at no cost of energy.

    `bodies`: those that move, joined with each other by joints that act laterally; `held_by`:
    bearings that act laterally between them and what does not move; `count`: number of independent
    motions at rest, each a pair of zero eigenvalues.
    """

    bodies: tuple[str, ...]
    held_by: tuple[str, ...]
    count: int


def free_lateral_motions(assembled: AssembledSystem) -> tuple[FreeMotion, ...]:
    """Find the bodies whose lateral motion at rest nothing holds, or not all of it.

    One for each group of joined bodies, empty if all are held. Axial motion and torsion do not
    count: rotors have them free.

    The null space of K at rest, as `modes_at_speed` counts zeros, is written in the rigid motions
    of every body, weighted with the roots of their masses; its rank in ux, uy, rx and ry is the
    number of motions.
    """
    null = _null_motions(assembled)
    if not null.size:
        return ()
    moving = {}
    for name in assembled.system.rotors:
        part = _lateral_part(assembled, name, null)
        if part.size and np.linalg.norm(part, 2) > _SOME:
            moving[name] = part
    return tuple(
        FreeMotion(
            bodies=group,
            held_by=_holders(assembled, group, tuple(moving)),
            count=_rank(np.vstack([moving[name] for name in group])),
        )
        for group in _groups(assembled, tuple(moving))
    )


def unsupported_bodies(
    assembled: AssembledSystem, gravity_m_per_s2: npt.ArrayLike
) -> tuple[str, ...]:
    """Find the bodies that fall at rest, as no joint carries their weight.

    `gravity_m_per_s2`: acceleration along x, y, z, shape (3,). Returns their names; a body that is
    free to move but stays in balance is none.
    """
    null = _null_motions(assembled)
    weight = assembled.transformation.T @ gravity_load(assembled, gravity_m_per_s2)
    falling = null @ (null.T @ weight)
    fallen = {
        name: assembled.transformation[assembled.body_slices[name]] @ falling
        for name in assembled.system.rotors
    }
    # motion under the weight, per body, against that of a body that falls freely
    least = _SOME * np.linalg.norm(gravity_m_per_s2)
    return tuple(
        name
        for name, motion in fallen.items()
        if _root_energy(assembled, name, motion) > least * np.sqrt(_mass(assembled, name))
    )


def _root_energy(assembled: AssembledSystem, name: str, motion: FloatArray) -> float:
    mass = assembled.system.rotors[name].element.mass
    return float(np.sqrt(np.maximum(motion @ mass @ motion, 0.0)))


def _mass(assembled: AssembledSystem, name: str) -> float:
    """Largest mass of a body along an axis, kg; 0 if it moves along none."""
    element = assembled.system.rotors[name].element
    along = element.rigid_body_modes[:, :3]
    return float(np.diag(along.T @ element.mass @ along).max())


def _null_motions(assembled: AssembledSystem) -> FloatArray:
    """Motions at rest that cost no energy, each of unit modal mass, shape (n, motions)."""
    return null_motions(assembled, matrices_at_speed(assembled, 0.0))


def null_motions(assembled: AssembledSystem, matrices: SpeedMatrices) -> FloatArray:
    """Return the motions that the stiffness in some matrices leaves free, of unit modal mass.

    `assembled`: whose bodies tell what rounding is; returns shape (n, motions).
    """
    scaled = scaled_stiffness(assembled, matrices)
    if not scaled.zero_count:
        return np.empty((assembled.size, 0))
    lowest = np.argsort(np.abs(scaled.eigenvalues))[: scaled.zero_count]
    vectors = scaled.scale[:, None] * scaled.vectors[:, lowest]
    root = la.cholesky(vectors.T @ matrices.mass @ vectors)
    return np.asarray(la.solve_triangular(root, vectors.T, trans="T").T)


def _lateral_part(assembled: AssembledSystem, name: str, null: FloatArray) -> FloatArray:
    """Lateral rigid motions of a body in each column, in roots of kinetic energy; (k, columns)."""
    element = assembled.system.rotors[name].element
    present = np.flatnonzero(element.rigid_body_present)
    motions = assembled.transformation[assembled.body_slices[name]] @ null
    modes = element.rigid_body_modes[:, present]
    amounts, *_ = la.lstsq(modes, motions)
    lateral = np.isin(present, _LATERAL)
    own = modes[:, lateral]
    if not own.size:
        return np.empty((0, null.shape[1]))
    weight = la.cholesky(own.T @ element.mass @ own)
    return np.asarray(weight @ amounts[lateral])


def _rank(parts: FloatArray) -> int:
    return int(np.count_nonzero(la.svdvals(parts) > _SOME))


def _acts_laterally(assembled: AssembledSystem, bearing: Bearing) -> bool:
    """Whether a bearing resists a lateral motion or a tilt at rest."""
    stiffness = coefficients_at_speed(assembled, bearing, 0.0).stiffness_n_per_m
    return bool(
        _LATERAL_NAMES & set(bearing.rigid)
        or stiffness.any()
        or bearing.tilt_stiffness_n_m_per_rad.any()
    )


def _joints(assembled: AssembledSystem) -> list[tuple[str, tuple[str, ...]]]:
    """Joints that act laterally, and their bodies; the ground is none."""
    system = assembled.system
    found = [
        (b.name, tuple(end.body for end in b.ends))
        for b in system.bearings
        if _acts_laterally(assembled, b)
    ]
    meshes = (g for g in system.gears if g.line_of_action_rad is not None)
    return found + [(g.name, tuple(end.body for end in g.ends)) for g in meshes]


def _groups(assembled: AssembledSystem, moving: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Bodies that move, in groups that are joined."""
    label = {name: k for k, name in enumerate(moving)}
    for _, bodies in _joints(assembled):
        labels = {label[name] for name in bodies if name in label}
        label = {n: min(labels) if k in labels else k for n, k in label.items()}
    return [tuple(name for name in moving if label[name] == k) for k in sorted(set(label.values()))]


def _holders(
    assembled: AssembledSystem, group: tuple[str, ...], moving: tuple[str, ...]
) -> tuple[str, ...]:
    """Joints between a group and what stands still."""
    return tuple(
        name
        for name, bodies in _joints(assembled)
        if set(bodies) & set(group) and (len(bodies) == 1 or set(bodies) - set(moving))
    )
