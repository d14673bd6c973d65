"""Layers of springs between the two sides of a joint's face, on the meridian.

Both sides have nodes at the same places, so that the jump u_B - u_A is a polynomial of the
elements' degree along every facet. With its components (n, θ, s), n out of side A and s along the
meridian,

    K: ∫ k_n [v]_n [u]_n + k_t ([v]_θ [u]_θ + [v]_s [u]_s) dA .

A traction t that the layer carries at unit speed turns with the face, which is the layer's part of
the geometric stiffness: ∫ δt(u)·[v] + δt(v)·[u] dA, δt = ω(u) × t with the turn ω of the face. With
it Kσ - S costs a rigid tilt no force, as without joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from petsc4py import PETSc
from scipy.spatial import cKDTree
from scipy.special import roots_legendre

from solidwhirl.meshing.records import seat_name
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray

# Directions that differ by less are one.
_PARALLEL = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerPoints:
    """Points of quadrature on the faces of all joints of a body, and what moves there."""

    joint: IntArray  #: (q,) which joint
    places_m: FloatArray  #: (q, 2) places (z, r)
    normal: FloatArray  #: (q, 2) unit normal (z, r), out of the first section
    #: (q,) length along the meridian times r [m²]: of the whole circumference times 2π (order 0)
    area_m2: FloatArray
    nodes: IntArray  #: (q, 2, p + 1) nodes of the facet on both sides
    shapes: FloatArray  #: (q, p + 1) shape functions of these nodes
    slopes: FloatArray  #: (q, p + 1) their derivatives along the facet's tangent s = (n_r, -n_z)
    unknowns: int  #: Components of u on this rank

    @property
    def is_plane(self) -> BoolArray:
        """(q,) whether the face is a plane z = const there."""
        return np.asarray(np.abs(self.normal[:, 1]) < _PARALLEL)

    @property
    def is_cylinder(self) -> BoolArray:
        """(q,) whether the face is parallel to the axis there."""
        return np.asarray(np.abs(self.normal[:, 0]) < _PARALLEL)

    @property
    def per_facet(self) -> int:
        """Points of every facet, which follow each other."""
        return self.nodes.shape[2]

    def at(self, chosen: IntArray) -> LayerPoints:
        """Some of the points."""
        kept = {f.name: getattr(self, f.name) for f in fields(self)}
        own = {k: v[chosen] if k != "unknowns" else v for k, v in kept.items()}
        return LayerPoints(**own)

    def jumps(self) -> Any:
        """(3 q, u) sparse: jump B - A along n, θ and s, one after the other of every point."""
        both = [self._side(side, self.shapes) for side in range(2)]
        return (both[1] - both[0]).tocsr()

    def turned(self, order: int, traction: FloatArray) -> Any:
        """(3 q, u) sparse: change of a traction by the turn of the face, along n, θ and s.

        `traction`: (q, 2) along n and s.
        """
        across, along = traction[:, :1], traction[:, 1:]
        (n_z, n_r), r = self.normal.T[:, :, None], self.places_m[:, 1:]
        v, d = self.shapes, self.slopes
        zero = np.zeros_like(v)
        # of the components (r, θ, z): n·∂u/∂s, and how n tilts around the axis
        bend = np.stack([n_r * d, zero, n_z * d], axis=2)
        tilt = np.stack([order * n_r * v / r, n_r * v / r, order * n_z * v / r], axis=2)
        twist = np.stack([zero, d, zero], axis=2)
        weights = np.stack(
            [along[..., None] * bend, across[..., None] * tilt + along[..., None] * twist,
             -across[..., None] * bend],
            axis=1,
        )  # fmt: skip
        return self._sparse(self.nodes[:, 0], weights)

    def _side(self, side: int, shapes: FloatArray) -> Any:
        (n_z, n_r), zero = self.normal.T, np.zeros(len(self.normal))
        frame = np.stack(
            [np.stack([n_r, zero, n_z], 1), np.stack([zero, zero + 1.0, zero], 1),
             np.stack([-n_z, zero, n_r], 1)],
            axis=1,
        )  # fmt: skip
        return self._sparse(self.nodes[:, side], frame[:, :, None, :] * shapes[:, None, :, None])

    def _sparse(self, nodes: IntArray, weights: FloatArray) -> Any:
        """Rows from weights (q, 3, p + 1, 3 components of u)."""
        rows = np.arange(3 * len(nodes)).reshape(-1, 3, 1, 1)
        columns = 3 * nodes[:, None, :, None] + np.arange(3)
        shape = weights.shape
        place = (np.broadcast_to(rows, shape).ravel(), np.broadcast_to(columns, shape).ravel())
        whole = (3 * len(nodes), self.unknowns)
        return sp.csr_matrix((weights.ravel(), place), shape=whole)


@dataclass(frozen=True, kw_only=True, eq=False)
class JointSprings:
    """Springs per area of one joint, normal to its face and along it."""

    moving_n_per_m3: tuple[float, float]  #: As the body moves
    static_n_per_m3: tuple[float, float]  #: What the centrifugal load is carried by
    #: Places (m, 2) and whether the face is closed there (m,); None: everywhere
    closed: tuple[FloatArray, BoolArray] | None = None
    #: (m,) as well, at the largest speed
    closed_at_top: BoolArray | None = None

    @property
    def at_top(self) -> JointSprings:
        """Those of the largest speed."""
        if self.closed is None or self.closed_at_top is None:
            return self
        return replace(self, closed=(self.closed[0], self.closed_at_top))

    def at(self, places_m: FloatArray, springs: tuple[float, float]) -> FloatArray:
        """(q, 2) springs at places on the face, none where it is open."""
        out = np.tile(np.array(springs), (len(places_m), 1))
        if self.closed is not None:
            out *= self.closed[1][cKDTree(self.closed[0]).query(places_m)[1]][:, None]
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """Springs of all joints of a body, in one space."""

    points: LayerPoints
    springs_n_per_m3: FloatArray  #: (q, 2) normal and along the face, as bodies move
    #: (q, 2) those that the centrifugal load is carried by
    static_n_per_m3: FloatArray
    #: (q, 2) what the layer carries at unit speed along n and s [Pa/(rad/s)²]; None: not known
    traction_pa: FloatArray | None = None

    def stiffness(self, kin: Kinematics, factor: float = 1.0) -> Any:
        """PETSc matrix of the springs in all of u."""
        return self._petsc(self._of_springs(self.springs_n_per_m3 * factor, kin))

    def without(self, other: Layer) -> Layer | None:
        """Springs that another layer on the same points lacks; None if it lacks none."""
        lost = self.springs_n_per_m3 - other.springs_n_per_m3
        return replace(self, springs_n_per_m3=lost) if lost.any() else None

    def static_stiffness(self, kin: Kinematics) -> Any:
        """As `stiffness`, of what carries the centrifugal load."""
        return self._petsc(self._of_springs(self.static_n_per_m3, kin))

    def loaded(self, displacement: FloatArray) -> Layer:
        """With the traction of a displacement (u,) of order 0."""
        jump = (self.points.jumps() @ displacement).reshape(-1, 3)
        return replace(self, traction_pa=self.static_n_per_m3 * jump[:, [0, 2]])

    def carrying(self, other: Layer) -> Layer:
        """With the traction of a layer on the same facets that has other points on them."""
        assert other.traction_pa is not None
        count, traction = other.points.per_facet, other.traction_pa
        own = self.points.places_m.reshape(-1, self.points.per_facet, 2)
        given = other.points.places_m.reshape(-1, count, 2)
        start, step = given[:, :1], given[:, -1:] - given[:, :1]
        nodes, t = (
            np.sum((places - start) * step, axis=2) / np.sum(step**2, axis=2)
            for places in (given, own)
        )
        shapes = _lagrange(nodes, t)[0]
        values = np.einsum("ftp,fpc->ftc", shapes, traction.reshape(-1, count, 2))
        return replace(self, traction_pa=values.reshape(-1, 2))

    def stiffening(self, kin: Kinematics) -> Any:
        """PETSc matrix of what the traction adds to the geometric stiffness."""
        assert kin.harmonic is not None and self.traction_pa is not None
        weight = sp.diags(np.repeat(self.points.area_m2 * _around(kin), 3))
        half = self.points.jumps().T @ weight @ self.points.turned(kin.harmonic, self.traction_pa)
        return self._petsc(half + half.T)

    def _of_springs(self, springs: FloatArray, kin: Kinematics) -> Any:
        jumps = self.points.jumps()
        each = springs[:, [0, 1, 1]] * (self.points.area_m2 * _around(kin))[:, None]
        return jumps.T @ sp.diags(each.ravel()) @ jumps

    def _petsc(self, values: Any) -> Any:
        """All of a facet's unknowns beside each other, zeros too: one pattern for all matrices."""
        count = self.points.per_facet
        of_facet = self.points.nodes[::count].reshape(-1, 1)
        own = (3 * of_facet + np.arange(3)).reshape(-1, 6 * count)
        values = values.tocoo()
        rows = np.concatenate([np.repeat(own, own.shape[1], axis=1).ravel(), values.row])
        columns = np.concatenate([np.tile(own, own.shape[1]).ravel(), values.col])
        data = np.concatenate([np.zeros(own.shape[1] * own.size), values.data])
        matrix = sp.coo_matrix((data, (rows, columns)), shape=values.shape).tocsr()
        matrix.sort_indices()
        csr = (matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType),
               matrix.data)  # fmt: skip
        out = PETSc.Mat().createAIJ(size=matrix.shape, csr=csr, comm=PETSc.COMM_SELF)
        out.assemble()
        return out


