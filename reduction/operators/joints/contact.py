"""Faces that are pressed together: contact pressure of a spinning body, and where they lift.

The parts are pressed by an overlap, or clamped by a given pressure. Friction is left out of this
static solution, as in Lamé's of thick cylinders: the faces carry what is normal to them. With the
springs of pressed faces taken out, the opening g of every point on them follows from the pressure p
there and the square of the speed,

    g = F W p + Ω² g_1,   p = k (δ - g) where that is positive, else 0,

and the points that are closed are found by iteration (an active set).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl

from solidwhirl.geometry import Joint
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms
from solidwhirl.reduction.operators.dofs import body_unknowns, motion_vectors
from solidwhirl.reduction.operators.joints.layers import (
    JointSprings,
    Layer,
    LayerPoints,
    with_layer,
)
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.prestress import determinate_pins
from solidwhirl.reduction.solvers.constrained import factorise
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Steps without progress before points are changed one by one, and steps in all.
_PATIENCE, _MOST_STEPS = 4, 2000
# Rounding of a pressure in parts of what the stiff springs would make of the overlap.
_ROUNDING = 1e-15


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Pressed faces of a body in order 0, with all that their pressure does not change."""

    joints: tuple[Joint, ...]
    points: LayerPoints
    stiffness: FloatArray  #: (q,) k [N/m³]
    overlap: FloatArray  #: (q,) δ, with what clamps the faces
    clamp: FloatArray  #: (q,) pressure that is given from outside [Pa]
    flexibility: FloatArray  #: (q, q) F W
    opening: FloatArray  #: (q,) g_1 at unit speed
    moved: FloatArray  #: (u, q) displacement by unit pressure at a point
    spun: FloatArray  #: (u,) displacement at unit speed without the pressed faces

    def pressure(self, square: float) -> FloatArray:
        """(q,) pressure at a square of the speed.

        Block principal pivoting (Júdice and Pires, Comput. Oper. Res. 21 (1994) 587-596): all
        points that are on the wrong side change it; where that does not make them fewer, the last
        one alone, which ends for a positive definite flexibility.
        """
        # beyond the clamping pressure, which parts that nothing else holds answer without bounds
        right = self.overlap - self.clamp / self.stiffness - square * self.opening
        tiny = _ROUNDING * float(((np.abs(self.overlap) + np.abs(right)) * self.stiffness).max())
        shut, fewest, patience = np.ones(len(right), dtype=bool), len(right) + 1, _PATIENCE
        for _ in range(_MOST_STEPS):
            more = -self.clamp
            own = self.flexibility[np.ix_(shut, shut)] + np.diag(1.0 / self.stiffness[shut])
            given = right[shut] - self.flexibility[np.ix_(shut, ~shut)] @ more[~shut]
            more[shut] = np.linalg.solve(own, given)
            out = more + self.clamp
            gap = self.flexibility @ more + square * self.opening - self.overlap
            seen = _ROUNDING * (np.abs(self.flexibility) @ np.abs(more))
            wrong = np.where(shut, out < -tiny, gap < -tiny / self.stiffness - seen)
            count = int(wrong.sum())
            if not count:
                return np.where(out > tiny, out, 0.0)
            if count < fewest:
                fewest, patience = count, _PATIENCE
            elif patience:
                patience -= 1
            else:
                wrong[: np.flatnonzero(wrong)[-1]] = False
            shut = shut ^ wrong
        raise ReductionError(
            f"the pressed faces of {self.joints[0].where} find no rest at "
            f"{np.sqrt(square) * RPM_PER_RAD_S:.6g} rpm; choose another element size"
        )

    def own(self, joint: int) -> BoolArray:
        """(q,) which points are of a joint."""
        return np.asarray(self.points.joint == joint)

    def mean(self, joint: int, pressure: FloatArray) -> float:
        """Mean of a pressure (q,) over the face of a joint [Pa]."""
        own = self.own(joint)
        return float(np.average(pressure[own], weights=self.points.area_m2[own]))

    def displacement(self, pressure: FloatArray, square: float) -> FloatArray:
        """(u,) displacement of the body."""
        return np.asarray(self.moved @ (pressure - self.clamp) + square * self.spun)


