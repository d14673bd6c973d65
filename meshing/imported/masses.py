"""Point masses and reference nodes of a file, in kg and metres on the axis of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import (
    FileCoupling,
    FileMesh,
    MeshRequest,
    PointMass,
    axis_turn,
    on_axis,
)
from solidwhirl.meshing.imported.split import KINDS
from solidwhirl.meshing.records import FloatArray, IntArray

#: Pound-force in newtons: the unit of mass that goes with it and inches is lbf s²/in.
_LBF_N, _IN_M = 4.4482216152605, 0.0254
# Densities [kg/m³] that a solid may have.
_LIGHTEST, _HEAVIEST = 10.0, 50_000.0
# What an inertia tensor may be off one of revolution, and a place off the axis.
_ROUND, _ON_AXIS = 1e-3, 1e-6
# How far a point mass may be from a node of the mesh that is made, over its shortest edge.
_NEAR = 0.05


@dataclass(frozen=True, kw_only=True)
class CarriedMass:
    """A mass on a reference node, as a rigid disk of the interface that it becomes."""

    label: str
    coupling: FileCoupling
    mass_kg: float
    polar_kg_m2: float
    diametral_kg_m2: float
    offset_m: float


def mass_unit_kg(found: FileMesh, unit_m: float, given_kg: float | None) -> float:
    """Return what a mass of 1 in a file is in kg.

    `given_kg`: what the scene says; None: the unit that goes with newtons and the unit of length
    (t with mm, kg with m), or with pounds-force and inches. Raises MeshingError: the densities in
    the file are none of solids in that unit.
    """
    consistent = _LBF_N / _IN_M if unit_m == _IN_M else 1.0 / unit_m
    unit = given_kg if given_kg is not None else found.mass_factor * consistent
    wrong = [rho for rho in found.densities if not _LIGHTEST <= rho * unit / unit_m**3 <= _HEAVIEST]
    if given_kg is None and wrong:
        raise MeshingError(
            f"has masses in an unknown unit: the density {wrong[0]:g} of the file would be "
            f"{wrong[0] * unit / unit_m**3:.3g} kg/m³ if they were in {unit:.6g} kg; say mass_unit"
        )
    return unit


def used_nodes(found: FileMesh) -> IntArray:
    """Nodes of volume elements."""
    own = [b.nodes.ravel() for b in found.blocks if b.kind in KINDS]
    return np.unique(np.concatenate(own)) if own else np.empty(0, dtype=np.int64)


def nodal_masses(
    found: FileMesh, request: MeshRequest, points: FloatArray, shortest_m: float
) -> tuple[IntArray, FloatArray]:
    """Return nodes of the mesh of a body with point masses on them, and these [kg].

    `found`: with points on the axis [m]. `points`: of the mesh. Raises MeshingError: a mass on no
    node of a solid and no reference node, or one that needs rotations, which nodes of solids have
    not.
    """
    used = np.zeros(len(found.points), dtype=bool)
    used[used_nodes(found)] = True
    references = {coupling.node for coupling in found.couplings}
    own: list[PointMass] = []
    for mass in found.masses:
        if used[mass.node]:
            own.append(mass)
            if mass.offset.any() or mass.inertia.any():
                raise MeshingError(
                    f"{mass.label}: has an inertia or an offset and lies on a node of solid "
                    "elements, which has no rotation; put it on a reference node with an RBE3 or "
                    "*COUPLING onto a surface, or leave its inertia and offset out"
                )
        elif mass.node not in references:
            raise MeshingError(
                f"{mass.label}: lies on a node of no solid element and no coupling, so that "
                "nothing carries it; put it on a node of the body, or couple its node with an "
                "RBE3, an RBE2 or *COUPLING"
            )
    if not own:
        return np.empty(0, dtype=np.int64), np.empty(0)
    places = found.points[[mass.node for mass in own]]
    away, nodes = scipy.spatial.cKDTree(points).query(places)
    if away.max() > _NEAR * shortest_m:
        raise MeshingError(
            f"{own[int(away.argmax())].label}: lies on a node that the mesh has not (middles of "
            "faces and elements are left out); put it on a corner"
        )
    unit = mass_unit_kg(found, request.unit_m, request.mass_unit_kg)
    return nodes.astype(np.int64), unit * np.array([mass.mass for mass in own])


def carried_masses(found: FileMesh, request: MeshRequest) -> list[CarriedMass]:
    """Return the masses on reference nodes as rigid disks.

    `found`: as the file has it. Raises MeshingError: a place off the axis of a body that turns, or
    an inertia that is not the same in all directions about it.
    """
    used = np.zeros(len(found.points), dtype=bool)
    used[used_nodes(found)] = True
    by_node = {coupling.node: coupling for coupling in found.couplings}
    turn, out = axis_turn(request), []
    size = request.unit_m * float(np.ptp(found.points[used], axis=0).max(initial=0.0))
    for mass in found.masses:
        if used[mass.node] or mass.node not in by_node:
            continue
        unit = mass_unit_kg(found, request.unit_m, request.mass_unit_kg)
        offset = request.unit_m * turn @ mass.offset
        tensor = unit * request.unit_m**2 * turn @ mass.inertia @ turn.T
        place = on_axis(found.points[[mass.node]], request)[0]
        across = 0.5 * (tensor[0, 0] + tensor[1, 1])
        rest = np.abs(tensor - np.diag([across, across, tensor[2, 2]])).max()
        if rest > _ROUND * np.abs(tensor).max():
            raise MeshingError(
                f"{mass.label}: its inertia is not the same in all directions about the axis; give "
                "one that is, or mesh the part"
            )
        if np.hypot(*offset[:2]) > _ON_AXIS * size or (
            request.shape != "any" and np.hypot(*place[:2]) > _ON_AXIS * size
        ):
            raise MeshingError(
                f"{mass.label}: lies {max(np.hypot(*offset[:2]), np.hypot(*place[:2])):.3g} m off "
                "the axis; masses on reference nodes lie on it: check axis.origin and "
                "axis.direction, or put the mass on nodes of the body"
            )
        out.append(
            CarriedMass(
                label=mass.label,
                coupling=by_node[mass.node],
                mass_kg=unit * mass.mass,
                polar_kg_m2=max(float(tensor[2, 2]), 0.0),
                diametral_kg_m2=max(float(across), 0.0),
                offset_m=float(offset[2]),
            )
        )
    return out
