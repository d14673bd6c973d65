"""Static response: deflection, bearing loads and balance under weight, forces and gear torques.

The interfaces of a reduced body move as those of the larger model, exactly, for any static load:
constraint modes hold their stiffness, M R the work of the weight in them. Between interfaces
bodies sag as far as their modes can tell (`estimates.static_errors`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import joint_motion
from solidwhirl.rotordyn.assembly.parts import Bearing, End, Gear
from solidwhirl.rotordyn.assembly.reactions import JointForces, joint_forces
from solidwhirl.rotordyn.assembly.system import AssembledSystem, gravity_load, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix
from solidwhirl.rotordyn.core.errors import AnalysisError, AssemblyError, SuperelementError
from solidwhirl.rotordyn.superelement.centreline import centreline_motion, interface_rows
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS

#: Standard acceleration of free fall, m/s² (ISO 80000-3), and weight where y points up.
STANDARD_GRAVITY = 9.80665
DOWN = (0.0, -STANDARD_GRAVITY, 0.0)
# Fewest points of an axis that tell how it bends.
_BENT = 3
# Points closer than this fraction of the length are at one place.
_SAME_PLACE = 1e-6


@dataclass(frozen=True, kw_only=True)
class PointLoad:
    """A constant force along x, y, z and a moment about them on an interface, N and N m."""

    at: End
    force_n: tuple[float, float, float] = (0.0, 0.0, 0.0)
    moment_n_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def wrench(self) -> FloatArray:
        """Force and moment, shape (6,)."""
        return np.array([*self.force_n, *self.moment_n_m], dtype=float)


@dataclass(frozen=True, kw_only=True, eq=False)
class DeflectionLine:
    """The axis of one body under load, from low to high z.

    `axial_m`: shape (p,); `deflection_m`: ux, uy; `slope_rad`: their derivatives along z by
    differences, both (p, 2).
    """

    axial_m: FloatArray
    deflection_m: FloatArray
    slope_rad: FloatArray

    @property
    def sag(self) -> tuple[float, float]:
        """Largest deflection across the axis and its place, m; zeros of a body without points."""
        if not self.axial_m.size:
            return 0.0, 0.0
        size = np.hypot(*self.deflection_m.T)
        most = int(size.argmax())
        return float(size[most]), float(self.axial_m[most])


@dataclass(frozen=True, kw_only=True, eq=False)
class StaticResponse:
    """A system at rest under constant loads, as far as it turns at a constant speed.

    `displacement`: in the independent coordinates, shape (n,); `load`: on the coordinates of all
    bodies, shape (N,); `points`: what acts beside the weight, forces of teeth too. `lines`: by
    body. `bearing_loads`: force and moment of the first side of each bearing on its second, (6,);
    `bearing_motions`: of the first side relative to the second, (6,), m and rad; `slopes_rad`:
    dux/dz, duy/dz of the first side, (2,). `gear_forces_n`: of the teeth along the relative motion,
    from the torques given and from what else moves them; N m where a gear has no base radius.
    `balance`: sum of all forces and moments about the origin on each body, its weight by its mass
    and centre of gravity, (6,); zero in motions it can not make. `relative_residual`: largest
    balance over the largest force or moment in it.
    """

    speed_rad_s: float
    displacement: FloatArray
    load: FloatArray
    points: tuple[PointLoad, ...]
    lines: Mapping[str, DeflectionLine]
    bearing_loads: Mapping[str, FloatArray]
    bearing_motions: Mapping[str, FloatArray]
    slopes_rad: Mapping[str, FloatArray]
    gear_forces_n: Mapping[str, float]
    balance: Mapping[str, FloatArray]
    relative_residual: float


def static_response(
    assembled: AssembledSystem,
    gravity_m_per_s2: npt.ArrayLike = DOWN,
    points: Sequence[PointLoad] = (),
    gear_torques_n_m: Mapping[str, float] | None = None,
    speed_rad_s: float = 0.0,
) -> StaticResponse:
    """Solve K(Ω) q = f for weight, forces and gear forces.

    `gravity_m_per_s2`: acceleration along x, y, z, shape (3,). `gear_torques_n_m`: torque about
    +z that the shaft of the first wheel puts on it, by gear: the teeth press with T / r along the
    line of action. Torques themselves are in balance along each shaft and twist nothing here.
    `speed_rad_s`: Ω of the reference shaft, at which bearings with a law are taken.

    Supports may be redundant. Motions that nothing holds and nothing drives are left out. Raises
    AnalysisError: a load meets no stiffness, a gear has no line of action, or rigid joints hold a
    motion twice; AssemblyError: a place does not exist or lacks a component that is loaded.
    """
    torques = dict(gear_torques_n_m or {})
    acting = [*points, *_tooth_loads(assembled, torques)]
    load = gravity_load(assembled, gravity_m_per_s2) + _stacked(assembled, acting)
    stiffness = matrices_at_speed(assembled, speed_rad_s).stiffness
    found = static_equilibrium(stiffness, speed_rad_s, assembled.transformation.T @ load)
    still = np.zeros_like(found)
    own = {name: load[at] for name, at in assembled.body_slices.items()}
    joints = joint_forces(assembled, speed_rad_s, found, still, still, own)
    sums = _sums(assembled, np.asarray(gravity_m_per_s2, dtype=float), acting, joints)
    lines = {
        name: _line(rotor.element, assembled.transformation[assembled.body_slices[name]] @ found)
        for name, rotor in assembled.system.rotors.items()
    }
    every = assembled.system.bearings
    given = {name: _tooth_force(_gear(assembled, name), torque) for name, torque in torques.items()}
    return StaticResponse(
        speed_rad_s=float(speed_rad_s),
        displacement=found,
        load=load,
        points=tuple(acting),
        lines=lines,
        bearing_loads={name: np.asarray(force) for name, force in joints.bearings.items()},
        bearing_motions={b.name: joint_motion(assembled, b) @ found for b in every},
        slopes_rad={b.name: _slope(assembled, b, found, lines[b.first.body]) for b in every},
        gear_forces_n={n: float(f) + given.get(n, 0.0) for n, f in joints.gears.items()},
        balance={name: one.total for name, one in sums.items()},
        relative_residual=max(one.relative for one in sums.values()),
    )


def bearing_loads(
    assembled: AssembledSystem,
    gravity_m_per_s2: npt.ArrayLike = DOWN,
    points: Sequence[PointLoad] = (),
    gear_torques_n_m: Mapping[str, float] | None = None,
    speed_rad_s: float = 0.0,
) -> Mapping[str, FloatArray]:
    """Return the static load of each bearing by name: force on its second side along x, y, z (N).

    Arguments and errors as of `static_response`. Returns shape (3,) each; on the ground where a
    bearing has no second side. What a table of coefficients over the load is read at is
    np.hypot(*load[:2]).
    """
    found = static_response(assembled, gravity_m_per_s2, points, gear_torques_n_m, speed_rad_s)
    return {name: force[:3] for name, force in found.bearing_loads.items()}


def static_equilibrium(stiffness: Matrix, speed_rad_s: float, load: Matrix) -> Matrix:
    """Return the displacement under a constant load at a constant speed.

    `stiffness`: at that speed, shape (n, n); `load`: shape (n,). Returns shape (n,); without any
    part of motions that cost no energy. Raises AnalysisError if the load pushes along a motion that
    nothing resists.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(stiffness)), np.finfo(float).tiny))
    scale = np.where(np.diag(stiffness) == 0, 1.0, scale)
    scaled, pushed = scale[:, None] * stiffness * scale, scale * load
    found, *_ = la.lstsq(scaled, pushed, cond=1e-13)
    missed = la.norm(scaled @ found - pushed)
    if missed > 1e-6 * max(la.norm(pushed), np.finfo(float).tiny):
        raise AnalysisError(
            f"at {speed_rad_s:.6g} rad/s nothing holds the system against its load: a part "
            f"{missed / la.norm(pushed):.2e} of the load meets no stiffness"
        )
    return np.asarray(scale * found)


