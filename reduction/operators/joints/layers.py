"""Layers of springs between the two sides of a joint's face, on the meridian or in the solid.

Both sides have nodes at the same places, so that the jump u_B - u_A is a polynomial of the
elements' degree on every facet. With its components (n, θ, s), n out of side A and s along the
meridian,

    K: ∫ k_n [v]_n [u]_n + k_t ([v]_θ [u]_θ + [v]_s [u]_s) dA .

A traction t that the layer carries at unit speed turns with the face, which is the layer's part of
the geometric stiffness: ∫ δt(u)·[v] + δt(v)·[u] dA, δt = ω(u) × t with the turn ω of the face, the
mean of both sides. With it Kσ - S costs a rigid tilt no force, as without joints, and no turn of
one side against the other: a radial pressure has no moment about the axis. The normal is that of
the elements: edges of a solid are parabolas where the body has arcs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc
from scipy.spatial import cKDTree
from scipy.special import roots_legendre

from solidwhirl.meshing.records import seat_name
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray

# Directions and shares that differ by less are one.
_PARALLEL = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerPoints:
    """Points of quadrature on the faces of all joints of a body, and what moves there."""

    joint: IntArray  #: (q,) which joint
    places_m: FloatArray  #: (q, 2) places (z, r)
    edges_m: FloatArray  #: (q, 2, 2) ends (z, r) of the edge of the meridian that it lies on
    #: (q, 3, 3) unit vectors n, out of the first section, θ and s = n × θ in the components of u
    frame: FloatArray
    #: (q,) area [m²]; of a meridian of the whole circumference times 2π (order 0)
    area_m2: FloatArray
    nodes: IntArray  #: (q, 2, m) nodes of the facet on both sides
    shapes: FloatArray  #: (q, m) shape functions of these nodes
    #: (q, 2, m) their derivatives along θ and s; that along θ of a meridian follows from the order
    slopes: FloatArray
    per_facet: int  #: Points of every facet, which follow each other
    unknowns: int  #: Components of u on this rank
    is_meridian: bool

    @property
    def is_plane(self) -> BoolArray:
        """(q,) whether the face is a plane z = const there."""
        return np.asarray(np.hypot(self.frame[:, 0, 0], self.frame[:, 0, 1]) < _PARALLEL)

    @property
    def is_cylinder(self) -> BoolArray:
        """(q,) whether the face is parallel to the axis there."""
        return np.asarray(np.abs(self.frame[:, 0, 2]) < _PARALLEL)

    def along(self, other: LayerPoints) -> tuple[IntArray, FloatArray]:
        """Facet (q,) of a meridian that points of another are on, and how far along it, 0 to 1."""
        ends = self.edges_m[:: self.per_facet]
        facet = cKDTree(ends.mean(axis=1)).query(other.edges_m.mean(axis=1))[1]
        start, step = ends[facet, 0], ends[facet, 1] - ends[facet, 0]
        away = np.einsum("qi,qi->q", other.places_m - start, step)
        return facet, away / np.einsum("qi,qi->q", step, step)

    def owners(self, other: LayerPoints) -> IntArray:
        """(q,) point of a meridian in whose share of the face points of another are."""
        facet, along = self.along(other)
        weight = (self.area_m2 / self.places_m[:, 1]).reshape(-1, self.per_facet)
        ends = np.cumsum(weight, axis=1) / weight.sum(axis=1, keepdims=True)
        return np.asarray(facet * self.per_facet + (along[:, None] > ends[facet, :-1]).sum(axis=1))

    def at(self, chosen: IntArray) -> LayerPoints:
        """Some of the points, of every facet all or none."""
        values: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        own: dict[str, Any] = {k: v[chosen] for k, v in values.items() if isinstance(v, np.ndarray)}
        return replace(self, **own)

    def jumps(self) -> Any:
        """(3 q, u) sparse: jump B - A along n, θ and s, one after the other of every point."""
        weights = self.frame[:, :, None, :] * self.shapes[:, None, :, None]
        both = [self._sparse(self.nodes[:, side], weights) for side in range(2)]
        return (both[1] - both[0]).tocsr()

    def turned(self, order: int, traction: FloatArray) -> Any:
        """(3 q, u) sparse: change ω × t of a traction by the mean turn of both sides.

        Along n, θ and s, one after the other of every point.

        `traction`: (q, 3) along n, θ and s.
        """
        normal, around = self.frame[:, None, 0], self.frame[:, None, 1]
        v, (d_around, d_along) = self.shapes[..., None], self.slopes.transpose(1, 0, 2)[..., None]
        tilt = -d_around * normal
        if self.is_meridian:  # derivatives of the components (r, θ, z) around the axis
            n_r, n_z = normal[..., 0], normal[..., 2]
            spin = np.stack([order * n_r, n_r, order * n_z], axis=2)
            tilt = spin * v / self.places_m[:, 1, None, None]
        bend, twist = d_along * normal, -d_along * around
        t_n, t_a, t_s = traction.T[:, :, None, None]
        weights = [t_s * bend - t_a * tilt, t_n * tilt - t_s * twist, t_a * twist - t_n * bend]
        halves = 0.5 * np.stack(weights, axis=1)
        return sum(self._sparse(self.nodes[:, side], halves) for side in range(2))

    def _sparse(self, nodes: IntArray, weights: FloatArray) -> Any:
        """Rows from weights (q, 3, m, 3 components of u)."""
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
    #: Points (m,) on the meridian and whether the face is closed there; None: everywhere
    closed: tuple[LayerPoints, BoolArray] | None = None
    #: (m,) as well, at the largest speed
    closed_at_top: BoolArray | None = None

    @property
    def at_top(self) -> JointSprings:
        """Those of the largest speed."""
        if self.closed is None or self.closed_at_top is None:
            return self
        return replace(self, closed=(self.closed[0], self.closed_at_top))

    def at(self, points: LayerPoints, springs: tuple[float, float]) -> FloatArray:
        """(q, 2) springs at points of the face, none where it is open."""
        out = np.tile(np.array(springs), (len(points.joint), 1))
        if self.closed is not None:
            known, closed = self.closed
            out *= closed[known.owners(points)][:, None]
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """Springs of all joints of a body, in one space."""

    points: LayerPoints
    springs_n_per_m3: FloatArray  #: (q, 2) normal and along the face, as bodies move
    #: (q, 2) those that the centrifugal load is carried by
    static_n_per_m3: FloatArray
    #: (q, 3) what it carries along n, θ and s [Pa], at unit speed [Pa/(rad/s)²]; None: not known
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
        return replace(self, traction_pa=self.static_n_per_m3[:, [0, 1, 1]] * jump)

    def carried_from(self, meridian: Layer) -> FloatArray:
        """(q, 3) traction of a layer on the meridian's edges of the same facets."""
        assert meridian.traction_pa is not None
        known, count = meridian.points, meridian.points.per_facet
        facet, at = known.along(self.points)
        own = known.along(known)[1].reshape(-1, count, 1)
        values = meridian.traction_pa.reshape(-1, count, 3)
        out = np.empty((len(at), 3))
        for k, each in enumerate(values):
            there = facet == k
            out[there] = _lagrange(own[k], count - 1, at[there, None])[0] @ each
        return out

    def forces(self, kin: Kinematics, traction: FloatArray) -> FloatArray:
        """(u,) what the faces do to the body, taken as positive, with a traction (q, 3)."""
        weighted = traction * (self.points.area_m2 * _around(kin))[:, None]
        return np.asarray(self.points.jumps().T @ weighted.ravel())

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
        of_facet = self.points.nodes[::count]
        own = (3 * of_facet[..., None] + np.arange(3)).reshape(len(of_facet), -1)
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
        there = np.flatnonzero(points.joint == k)
        moving[there] = own.at(points.at(there), own.moving_n_per_m3)
        static[there] = own.at(points.at(there), own.static_n_per_m3)
    return Layer(points=points, springs_n_per_m3=moving, static_n_per_m3=static)


