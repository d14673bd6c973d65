"""Families of motions of a body: lateral, torsional, axial and those of its disks alone.

In a body of revolution they are independent of each other, but for blades at an angle; other bodies
mix them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.record import Superelement

#: In the order of weights and shares. A disk motion has two or more nodal diameters, or leaves the
#: interfaces of its body where they are.
FAMILIES = ("lateral", "torsional", "axial", "disk")
_FAMILY_OF = {"ux": 0, "uy": 0, "rx": 0, "ry": 0, "rz": 1, "uz": 2}
# Modes that all interfaces excite by less (squared, relative) are excited by none.
_LINKED = 1e-12
# Matrix entries below this part of the largest are rounding.
_ROUNDING = 1e-9
# A rigid motion has more than this share of the energy of a mode of a free body.
_RIGID = 0.5
# A mode whose surface moves in one way by more than this share (squared) moves in that way alone.
_ALONE = 0.9


class FamilyForm(NamedTuple):
    """A body in coordinates that each belong to families, p of q = basis · p.

    `basis`: (n, n). `mass`: of p, (n, n). `weights`: how much each belongs to each family, (n, 4);
    rows add up to 1.
    """

    basis: FloatArray
    mass: FloatArray
    weights: FloatArray


def family_form(element: Superelement) -> FamilyForm:
    """Return a body in Craig-Bampton coordinates and the families of these.

    Motions of interfaces, with all that follows statically, by their component: rz is torsional, uz
    axial, others are lateral. Fixed-interface modes by the interface motions whose inertia excites
    them. A mode that none excites is told by how a turn about the axis changes it, if the body
    knows: not at all (torsional, or axial if points move along the axis), once (lateral), several
    times (disk). If it does not know, it is a disk motion, but for bodies without interfaces.
    """
    held = np.array([c.kind == "interface" for c in element.coordinates], dtype=bool)
    free = np.flatnonzero(~held)
    basis = _craig_bampton(element, held, free)
    mass = basis.T @ element.mass @ basis
    kept = np.eye(len(FAMILIES))
    weights = np.zeros((element.size, len(FAMILIES)))
    weights[held] = kept[[_FAMILY_OF[c.component] for c in element.coordinates if c.interface]]
    size = np.diag(mass)
    scale = np.outer(size[free], size[held])
    squared = mass[np.ix_(~held, held)] ** 2
    linked = np.divide(squared, scale, out=np.zeros_like(squared), where=scale > 0.0)
    by_link = linked @ weights[held]
    for k, own in zip(free, by_link, strict=True):
        total = own.sum()
        weights[k] = own / total if total > _LINKED else kept[_own_family(element, basis[:, k])]
    return FamilyForm(basis, mass, weights)


def _craig_bampton(element: Superelement, held: BoolArray, free: IntArray) -> FloatArray:
    """Return the coordinates from those of interfaces and fixed-interface modes, (n, n)."""
    import scipy.linalg as la  # names of families are told where nothing is solved

    basis = np.eye(element.size)
    inside = np.ix_(free, free)
    stiffness, mass = element.stiffness[inside], element.mass[inside]
    across = element.stiffness[np.ix_(free, held)]
    rest = (across, stiffness - np.diag(np.diag(stiffness)), mass - np.diag(np.diag(mass)))
    small = _ROUNDING * np.abs(np.diag(element.stiffness)).max(initial=0.0)
    if all(np.abs(a).max(initial=0.0) <= small for a in rest[:2]) and not rest[2].any():
        return basis
    try:
        values, modes = la.eigh(stiffness, mass)
    except np.linalg.LinAlgError:  # no mass inside
        return basis
    if values[0] <= values.size * np.finfo(float).eps * values[-1]:  # what no interface holds
        return basis
    basis[np.ix_(free, held)] = -modes @ (modes.T @ across / values[:, None])
    basis[inside] = modes
    return basis


def _own_family(element: Superelement, mode: FloatArray) -> int:
    """Return the family of a mode that no interface excites, by what a turn of the body makes."""
    if element.spin_generator is None:
        is_held = any(c.kind == "interface" for c in element.coordinates)
        return FAMILIES.index("disk" if is_held else _family_by_surface(element, mode))
    turned = element.spin_generator @ mode
    squared = float(turned @ element.mass @ turned) / float(mode @ element.mass @ mode)
    turns = round(float(np.sqrt(max(squared, 0.0))))
    if turns:
        return FAMILIES.index("lateral" if turns == 1 else "disk")
    moved = np.abs(element.recovery_modes @ mode)
    along = moved[:, 2].max(initial=0.0) > _ROUNDING * moved.max(initial=0.0)
    return FAMILIES.index("axial" if along else "torsional")


def _family_by_surface(element: Superelement, mode: FloatArray) -> str:
    """Return the family of a mode of a body of any shape without interfaces, by its surface.

    Axial or torsional where nearly all motion is along or around the axis, lateral otherwise.
    """
    moved = element.recovery_modes @ mode
    x, y = element.recovery_points_m[:, 0], element.recovery_points_m[:, 1]
    around = x * moved[:, 1] - y * moved[:, 0]
    radius = np.hypot(x, y)
    around = np.divide(around, radius, out=np.zeros_like(around), where=radius > 0.0)
    most = _ALONE * float((moved**2).sum())
    if float(moved[:, 2] @ moved[:, 2]) > most > 0.0:
        return "axial"
    return "torsional" if float(around @ around) > most > 0.0 else "lateral"


def free_frequencies_by_family(element: Superelement) -> dict[str, FloatArray]:
    """Return the elastic frequencies of a free body at rest by family, rising, Hz.

    Of its reduced matrices; each under the one of `FAMILIES` that has most of its kinetic energy.
    """
    import scipy.linalg as la

    tied = np.eye(element.size) if element.constraint is None else element.constraint
    mass, stiffness = (tied.T @ a @ tied for a in (element.mass, element.stiffness))
    values, vectors = la.eigh(stiffness, mass)
    rigid = np.linalg.pinv(tied) @ element.rigid_body_modes[:, element.rigid_body_present]
    onto = vectors.T @ mass @ rigid
    share = np.einsum("ij,jk,ik->i", onto, np.linalg.pinv(rigid.T @ mass @ rigid), onto)
    elastic = share < _RIGID
    form = family_form(element)
    motion = np.linalg.solve(form.basis, tied @ vectors[:, elastic])
    largest = ((motion * (form.mass @ motion)).T @ form.weights).argmax(axis=1)
    hertz = np.sqrt(np.maximum(values[elastic], 0.0)) / (2.0 * np.pi)
    return {family: hertz[largest == k] for k, family in enumerate(FAMILIES)}
