"""Where on the mesh of a meridian or a sector the estimated error of chosen motions arises."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem

from solidwhirl.reduction.operators import compat, forms
from solidwhirl.reduction.residuals.residual_energy import FinerSpace
from solidwhirl.reduction.solvers.vectors import apply, symmetric
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray

# Share of the energy that the error fields which are looked at element by element must hold.
_SHARE = 0.98


@dataclass(frozen=True, kw_only=True, eq=False)
class ElementIndicators:
    """The error fields of one circumferential order of one body."""

    #: Space one order higher, with the omitted displacement per term of the residual
    finer: FinerSpace
    rows: IntArray  #: Coordinates of the superelement that belong to this order
    signs: FloatArray
    order: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionSample:
    """A motion q e^{st} of a body, at which errors are wanted."""

    coordinates: ComplexArray  #: (n,) complex, superelement's coordinates
    s: complex  #: Complex frequency [1/s]
    speed_rad_s: float
    weight: float  #: Factor on the energy, such as 1 / what makes it a relative error


def element_errors(
    indicators: ElementIndicators, samples: tuple[MotionSample, ...]
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Share of every element in the weighted sum of the samples' errors.

    Returns errors: (c,) per cell; points, cells: (m, 2) vertices (z, r), or (m, 3) of a sector, and
    vertices of the cells.
    """
    fine = indicators.finer
    terms = np.concatenate([_terms(indicators, sample) for sample in samples], axis=2)
    fields = np.einsum("tin,tnk->ik", fine.misses, terms)
    fields = _principal(fields, fine)
    return _by_element(fine, fields)


def _terms(indicators: ElementIndicators, sample: MotionSample) -> FloatArray:
    """Factors (4, n, k) of the omitted displacements; k real columns over families."""
    size = indicators.finer.misses.shape[2]
    families = len(indicators.signs) // size
    own = np.zeros(len(indicators.signs), dtype=complex)
    own[indicators.order] = sample.coordinates[indicators.rows]
    own = (own * indicators.signs).reshape(families, size)
    s, speed = sample.s, sample.speed_rad_s
    out = np.empty((4, families, size), dtype=complex)
    out[0], out[1], out[3] = own, s**2 * own, speed**2 * own
    out[2] = s * speed * (np.array([2.0 * own[1], -2.0 * own[0]]) if families == 2 else own)
    columns = np.sqrt(sample.weight) * out.transpose(0, 2, 1)
    real = np.concatenate([columns.real, columns.imag], axis=2)
    if not np.iscomplexobj(indicators.finer.misses):
        return np.asarray(real)
    # c = q1 - i q2 of the real and of the imaginary part
    return np.asarray(real[:, :, 0::2] - 1j * real[:, :, 1::2])


def _principal(fields: FloatArray, fine: FinerSpace) -> FloatArray:
    """Few fields with nearly the same sum of energies in every element."""
    values, turn = np.linalg.eigh(symmetric(fields.conj().T @ apply(fine.stiffness, fields)))
    falling = np.argsort(values)[::-1]
    held = np.cumsum(values[falling]) / max(values.sum(), 1e-300)
    count = int(np.searchsorted(held, _SHARE)) + 1
    return np.asarray(fields @ turn[:, falling[:count]])


def _by_element(fine: FinerSpace, fields: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Elastic energy of fields, element by element."""
    domain, given = fine.space.mesh, fine.ingredients
    cells = compat.scalar_space(domain, "DG", 0)
    field, test = fem.Function(fine.space), ufl.TestFunction(cells)
    kin, matter = given.kinematics, given.matter
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 6})
    density = ufl.inner(forms.stress(kin, matter, field), kin.strain(field)) * kin.weight
    form = compat.compiled(density * test * dx)
    out = np.zeros(len(compat.owned_values(fem.Function(cells))))
    full = fine.coupling.unknowns.displacement(fields)
    if np.iscomplexobj(full):
        full = np.hstack([full.real, full.imag])
    for k in range(full.shape[1]):
        compat.owned_values(field)[:] = full[:, k]
        field.x.scatter_forward()
        out += compat.assembled_vector(form)
    points, vertices = compat.straight_cells(domain)
    return out, points, vertices
