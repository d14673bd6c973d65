"""Held modes of a solid counted on a coarse meridian of the same body, at a small part of its cost.

The solid and the meridian share geometry, interfaces and nothing else that could lose a mode: the
count is the inertia of a factorisation (Sylvester), the shift lies in a gap of the solid's list
that is wider than what both meshes can move an eigenvalue.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from mpi4py import MPI

from solidwhirl.geometry import Body, GeometryError
from solidwhirl.meshing import Mesh, MeshingError, MeshSize, mesh_meridian
from solidwhirl.reduction.craig_bampton import Basis
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import OperatorEffects, build_operators
from solidwhirl.reduction.verification import MISSING, MODES, modes_below
from solidwhirl.rotordyn.invariants import Invariant, compared, undecided

# Two eigenvalues this far apart (relative) stay in order on both meshes, of which each may be off
# by half of it: a frequency by 6 %.
_WIDE = 0.25
_DEGREE = 2
# Elements of the meridian over the corner size of the solid, whose cost is in the circumference.
_COARSER = 2.0
_FAMILIES = {0: 1, 1: 2}


def count_solid_modes(
    body: Body,
    mesh: Mesh | None,
    comm: Any,
    basis: Basis,
    orders: tuple[int, ...],
    effects_of: Callable[[int], OperatorEffects],
) -> Invariant:
    """Check that no held mode at rest of a solid is missing.

    Parameters
    ----------
    body
        The body.
    mesh
        Of the solid, on rank 0.
    comm
        Communicator of the solid; the meridian is worked on by rank 0.
    basis
        Of the solid.
    orders
        Circumferential orders of its modes.
    effects_of
        Interface motions by circumferential order.

    Returns
    -------
    Invariant
        Not decided where the list has no gap that is wide enough.
    """
    found = _on_rank_0(body, mesh, basis, orders, effects_of) if comm.rank == 0 else None
    out: Invariant = comm.bcast(found, root=0)
    return out


def _on_rank_0(
    body: Body,
    mesh: Mesh | None,
    basis: Basis,
    orders: tuple[int, ...],
    effects_of: Callable[[int], OperatorEffects],
) -> Invariant:
    shift, below = widest_gap(basis)
    if not below:
        reason = "no gap between the eigenvalues is wider than what a mesh may move them"
        return undecided(MISSING, body.name, MODES, reason)
    assert mesh is not None
    try:
        counted = meridian_count(body, mesh.size, orders, effects_of, shift)
    except (GeometryError, MeshingError, ReductionError) as error:
        return undecided(MISSING, body.name, MODES, f"no coarse meridian: {error}")
    counted -= basis.free.shape[1]
    text = f"{counted} modes counted on a coarse meridian, {below} found below "
    text += f"{np.sqrt(shift) / (2.0 * np.pi):.6g} Hz"
    return compared(MISSING, body.name, abs(counted - below), 0.0, MODES, text)


def widest_gap(basis: Basis) -> tuple[float, int]:
    """Return a shift in the widest gap in the upper half of the held modes, and the modes below.

    Parameters
    ----------
    basis
        With its held modes at rest and the eigenvalue that follows them.

    Returns
    -------
    shift [1/s²], count
        Zero modes if no gap is wide enough.
    """
    values = np.sort(np.append(basis.fixed_eigenvalues, basis.omitted_eigenvalue))
    gaps = np.diff(values) / values[:-1]
    gaps[: len(gaps) // 2] = 0.0
    if not gaps.size or gaps.max() < _WIDE:
        return 0.0, 0
    place = int(gaps.argmax())
    return float(np.sqrt(values[place] * values[place + 1])), place + 1


def meridian_count(
    body: Body,
    size: MeshSize,
    orders: tuple[int, ...],
    effects_of: Callable[[int], OperatorEffects],
    eigenvalue: float,
) -> int:
    """Count the held eigenvalues below a shift on a coarse meridian, those of pairs twice.

    Parameters
    ----------
    body
        The body.
    size
        Of the solid's mesh.
    orders
        Circumferential orders, of 0 and 1.
    effects_of
        Interface motions by circumferential order.
    eigenvalue
        σ [1/s²].
    """
    corner = min(_COARSER * size.corner_size_m, size.size_m)
    coarse = MeshSize(
        size_m=size.size_m,
        corner_size_m=corner,
        growth=size.growth,
        through_thickness=size.through_thickness,
    )
    meridian = mesh_meridian(body, coarse)
    count = 0
    for order in orders:
        operators = build_operators(
            body,
            meridian,
            MPI.COMM_SELF,
            order=order,
            degree=_DEGREE,
            effects=effects_of(order),
        )
        try:
            count += _FAMILIES[order] * modes_below(operators, eigenvalue)
        finally:
            operators.release()
    return count
