"""Motions of interfaces, joints and bodies in the independent coordinates of a system."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.joints import relative_motion
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AssemblyError, SuperelementError


def interface_row(
    assembled: AssembledSystem, body: str, interface: str, component: str
) -> FloatArray:
    """Return one motion of an interface per independent coordinate.

    `component`: "ux" to "rz". Returns shape (n,). Raises AssemblyError if there is no such
    coordinate; the message names what exists.
    """
    rotors = assembled.system.rotors
    if body not in rotors:
        raise AssemblyError((f"there is no body {body!r}; there are {list(rotors)}",))
    try:
        index = rotors[body].element.interface_index(interface, component)
    except SuperelementError as error:
        raise AssemblyError((f"body {body!r}: {error}",)) from error
    return np.asarray(assembled.transformation[assembled.body_slices[body].start + index])


def joint_motion(assembled: AssembledSystem, bearing: Bearing) -> FloatArray:
    """Return the motion of a bearing's first side relative to its second.

    Returns ux to rz per independent coordinate, shape (6, n); zero rows where a side has no such
    coordinate.
    """
    return relative_motion(
        assembled.system, assembled.body_slices, assembled.transformation, bearing
    )


def body_rows(assembled: AssembledSystem, body: str) -> FloatArray:
    """Return the coordinates of one body per independent coordinate.

    Returns shape (n_body, n). Raises AssemblyError if there is no such body.
    """
    if body not in assembled.body_slices:
        known = list(assembled.body_slices)
        raise AssemblyError((f"there is no body {body!r}; there are {known}",))
    return assembled.transformation[assembled.body_slices[body]]
