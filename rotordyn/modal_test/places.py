"""Motion of places of a body that a hammer hits or a sensor sees, per coordinate of a system."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from solidwhirl.rotordyn.assembly.coordinates import body_rows, interface_row
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.superelement.centreline import Centreline, centreline_motion

# Share of the length of a body beyond its outermost known points at which a place still counts as
# on it; what is beyond them is continued.
_REACH = 0.02
_SAME_PLACE = 1e-9


def interface_direction(
    system: AssembledSystem, body: str, interface: str, direction: FloatArray
) -> FloatArray:
    """Return the motion of an interface along a direction per coordinate, shape (n,).

    `direction`: of x, y and z, unit length, (3,). Raises AssemblyError if it has no such motion.
    """
    rows = [
        factor * interface_row(system, body, interface, component)
        for factor, component in zip(direction, ("ux", "uy", "uz"), strict=True)
        if factor
    ]
    return np.asarray(sum(rows))


def place_direction(
    system: AssembledSystem, body: str, at_m: float, direction: FloatArray
) -> FloatArray:
    """Return the lateral motion of the axis of a body at a place, shape (n,).

    `at_m`: along the axis, m; `direction`: of x and y, unit length, (2,). Between points whose
    motion is known (`centreline_motion`) a cubic spline holds, between two a line. Raises
    AnalysisError if the place lies off the body, AssemblyError if there is no such body.
    """
    rows = body_rows(system, body)
    line = _known_points(system, body)
    low, high = float(line.axial_m[0]), float(line.axial_m[-1])
    reach = _REACH * (high - low)
    if not low - reach <= at_m <= high + reach:
        raise AnalysisError(
            f"{at_m:g} m lies off body {body!r}, whose axis is known from {low:g} to {high:g} m"
        )
    single = line.axial_m.size == 1
    motion = line.modes[0] if single else CubicSpline(line.axial_m, line.modes)(at_m)
    return np.asarray(direction @ motion @ rows)


def _known_points(system: AssembledSystem, body: str) -> Centreline:
    """Return the centre line of a body, of points at one place the first."""
    places, modes = centreline_motion(system.system.rotors[body].element)
    if not places.size:
        raise AnalysisError(f"nothing is known of the lateral motion of body {body!r}")
    apart = np.append(True, np.diff(places) > _SAME_PLACE * max(float(np.ptp(places)), 1e-300))
    return Centreline(places[apart], modes[apart])


def lateral_rows(system: AssembledSystem) -> FloatArray:
    """Return ux and uy of the axes of all bodies per coordinate, shape (p, n)."""
    found = [
        _known_points(system, body).modes @ body_rows(system, body) for body in system.system.rotors
    ]
    return np.asarray(np.concatenate(found).reshape(-1, system.size))


def axial_rows(system: AssembledSystem) -> FloatArray:
    """Return uz of all interfaces that have it per coordinate, shape (p, n)."""
    found = [
        interface_row(system, body, node.name, "uz")
        for body, rotor in system.system.rotors.items()
        for node in rotor.element.interfaces
        if "uz" in rotor.element.components_at(node.name)
    ]
    return np.array(found).reshape(-1, system.size)
