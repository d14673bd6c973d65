"""Element sizes of the next mesh from the errors of the elements of the last."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from solidwhirl.geometry import Body, merge_fillets, subdivide
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.grading import graded_places
from solidwhirl.meshing.own.quality import doubled_areas
from solidwhirl.meshing.records import FloatArray, IntArray, LocalSize, MeshSize
from solidwhirl.rotordyn.core.arrays import BoolArray

#: Twice the exponent of the elastic corner singularity at 270°: errors of frequencies fall so.
CORNER_RATE = 1.0889
# Shares of the target: a corner is refined at the price of a few elements, so it gets less.
_CORNER_SHARE, _SMOOTH_SHARE = 0.4, 0.5
# Largest change of an element's edge in one step, finer and coarser; a corner's may fall faster.
_FINER, _COARSER, _CORNER_FINER = 0.2, 2.0, 1e-3
# The same of tetrahedra at an edge, and how many come for each of them where the edge is halved.
_EDGE_FINER, _EDGE_PRICE = 0.05, 4.0
# Nodes are at one place, and in the plane of a meridian, up to this part of the size.
_NEAR = 1e-9


def first_at_place(points: FloatArray) -> IntArray:
    """Lowest of the numbers of the nodes that are at one place, for every node."""
    from scipy.sparse import coo_matrix  # plans need the sizes alone
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near, count = _NEAR * float(np.abs(points).max()), len(points)
    pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    place = connected_components(links, directed=False)[1]
    _, first = np.unique(place, return_index=True)
    return np.asarray(first[place])


def meridian_errors(
    points: FloatArray, cells: IntArray, errors: FloatArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Add the errors of the tetrahedra of every triangle that was revolved.

    `points`, `cells`: corners (m, 3) of the elements of a revolved sector, and (c, 4) of each.
    `errors`: (c,) of the elements. Returned: points (k, 2), triangles (t, 3), errors (t,).
    """
    from scipy.spatial import cKDTree  # plans need the sizes alone

    flat = np.flatnonzero(np.abs(points[:, 1]) <= _NEAR * np.abs(points).max())
    z_r = np.column_stack([points[:, 2], np.hypot(points[:, 0], points[:, 1])])
    _, below = cKDTree(z_r[flat]).query(z_r)
    below = first_at_place(z_r[flat])[below]
    # of the four corners two lie on the circle of one node
    around = np.sort(below[cells], axis=1)
    twice = np.argmax(around[:, 1:] == around[:, :-1], axis=1)
    once = around[np.arange(4) != twice[:, None]].reshape(-1, 3)
    triangles, owner = np.unique(once, axis=0, return_inverse=True)
    added = np.bincount(owner.ravel(), errors, len(triangles))
    return z_r[flat], np.asarray(triangles), added.astype(float)


def refined_size(
    body: Body,
    size: MeshSize,
    points: FloatArray,
    triangles: IntArray,
    errors: FloatArray,
    *,
    degree: int,
    target: float,
    last: LocalSize | None = None,
) -> LocalSize:
    """Choose sizes with which the errors of all elements add up to a target.

    With n ~ Σ (h_old / h_new)² elements and errors that fall as h^(2p), the fewest elements are had
    for h_new / h_old ~ error^(-1 / (2p + 2)) (Zienkiewicz and Zhu, Int. J. Numer. Methods Eng. 24
    (1987) 337-357, with the count as cost). Elements at re-entrant corners and at the ends of rigid
    interfaces fall as h^1.09 only; there the size is set at the corner and grows with the distance.

    `points`, `triangles`: vertices (m, 2) and cells (c, 3) of the last mesh. `errors`: (c,) errors
    of its elements. `target`: what the errors shall add up to. `last`: local sizes of the last
    mesh, if it had any. Raises MeshingError: the target is not positive, or there are no errors to
    go by.
    """
    _check_target(target, errors)
    if last is None:
        places = graded_places(body, merge_fillets(subdivide(body)), size)
    else:
        places = list(last.places)
    at_place = _touching(points, triangles, places)
    edge = _edges(points, triangles)
    corners = _refined_places(places, at_place, edge, errors, target, size.size_m)
    smooth = ~np.any(at_place, axis=0) if at_place else np.ones(len(errors), dtype=bool)
    ratio = np.ones(len(errors))
    ratio[smooth] = _ratios(errors[smooth], degree, _SMOOTH_SHARE * target)
    wanted = np.minimum(edge * ratio, size.size_m)
    return LocalSize(
        points=points,
        cells=triangles,
        size_m=_at_points(points, triangles, wanted, smooth),
        places=tuple(corners),
        growth=size.growth,
    )


