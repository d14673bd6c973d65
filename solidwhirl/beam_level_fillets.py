"""Fillets in a beam model: their mass where they are, their stiffness left out."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_profile import Skeleton
from solidwhirl.geometry import Body
from solidwhirl.geometry.fillets import Fillet
from solidwhirl.geometry.subdivision import planned_fillets

# Radial lines from the corner: polynomials of degree 4; the angle: entire functions.
_ALONG = np.polynomial.legendre.leggauss(3)  # type: ignore[no-untyped-call]
_ACROSS = np.polynomial.legendre.leggauss(24)  # type: ignore[no-untyped-call]


class Lump(NamedTuple):
    """A small ring fixed to a column: mass, centre, moments of inertia about its own centre."""

    column: int
    z_m: float
    mass_kg: float
    polar_kg_m2: float
    diametral_kg_m2: float


def fillet_lumps(body: Body, skeleton: Skeleton) -> tuple[Lump, ...]:
    """Return the fillets of a body as rings on its columns.

    Parameters
    ----------
    body
        The body.
    skeleton
        Its columns; a fillet that touches none goes to the column that carries its plate.

    Returns
    -------
    tuple of Lump
        Together they have the mass properties of all fillets.
    """
    if body.fillet_radius_m == 0.0:
        return ()
    return tuple(_lump(body, skeleton, fillet) for fillet in planned_fillets(body))


def _lump(body: Body, skeleton: Skeleton, fillet: Fillet) -> Lump:
    spokes = fillet.tangent_points_m - fillet.centre_m
    cross = float(spokes[0, 0] * spokes[1, 1] - spokes[0, 1] * spokes[1, 0])
    sweep = math.atan2(cross, float(spokes[0] @ spokes[1]))
    angle = math.atan2(spokes[0, 1], spokes[0, 0]) + sweep * 0.5 * (_ACROSS[0] + 1.0)
    direction = np.column_stack((np.cos(angle), np.sin(angle)))
    arm = fillet.centre_m + fillet.radius_m * direction - fillet.vertex_m
    # points corner + s arm; area element s |arm × d arc|
    area = np.abs(np.einsum("ij,ij->i", arm, direction)) * fillet.radius_m
    area = area * 0.5 * abs(sweep) * _ACROSS[1]
    share, weight = 0.5 * (_ALONG[0] + 1.0), 0.5 * _ALONG[1]
    points = fillet.vertex_m + share[:, None, None] * arm
    z, r = points[..., 0].ravel(), points[..., 1].ravel()
    density = body.sections[fillet.section].material.density_kg_per_m3
    mass = 2.0 * math.pi * density * r * np.outer(weight * share, area).ravel()
    center = float(mass @ z) / float(mass.sum())
    polar = float(mass @ r**2)
    return Lump(
        _column(skeleton, fillet),
        center,
        float(mass.sum()),
        polar,
        0.5 * polar + float(mass @ (z - center) ** 2),
    )


def _column(skeleton: Skeleton, fillet: Fillet) -> int:
    z, r = (float(value) for value in fillet.vertex_m)
    slack = 1e3 * skeleton.tolerance_m
    for k, column in enumerate(skeleton.columns):
        if column.start_m - slack <= z <= column.end_m + slack:
            inside = min(max(z, column.start_m), column.end_m)
            if column.inner_m(inside) - slack <= r <= column.outer_m(inside) + slack:
                return k
    for plate in skeleton.plates:
        for cell in plate.cells:
            beside = cell.start_m - slack <= z <= cell.end_m + slack
            place = plate.inner or plate.outer
            if beside and cell.inner_m - slack <= r <= cell.outer_m + slack and place:
                return place.column
    raise AssertionError(f"fillet at {fillet.place} lies on no part of the body")
