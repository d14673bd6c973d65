"""Error estimates of the frequencies of a system, from the error forms of its bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from solidwhirl.rotordyn.assembly.parts import Rotor
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    SpeedMatrices,
    at_rate,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import (
    ComplexArray,
    FloatArray,
    together,
)
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns
from solidwhirl.rotordyn.modes.nearby import with_own_bearings
from solidwhirl.rotordyn.perturbation.left_vectors import ModePairs, mode_pairs, state_products
from solidwhirl.rotordyn.superelement.residual_energy import (
    NOT_SUMMED,
    PARTS,
    ErrorForm,
    form_projection,
    form_weight,
)

# Modes closer than this times their estimates are changed together, but none that are further
# apart than this fraction of the frequency: E belongs to one s and grows with its fourth power.
_CLOSE = 3.0
WIDEST = 0.1
# Frequencies below this fraction of the lowest elastic one are near zero: precession of a body that
# nothing holds, tilts that the spin holds back.
_NEAR_ZERO = 1e-2
# Weight of nearness beside MAC where changed modes are given to unchanged ones.
_NEARNESS = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class FrequencyErrors:
    """Hold relative error estimates of eigenvalues.

    `parts`: |δs| / |s| by name of the part, shape (m,) each, near zero over `error_scale`. A part
    that no body has a form of is absent; "eigen_solver" is always there. `bodies_without_estimate`:
    bodies that deform and have no error forms (imported ones): nothing of theirs is in the parts.
    """

    parts: Mapping[str, FloatArray]
    bodies_without_estimate: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", frozen_parts(self.parts))

    @property
    def known(self) -> FloatArray:
        """Sum of all parts but those that are a choice of the model, in their shape."""
        return sum_of_parts(self.parts)

    @property
    def total(self) -> FloatArray:
        """The same where every body has an estimate; nan where one has none."""
        return self.known * (np.nan if self.bodies_without_estimate else 1.0)


class EigenvalueShifts(NamedTuple):
    """Changes δs of eigenvalues by part, (m,) each, that of the solver, and the vectors used."""

    parts: dict[str, ComplexArray]
    solver: FloatArray
    pairs: ModePairs


def frequency_errors(assembled: AssembledSystem, modes: Modes) -> FrequencyErrors:
    """Estimate the relative errors of the eigenvalues of a system at one speed, for each mode.

    `modes`: modes of equal frequency are best all there.

    To first order δs = yᵀ(E − Ω²ΔK2)x / (yᵀD'(s)x), summed over the bodies, each at its own speed
    and times its safety and amplification. Modes nearer to each other than three times their
    estimates (and a tenth of s) are changed together: eigenvalues of the change projected on all
    of them, given to the modes by MAC. "eigen_solver" is |yᵀD(s)x / (yᵀD'x)| / |s| plus what
    rounding may do: eps |y|ᵀ|K||x| / |s yᵀD'x| of the entries of K, or eps body_rate / 2|s|² of
    the stiffest coordinate of a body, whichever is larger.
    """
    shifts = eigenvalue_shifts(assembled, modes)
    size = error_scale(assembled, shifts.pairs.rates)
    parts = {name: np.abs(shift) / size for name, shift in shifts.parts.items()}
    parts["eigen_solver"] = shifts.solver / size
    return FrequencyErrors(parts=parts, bodies_without_estimate=bodies_without_forms(assembled))


def decrement_errors(assembled: AssembledSystem, modes: Modes) -> FloatArray:
    """Estimate the errors of the logarithmic decrements of modes at one speed, (m,), absolute.

    δ = −2π Re s / Im s changes by −2π (Re δs − Re s Im δs / Im s) / Im s with the δs of each part
    of `eigenvalue_shifts`; the sizes are summed. Bodies without error forms add nothing.
    """
    shifts = eigenvalue_shifts(assembled, modes)
    rates = modes.eigenvalues
    slope = rates.real / rates.imag
    changes = {part: np.abs(s.real - slope * s.imag) for part, s in shifts.parts.items()}
    changes["eigen_solver"] = shifts.solver * np.hypot(1.0, slope)
    return np.asarray(2.0 * np.pi * sum_of_parts(changes) / rates.imag)


def error_scale(assembled: AssembledSystem, rates: npt.ArrayLike) -> FloatArray:
    """Return what errors of eigenvalues are measured against.

    `rates`: s, 1/s, any shape. Returns |s|, or a hundredth of the lowest elastic frequency of a
    free body at rest if that is larger, 1/s. A motion that strains nothing has no frequency of its
    own scale: it is as near zero as the spin is slow.
    """
    elastic = [rotor.element.free_frequencies_hz for rotor in assembled.system.rotors.values()]
    lowest = min((float(hz.min()) for hz in elastic if hz.size), default=0.0)
    floor = 2.0 * np.pi * _NEAR_ZERO * lowest
    return np.asarray(np.maximum(np.abs(np.asarray(rates)), floor))


def eigenvalue_shifts(assembled: AssembledSystem, modes: Modes) -> EigenvalueShifts:
    """Return the changes of the eigenvalues of a system by what its bodies leave out.

    Returns δs with safety and amplification, complex; the solver's part is a size, 1/s.
    """
    if assembled.depends_on_frequency:
        return _dependent_shifts(assembled, modes)
    return _shifts(assembled, modes)


def _dependent_shifts(assembled: AssembledSystem, modes: Modes) -> EigenvalueShifts:
    """Return the changes of modes each with its own bearings, which change with it."""
    found = []
    for column, rate in enumerate(modes.eigenvalues):
        one = _shifts(at_rate(assembled, complex(rate)), mode_columns(modes, np.array([column])))
        left, right = one.pairs.left[:, 0], one.pairs.right[:, 0]
        place = (assembled, modes.speed_rad_s, complex(rate), (left, right))
        parts = {
            part: np.array([with_own_bearings(*place, complex(shift[0]))])
            for part, shift in one.parts.items()
        }
        found.append(one._replace(parts=parts))
    names = found[0].parts if found else {}
    return EigenvalueShifts(
        {part: np.concatenate([one.parts[part] for one in found]) for part in names},
        np.concatenate([one.solver for one in found]) if found else np.empty(0),
        ModePairs(
            modes.eigenvalues,
            np.hstack([one.pairs.right for one in found]) if found else modes.shapes,
            np.hstack([one.pairs.left for one in found]) if found else modes.shapes,
        ),
    )


def _shifts(assembled: AssembledSystem, modes: Modes) -> EigenvalueShifts:
    matrices = matrices_at_speed(assembled, modes.speed_rad_s)
    pairs = mode_pairs(matrices, modes)
    changes = _projected_changes(assembled, modes.speed_rad_s, pairs)
    own = {part: np.diag(change) for part, change in changes.items()}
    largest = np.abs(np.array(list(own.values()))).sum(axis=0) if own else np.zeros(0)
    shifts = {part: values.copy() for part, values in own.items()}
    if own:
        gap = np.abs(pairs.rates[:, None] - pairs.rates)
        near = gap <= np.minimum(
            _CLOSE * np.maximum(largest[:, None], largest), WIDEST * np.abs(pairs.rates)
        )
        for group in together(near):
            if group.size > 1:
                rates, left, right = (a[..., group] for a in (pairs.rates, pairs.left, pairs.right))
                states = state_products(matrices, rates, left, right)
                for part, change in changes.items():
                    inside = change[np.ix_(group, group)]
                    shifts[part][group] = _cluster_shifts(rates, states, inside)
    return EigenvalueShifts(shifts, _solver_shifts(assembled, matrices, pairs), pairs)


def body_forms(assembled: AssembledSystem) -> Iterator[tuple[FloatArray, float, ErrorForm]]:
    """Yield of each form the rows of its body (n_body, n), the speed ratio, and the form."""
    for name, rotor in assembled.system.rotors.items():
        rows = assembled.transformation[assembled.body_slices[name]]
        for form in rotor.element.error_forms:
            yield rows, rotor.speed_ratio, form


def bodies_without_forms(assembled: AssembledSystem) -> tuple[str, ...]:
    """Return the names of the bodies that deform and have no error forms, in their order."""
    return without_forms(assembled.system.rotors)


def without_forms(rotors: Mapping[str, Rotor]) -> tuple[str, ...]:
    """Return the names of those that deform and have no error forms, in their order."""
    elements = {name: rotor.element for name, rotor in rotors.items()}
    return tuple(n for n, e in elements.items() if e.level != "lumped" and not e.error_forms)


def sum_of_parts(parts: Mapping[str, FloatArray]) -> FloatArray:
    """Return the total of all parts (of one shape) but those that are a choice of the model."""
    return np.asarray(sum(value for part, value in parts.items() if part not in NOT_SUMMED))


def frozen_parts(parts: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return read-only copies of the parts in the order of `residual_energy.PARTS`."""
    frozen = {part: np.array(parts[part], dtype=float) for part in PARTS if part in parts}
    for values in frozen.values():
        values.setflags(write=False)
    return frozen


def _projected_changes(
    assembled: AssembledSystem, speed_rad_s: float, pairs: ModePairs
) -> dict[str, ComplexArray]:
    """Return y_iᵀ (E − Ω²ΔK2) x_j of all bodies by part, weighted, shape (m, m)."""
    changes: dict[str, ComplexArray] = {}
    for rows, ratio, form in body_forms(assembled):
        left, right = rows @ pairs.left, rows @ pairs.right
        found = form_projection(form, pairs.rates, ratio * speed_rad_s, left, right)
        root = np.sqrt(form_weight(form, pairs.rates))
        changes[form.part] = changes.get(form.part, 0.0) + root[:, None] * found * root
    return changes


def _cluster_shifts(
    rates: ComplexArray, states: ComplexArray, change: ComplexArray
) -> ComplexArray:
    """Return δs of modes that are perturbed together.

    In the states of the group the unchanged problem is P diag(s), the changed one adds the
    projected change. The eigenvalues are taken relative to their mean to keep the digits.
    """
    middle = rates.mean()
    moved, vectors = np.linalg.eig(np.diag(rates - middle) + np.linalg.solve(states, change))
    mac = np.abs(vectors) ** 2
    distance = np.abs((rates - middle)[:, None] - moved)
    nearness = distance / max(float(distance.max()), np.finfo(float).tiny)
    _, partner = scipy.optimize.linear_sum_assignment(_NEARNESS * nearness - mac)
    return np.asarray(moved[partner] - (rates - middle))


def _solver_shifts(
    assembled: AssembledSystem, matrices: SpeedMatrices, pairs: ModePairs
) -> FloatArray:
    """Return |yᵀD(s)x| and the rounding of K, both over yᵀD'x = 1."""
    rates, right, left = pairs
    velocity = matrices.damping + matrices.gyroscopic
    force = matrices.stiffness @ right + rates * (velocity @ right)
    residual = (left * (force + rates**2 * (matrices.mass @ right))).sum(axis=0)
    rounding = (np.abs(left) * (np.abs(matrices.stiffness) @ np.abs(right))).sum(axis=0)
    of_bodies = 0.5 * assembled.body_rate / np.abs(rates)
    return np.asarray(np.abs(residual) + np.finfo(float).eps * np.maximum(rounding, of_bodies))