def refined_sector(
    size: MeshSize,
    points: FloatArray,
    cells: IntArray,
    errors: FloatArray,
    singular: BoolArray,
    *,
    degree: int,
    target: float,
) -> LocalSize:
    """Choose sizes of a sector's tetrahedra with which their errors add up to a target.

    As `refined_size`, with n ~ Σ (h_old / h_new)³ elements. Errors of elements at re-entrant edges
    fall as h^1.09 and their number rises as 1 / h only, as elements grow with the distance from the
    edge; the sizes have the smallest Σ n for the target.

    `points`, `cells`: vertices (m, 3) and tetrahedra (c, 4) of the last mesh. `errors`: (c,) errors
    of its elements. `singular`: (m,) whether a vertex lies on such an edge. Raises MeshingError:
    the target is not positive, or there are no errors to go by.
    """
    _check_target(target, errors)
    at_edge = singular[cells].any(axis=1)
    corners = points[cells]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    edge = np.cbrt(6.0 * np.sqrt(2.0) * volume)  # of the regular tetrahedron
    rate = np.where(at_edge, CORNER_RATE, 2.0 * degree)
    power = np.where(at_edge, 1.0, 3.0)
    price = np.where(at_edge, _EDGE_PRICE, 1.0)
    ratio = _cheapest_ratios(errors, rate, power, price, target)
    smooth = np.where(at_edge, 0.0, 1.0)
    wanted = _at_vertices(points, cells, edge * ratio, smooth)
    # vertices beside an edge may have no other elements around
    alone = np.isnan(wanted)
    wanted[alone] = _at_vertices(points, cells, edge, 1.0 - smooth)[alone]
    along = _along_edges(points, cells, singular)
    wanted[singular] = (along * _at_vertices(points, cells, ratio, 1.0 - smooth))[singular]
    # nodes that are the corner of no cell have none
    wanted = np.fmin(wanted, size.size_m)
    return LocalSize(points=points, cells=cells, size_m=_graded(points, cells, wanted, size.growth))


def _cheapest_ratios(
    errors: FloatArray, rate: FloatArray, power: FloatArray, price: FloatArray, target: float
) -> FloatArray:
    """Change r of the element edges with Σ error r^rate at the target and least Σ price r^-power.

    There d(price r^-power) / d(error r^rate) is the same for all elements.
    """
    floor = 1e-9 * max(float(errors.max(initial=0.0)), 1e-300)
    worth = price * power / (rate * np.maximum(errors, floor))
    finest = np.where(power == 1.0, _EDGE_FINER, _FINER)

    def of(factor: float) -> FloatArray:
        return np.asarray(np.clip((factor * worth) ** (1.0 / (rate + power)), finest, _COARSER))

    low, high = 1e-30, 1e30
    for _ in range(200):
        factor = np.sqrt(low * high)
        if errors @ of(factor) ** rate > target:
            high = factor
        else:
            low = factor
    return np.asarray(of(low))


def _at_vertices(
    points: FloatArray, cells: IntArray, wanted: FloatArray, weight: FloatArray
) -> FloatArray:
    """Geometric mean of the cells around every vertex; nan where none has a weight."""
    total, count = np.zeros(len(points)), np.zeros(len(points))
    for k in range(cells.shape[1]):
        np.add.at(total, cells[:, k], weight * np.log(wanted))
        np.add.at(count, cells[:, k], weight)
    out = np.full(len(points), np.nan)
    used = count > 0.0
    out[used] = np.exp(total[used] / count[used])
    return out


