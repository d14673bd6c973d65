"""What measurements with known uncertainty say of parameters, by the linear model at the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray

#: Of the intervals.
CONFIDENCE = 0.95
# Standard deviations that hold so much of a normal distribution.
_WITHIN = float(special.ndtri(0.5 + 0.5 * CONFIDENCE))
#: Size of a correlation from which on two parameters can not be told apart.
ONE = 0.95
#: Probability below which deviations are larger than the uncertainties allow.
UNLIKELY = 0.05
# Singular values below this part of the largest say nothing but round-off.
_ZERO = 1e-10


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """Spread of n parameters in shares of their ranges."""

    #: (JᵀJ)⁻¹ in the directions that the data see, and the projection on those they do not, (n, n)
    covariance: FloatArray
    blind: FloatArray
    #: Of pairs, (n, n)
    correlation: FloatArray
    #: Half widths of the intervals, (n,)
    half_width: FloatArray
    #: Sum of the squared deviations in standard deviations, and how many more data there are
    chi_squared: float
    freedom: int
    #: Of so large a sum or a larger one by chance; None without more data than parameters
    probability: float | None


def estimate(slopes: FloatArray, deviations: FloatArray, lost: int = 0) -> Estimate:
    """Return the spread that independent normal errors leave.

    `slopes`: d(deviation)/d(parameter/range), (t, n); `deviations`: of model and measurement at the
    best parameters, in standard deviations, (t,); `lost`: data that other unknowns use up.

    Covariance (JᵀJ)⁻¹ of weighted least squares; Bard 1974, Nonlinear Parameter Estimation, chapter
    7. Directions that the data do not see get an infinite variance, so that every parameter with a
    part in them has one.
    """
    _, singular, right = np.linalg.svd(slopes)
    padded = np.zeros(slopes.shape[1])
    padded[: singular.size] = singular
    seen = padded > _ZERO * max(float(padded.max(initial=0.0)), 1e-300)
    inverse = np.where(seen, 1.0 / np.where(seen, padded, 1.0) ** 2, 0.0)
    known = right.T @ (inverse[:, None] * right)
    blind = right[~seen].T @ right[~seen]
    # correlation in the limit of a variance that grows without end along what is not seen
    large = 1.0 / _ZERO**2 * float(inverse.max(initial=1.0))
    limit = known + large * blind
    spread = np.sqrt(np.diag(limit))
    unseen = np.diag(blind) > _ZERO
    freedom = slopes.shape[0] - slopes.shape[1] - lost
    chi = float(deviations @ deviations)
    return Estimate(
        covariance=known,
        blind=blind,
        correlation=limit / np.outer(spread, spread),
        half_width=_WITHIN * np.where(unseen, np.inf, np.sqrt(np.diag(known))),
        chi_squared=chi,
        freedom=freedom,
        probability=float(special.chdtrc(freedom, chi)) if freedom > 0 else None,
    )


def not_told_apart(found: Estimate) -> list[tuple[int, int]]:
    """Return pairs of parameters whose correlation is `ONE` or more in size."""
    first, second = np.triu_indices(len(found.correlation), 1)
    alike = np.abs(found.correlation[first, second]) >= ONE
    return list(zip(first[alike].tolist(), second[alike].tolist(), strict=True))


def scores(slopes: FloatArray, deviations: FloatArray, found: Estimate) -> FloatArray:
    """Return how far measurements that were kept aside lie from what is predicted, (t,).

    `slopes`, `deviations`: theirs, as of `estimate`. In standard deviations of the difference,
    their own and that of the prediction: √(1 + J C Jᵀ). 0 where nothing is predicted.
    """
    variance = np.einsum("tn,nm,tm->t", slopes, found.covariance, slopes)
    unknown = np.linalg.norm(slopes @ found.blind, axis=1) > _ZERO * np.linalg.norm(slopes, axis=1)
    return np.where(unknown, 0.0, deviations / np.sqrt(1.0 + np.maximum(variance, 0.0)))


def agrees(score: FloatArray) -> BoolArray:
    """Whether measurements lie where `CONFIDENCE` of them should."""
    return np.asarray(np.abs(score) <= _WITHIN)
