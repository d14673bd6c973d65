"""A shaft alone on rigid supports at its journals: static loads, and its first critical speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from solidwhirl.rotordyn.assembly.parts import Bearing, End
from solidwhirl.rotordyn.assembly.reactions import joint_forces
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    assemble,
    bearing_matrices,
    gravity_load,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.undamped import undamped_critical_speeds
from solidwhirl.rotordyn.modes.whirl import excitation_by
from solidwhirl.rotordyn.response.static import static_equilibrium
from solidwhirl.rotordyn.superelement.record import Superelement

# Bearings below this part of the stiffest one do not carry a shaft.
_CARRIES = 0.01
# How far above a speed the first critical speed is sought, times that speed.
_FARTHEST = 64.0


def shaft_bodies(assembled: AssembledSystem, shaft: str) -> tuple[str, ...]:
    """Return the bodies that turn as a shaft does, itself first."""
    rotors = assembled.system.rotors
    ratio = rotors[shaft].speed_ratio
    return (shaft, *(n for n, r in rotors.items() if n != shaft and r.speed_ratio == ratio))


def seat_of(bearing: Bearing, bodies: Sequence[str]) -> End | None:
    """Return where a bearing holds a shaft; None if it holds it against itself or not at all."""
    own = [end for end in bearing.ends if end.body in bodies]
    return own[0] if len(own) == 1 else None


def journal_seats(
    assembled: AssembledSystem, shaft: str, speed_rad_s: float, names: Sequence[str] = ()
) -> dict[str, End]:
    """Return where the journal bearings of a shaft hold it, by name and along the axis.

    `names`: of the bearings; none takes those that hold the shaft sideways with 1 % of the
    stiffest or more at a speed Ω. Raises AnalysisError if there is none, or a named one does not
    hold the shaft against something else.
    """
    bodies = shaft_bodies(assembled, shaft)
    found: dict[str, End] = {}
    stiffness: dict[str, float] = {}
    for bearing in assembled.system.bearings:
        seat = seat_of(bearing, bodies)
        if seat is None:
            continue
        found[bearing.name] = seat
        k, _ = bearing_matrices(assembled, bearing, speed_rad_s)
        rigid = {"ux", "uy"} & set(bearing.rigid)
        stiffness[bearing.name] = np.inf if rigid else float(np.trace(k[:2, :2]))
    strange = [name for name in names if name not in found]
    if strange:
        raise AnalysisError(
            f"bearings {strange} do not hold {shaft!r} against another body or the ground; those "
            f"that do are {list(found)}"
        )
    most = max(stiffness.values(), default=0.0)
    kept = names or [n for n, k in stiffness.items() if k > 0.0 and k >= _CARRIES * most]
    if not kept:
        raise AnalysisError(f"no bearing holds {shaft!r} sideways; it has no journals")
    return dict(sorted(((n, found[n]) for n in kept), key=lambda item: axial_m(assembled, item[1])))


def axial_m(assembled: AssembledSystem, end: End) -> float:
    """Return the place of an interface along the axis, m."""
    nodes = assembled.system.rotors[end.body].element.interfaces
    return float(next(n.position_m[2] for n in nodes if n.name == end.interface))


def on_rigid_supports(
    assembled: AssembledSystem, shaft: str, seats: Mapping[str, End]
) -> AssembledSystem:
    """Return a shaft alone, held exactly in ux and uy at its journals.

    `seats`: of `journal_seats`. What joins the bodies of the shaft to each other stays.
    """
    bodies = shaft_bodies(assembled, shaft)
    system = assembled.system
    joints = [b for b in system.bearings if b.second and all(end.body in bodies for end in b.ends)]
    held = [Bearing(name=n, first=seat, rigid=("ux", "uy")) for n, seat in seats.items()]
    return assemble({name: system.rotors[name] for name in bodies}, (*held, *joints))


def journal_loads_kg(rigid: AssembledSystem, names: Sequence[str]) -> dict[str, float]:
    """Return the weights on journals over gravity, kg, by name.

    `rigid`: of `on_rigid_supports`; with two journals these are the loads of statics. Raises
    AnalysisError if the journals do not hold the shaft against its weight.
    """
    stacked = gravity_load(rigid, (0.0, -1.0, 0.0))
    load = rigid.transformation.T @ stacked
    displacement = static_equilibrium(matrices_at_speed(rigid, 0.0).stiffness, 0.0, load)
    still = np.zeros_like(displacement)
    weights = {body: stacked[rows] for body, rows in rigid.body_slices.items()}
    forces = joint_forces(rigid, 0.0, displacement, still, still, weights).bearings
    return {name: -float(forces[name][1]) for name in names}


def overhung_masses_kg(
    assembled: AssembledSystem,
    shaft: str,
    seats: Mapping[str, End],
    masses_beyond: Callable[[str, float, float], tuple[float, float] | None] = lambda *_: None,
) -> tuple[float, float]:
    """Return the masses beyond the middles of the first and of the last journal, kg.

    `masses_beyond`: of a body below one place along the axis and above another, m, as it is drawn;
    None of one without a drawing. A rigid body then counts where its centre of gravity is, and of
    others counts what weighs on the interfaces beyond: what lies between an interface and the
    journal is shared by both as their static deflections are, so that this is too little.
    """
    ends = [axial_m(assembled, seat) for seat in seats.values()]
    found = [
        masses_beyond(body, ends[0], ends[-1])
        or _weighing_beyond_kg(assembled.system.rotors[body].element, ends[0], ends[-1])
        for body in shaft_bodies(assembled, shaft)
    ]
    below, above = (sum(side) for side in zip(*found, strict=True))
    return max(below, 0.0), max(above, 0.0)


def _weighing_beyond_kg(element: Superelement, low_m: float, high_m: float) -> tuple[float, float]:
    """Masses on interfaces below one place and above another, by the mass matrix of a body."""
    if element.level == "lumped":
        place = float(element.center_of_gravity_m[2])
        return element.mass_kg * (place < low_m), element.mass_kg * (place > high_m)
    weight = element.mass @ element.rigid_body_modes[:, 1]
    own = [
        (float(node.position_m[2]), float(weight[element.interface_index(node.name, "uy")]))
        for node in element.interfaces
        if "uy" in element.components_at(node.name)
    ]
    return (
        sum(mass for place, mass in own if place < low_m),
        sum(mass for place, mass in own if place > high_m),
    )


def excited_critical_speeds(
    assembled: AssembledSystem, shaft: str, limit_rad_s: float
) -> list[tuple[float, ComplexArray]]:
    """Return undamped critical speeds that unbalance of a shaft excites, with shapes (n,).

    Speeds of the shaft itself up to a limit, rising; if there is none, the first one beyond, sought
    up to 64 times the limit.
    """
    bodies = shaft_bodies(assembled, shaft)
    ratio = abs(assembled.system.rotors[shaft].speed_ratio)
    for limit in limit_rad_s * 2.0 ** np.arange(0.0, np.log2(_FARTHEST) + 1.0):
        speeds, shapes = undamped_critical_speeds(assembled, ratio, limit / ratio)
        found = [
            (float(ratio * speed), shape)
            for speed, shape in zip(speeds, shapes.T, strict=True)
            if speed > 0.0 and excitation_by(assembled, shape, bodies).excited
        ]
        if found:
            return found if limit == limit_rad_s else found[:1]
    return []


def first_critical_speed_rad_s(rigid: AssembledSystem, shaft: str, near_rad_s: float) -> float:
    """Return the first undamped critical speed of a shaft on rigid supports, of the shaft itself.

    `rigid`: of `on_rigid_supports`; `near_rad_s`: a speed of the shaft, from which on it is sought
    upward to 64 times that. Unbalance must excite it. Returns inf if there is none.
    """
    found = excited_critical_speeds(rigid, shaft, near_rad_s)
    return found[0][0] if found else float("inf")