def _points_in(space: Any, facet_tags: Mapping[str, Any], joints: int) -> LayerPoints | None:
    """Points on the faces of so many joints in a space; None without joints."""
    if not joints:
        return None
    parts = [_of_joint(space, facet_tags, k) for k in range(joints)]
    flat = space.mesh.topology.dim == 2
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return LayerPoints(
        per_facet=(compat.polynomial_degree(space) + 1) ** (1 if flat else 2),
        unknowns=3 * space.dofmap.index_map.size_local,
        is_meridian=flat,
        **joined,
    )


class _Side(NamedTuple):
    """Facets on one side of a joint, each with the corners of its cell in the cell's order."""

    nodes: IntArray  #: (f, m) of the space
    at: FloatArray  #: (f, m, d - 1) where these are in coordinates of the facet
    points: FloatArray  #: (f, k, d) places of the nodes of the geometry
    points_at: FloatArray  #: (f, k, d - 1) and where they are
    inside: FloatArray  #: (f, d) the corner of the cell that is not on the facet


def _side(space: Any, tags: Any) -> _Side:
    topology, d = space.mesh.topology, space.mesh.topology.dim
    topology.create_connectivity(d - 1, d)
    topology.create_connectivity(d, d - 1)
    cells_of, facets_of = topology.connectivity(d - 1, d), topology.connectivity(d, d - 1)
    cells = np.array([cells_of.links(f)[0] for f in tags.indices])
    local = np.array(
        [
            np.flatnonzero(facets_of.links(c) == f)[0]
            for c, f in zip(cells, tags.indices, strict=True)
        ]
    )
    places, nodes = compat.curved_cells(space.mesh)
    own = [
        (compat.cell_unknowns(space).reshape(-1, len(ref)), ref)
        for ref in (compat.reference_points(space),)
    ]
    own.append((nodes, compat.geometry_points(d)))
    found = []
    for table, reference in own:
        # facet k is where the k-th of these is 0
        share = np.column_stack([1.0 - reference.sum(axis=1), reference])
        kept = [np.flatnonzero(np.abs(share[:, k]) < _PARALLEL) for k in range(d + 1)]
        at = [np.delete(share[rows], k, axis=1)[:, 1:] for k, rows in enumerate(kept)]
        found.append((np.array([table[c, kept[k]] for c, k in zip(cells, local, strict=True)]),
                      np.array([at[k] for k in local])))  # fmt: skip
    return _Side(
        nodes=found[0][0],
        at=found[0][1],
        points=places[found[1][0]],
        points_at=found[1][1],
        inside=places[nodes[cells, local]],
    )


