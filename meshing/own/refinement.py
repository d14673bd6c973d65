"""Element sizes of the next meridian mesh from the errors of the elements of the last."""

from __future__ import annotations

import numpy as np

from solidwhirl.geometry import Body, merge_fillets, subdivide
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.drawing import graded_places
from solidwhirl.meshing.own.quality import doubled_areas
from solidwhirl.meshing.records import FloatArray, IntArray, LocalSize, MeshSize

#: Twice the exponent of the elastic corner singularity at 270°: errors of frequencies fall so.
CORNER_RATE = 1.0889
# Shares of the target: a corner is refined at the price of a few elements, so it gets less.
_CORNER_SHARE, _SMOOTH_SHARE = 0.4, 0.5
# Largest change of an element's edge in one step, finer and coarser; a corner's may fall faster.
_FINER, _COARSER, _CORNER_FINER = 0.2, 2.0, 1e-3


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
    if not (target > 0.0 and np.isfinite(target) and np.isfinite(errors).all()):
        raise MeshingError(f"mesh target error is {target}; a positive number is needed")
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
        triangles=triangles,
        size_m=_at_points(points, triangles, wanted, smooth),
        places=tuple(corners),
        growth=size.growth,
    )


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
    total, count = np.zeros(len(points)), np.zeros(len(points))
    weight = np.where(smooth, 1.0, 1e-6)
    for k in range(3):
        np.add.at(total, triangles[:, k], weight * np.log(wanted))
        np.add.at(count, triangles[:, k], weight)
    used = count > 0.0
    out = np.full(len(points), float(wanted.max()))
    out[used] = np.exp(total[used] / count[used])
    return out
