"""Faults of a system, all of them found in one pass."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from solidwhirl.rotordyn.parts import Bearing, End, Gear, System
from solidwhirl.rotordyn.superelement_checks import MOTIONS

# Gear ratio and speed ratios must agree to this.
_SAME_RATIO = 1e-9
_CROSS_COUPLING = ("with_spin", "as_given", "mirrored")
_SQUARE = (
    "stiffness_n_per_m",
    "damping_n_s_per_m",
    "tilt_stiffness_n_m_per_rad",
    "tilt_damping_n_m_s_per_rad",
)
_SCALAR = (
    "axial_stiffness_n_per_m",
    "axial_damping_n_s_per_m",
    "torsion_stiffness_n_m_per_rad",
    "torsion_damping_n_m_s_per_rad",
)


def find_problems(system: System) -> tuple[str, ...]:
    """Return one sentence for each fault of a system.

    Parameters
    ----------
    system
        The system as written by the user.

    Returns
    -------
    tuple of str
        Empty if the system can be assembled.
    """
    problems = list(_rotor_problems(system))
    names = [bearing.name for bearing in system.bearings]
    for name in sorted({name for name in names if names.count(name) > 1}):
        problems.append(f"bearing name {name!r} occurs {names.count(name)} times; use it once")
    for bearing in system.bearings:
        found = [*_number_problems(bearing), *_coupling_problems(bearing)]
        if not found:
            found += _end_problems(system, bearing)
            found += _rigid_problems(bearing)
            found += _torsion_problems(system, bearing)
        problems += [f"bearing {bearing.name!r}: {text}" for text in found]
    names = [gear.name for gear in system.gears]
    for name in sorted({name for name in names if names.count(name) > 1}):
        problems.append(f"gear name {name!r} occurs {names.count(name)} times; use it once")
    for gear in system.gears:
        found = [*_gear_number_problems(gear), *_gear_end_problems(system, gear)]
        problems += [f"gear {gear.name!r}: {text}" for text in found]
    return tuple(problems)


def _rotor_problems(system: System) -> Iterator[str]:
    if not system.rotors:
        yield "there are no rotors; at least one is needed"
    for name, rotor in system.rotors.items():
        if not np.isfinite(rotor.speed_ratio):
            yield f"rotor {name!r}: speed_ratio is {rotor.speed_ratio}; it must be finite"
        damping = rotor.internal_damping
        values = () if damping is None else (damping.stiffness_coefficient_s, damping.modal_ratio)
        if not all(np.isfinite(value) and value >= 0 for value in values):
            yield f"rotor {name!r}: internal damping {values}; both must be 0 or more"
    if system.reference is None:
        return
    if system.reference not in system.rotors:
        yield f"reference {system.reference!r} is not a rotor; there are {list(system.rotors)}"
    elif system.rotors[system.reference].speed_ratio != 1.0:
        ratio = system.rotors[system.reference].speed_ratio
        yield f"reference rotor {system.reference!r} has speed_ratio {ratio}; it must be 1"


def _number_problems(bearing: Bearing) -> Iterator[str]:
    for name in _SQUARE:
        value = getattr(bearing, name)
        if value.shape != (2, 2):
            yield f"{name} has shape {value.shape}, allowed is (2, 2)"
        elif not np.issubdtype(value.dtype, np.number) or not np.isfinite(value).all():
            yield f"{name} is {value.tolist()}; all numbers must be finite"
    for name in _SCALAR:
        if not np.isfinite(getattr(bearing, name)):
            yield f"{name} is {getattr(bearing, name)}; it must be finite"


def _coupling_problems(bearing: Bearing) -> Iterator[str]:
    if bearing.cross_coupling not in _CROSS_COUPLING:
        yield f"cross_coupling is {bearing.cross_coupling!r}; use {list(_CROSS_COUPLING)}"


def _end_problems(system: System, bearing: Bearing) -> Iterator[str]:
    if bearing.second == bearing.first:
        yield f"both ends are {bearing.first.label}; they must differ"
    stiffness, damping = bearing.matrices()
    used = (stiffness != 0) | (damping != 0)
    needed = [c for i, c in enumerate(MOTIONS) if used[i].any() or used[:, i].any()]
    needed += [c for c in bearing.rigid if c in MOTIONS and c not in needed]
    if bearing.speed_law is not None:
        needed += [c for c in ("ux", "uy") if c not in needed]
    for end in bearing.ends:
        yield from _seat_problems(system, end, needed)


def _seat_problems(system: System, end: End, needed: Sequence[str]) -> Iterator[str]:
    if end.body not in system.rotors:
        yield f"{end.label}: no rotor {end.body!r}; there are {list(system.rotors)}"
        return
    element = system.rotors[end.body].element
    names = [node.name for node in element.interfaces]
    if end.interface not in names:
        yield f"{end.label}: rotor {end.body!r} has interfaces {names}"
        return
    has = element.components_at(end.interface)
    missing = [component for component in needed if component not in has]
    if missing:
        yield f"{end.label}: needs components {missing}, the interface has {list(has)}"


def _torsion_problems(system: System, bearing: Bearing) -> Iterator[str]:
    """Yield a fault of a joint that would wind up, as its two bodies turn at different speeds."""
    if bearing.second is None or not {end.body for end in bearing.ends} <= set(system.rotors):
        return
    if "rz" in bearing.rigid:
        joint = 'rigid = ["rz"]'
    elif bearing.torsion_stiffness_n_m_per_rad != 0:
        joint = "torsion_stiffness_n_m_per_rad"
    else:
        return
    first, second = (system.rotors[end.body].speed_ratio for end in bearing.ends)
    if abs(first - second) > _SAME_RATIO * max(abs(first), abs(second)):
        yield (
            f"{joint} joins {bearing.ends[0].body!r}, which turns at {first:g} times the reference "
            f"speed, with {bearing.ends[1].body!r} at {second:g}: it would wind up; allowed is "
            "between bodies of one speed_ratio, and a gear between others"
        )


def _gear_number_problems(gear: Gear) -> Iterator[str]:
    if not np.isfinite(gear.ratio) or gear.ratio == 0:
        yield f"ratio is {gear.ratio}; finite and not 0 is allowed"
    if gear.mesh_stiffness_n_per_m is not None and not 0 < gear.mesh_stiffness_n_per_m < np.inf:
        yield f"mesh_stiffness_n_per_m is {gear.mesh_stiffness_n_per_m}; it must be positive"
    if not 0 <= gear.mesh_damping_n_s_per_m < np.inf:
        yield f"mesh_damping_n_s_per_m is {gear.mesh_damping_n_s_per_m}; 0 or more is allowed"
    if gear.mesh_stiffness_n_per_m is None and gear.mesh_damping_n_s_per_m:
        yield "a rigid mesh has no damping; give mesh_stiffness_n_per_m too"
    if gear.line_of_action_rad is not None and not np.isfinite(gear.line_of_action_rad):
        yield f"line_of_action_rad is {gear.line_of_action_rad}; it must be finite"
    radius = gear.base_radius_first_m
    if radius is not None and not 0 < radius < np.inf:
        yield f"base_radius_first_m is {radius}; it must be positive"
    elastic = gear.mesh_stiffness_n_per_m is not None or gear.line_of_action_rad is not None
    if radius is None and elastic:
        yield "base_radius_first_m is needed with a mesh stiffness or a line of action"


def _gear_end_problems(system: System, gear: Gear) -> Iterator[str]:
    if gear.first.body == gear.second.body:
        yield f"both seats are on body {gear.first.body!r}; they must be on two"
    needed = ["rz"] if gear.line_of_action_rad is None else ["ux", "uy", "rz"]
    for end in gear.ends:
        yield from _seat_problems(system, end, needed)
    if not {end.body for end in gear.ends} <= set(system.rotors):
        return
    first, second = (system.rotors[end.body].speed_ratio for end in gear.ends)
    if abs(second - gear.ratio * first) > _SAME_RATIO * abs(second):
        yield (
            f"ratio is {gear.ratio:g}, but {gear.first.body!r} turns at {first:g} and "
            f"{gear.second.body!r} at {second:g} times the reference speed"
        )


def _rigid_problems(bearing: Bearing) -> Iterator[str]:
    unknown = [component for component in bearing.rigid if component not in MOTIONS]
    if unknown:
        yield f"rigid components {unknown} are unknown; allowed are {list(MOTIONS)}"
    stiffness, damping = bearing.matrices()
    for component in (c for c in bearing.rigid if c in MOTIONS):
        at = MOTIONS.index(component)
        if any(matrix[at].any() or matrix[:, at].any() for matrix in (stiffness, damping)):
            yield f"{component} is rigid and has stiffness or damping; give one of the two"
