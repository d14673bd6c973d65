"""Inputs and outputs of a state-space model: forces, ground motion, motions, bearing forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import interface_row, joint_motion
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem
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


@dataclass(frozen=True, kw_only=True)
class GroundInput:
    """The motion of the ground under a bearing: two inputs, displacement and velocity.

    Of one component, m and m/s or rad and rad/s; the user supplies both, as the bearing's damping
    acts on the second.
    """

    bearing: str
    component: str


@dataclass(frozen=True, kw_only=True)
class MotionOutput:
    """The motion of an interface: displacement, velocity or acceleration of one component."""

    body: str
    interface: str
    component: str
    quantity: Quantity = "displacement"


@dataclass(frozen=True, kw_only=True)
class BearingForceOutput:
    """The force or moment the first side of a bearing exerts on its second, or on the ground."""

    bearing: str
    component: str


Input: TypeAlias = ForceInput | GroundInput
Output: TypeAlias = MotionOutput | BearingForceOutput


class Channels(NamedTuple):
    """Loads and motions per input and output at one speed.

    The load on the independent coordinates is load (n, m) · u, and the outputs are
    displacement · q + velocity · q' + acceleration · q'' (p, n) + direct (p, m) · u.
    """

    load: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    direct: FloatArray


class Names(NamedTuple):
    """Names and units of the inputs or outputs."""

    names: tuple[str, ...]
    units: tuple[str, ...]


def channels_at_speed(
    assembled: AssembledSystem,
    inputs: Sequence[Input],
    outputs: Sequence[Output],
    speed_rad_s: float,
) -> Channels:
    """Return the loads and motions of inputs and outputs at one speed.

    `inputs`, `outputs`: at least one of each; `speed_rad_s`: Ω, for bearings that depend on it.
    m counts a ground motion twice. Raises AnalysisError if there is no input or output, a
    bearing or component does not exist, a ground motion is asked for at a bearing between two
    bodies, or the component of a bearing is rigid. Raises AssemblyError if an interface does not
    exist.
    """
    if not inputs or not outputs:
        raise AnalysisError(
            f"a state space needs inputs and outputs; there are {len(inputs)} and {len(outputs)}"
        )
    load = np.hstack([_load(assembled, item, speed_rad_s) for item in inputs])
    rows, direct = [], []
    for output in outputs:
        motion, through = _rows(assembled, inputs, output, speed_rad_s)
        rows.append(motion)
        direct.append(through)
    displacement, velocity, acceleration = np.stack(rows, axis=1)
    return Channels(load, displacement, velocity, acceleration, np.array(direct))


def input_names(inputs: Sequence[Input]) -> Names:
    """Return names such as "force rotor.front.ux" and their units."""
    names, units = [], []
    for item in inputs:
        length, force = _unit(item.component)
        if isinstance(item, ForceInput):
            names.append(f"force {item.body}.{item.interface}.{item.component}")
            units.append(force)
            continue
        for quantity in ("displacement", "velocity"):
            names.append(f"ground {quantity} {item.bearing}.{item.component}")
            units.append(length + _DERIVATIVE[quantity])
    return Names(tuple(names), tuple(units))


def output_names(outputs: Sequence[Output]) -> Names:
    """Return names such as "velocity rotor.front.ux" and their units."""
    names, units = [], []
    for item in outputs:
        length, force = _unit(item.component)
        if isinstance(item, MotionOutput):
            names.append(f"{item.quantity} {item.body}.{item.interface}.{item.component}")
            units.append(length + _DERIVATIVE[item.quantity])
        else:
            names.append(f"bearing force {item.bearing}.{item.component}")
            units.append(force)
    return Names(tuple(names), tuple(units))


def _unit(component: str) -> tuple[str, str]:
    return ("m", "N") if component.startswith("u") else ("rad", "N m")


def _load(assembled: AssembledSystem, item: Input, speed: float) -> FloatArray:
    """Return the load per input, shape (n, 1) or, for a ground motion, (n, 2)."""
    if isinstance(item, ForceInput):
        return interface_row(assembled, item.body, item.interface, item.component)[:, None]
    bearing = _bearing(assembled, item.bearing, item.component)
    if bearing.second is not None:
        raise AnalysisError(
            f"ground motion: bearing {item.bearing!r} joins two bodies; name one to the ground"
        )
    stiffness, damping = _coefficients(assembled, bearing, speed)
    motion, at = joint_motion(assembled, bearing), MOTIONS.index(item.component)
    return np.column_stack((motion.T @ stiffness[:, at], motion.T @ damping[:, at]))


def _rows(
    assembled: AssembledSystem, inputs: Sequence[Input], output: Output, speed: float
) -> tuple[FloatArray, FloatArray]:
    """Return what an output takes of q, q', q'', shape (3, n), and of the inputs, shape (m,)."""
    rows = np.zeros((3, assembled.size))
    direct = np.zeros(len(input_names(inputs).names))
    if isinstance(output, MotionOutput):
        if output.quantity not in get_args(Quantity):
            raise AnalysisError(
                f"quantity is {output.quantity!r}, allowed are {list(get_args(Quantity))}"
            )
        order = list(_DERIVATIVE).index(output.quantity)
        rows[order] = interface_row(assembled, output.body, output.interface, output.component)
        return rows, direct
    bearing = _bearing(assembled, output.bearing, output.component)
    stiffness, damping = _coefficients(assembled, bearing, speed)
    motion, at = joint_motion(assembled, bearing), MOTIONS.index(output.component)
    rows[0], rows[1] = stiffness[at] @ motion, damping[at] @ motion
    place = 0
    for item in inputs:
        if isinstance(item, ForceInput):
            place += 1
            continue
        if item.bearing == output.bearing:
            moved = MOTIONS.index(item.component)
            direct[place], direct[place + 1] = -stiffness[at, moved], -damping[at, moved]
        place += 2
    return rows, direct


def _bearing(assembled: AssembledSystem, name: str, component: str) -> Bearing:
    bearings = {bearing.name: bearing for bearing in assembled.system.bearings}
    if name not in bearings:
        raise AnalysisError(f"there is no bearing {name!r}; there are {list(bearings)}")
    if component not in MOTIONS:
        raise AnalysisError(f"component is {component!r}, allowed are {list(MOTIONS)}")
    if component in bearings[name].rigid:
        raise AnalysisError(
            f"bearing {name!r} is rigid in {component}, which leaves no motion to compute its "
            "force from; give it a stiffness"
        )
    return bearings[name]


def _coefficients(
    assembled: AssembledSystem, bearing: Bearing, speed: float
) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and damping (6, 6) of a bearing at a speed."""
    stiffness, damping = bearing.matrices()
    for joint in assembled.law_joints:
        if joint.bearing == bearing.name:
            stiffness[:2, :2], damping[:2, :2] = joint.coefficients(speed)
    return stiffness, damping
