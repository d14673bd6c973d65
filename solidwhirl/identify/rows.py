"""Numbers that targets want: one of most, one for each place of a mode shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.identify.targets import TargetSpec, is_mass_target
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray


class Rows(NamedTuple):
    """Numbers of all targets in turn, each field of shape (rows,)."""

    #: Number of the target in the list
    target: tuple[int, ...]
    #: Name of the target, with the place of a shape
    name: tuple[str, ...]
    wanted: FloatArray
    #: Deviations are parts of this: the value itself, the largest one of a shape
    reference: FloatArray
    #: Deviation that is allowed, or the standard deviation, as such a part
    tolerance: FloatArray
    #: Whether it has a closed form in the geometry; is no part of a shape; decides the result
    is_mass: BoolArray
    is_single: BoolArray
    is_fitted: BoolArray

    def parts(self, quantities: FloatArray) -> FloatArray:
        """Return deviations in parts of the references, (rows,)."""
        return np.asarray((quantities - self.wanted) / self.reference)

    def deviations(self, quantities: FloatArray) -> FloatArray:
        """Return deviations in units of the tolerances, (rows,)."""
        return np.asarray(self.parts(quantities) / self.tolerance)


def rows_of(targets: Sequence[TargetSpec]) -> Rows:
    """Return the numbers that targets want."""
    at, names, wanted, reference = [], [], [], []
    for k, target in enumerate(targets):
        largest = max(map(abs, target.shape)) if target.shape else target.value
        for j, value in enumerate(target.shape or (target.value,)):
            at.append(k)
            names.append(f"{target.name}, {target.at[j]}" if target.shape else target.name)
            wanted.append(value)
            reference.append(largest)
    each = [targets[k] for k in at]
    return Rows(
        target=tuple(at),
        name=tuple(names),
        wanted=np.array(wanted),
        reference=np.array(reference),
        tolerance=np.array([t.spread for t in each]),
        is_mass=np.array([is_mass_target(t) for t in each]),
        is_single=np.array([not t.shape for t in each]),
        is_fitted=np.array([t.use == "fit" for t in each]),
    )


def scaled_to(shape: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return a shape in the scale in which it is nearest to another; zero if it does not move."""
    size = float(shape @ shape)
    return np.asarray(shape * (float(shape @ wanted) / size) if size > 0.0 else shape)
