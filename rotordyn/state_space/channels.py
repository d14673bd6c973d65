"""Inputs and outputs of a state-space model: forces, motions, bearing forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.system import AssembledSystem, bearing_force_rows
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.superelement.validation import MOTIONS

Quantity = Literal["displacement", "velocity", "acceleration"]

_DERIVATIVE = {"displacement": "", "velocity": "/s", "acceleration": "/s2"}


@dataclass(frozen=True, kw_only=True)
class ForceInput:
    """A force (ux, uy, uz) or moment (rx, ry, rz) on an interface, N or N m."""

    body: str
    interface: str
    component: str

    @property
    def name_and_unit(self) -> tuple[str, str]:
        """Such as "force rotor.front.ux", N."""
        return f"force {self.body}.{self.interface}.{self.component}", _force(self.component)


@dataclass(frozen=True, kw_only=True)
class MotionOutput:
    """The motion of an interface: displacement, velocity or acceleration of one component."""

    body: str
    interface: str
    component: str
    quantity: Quantity = "displacement"

    @property
    def name_and_unit(self) -> tuple[str, str]:
        """Such as "velocity rotor.front.ux", m/s."""
        length = "m" if self.component.startswith("u") else "rad"
        name = f"{self.quantity} {self.body}.{self.interface}.{self.component}"
        return name, length + _DERIVATIVE[self.quantity]


@dataclass(frozen=True, kw_only=True)
class BearingForceOutput:
    """The force or moment the first side of a bearing exerts on its second, or on the ground."""

    bearing: str
    component: str

    @property
    def name_and_unit(self) -> tuple[str, str]:
        """Such as "bearing force mount.ux", N."""
        return f"bearing force {self.bearing}.{self.component}", _force(self.component)


Output: TypeAlias = MotionOutput | BearingForceOutput


class Channels(NamedTuple):
    """Loads and motions per input and output at one speed.

    The load on the independent coordinates is load (n, m) · u, and the outputs are
    displacement · q + velocity · q' + acceleration · q'', (p, n) each.
    """

    load: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


def channels_at_speed(
    assembled: AssembledSystem,
    inputs: Sequence[ForceInput],
    outputs: Sequence[Output],
    speed_rad_s: float,
) -> Channels:
    """Return the loads and motions of inputs and outputs at one speed.

    `inputs`, `outputs`: at least one of each; `speed_rad_s`: Ω, for bearings that depend on it.
    Raises AnalysisError if there is no input or output, a bearing or component does not exist, or
    the component of a bearing is rigid. Raises AssemblyError if an interface does not exist.
    """
    if not inputs or not outputs:
        raise AnalysisError(
            f"a state space needs inputs and outputs; there are {len(inputs)} and {len(outputs)}"
        )
    loads = [interface_row(assembled, i.body, i.interface, i.component) for i in inputs]
    rows = np.stack([_rows(assembled, output, speed_rad_s) for output in outputs], axis=1)
    return Channels(np.column_stack(loads), *rows)


def _force(component: str) -> str:
    return "N" if component.startswith("u") else "N m"


def _rows(assembled: AssembledSystem, output: Output, speed: float) -> FloatArray:
    """Return what an output takes of q, q' and q'', shape (3, n)."""
    rows = np.zeros((3, assembled.size))
    if isinstance(output, MotionOutput):
        known = list(_DERIVATIVE)
        if output.quantity not in known:
            raise AnalysisError(f"quantity is {output.quantity!r}, allowed are {known}")
        order = known.index(output.quantity)
        rows[order] = interface_row(assembled, output.body, output.interface, output.component)
        return rows
    bearings = {bearing.name: bearing for bearing in assembled.system.bearings}
    if output.bearing not in bearings:
        raise AnalysisError(f"there is no bearing {output.bearing!r}; there are {list(bearings)}")
    if output.component not in MOTIONS:
        raise AnalysisError(f"component is {output.component!r}, allowed are {list(MOTIONS)}")
    bearing = bearings[output.bearing]
    if output.component in bearing.rigid:
        raise AnalysisError(
            f"bearing {output.bearing!r} is rigid in {output.component}, which leaves no motion to "
            "compute its force from; give it a stiffness"
        )
    at = MOTIONS.index(output.component)
    rows[0], rows[1] = (part[at] for part in bearing_force_rows(assembled, bearing, speed))
    return rows
