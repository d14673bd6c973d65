"""Motions of interfaces, joints and bodies in the independent coordinates of a system."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import NamedTuple, Protocol

import numpy as np

from solidwhirl.rotordyn.assembly.parts import Bearing, End, Gear, System
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AssemblyError, SuperelementError
from solidwhirl.rotordyn.superelement.validation import MOTIONS


class Placed(Hashable, Protocol):
    """A system whose bodies have rows in a matrix T of all coordinates from some, (N, n)."""

    @property
    def system(self) -> System:
        """The parts."""

    @property
    def body_slices(self) -> Mapping[str, slice]:
        """Rows of each body."""

    @property
    def transformation(self) -> FloatArray:
        """T, shape (N, n)."""


class Rows(NamedTuple):
    """A system before it is assembled, or in other coordinates."""

    system: System
    body_slices: Mapping[str, slice]
    transformation: FloatArray


def interface_row(assembled: Placed, body: str, interface: str, component: str) -> FloatArray:
    """Return one motion of an interface per independent coordinate.

    `component`: "ux" to "rz". Returns shape (n,). Raises AssemblyError if there is no such
    coordinate; the message names what exists.
    """
    rows = body_rows(assembled, body)
    try:
        index = assembled.system.rotors[body].element.interface_index(interface, component)
    except SuperelementError as error:
        raise AssemblyError((f"body {body!r}: {error}",)) from error
    return np.asarray(rows[index])


def seat_motion(assembled: Placed, end: End) -> FloatArray:
    """Return ux to rz of an interface per independent coordinate, zero rows where it has none.

    Returns shape (6, n). Raises AssemblyError if there is no such body.
    """
    rows = body_rows(assembled, end.body)
    element = assembled.system.rotors[end.body].element
    motion = np.zeros((6, rows.shape[1]))
    for component in element.components_at(end.interface):
        row = element.interface_index(end.interface, component)
        motion[MOTIONS.index(component)] = rows[row]
    return motion


def joint_motion(assembled: Placed, bearing: Bearing) -> FloatArray:
    """Return the motion of a bearing's first side relative to its second.

    Returns ux to rz per independent coordinate, shape (6, n); zero rows where a side has no such
    coordinate.
    """
    motion = seat_motion(assembled, bearing.first)
    return motion if bearing.second is None else motion - seat_motion(assembled, bearing.second)


def sensed_motion(assembled: Placed, bearing: Bearing) -> FloatArray:
    """Return the motion of a bearing's sensor relative to its second side, see `joint_motion`."""
    if bearing.sensor is None:
        return joint_motion(assembled, bearing)
    motion = seat_motion(assembled, bearing.sensor)
    return motion if bearing.second is None else motion - seat_motion(assembled, bearing.second)


def tooth_motion(assembled: Placed, gear: Gear) -> FloatArray:
    """Return the relative motion of a gear's teeth per independent coordinate, shape (n,).

    It is along the line of action; in radians of the first wheel where no base radius is given.
    """
    first, second = gear.tooth_motion()
    motion = first @ seat_motion(assembled, gear.first)
    return np.asarray(motion + second @ seat_motion(assembled, gear.second))


def body_rows(assembled: Placed, body: str) -> FloatArray:
    """Return the coordinates of one body per independent coordinate.

    Returns shape (n_body, n). Raises AssemblyError if there is no such body.
    """
    if body not in assembled.body_slices:
        known = list(assembled.body_slices)
        raise AssemblyError((f"there is no body {body!r}; there are {known}",))
    return assembled.transformation[assembled.body_slices[body]]
