"""Error estimates of a static response: what the reduction of bodies makes too stiff."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.estimates.eigenvalue_errors import bodies_without_forms
from solidwhirl.rotordyn.response.static import StaticResponse
from solidwhirl.rotordyn.superelement.residual_energy import NOT_SUMMED, ErrorForm, form_weight


@dataclass(frozen=True, kw_only=True, eq=False)
class StaticErrors:
    """Relative errors of the deflection, weighted with the load, by part.

    `parts`: of Σ f·u, see `residual_energy.PARTS`. `bodies_without_estimate`: bodies whose errors
    are not in the numbers.
    """

    parts: Mapping[str, float]
    bodies_without_estimate: tuple[str, ...]

    @property
    def total(self) -> float:
        """Sum of all parts but those that are a choice of the model."""
        return sum(value for part, value in self.parts.items() if part not in NOT_SUMMED)


def static_errors(
    assembled: AssembledSystem, gravity_m_per_s2: npt.ArrayLike, response: StaticResponse
) -> StaticErrors:
    """Estimate how much further a system would give way without what its bodies leave out.

    `response`: of `assembled` under this gravity. With the residual r = K V u − M V R g + Ω²K2 V u
    of the larger model, which forces at interfaces have no part in, the work of the loads grows by
    rᵀK⁻¹r = xᵀΓx, x = (u, −R g, 0, Ω² u).
    """
    work = float(response.load @ (assembled.transformation @ response.displacement))
    parts: dict[str, float] = {}
    for name, rotor in assembled.system.rotors.items():
        rows = assembled.transformation[assembled.body_slices[name]]
        moved = rows @ response.displacement
        fall = rotor.element.rigid_body_modes[:, :3] @ np.asarray(gravity_m_per_s2, dtype=float)
        spin = rotor.speed_ratio * response.speed_rad_s
        still = np.zeros_like(moved)
        residual = np.concatenate((moved, -fall, still, spin**2 * moved))
        for form in rotor.element.error_forms:
            added = float(form_weight(form, 0.0)) * (residual @ form.gram @ residual)
            parts[form.part] = parts.get(form.part, 0.0) + added - _change(form, spin, moved)
    return StaticErrors(
        parts={part: abs(value) / abs(work) if work else 0.0 for part, value in parts.items()},
        bodies_without_estimate=bodies_without_forms(assembled),
    )


def _change(form: ErrorForm, spin: float, moved: npt.NDArray[np.float64]) -> float:
    if form.stiffness_change is None:
        return 0.0
    return form.safety * spin**2 * float(moved @ form.stiffness_change @ moved)