def with_layer(matrix: Any, layer: Any, factor: float = 1.0) -> Any:
    """Add a PETSc matrix times a factor, which is used up, to another, which is returned."""
    if layer is not None:
        matrix.axpy(factor, layer, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        layer.destroy()
    return matrix


def layer_in(
    space: Any, facet_tags: Mapping[str, Any], springs: Sequence[JointSprings]
) -> Layer | None:
    """Layer of a body's joints in a space on one process; None without joints."""
    points = _points_in(space, facet_tags, len(springs))
    return None if points is None else layer_on(points, springs)


def layer_on(points: LayerPoints, springs: Sequence[JointSprings]) -> Layer:
    """Layer of a body's joints on points of quadrature."""
    moving, static = (np.zeros((len(points.joint), 2)) for _ in range(2))
    for k, own in enumerate(springs):
        there = points.joint == k
        moving[there] = own.at(points.places_m[there], own.moving_n_per_m3)
        static[there] = own.at(points.places_m[there], own.static_n_per_m3)
    return Layer(points=points, springs_n_per_m3=moving, static_n_per_m3=static)


def _points_in(space: Any, facet_tags: Mapping[str, Any], joints: int) -> LayerPoints | None:
    """Points on the faces of so many joints in a space; None without joints."""
    parts = [p for k in range(joints) if (p := _of_joint(space, facet_tags, k)) is not None]
    if not parts:
        return None
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return LayerPoints(unknowns=3 * space.dofmap.index_map.size_local, **joined)


def _of_joint(space: Any, facet_tags: Mapping[str, Any], joint: int) -> dict[str, Any] | None:
    """Points of one joint by the fields of `LayerPoints`."""
    x = space.tabulate_dof_coordinates()[:, :2]
    sides = []
    for side in range(2):
        tags = facet_tags[seat_name(joint, side)]
        sides.append([fem.locate_dofs_topological(space, 1, np.array([f])) for f in tags.indices])
    middles = [np.array([x[nodes].mean(axis=0) for nodes in side]) for side in sides]
    partner = cKDTree(middles[1]).query(middles[0])[1]
    pairs = []
    for nodes, other in zip(sides[0], partner, strict=True):
        match = cKDTree(x[sides[1][other]]).query(x[nodes])[1]
        pairs.append(np.stack([nodes, sides[1][other][match]]))
    nodes = np.array(pairs, dtype=np.int64)  # (f, 2, p + 1)
    inside = _inside(space, facet_tags[seat_name(joint, 0)])
    return _quadrature(x, nodes, inside, joint)


def _inside(space: Any, tags: Any) -> FloatArray:
    """(f, 2) a place inside the cell of every facet."""
    domain = space.mesh
    domain.topology.create_connectivity(1, 2)
    cells = domain.topology.connectivity(1, 2)
    points, nodes = compat.straight_cells(domain)
    return np.array([points[nodes[cells.links(f)[0]]].mean(axis=0) for f in tags.indices])


def _quadrature(x: FloatArray, nodes: IntArray, inside: FloatArray, joint: int) -> dict[str, Any]:
    """Gauss points of straight facets, exact for products of two shape functions and r."""
    count, degree = len(nodes), nodes.shape[2] - 1
    own = x[nodes[:, 0]]
    far = np.linalg.norm(own - own.mean(axis=1, keepdims=True), axis=2).argmax(axis=1)
    start = own[np.arange(count), far]
    away = own - start[:, None]
    end = np.linalg.norm(away, axis=2).argmax(axis=1)
    step = away[np.arange(count), end]
    length = np.linalg.norm(step, axis=1)
    normal = np.stack([-step[:, 1], step[:, 0]], 1) / length[:, None]
    outward = np.einsum("fi,fi->f", start + 0.5 * step - inside, normal) > 0.0
    normal *= np.where(outward, 1.0, -1.0)[:, None]
    tangent = np.stack([normal[:, 1], -normal[:, 0]], 1)
    at = np.einsum("fpi,fi->fp", away, step) / (length**2)[:, None]
    gauss, weight = roots_legendre(degree + 1)
    t, weight = 0.5 * (gauss + 1.0), 0.5 * weight
    shapes, slopes = _lagrange(at, np.broadcast_to(t, (count, len(t))))
    sign = np.sign(np.einsum("fi,fi->f", tangent, step)) / length
    places = start[:, None] + t[:, None] * step[:, None]
    q = degree + 1
    return {
        "joint": np.full(count * q, joint),
        "places_m": places.reshape(-1, 2),
        "normal": np.repeat(normal, q, axis=0),
        "area_m2": (weight * length[:, None] * places[:, :, 1]).ravel(),
        "nodes": np.repeat(nodes, q, axis=0),
        "shapes": shapes.reshape(count * q, degree + 1),
        "slopes": (slopes * sign[:, None, None]).reshape(count * q, degree + 1),
    }


def _lagrange(nodes: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values and derivatives (f, t, p + 1) at t (f, t) of polynomials, 1 at one node (f, p + 1)."""
    powers = np.arange(nodes.shape[1])
    inverse = np.linalg.inv(nodes[:, :, None] ** powers)  # (f, power, node)
    raised = t[:, :, None] ** powers
    derived = np.zeros(raised.shape)
    derived[:, :, 1:] = powers[1:] * raised[:, :, :-1]
    return raised @ inverse, derived @ inverse


def _around(kin: Kinematics) -> float:
    """Integral over the circumference, as in the weight of the forms."""
    return (2.0 if kin.harmonic == 0 else 1.0) * np.pi
