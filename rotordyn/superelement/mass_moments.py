"""Mass moments of a displacement, from which programs with moving frames take their terms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray, cross_matrix
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.validation import SYMMETRY_LIMIT, finite_array


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MassMoments:
    """Hold integrals over the mass of a body at rest.

    φ_j is the displacement field of coordinate j at unit amplitude, x the place from the origin;
    a, b are the Cartesian directions x, y, z.

    Attributes
    ----------
    displacement_kg
        ∫ φ_aj dm, shape (3, n).
    first_kg_m
        ∫ x_a φ_bj dm, shape (3, 3, n): [a, b, j].
    second_kg
        ∫ φ_aj φ_bk dm, shape (3, 3, n, n): [a, b, j, k]; equal to [b, a, k, j].

    Raises
    ------
    SuperelementError
        If shapes disagree, a number is not finite, or second_kg[a, b, j, k] differs from
        second_kg[b, a, k, j] by more than 1e-10 of its largest entry.
    """

    displacement_kg: FloatArray
    first_kg_m: FloatArray
    second_kg: FloatArray

    def __post_init__(self) -> None:
        where = "mass moments"
        simple = finite_array(where, "displacement_kg", self.displacement_kg, (3, None))
        n = simple.shape[1]
        first = finite_array(where, "first_kg_m", self.first_kg_m, (3, 3, n))
        second = finite_array(where, "second_kg", self.second_kg, (3, 3, n, n))
        object.__setattr__(self, "displacement_kg", simple)
        object.__setattr__(self, "first_kg_m", first)
        object.__setattr__(self, "second_kg", _exchanged(where, second))

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.displacement_kg.shape[1])


def _exchanged(where: str, second: FloatArray) -> FloatArray:
    """The second moments made exactly symmetric in exchange of both fields, or refused."""
    largest = float(np.abs(second).max(initial=0.0)) or 1.0
    # scaled, so that no sum overflows
    scaled = second / largest
    error = float(np.abs(scaled - scaled.transpose(1, 0, 3, 2)).max(initial=0.0))
    if error > SYMMETRY_LIMIT:
        raise SuperelementError(
            f"{where}: second_kg[a, b, j, k] differs from second_kg[b, a, k, j] by {error:.3e} of "
            f"its largest entry, allowed is {SYMMETRY_LIMIT:g}"
        )
    exact: FloatArray = np.ascontiguousarray(0.5 * (second + second.transpose(1, 0, 3, 2)))
    exact.setflags(write=False)
    return exact


def projected_moments(moments: MassMoments | None, basis: npt.ArrayLike) -> MassMoments | None:
    """Return the moments of the coordinates a in q = basis · a, basis (n, m); None stays None."""
    if moments is None:
        return None
    columns = np.asarray(basis, dtype=float)
    return MassMoments(
        displacement_kg=moments.displacement_kg @ columns,
        first_kg_m=moments.first_kg_m @ columns,
        second_kg=columns.T @ moments.second_kg @ columns,
    )


def joined_moments(first: MassMoments | None, second: MassMoments | None) -> MassMoments | None:
    """Return the moments of two parts in the same coordinates; None if one is not known."""
    if first is None or second is None:
        return None
    return MassMoments(
        displacement_kg=first.displacement_kg + second.displacement_kg,
        first_kg_m=first.first_kg_m + second.first_kg_m,
        second_kg=first.second_kg + second.second_kg,
    )


def rigid_motion_moments(
    mass_kg: float,
    center_of_gravity_m: FloatArray,
    inertia_kg_m2: FloatArray,
    pivot_m: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> MassMoments:
    """Return the moments of a rigid body in its six motions about a point.

    `center_of_gravity_m`: centre of gravity c, shape (3,), m; `inertia_kg_m2`: inertia tensor I
    about the centre of gravity, shape (3, 3), kg m²; `pivot_m`: the point, shape (3,), m. The
    result is of ux, uy, uz, rx, ry, rz: a point moves by t + θ × (x − pivot).

    With ξ = x − c, φ_j = t_j + A_j ξ and ∫ ξ ξᵀ dm = ½ tr(I) 1 − I.
    """
    center = np.asarray(center_of_gravity_m, dtype=float)
    arm = center - np.asarray(pivot_m, dtype=float)
    inertia = np.asarray(inertia_kg_m2, dtype=float)
    spread = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    gradient = np.zeros((6, 3, 3))
    gradient[3:] = cross_matrix(np.eye(3))
    at_center = gradient @ arm
    at_center[:3] = np.eye(3)
    return MassMoments(
        displacement_kg=mass_kg * at_center.T,
        first_kg_m=mass_kg * np.einsum("a,jb->abj", center, at_center)
        + np.einsum("ad,jbd->abj", spread, gradient),
        second_kg=mass_kg * np.einsum("ja,kb->abjk", at_center, at_center)
        + np.einsum("jad,de,kbe->abjk", gradient, spread, gradient),
    )
