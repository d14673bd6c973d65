"""What ranks tell each other of unknowns and places, without anyone holding all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray

# Slabs of places per rank; neighbouring slabs belong to different ranks, which evens them out.
_SLABS = 64


def values_of_owners(own: IntArray, wanted: IntArray, comm: Any) -> IntArray:
    """Return values that other ranks hold.

    `own`: (n,) values of this rank; the numbering goes on from rank to rank. `wanted`: (m,) numbers
    in that numbering, of any rank. `comm`: communicator; all ranks must call.
    """
    ends = np.cumsum(comm.allgather(len(own)))
    distinct, place = np.unique(wanted, return_inverse=True)
    shares = np.split(distinct, np.searchsorted(distinct, ends[:-1]))
    first = ends[comm.rank] - len(own)
    answers = comm.alltoall([own[asked - first] for asked in comm.alltoall(shares)])
    return np.asarray(np.concatenate(answers)[place], dtype=np.int64)


def numbers_at_places(
    places: FloatArray, numbers: IntArray, wanted: FloatArray, near: float, comm: Any
) -> tuple[IntArray, FloatArray]:
    """Return the number of the nearest place of any rank for every wanted place.

    Places meet on the rank of their slab of the third coordinate; one near the end of its slab is
    told to both sides.

    Parameters
    ----------
    places
        (n, 3) places of this rank [m].
    numbers
        (n,) their numbers.
    wanted
        (m, 3) [m].
    near
        Distance up to which places are looked for [m].
    comm
        Communicator; all ranks must call.

    Returns
    -------
    numbers (m,), distances (m,) [m]
        -1 and inf where nothing is near.
    """
    low, high = _extent(places[:, 2], wanted[:, 2], comm)
    height = max((high - low) / (_SLABS * comm.size), 4.0 * near, np.finfo(float).tiny)

    def rank_of(z: FloatArray) -> IntArray:
        return np.asarray(np.floor((z - low) / height).astype(np.int64) % comm.size)

    below, above = rank_of(places[:, 2] - near), rank_of(places[:, 2] + near)
    told = [np.flatnonzero((below == r) | (above == r)) for r in range(comm.size)]
    home = rank_of(wanted[:, 2])
    asked = [np.flatnonzero(home == r) for r in range(comm.size)]
    heard = comm.alltoall([(places[k], numbers[k]) for k in told])
    known = np.vstack([p for p, _ in heard])
    number = np.concatenate([n for _, n in heard])
    answers = comm.alltoall([_nearest(known, number, q, near) for q in _sent(wanted, asked, comm)])
    found = np.full(len(wanted), -1, dtype=np.int64)
    gap = np.full(len(wanted), np.inf)
    for k, (number_there, gap_there) in zip(asked, answers, strict=True):
        found[k], gap[k] = number_there, gap_there
    return found, gap


def _extent(first: FloatArray, second: FloatArray, comm: Any) -> tuple[float, float]:
    """Least and largest of all values of all ranks."""
    values = np.concatenate([first, second])
    ends = (values.min(initial=np.inf), values.max(initial=-np.inf))
    every = comm.allgather(ends)
    low, high = min(e[0] for e in every), max(e[1] for e in every)
    return (float(low), float(high)) if high >= low else (0.0, 0.0)


def _sent(values: FloatArray, shares: list[IntArray], comm: Any) -> list[FloatArray]:
    """What this rank is sent of everyone's values."""
    return list(comm.alltoall([values[k] for k in shares]))


def _nearest(
    places: FloatArray, numbers: IntArray, wanted: FloatArray, near: float
) -> tuple[IntArray, FloatArray]:
    if not len(places) or not len(wanted):
        return np.full(len(wanted), -1, dtype=np.int64), np.full(len(wanted), np.inf)
    gap, nearest = cKDTree(places).query(wanted, distance_upper_bound=near)
    return np.append(numbers, -1)[nearest], gap