def _gear(assembled: AssembledSystem, name: str) -> Gear:
    gears = {gear.name: gear for gear in assembled.system.gears}
    if name not in gears:
        raise AnalysisError(f"there is no gear {name!r}; there are {list(gears)}")
    gear = gears[name]
    if gear.line_of_action_rad is None or gear.base_radius_first_m is None:
        raise AnalysisError(
            f"gear {name!r} has no line of action: it loads no bearing; give the line of action "
            "and the base radius of the first wheel"
        )
    return gear


def _tooth_force(gear: Gear, torque_n_m: float) -> float:
    assert gear.base_radius_first_m is not None  # `_gear` looks
    return torque_n_m / gear.base_radius_first_m


def _tooth_loads(assembled: AssembledSystem, torques: Mapping[str, float]) -> list[PointLoad]:
    """Forces of the teeth across the axis: −F n on the first wheel, F n on the second."""
    found = []
    for name, torque in torques.items():
        gear = _gear(assembled, name)
        across = _tooth_force(gear, torque) * gear.tooth_motion()[0][:2]
        for end, sign in zip(gear.ends, (-1.0, 1.0), strict=True):
            x, y = (sign * across).tolist()
            found.append(PointLoad(at=end, force_n=(x, y, 0.0)))
    return found


def _stacked(assembled: AssembledSystem, points: Sequence[PointLoad]) -> FloatArray:
    """Return loads on the coordinates of all bodies, shape (N,)."""
    load = np.zeros(assembled.transformation.shape[0])
    for point in points:
        if point.at.body not in assembled.body_slices:
            known = list(assembled.body_slices)
            raise AssemblyError((f"there is no body {point.at.body!r}; there are {known}",))
        element = assembled.system.rotors[point.at.body].element
        start = assembled.body_slices[point.at.body].start
        for component, value in zip(MOTIONS, point.wrench, strict=True):
            if value:
                try:
                    own = element.interface_index(point.at.interface, component)
                except SuperelementError as error:
                    raise AssemblyError((f"body {point.at.body!r}: {error}",)) from error
                load[start + own] += value
    return load


