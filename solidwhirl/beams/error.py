"""How far beam theory may be off: the spread of models that bracket its doubtful choices."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.beams.assembly import RootRule
from solidwhirl.beams.profile import BeamLevelError
from solidwhirl.beams.sections import ShearRule, StiffnessRule
from solidwhirl.rotordyn.core.arrays import FloatArray

CentrifugalRule = Literal["plates", "none"]
SeatRule = Literal["given", "blurred"]


class Variant(NamedTuple):
    """Choices of one model."""

    name: str
    stiffness_rule: StiffnessRule = "spread"
    shear_rule: ShearRule = "weighted"
    root_rule: RootRule = "elastic"
    centrifugal_rule: CentrifugalRule = "plates"
    seat_rule: SeatRule = "given"


VARIANTS: tuple[Variant, ...] = (
    Variant("nominal"),
    Variant("soft", stiffness_rule="soft"),
    Variant("stiff", stiffness_rule="stiff"),
    Variant("rigid roots", root_rule="rigid"),
    Variant("shear coefficient", shear_rule="shifted"),
    Variant("shear doubled", shear_rule="doubled"),
    Variant("no centrifugal stiffness", centrifugal_rule="none"),
    Variant("blurred seats", seat_rule="blurred"),
)
"""Models of `beam_variants`, the one to be judged first."""

# Calibrated against converged harmonic models; see tests/program/beams.
_STEPS, _ROOTS, _COEFFICIENT, _SHORT_WAVES, _CENTRIFUGAL = 1.5, 0.5, 1.25, 2.0, 0.5


def beam_theory_error(values: npt.ArrayLike) -> FloatArray:
    """Estimate the relative error that beam theory makes in frequencies or other numbers.

    `values`: the same positive numbers from all variants, in the order of `VARIANTS`, shape (8, m).
    Result: shape (m,), not negative, of the first variant. Raises BeamLevelError if the shape or
    sign is wrong.

    The sum of six parts: how steps and disks stiffen a shaft, how far it gives way at the roots of
    disks and thin walls stretch there, the shear coefficient, centrifugal stiffness, of which drums
    have none here, how far along the shaft a seat reaches, and short waves, for which beam theory
    breaks down: that part goes with the square of what shear takes off, as its expansion in wave
    number does. Seats count whole: they differ by the length in which stresses settle.
    """
    found = np.atleast_2d(np.asarray(values, dtype=float))
    if found.shape[0] != len(VARIANTS) or not (np.isfinite(found).all() and (found > 0.0).all()):
        raise BeamLevelError(
            f"values of the beam variants have shape {found.shape}; {len(VARIANTS)} rows of "
            "positive numbers are needed, one row for each variant"
        )
    change = np.abs(found[1:] / found[0] - 1.0)
    soft, stiff, roots, coefficient, doubled, centrifugal, seats = change
    steps = np.maximum(soft, stiff)
    return np.asarray(
        _STEPS * steps
        + _ROOTS * roots
        + _COEFFICIENT * coefficient
        + _SHORT_WAVES * doubled**2
        + _CENTRIFUGAL * centrifugal
        + seats
    )
