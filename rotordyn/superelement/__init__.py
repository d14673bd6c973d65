"""One spinning body as dense matrices in named coordinates.

The record, its mass moments, residual energy, axis and surface, rigid bodies, and checks of a body.
In: matrices of any origin. Out: `Superelement`, the only record between reduction and assembly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from solidwhirl.rotordyn.core.later import import_later

if TYPE_CHECKING:
    from solidwhirl.rotordyn.superelement.record import (
        Coordinate,
        ErrorForm,
        InterfaceNode,
        MassMoments,
        Superelement,
    )

__all__ = ["Coordinate", "ErrorForm", "InterfaceNode", "MassMoments", "Superelement"]

import_later(__name__)