def _line(element: Superelement, coordinates: FloatArray) -> DeflectionLine:
    found = centreline_motion(element)
    places, modes = found.axial_m, found.modes
    if places.size < _BENT:  # as of a bar, whose faces have a point on the axis at its ends alone
        nodes = interface_rows(element)
        apart = np.abs(nodes.axial_m[:, None] - places).min(axis=1, initial=np.inf)
        new = apart > _SAME_PLACE * np.ptp(np.concatenate((nodes.axial_m, places)))
        places = np.concatenate((places, nodes.axial_m[new]))
        modes = np.concatenate((modes, nodes.modes[new]))
    order = np.argsort(places, kind="stable")
    axial, moved = places[order], (modes @ coordinates)[order]
    slope = np.zeros_like(moved)
    if axial.size > 1:
        slope = np.gradient(moved, axial, axis=0, edge_order=1 if axial.size == 2 else 2)
    return DeflectionLine(axial_m=axial, deflection_m=moved, slope_rad=slope)


def _slope(
    assembled: AssembledSystem, bearing: Bearing, found: FloatArray, line: DeflectionLine
) -> FloatArray:
    """Slopes of the first side: tilts ry and −rx, those of the line where it has no tilts."""
    element = assembled.system.rotors[bearing.first.body].element
    own = element.components_at(bearing.first.interface)
    moved = assembled.transformation[assembled.body_slices[bearing.first.body]] @ found
    if {"rx", "ry"} <= set(own):
        rx, ry = (moved[element.interface_index(bearing.first.interface, c)] for c in ("rx", "ry"))
        return np.array([ry, -rx])
    at = float(element.interface_node(bearing.first.interface).position_m[2])
    if not line.axial_m.size:
        return np.zeros(2)
    return np.array([np.interp(at, line.axial_m, part) for part in line.slope_rad.T])


class _Sum(NamedTuple):
    """Sum of wrenches about the origin on a body, and that over the largest of them."""

    total: FloatArray
    relative: float


def _sums(
    assembled: AssembledSystem,
    gravity: FloatArray,
    points: Sequence[PointLoad],
    joints: JointForces,
) -> dict[str, _Sum]:
    """Forces and moments on each body, by places and masses alone."""
    seats = [(point.at, point.wrench) for point in points]
    for bearing in assembled.system.bearings:
        force = joints.bearings[bearing.name]
        seats.append((bearing.first, -force))
        if bearing.second is not None:
            seats.append((bearing.second, force))
    for gear in assembled.system.gears:
        for end, factors in zip(gear.ends, gear.tooth_motion(), strict=True):
            seats.append((end, -joints.gears[gear.name] * factors))
    found = {}
    for name, rotor in assembled.system.rotors.items():
        element = rotor.element
        own = [(element.center_of_gravity_m, np.append(element.mass_kg * gravity, np.zeros(3)))]
        own += [
            (element.interface_node(end.interface).position_m, wrench)
            for end, wrench in seats
            if end.body == name
        ]
        every = np.array([_about_origin(*one) for one in own])
        every[:, ~element.rigid_body_present] = 0.0
        found[name] = _Sum(every.sum(axis=0), _relative(every))
    return found


def _about_origin(place: FloatArray, wrench: FloatArray) -> FloatArray:
    force, moment = wrench[:3], wrench[3:]
    return np.concatenate((force, moment + np.cross(place, force)))


def _relative(wrenches: FloatArray) -> float:
    """Sum of forces over the largest one, and of moments; the larger of both."""
    total = np.abs(wrenches.sum(axis=0))
    sizes = np.abs(wrenches).max(axis=0)
    kinds = (slice(0, 3), slice(3, 6))
    return max(float(total[k].max() / max(sizes[k].max(), 1e-300)) for k in kinds)
