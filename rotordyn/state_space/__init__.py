"""State-space models between forces and motions.

Channels, models at one or many speeds, their frequency responses and files.
In: `AssembledSystem` and channels. Out: `StateSpace`, files for Python and Matlab.
"""

from __future__ import annotations

from solidwhirl.rotordyn.state_space.model import (
    StateMatrices,
    StateSpace,
    state_space,
    tabulated_state_space,
)

__all__ = ["StateMatrices", "StateSpace", "state_space", "tabulated_state_space"]