def _mesh_edges(points: FloatArray, cells: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Ends of all edges of the cells, and their lengths."""
    edges = np.concatenate([cells[:, pair] for pair in combinations(range(cells.shape[1]), 2)])
    a, b = np.unique(np.sort(edges, axis=1), axis=0).T
    return a, b, np.linalg.norm(points[a] - points[b], axis=1)


def _along_edges(points: FloatArray, cells: IntArray, singular: BoolArray) -> FloatArray:
    """Of every singular vertex the shortest edge to another one; inf of others."""
    a, b, length = _mesh_edges(points, cells)
    on = singular[a] & singular[b]
    out = np.full(len(points), np.inf)
    np.minimum.at(out, a[on], length[on])
    np.minimum.at(out, b[on], length[on])
    return out


def _graded(points: FloatArray, cells: IntArray, size_m: FloatArray, growth: float) -> FloatArray:
    """Sizes that nowhere grow faster along an edge of the mesh, none larger than it was."""
    a, b, length = _mesh_edges(points, cells)
    rise = growth * length
    out = size_m.copy()
    for _ in range(len(points)):
        before = out.copy()
        np.minimum.at(out, a, before[b] + rise)
        np.minimum.at(out, b, before[a] + rise)
        if np.array_equal(out, before):
            break
    return out


def _check_target(target: float, errors: FloatArray) -> None:
    if not (target > 0.0 and np.isfinite(target) and np.isfinite(errors).all()):
        raise MeshingError(f"mesh target error is {target}; a positive number is needed")


def _refined_places(
    places: list[tuple[float, float, float]],
    at_place: list[FloatArray],
    edge: FloatArray,
    errors: FloatArray,
    target: float,
    largest: float,
) -> list[tuple[float, float, float]]:
    """Graded places with the edges that their elements' errors ask for."""
    owned = np.array([errors[own].sum() for own in at_place])
    weight = np.sqrt(owned) / max(np.sqrt(owned).sum(), 1e-300)
    out = []
    for (z, r, h), own, error, part in zip(places, at_place, owned, weight, strict=True):
        found = float(edge[own].min()) if own.any() else h
        factor = (_CORNER_SHARE * target * part / error) ** (1.0 / CORNER_RATE) if error else 1.0
        out.append((z, r, min(found * max(min(factor, 2.0), _CORNER_FINER), largest)))
    return out


def _touching(
    points: FloatArray, triangles: IntArray, places: list[tuple[float, float, float]]
) -> list[FloatArray]:
    """For every graded place which triangles have it as a vertex."""
    scale = float(np.abs(points).max())
    out = []
    for z, r, _ in places:
        near = np.linalg.norm(points - np.array([z, r]), axis=1) < 1e-9 * scale
        out.append(near[triangles].any(axis=1))
    return out


def _edges(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Edge of the equilateral triangle with the same area, per cell."""
    area = 0.5 * np.abs(doubled_areas(points[triangles]))
    return np.asarray(np.sqrt(4.0 / np.sqrt(3.0) * area))


def _ratios(errors: FloatArray, degree: int, target: float) -> FloatArray:
    """Change of the element edges that brings Σ error · ratio^(2p) to the target."""
    floor = 1e-6 * max(float(errors.max(initial=0.0)), 1e-300)
    shape = np.maximum(errors, floor) ** (-1.0 / (2.0 * degree + 2.0))
    low, high = 1e-12, 1e12
    for _ in range(200):  # the sum rises with the factor: bisection on its logarithm
        factor = np.sqrt(low * high)
        ratio = np.clip(factor * shape / shape.min(), _FINER, _COARSER)
        if errors @ ratio ** (2.0 * degree) > target:
            high = factor
        else:
            low = factor
    return np.asarray(np.clip(low * shape / shape.min(), _FINER, _COARSER))


def _at_points(
    points: FloatArray, triangles: IntArray, wanted: FloatArray, smooth: FloatArray
) -> FloatArray:
    """Sizes at the vertices: geometric mean of the cells around, corner cells only if alone."""
    out = _at_vertices(points, triangles, wanted, np.where(smooth, 1.0, 1e-6))
    return np.where(np.isnan(out), float(wanted.max()), out)
