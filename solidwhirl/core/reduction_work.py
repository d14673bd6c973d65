"""What the reduction of a body did: free of the solvers, so that it can be cached."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from solidwhirl.rotordyn import Invariant


@dataclass(frozen=True, kw_only=True, eq=False)
class ReductionWork:
    """What one reduction did, apart from its superelement.

    Attributes
    ----------
    assembled, solved
        Matrices and solutions by circumferential order ("solid" for the solid level).
    orthogonality_error
        Largest deviation of the interior modes from M-orthonormality.
    hoop_strain
        Largest hoop strain of the centrifugal field at the top speed (0 if it was not computed).
        The prestress neglects the change of shape, which is of that relative order.
    solver
        "direct" or "iterative": how the systems of the basis were solved.
    seconds
        Wall time of operators, of basis and projection, of the error estimate and of the checks.
    indicators
        Gives `ElementIndicators`: where on the mesh the estimated error arises. A body from the
        cache is reduced again for them. None unless "mesh" was asked for.
    checks
        What must hold for the basis, and whether it does.
    """

    assembled: Mapping[str, tuple[str, ...]]
    solved: Mapping[str, tuple[str, ...]]
    orthogonality_error: float
    hoop_strain: float
    solver: str
    seconds: Mapping[str, float]
    indicators: Callable[[], tuple[Any, ...]] | None = None
    checks: tuple[Invariant, ...] = ()
