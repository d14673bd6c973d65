"""What a reduction left out of a body, as quadratic forms from which errors of results follow.

A body's coordinates q span a part V of a larger model. In q e^{st} at the spin Ω the larger model
keeps the residual (K + s²M + sΩG + Ω²K2) V q. Eliminating what was left out, its elastic
stiffness taken for its dynamic one, changes the dynamic stiffness of the body to
D + Ω² ΔK2 − E(s, Ω), E = Σ_ab l_a r_b Γ_ab with r = (1, s², sΩ, Ω²) and l = (1, s², −sΩ, Ω²).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.validation import (
    finite_array,
    part_of_body,
    symmetrised,
)

# All parts of an estimate, in the order of tables.
PARTS = (
    "mesh",
    "circumferential",  # of files that older versions wrote
    "stage_joints",
    "joint_lift",
    "mode_truncation",
    "speed_interpolation",
    "interface_coupling",
    "beam_theory",
    "eigen_solver",
    "harmonics",
    "sampling",
)
# A choice of the model: shown, not summed.
NOT_SUMMED = ("interface_coupling",)
# Parts a body can have forms of.
FORM_PARTS = (
    "mesh",
    "circumferential",
    "stage_joints",
    "joint_lift",
    "mode_truncation",
    "interface_coupling",
    "beam_theory",
)
# Matrices whose residuals the form holds: K, M, G, K2.
BLOCKS = 4
# (|s| / cutoff)² is limited to this, where what was left out resonates and the form ends.
_NEAREST = 0.9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ErrorForm:
    """Hold the first-order change of a body's dynamic stiffness by what its reduction left out.

    Attributes
    ----------
    part
        What was left out, one of `FORM_PARTS`: "mode_truncation" for the modes beyond the basis,
        "mesh" for a finer mesh.
    gram
        Γ, shape (4n, 4n), symmetric and positive semidefinite: Γ_ab = R_aᵀ K⁻¹ R_b of the
        residuals R of K, M, G and K2 = Kgeo − S, blocks in that order, in the n coordinates of
        the superelement.
    stiffness_change
        ΔK2, change of Kgeo − S per (rad/s)², shape (n, n), symmetric, kg; None for no change.
    safety
        Factor on the first-order change, 1 or more.
    cutoff_rad_s
        Lowest frequency of what was left out, rad/s; inf if that is far above every mode.

    Raises
    ------
    SuperelementError
        If the part is unknown, shapes disagree, a number is not finite, a matrix is not symmetric
        to 1e-10 of its largest entry, the safety is below 1 or the cutoff is not positive.
    """

    part: str
    gram: FloatArray
    stiffness_change: FloatArray | None
    safety: float
    cutoff_rad_s: float

    def __post_init__(self) -> None:
        if self.part not in FORM_PARTS:
            raise SuperelementError(
                f"error form: part is {self.part!r}, allowed are {list(FORM_PARTS)}"
            )
        where = f"error form {self.part!r}"
        gram = finite_array(where, "gram", self.gram, (None, None))
        n = gram.shape[0] // BLOCKS
        if n < 1 or gram.shape != (BLOCKS * n, BLOCKS * n):
            raise SuperelementError(
                f"{where}: gram has shape {gram.shape}, allowed is (4n, 4n) for n coordinates"
            )
        object.__setattr__(self, "gram", symmetrised(where, "gram", gram, 1.0))
        if self.stiffness_change is not None:
            change = finite_array(where, "stiffness_change", self.stiffness_change, (n, n))
            change = symmetrised(where, "stiffness_change", change, 1.0)
            object.__setattr__(self, "stiffness_change", change)
        if not (np.isfinite(self.safety) and self.safety >= 1):
            raise SuperelementError(f"{where}: safety is {self.safety}, allowed is 1 or more")
        if not self.cutoff_rad_s > 0:
            raise SuperelementError(
                f"{where}: cutoff_rad_s is {self.cutoff_rad_s}, allowed is more than 0, or inf"
            )
        object.__setattr__(self, "safety", float(self.safety))
        object.__setattr__(self, "cutoff_rad_s", float(self.cutoff_rad_s))

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.gram.shape[0]) // BLOCKS


def checked_forms(where: str, forms: Any, n: int) -> tuple[ErrorForm, ...]:
    """Return the forms of a body with n coordinates, refusing those of another size.

    `forms`: sequence of `ErrorForm`, each part at most once. Returns the same forms in the order of
    `FORM_PARTS`. Raises SuperelementError if one is no form, is of another size, or a part occurs
    twice.
    """
    found = tuple(part_of_body(where, "error form", form, ErrorForm, n) for form in forms)
    if None in found:
        raise SuperelementError(f"{where}: error_forms has a None, allowed are ErrorForm records")
    parts = [form.part for form in found]
    repeated = sorted({part for part in parts if parts.count(part) > 1})
    if repeated:
        raise SuperelementError(f"{where}: error forms of {repeated} occur more than once")
    return tuple(sorted(found, key=lambda form: FORM_PARTS.index(form.part)))


def form_products(
    form: ErrorForm,
    rates: npt.ArrayLike,
    spin_rad_s: float,
    left: npt.ArrayLike,
    right: npt.ArrayLike,
) -> ComplexArray:
    """Return yᵀ [E(s, Ω) − Ω² ΔK2] x for pairs of vectors, not building the matrices.

    `rates`: s of each pair, 1/s, shape (m,); `spin_rad_s`: Ω of the body itself, rad/s. `left`,
    `right`: y and x in the coordinates of the body, shape (n, m); y is not conjugated. Returns
    shape (m,), complex; without safety and amplification.
    """
    spread_y, spread_x = _spread(rates, spin_rad_s, left, right)
    products = (spread_y * _times(form.gram, spread_x)).sum(axis=0)
    if form.stiffness_change is not None:
        y, x = np.asarray(left), np.asarray(right)
        products = products - spin_rad_s**2 * (y * (form.stiffness_change @ x)).sum(axis=0)
    return np.asarray(products)


def form_projection(
    form: ErrorForm,
    rates: npt.ArrayLike,
    spin_rad_s: float,
    left: npt.ArrayLike,
    right: npt.ArrayLike,
) -> ComplexArray:
    """Return y_iᵀ [E − Ω² ΔK2] x_j of all pairs, with l of s_i and r of s_j.

    Arguments as in `form_products`, which is the diagonal. Returns shape (m, m), complex; without
    safety and amplification.
    """
    spread_y, spread_x = _spread(rates, spin_rad_s, left, right)
    products = spread_y.T @ _times(form.gram, spread_x)
    if form.stiffness_change is not None:
        y, x = np.asarray(left), np.asarray(right)
        products = products - spin_rad_s**2 * y.T @ (form.stiffness_change @ x)
    return np.asarray(products)


def form_weight(form: ErrorForm, rates: npt.ArrayLike) -> FloatArray:
    """Return safety times amplification of a form, the factor on the first-order change.

    `rates`: s, 1/s, any shape. Returns safety / (1 − (|s|/cutoff)²), with the square limited to
    0.9: what was left out yields more, the closer s comes to its own frequencies.
    """
    closeness = (np.abs(np.asarray(rates)) / form.cutoff_rad_s) ** 2
    return np.asarray(form.safety / (1.0 - np.minimum(closeness, _NEAREST)))


def _spread(
    rates: npt.ArrayLike, spin_rad_s: float, left: npt.ArrayLike, right: npt.ArrayLike
) -> tuple[ComplexArray, ComplexArray]:
    """Return l ⊗ y and r ⊗ x of each pair, each (4n, m)."""
    y, x = np.asarray(left, dtype=complex), np.asarray(right, dtype=complex)
    first, second = _powers(np.asarray(rates, dtype=complex), spin_rad_s)
    spread_y, spread_x = first[:, None, :] * y, second[:, None, :] * x
    rows = BLOCKS * len(y)  # written out, as there may be no pair
    return spread_y.reshape(rows, y.shape[1]), spread_x.reshape(rows, x.shape[1])


def _times(matrix: FloatArray, vectors: ComplexArray) -> ComplexArray:
    """Return a real matrix times complex vectors without a complex copy of the matrix."""
    # copies, as products with strided arrays take many times longer
    real, imaginary = (np.ascontiguousarray(part) for part in (vectors.real, vectors.imag))
    return np.asarray(matrix @ real + 1j * (matrix @ imaginary))


def _powers(rates: ComplexArray, spin_rad_s: float) -> tuple[ComplexArray, ComplexArray]:
    """Return l and r of the residual of K, M, G and K2, each (4, m)."""
    one, spin = np.ones_like(rates), np.full_like(rates, spin_rad_s**2)
    right = np.stack((one, rates**2, rates * spin_rad_s, spin))
    left = np.stack((one, rates**2, -rates * spin_rad_s, spin))
    return left, right
