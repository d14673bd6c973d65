"""Families of motions of a body: lateral, torsional, axial and those of its disks alone.

In a body of revolution they are independent of each other, but for blades at an angle; other bodies
mix them.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.record import Superelement

#: In the order of weights and shares. A disk motion has two or more nodal diameters, or leaves the
#: interfaces of its body where they are.
FAMILIES = ("lateral", "torsional", "axial", "disk")
_FAMILY_OF = {"ux": 0, "uy": 0, "rx": 0, "ry": 0, "rz": 1, "uz": 2}
# Modes with a weaker link (squared, relative) to all interfaces have none.
_LINKED = 1e-12
# A rigid motion has more than this share of the energy of a mode of a free body.
_RIGID = 0.5


def family_weights(element: Superelement) -> FloatArray:
    """Return how much each coordinate of a body belongs to each family, (n, 4).

    Rows add up to 1. Coordinates of interfaces by their component: rz is torsional, uz axial,
    others are lateral. All others by the interfaces that M and K link them to, directly or through
    each other: the chances of a walk along the links to end at each. Those that no interface is
    linked to by how a turn about the axis changes them, if the body knows: not at all (torsional,
    or axial if points move along the axis), once (lateral), several times (disk).
    """
    kept = np.eye(len(FAMILIES))
    held = np.array([c.kind == "interface" for c in element.coordinates], dtype=bool)
    free = np.flatnonzero(~held)
    weights = np.zeros((element.size, len(FAMILIES)))
    weights[held] = kept[[_FAMILY_OF[c.component] for c in element.coordinates if c.interface]]
    if not free.size:
        return weights
    links = np.zeros((free.size, element.size))
    for matrix in (element.mass, element.stiffness):
        size = np.abs(np.diag(matrix))
        scale = np.outer(size[free], size)
        squared = matrix[free] ** 2
        links += np.divide(squared, scale, out=np.zeros_like(squared), where=scale > 0.0)
    links[np.arange(free.size), free] = 0.0
    own = kept[[_own_family(element, int(k)) for k in free]]
    leaving = np.diag(links.sum(axis=1) + _LINKED) - links[:, free]
    weights[free] = la.solve(leaving, links[:, held] @ weights[held] + _LINKED * own)
    return weights


def _own_family(element: Superelement, k: int) -> int:
    """Return the family of a coordinate of no interface, by what a turn of the body makes of it."""
    if element.spin_generator is None:
        return FAMILIES.index("disk")
    turns = round(float(la.norm(element.spin_generator[:, k])))
    if turns:
        return FAMILIES.index("lateral" if turns == 1 else "disk")
    along = np.abs(element.recovery_modes[:, 2, k]).max(initial=0.0)
    return FAMILIES.index("axial" if along else "torsional")


def free_frequencies_by_family(element: Superelement) -> dict[str, FloatArray]:
    """Return the elastic frequencies of a free body at rest by family, rising, Hz.

    Of its reduced matrices; each under the one of `FAMILIES` that has most of its kinetic energy.
    """
    tied = np.eye(element.size) if element.constraint is None else element.constraint
    mass, stiffness = (tied.T @ a @ tied for a in (element.mass, element.stiffness))
    values, vectors = la.eigh(stiffness, mass)
    rigid = np.linalg.pinv(tied) @ element.rigid_body_modes[:, element.rigid_body_present]
    onto = vectors.T @ mass @ rigid
    share = np.einsum("ij,jk,ik->i", onto, np.linalg.pinv(rigid.T @ mass @ rigid), onto)
    elastic = share < _RIGID
    motion = tied @ vectors[:, elastic]
    energy = (motion * (element.mass @ motion)).T @ family_weights(element)
    largest = energy.argmax(axis=1)
    hertz = np.sqrt(np.maximum(values[elastic], 0.0)) / (2.0 * np.pi)
    return {family: hertz[largest == k] for k, family in enumerate(FAMILIES)}