def contact_of(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    layer: Layer,
    joints: Sequence[Joint],
    springs: Sequence[JointSprings],
) -> Contact:
    """Flexibility of the pressed faces, by one factorisation without their springs."""
    points, dx = layer.points, forms.measure(space.mesh, kin, compat.polynomial_degree(space))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    matrix = compat.assemble_matrix(compat.compiled(forms.stiffness_form(kin, matter, u, v, dx)))
    matrix = with_layer(matrix, layer.static_stiffness(kin))
    load = compat.assembled_vector(compat.compiled(forms.centrifugal_form(kin, matter, v, dx)))
    chosen = np.flatnonzero([joints[k].is_pressed for k in points.joint])
    normal = points.jumps()[3 * chosen]
    forces = (normal.T @ sp.diags(2.0 * np.pi * points.area_m2[chosen])).toarray()
    unknowns = body_unknowns(space, kin, {}, [])
    motions = np.column_stack(
        [unknowns.of_motion(kin, c, m) for c, m in motion_vectors(space, kin, 0.0).items()]
    )
    factor = factorise(matrix, determinate_pins(motions, space.mesh.comm))
    moved = factor.solve(np.hstack([forces, load[:, None]]), None)[: len(load)]
    for made in (factor, matrix, unknowns):
        made.destroy()
    kept = points.at(chosen)
    overlap, clamp = (np.zeros(len(chosen)) for _ in range(2))
    for k in np.unique(kept.joint):
        there = kept.joint == k
        overlap[there], clamp[there] = _pressing(joints[k], kept, there, springs[k])
    return Contact(
        joints=tuple(joints),
        points=kept,
        stiffness=np.array([springs[k].moving_n_per_m3[0] for k in kept.joint]),
        overlap=overlap,
        clamp=clamp,
        flexibility=normal @ moved[:, :-1],
        opening=normal @ moved[:, -1],
        moved=moved[:, :-1],
        spun=moved[:, -1],
    )


def _pressing(
    joint: Joint, points: LayerPoints, there: BoolArray, springs: JointSprings
) -> tuple[FloatArray, FloatArray]:
    """Overlap (q,) of a joint's faces and the pressure (q,) that clamps them from outside.

    Of a mean pressure on a cylinder the overlap is left to `overlapped`.
    """
    r = points.places_m[there, 1]
    if points.is_cylinder[there].all():
        warm = joint.expansion_per_k * joint.temperature_difference_k * r
        return (joint.interference_m or 0.0) - warm, np.zeros(len(r))
    if not points.is_plane[there].all():
        raise ReductionError(
            f"{joint.where}: its face is neither a cylinder nor a plane, and what holds a cone on "
            "its seat is friction; give stiffness_n_per_m3 alone"
        )
    if joint.pressure_pa is None:
        raise ReductionError(
            f"{joint.where}: interference_m presses cylinders; its face is a plane: give the "
            "pressure_pa that clamps it (force of the tie bolts over its area)"
        )
    if joint.temperature_difference_k:
        raise ReductionError(
            f"{joint.where}: temperature_difference_k changes the fit of cylinders; its face is a "
            "plane, which tie bolts clamp: leave it out"
        )
    clamp = np.full(len(r), joint.pressure_pa)
    return clamp / springs.moving_n_per_m3[0], clamp


def overlapped(contact: Contact) -> Contact:
    """With the overlaps that give the mean pressures asked for on cylinders, all faces closed."""
    asked = [
        k
        for k, joint in enumerate(contact.joints)
        if joint.pressure_pa is not None and not contact.clamp[contact.own(k)].any()
    ]
    if not asked:
        return contact
    whole = contact.flexibility + np.diag(1.0 / contact.stiffness)
    warm = contact.overlap.copy()
    units = np.zeros((len(warm), len(asked)))
    for column, k in enumerate(asked):
        units[contact.own(k), column] = 1.0
        warm[contact.own(k)] = 0.0
    clamped = warm - contact.clamp / contact.stiffness
    found = np.linalg.solve(whole, np.column_stack([units, clamped]))
    means = np.array([[contact.mean(k, column) for column in found.T] for k in asked])
    target = np.array([contact.joints[k].pressure_pa for k in asked]) - means[:, -1]
    return replace(
        contact, overlap=contact.overlap + units @ np.linalg.solve(means[:, :-1], target)
    )
