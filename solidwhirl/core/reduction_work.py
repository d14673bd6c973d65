"""What the reduction of a body did: free of the solvers, so that it can be cached."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from solidwhirl.core.joint_states import JointState
from solidwhirl.rotordyn.core.ledger import Ledger

if TYPE_CHECKING:
    from solidwhirl.rotordyn import Invariant

#: Finite element matrices of bodies, their factors and eigenproblems
BODIES = Ledger("problems of bodies")


@dataclass(frozen=True, kw_only=True, eq=False)
class ReductionWork:
    """What one reduction did, apart from its superelement."""

    #: Matrices and solutions by circumferential order ("solid" for the solid level)
    assembled: Mapping[str, tuple[str, ...]]
    solved: Mapping[str, tuple[str, ...]]
    #: Largest deviation of the interior modes from M-orthonormality
    orthogonality_error: float
    #: Largest hoop strain of the centrifugal field at the top speed (0 if it was not computed). The
    #: prestress neglects the change of shape, which is of that relative order.
    hoop_strain: float
    #: "direct" or "iterative": how the systems of the basis were solved
    solver: str
    #: Wall time of operators, of basis and projection, of the error estimate and of the checks
    seconds: Mapping[str, float]
    #: Gives `ElementIndicators`: where on the mesh the estimated error arises. A body from the
    #: cache is reduced again for them. None unless "mesh" was asked for.
    indicators: Callable[[], tuple[Any, ...]] | None = None
    #: What must hold for the basis, and whether it does
    checks: tuple[Invariant, ...] = ()
    joints: tuple[JointState, ...] = ()  #: Of joints whose faces are pressed together