def _of_joint(space: Any, facet_tags: Mapping[str, Any], joint: int) -> dict[str, Any]:
    """Points of one joint by the fields of `LayerPoints`."""
    x = space.tabulate_dof_coordinates()
    first, second = (_side(space, facet_tags[seat_name(joint, side)]) for side in range(2))
    partner = cKDTree(x[second.nodes].mean(axis=1)).query(x[first.nodes].mean(axis=1))[1]
    pairs = []
    for nodes, others in zip(first.nodes, second.nodes[partner], strict=True):
        pairs.append(np.stack([nodes, others[cKDTree(x[others]).query(x[nodes])[1]]]))
    degree = compat.polynomial_degree(space)
    parts = [_on_facet(_Side(*row), degree) for row in zip(*first, strict=True)]
    count = len(parts[0]["area_m2"])
    return {
        "joint": np.full(count * len(parts), joint),
        "nodes": np.repeat(np.array(pairs, dtype=np.int64), count, axis=0),
        **{name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
    }


def _rule(side: _Side, degree: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Points of quadrature on one facet, exact for products of two shape functions and r.

    On the triangles of a revolved meridian they are in rows around the axis above the points that
    the meridian has: where a part of a facet lifts, both lose the same. Returns the coordinates of
    the facet (q, d - 1), weights (q,), the ends (z, r) of the meridian's edge (2, 2), and how far
    along it they are (q,).
    """
    gauss, weight = roots_legendre(degree + 1)
    t, weight = 0.5 * (gauss + 1.0), 0.5 * weight
    d = side.points.shape[1]
    x = side.points[:d]
    if d == 2:
        return t[:, None], weight, x, t
    z_r = np.column_stack([x[:, 2], np.hypot(x[:, 0], x[:, 1])])
    # two corners are on one circle, and the third is where the collapsed square ends
    apart = [np.linalg.norm(z_r[k - 2] - z_r[k - 1]) for k in range(3)]
    apex = int(np.argmin(apart))
    along, across = (each.ravel() for each in np.meshgrid(t, t, indexing="ij"))
    share = np.empty((len(along), 3))
    share[:, apex], share[:, apex - 2] = 1.0 - along, along * across
    share[:, apex - 1] = along * (1.0 - across)
    return share[:, 1:], np.outer(weight * t, weight).ravel(), z_r[[apex, apex - 1]], along


def _on_facet(side: _Side, degree: int) -> dict[str, FloatArray]:
    """Points on one facet (a row of a side) by the fields of `LayerPoints`."""
    at, weight, edge, along_edge = _rule(side, degree)
    shapes, change = _lagrange(side.at, degree, at)
    own, slope = _lagrange(side.points_at, 2, at)
    places, tangents = own @ side.points, np.einsum("kqp,pi->qik", slope, side.points)
    gram = np.einsum("qik,qil->qkl", tangents, tangents)
    area = weight * np.sqrt(np.linalg.det(gram))
    frame = _frames(places, tangents, side.inside)
    if places.shape[1] == 2:
        area, ways = area * places[:, 1], [None, frame[:, 2, [2, 0]]]
    else:
        ways = [frame[:, 1], frame[:, 2]]
    slopes = np.zeros((len(at), 2, shapes.shape[1]))
    for k, way in enumerate(ways):
        if way is not None:
            share = np.linalg.solve(gram, np.einsum("qik,qi->qk", tangents, way)[..., None])
            slopes[:, k] = np.einsum("qk,kqm->qm", share[..., 0], change)
    return {
        "places_m": edge[0] + along_edge[:, None] * (edge[1] - edge[0]),
        "edges_m": np.broadcast_to(edge, (len(at), 2, 2)),
        "frame": frame,
        "area_m2": area,
        "shapes": shapes,
        "slopes": slopes,
    }


def _frames(places: FloatArray, tangents: FloatArray, inside: FloatArray) -> FloatArray:
    """(q, 3, 3) unit vectors n, θ and s at places of a facet, in the components of u.

    `tangents`: (q, d, d - 1). `inside`: (d,) a place inside the first section.
    """
    outward, zero = places - inside, np.zeros(len(places))
    if places.shape[1] == 2:
        normal = np.stack([-tangents[:, 0, 0], zero, tangents[:, 1, 0]], axis=1)
        around = np.stack([zero, zero + 1.0, zero], axis=1)
        outward = np.stack([outward[:, 1], zero, outward[:, 0]], axis=1)
    else:
        normal = np.cross(tangents[..., 0], tangents[..., 1])
        around = np.stack([-places[:, 1], places[:, 0], zero], axis=1)
    normal = normal * np.sign(np.einsum("qi,qi->q", outward, normal))[:, None]
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    around = around - np.einsum("qi,qi->q", around, normal)[:, None] * normal
    around = around / np.linalg.norm(around, axis=1)[:, None]
    return np.stack([normal, around, np.cross(normal, around)], axis=1)


def _lagrange(nodes: FloatArray, degree: int, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (q, m) and derivatives (k, q, m) at (q, k) of polynomials, 1 at one node (m, k)."""
    k = nodes.shape[1]
    rows = [e for e in product(range(degree + 1), repeat=k) if sum(e) <= degree]
    powers = np.array(rows, dtype=np.int64)
    inverse = np.linalg.inv(np.prod(nodes[:, None] ** powers, axis=2))  # (power, node)
    derived = []
    for way in np.eye(k, dtype=np.int64):
        raised = np.prod(at[:, None] ** np.maximum(powers - way, 0), axis=2)
        derived.append((raised * (powers @ way)) @ inverse)
    return np.prod(at[:, None] ** powers, axis=2) @ inverse, np.array(derived)


def _around(kin: Kinematics) -> float:
    """Factor of integrals over the face, as in the weight of the forms."""
    if kin.dimension == 3:
        return float(kin.weight.value)
    return (2.0 if kin.harmonic == 0 else 1.0) * np.pi
