"""Measured modes beside computed ones: the modal assurance criterion, and which belong together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray

#: Least MAC of modes that are taken for the same.
ALIKE = 0.5
# Directions of a family that sensors see less of than this part of the largest are not seen.
_SEEN = 1e-8
# |ln(measured/computed)| beyond which frequencies alone make no pair.
_FAR = 0.25
# Share of the frequency's part in the choice of pairs that shapes alone leave open.
_SMALL = 1e-3


class Pair(NamedTuple):
    """Numbers of a measured mode and of the family that it belongs to, None if there is none."""

    measured: int
    computed: int | None


def assurance(measured: ComplexArray, computed: Sequence[FloatArray | ComplexArray]) -> FloatArray:
    """Return the modal assurance criterion of measured modes and families, shape (m, g).

    `measured`: motions of p sensors, shape (p, m), not zero; `computed`: motions of the same
    sensors in the modes of each family, (p, c).

    |φᴴψ|²/(φᴴφ ψᴴψ) with the combination ψ of the modes of a family that is most like φ: the share
    of φ within what the family can do. Of a single mode it is the usual criterion (Allemang 2003,
    Sound and Vibration 37(8)). A family that the sensors do not see has 0.
    """
    size = np.linalg.norm(measured, axis=0)
    found = np.zeros((measured.shape[1], len(computed)))
    for k, motions in enumerate(computed):
        seen, _ = seen_directions(motions)
        found[:, k] = (np.linalg.norm(seen.conj().T @ measured, axis=0) / size) ** 2
    return found


def seen_directions(
    motions: FloatArray | ComplexArray,
) -> tuple[FloatArray | ComplexArray, FloatArray]:
    """Return orthonormal directions of p sensors in which a family moves, (p, d), and how far.

    `motions`: of the sensors in its modes, (p, c). The largest comes first.
    """
    left, singular, _ = np.linalg.svd(motions, full_matrices=False)
    seen = singular > _SEEN * max(float(singular.max(initial=0.0)), 1e-300)
    return left[:, seen], singular[seen]


def pairs_by_shape(
    mac: FloatArray, measured_hz: FloatArray, computed_hz: FloatArray, sizes: IntArray
) -> list[Pair]:
    """Pair measured modes with families so that the sum of MAC is largest.

    `mac`: shape (m, g); `sizes`: modes that a family has, (g,), as many measured ones may belong to
    it. Where shapes are as good, the nearer frequency decides. Pairs below `ALIKE` are none.
    """
    apart = np.abs(np.log(measured_hz[:, None] / computed_hz[None, :]))
    chosen = _assigned(_SMALL * apart / (1.0 + apart) - mac, sizes)
    return [
        Pair(k, g if g is not None and mac[k, g] >= ALIKE else None) for k, g in enumerate(chosen)
    ]


def pairs_by_frequency(measured_hz: FloatArray, computed_hz: FloatArray) -> list[Pair]:
    """Pair frequencies so that the sum of |ln(measured/computed)| is least.

    Each computed one has one measured one at most; pairs farther apart than a quarter are none.
    """
    apart = np.abs(np.log(measured_hz[:, None] / computed_hz[None, :]))
    chosen = _assigned(np.minimum(apart, _FAR), np.ones(len(computed_hz), dtype=int))
    return [
        Pair(k, g if g is not None and apart[k, g] < _FAR else None) for k, g in enumerate(chosen)
    ]


def _assigned(cost: FloatArray, sizes: IntArray) -> list[int | None]:
    """Return the column of each row at the least sum, with so many places in each column."""
    place = np.repeat(np.arange(cost.shape[1]), sizes)
    rows, columns = linear_sum_assignment(cost[:, place])
    found = dict(zip(rows.tolist(), place[columns].tolist(), strict=True))
    return [found.get(k) for k in range(cost.shape[0])]
