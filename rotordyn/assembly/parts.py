"""What an engine is made of: rotors with their speed ratios, and the bearings between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly import bearing_laws
from solidwhirl.rotordyn.assembly.bearing_laws import SpeedLaw
from solidwhirl.rotordyn.assembly.law_pieces import BearingCoefficients
from solidwhirl.rotordyn.core.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.reprs import MOST_LINES, count_of, lines_of, row
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS

CrossCoupling = Literal["with_spin", "as_given", "mirrored"]
# Coefficients of a bearing: how its text calls them, their field and unit; the first four couple.
_TOLD = (
    ("k", "stiffness_n_per_m", "N/m"),
    ("c", "damping_n_s_per_m", "N s/m"),
    ("tilt k", "tilt_stiffness_n_m_per_rad", "N m/rad"),
    ("tilt c", "tilt_damping_n_m_s_per_rad", "N m s/rad"),
    ("axial k", "axial_stiffness_n_per_m", "N/m"),
    ("axial c", "axial_damping_n_s_per_m", "N s/m"),
    ("torsion k", "torsion_stiffness_n_m_per_rad", "N m/rad"),
    ("torsion c", "torsion_damping_n_m_s_per_rad", "N m s/rad"),
)
_COUPLED = tuple(key for _, key, _ in _TOLD[:4])
_SCALAR = tuple(key for _, key, _ in _TOLD[4:])
# Gear ratio and speed ratios must agree to this.
_SAME_RATIO = 1e-9


def _zero_matrix() -> FloatArray:
    return np.zeros((2, 2))


@dataclass(frozen=True, kw_only=True)
class End:
    """Name one side of a bearing: an interface of a body."""

    body: str
    interface: str

    @property
    def label(self) -> str:
        """Text such as "inner.front"."""
        return f"{self.body}.{self.interface}"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Bearing:
    """Join an interface to another one or to the ground.

    The force on `first` is −k (u_first − u_second) − c (u̇_first − u̇_second), in fixed
    components.

    `name`: unique within the system; `first`: one side. `second`: the other side; None is the
    ground. `stiffness_n_per_m`, `damping_n_s_per_m`: on (ux, uy), shape (2, 2). Need not be
    symmetric (cross-coupled seals and oil films). `tilt_stiffness_n_m_per_rad`,
    `tilt_damping_n_m_s_per_rad`: on (rx, ry), shape (2, 2); `axial_stiffness_n_per_m`,
    `axial_damping_n_s_per_m`: on uz; `torsion_stiffness_n_m_per_rad`,
    `torsion_damping_n_m_s_per_rad`: on rz. `rigid`: components, "ux" to "rz", joined exactly: the
    coordinates are eliminated, no large spring is used. A component is either rigid or has
    stiffness and damping, not both. `speed_law`: how the coefficients on (ux, uy) change with the
    spin speed of the body of `first`; None keeps them constant. `cross_coupling`: "with_spin":
    unequal cross terms (xy ≠ yx) come from the rotation and are given for a shaft that turns
    forward, so that `assemble` changes the sign of all cross terms of the bearing where it turns
    backward, and writes "mirrored" here. "as_given": they are taken as they are. Equal cross terms
    (xy = yx in stiffness and damping, at all speeds) are those of an elastic support with inclined
    axes, and stay. `sensor`: where the sensors of a magnetic bearing look, against `second`; None:
    where `first` is.
    """

    name: str
    first: End
    second: End | None = None
    stiffness_n_per_m: FloatArray = field(default_factory=_zero_matrix)
    damping_n_s_per_m: FloatArray = field(default_factory=_zero_matrix)
    tilt_stiffness_n_m_per_rad: FloatArray = field(default_factory=_zero_matrix)
    tilt_damping_n_m_s_per_rad: FloatArray = field(default_factory=_zero_matrix)
    axial_stiffness_n_per_m: float = 0.0
    axial_damping_n_s_per_m: float = 0.0
    torsion_stiffness_n_m_per_rad: float = 0.0
    torsion_damping_n_m_s_per_rad: float = 0.0
    rigid: tuple[str, ...] = ()
    speed_law: SpeedLaw | None = None
    cross_coupling: CrossCoupling = "with_spin"
    sensor: End | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self, *_COUPLED)

    def __repr__(self) -> str:
        second = "ground" if self.second is None else self.second.label
        found = [_told(name, getattr(self, key), unit) for name, key, unit in _TOLD]
        found += [f"rigid {' '.join(self.rigid)}"] if self.rigid else []
        found += [f"law {self.speed_law.name!r}"] if self.speed_law is not None else []
        told = "; ".join(text for text in found if text) or "nothing"
        return f"Bearing {self.name!r}, {self.first.label} to {second}: {told}"

    @property
    def ends(self) -> tuple[End, ...]:
        """The sides that are not the ground."""
        return (self.first,) if self.second is None else (self.first, self.second)

    @property
    def has_spin_coupling(self) -> bool:
        """Whether cross terms are unequal at some speed, as rotation makes them."""
        own = (getattr(self, name) for name in _COUPLED)
        constant = any(not np.array_equal(matrix, matrix.T) for matrix in own)
        return constant or (
            self.speed_law is not None and bearing_laws.is_turned_by_spin(self.speed_law)
        )

    def mirrored(self) -> Bearing:
        """Return the bearing under a shaft that turns the other way: all cross terms change sign.

        The result is with the `cross_coupling` "mirrored".
        """
        law = None if self.speed_law is None else bearing_laws.mirrored_law(self.speed_law)
        turned: dict[str, Any] = {
            name: bearing_laws.mirrored(getattr(self, name)) for name in _COUPLED
        }
        return replace(self, **turned, speed_law=law, cross_coupling="mirrored")

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping on (ux, uy, uz, rx, ry, rz), a speed law left aside.

        Returns shape (6, 6); N/m and N s/m, N m/rad and N m s/rad.
        """
        k, c = self.stiffness_n_per_m, self.damping_n_s_per_m
        tilt_k, tilt_c = self.tilt_stiffness_n_m_per_rad, self.tilt_damping_n_m_s_per_rad
        uz, rz = self.axial_stiffness_n_per_m, self.torsion_stiffness_n_m_per_rad
        uz_c, rz_c = self.axial_damping_n_s_per_m, self.torsion_damping_n_m_s_per_rad
        return la.block_diag(k, uz, tilt_k, rz), la.block_diag(c, uz_c, tilt_c, rz_c)

    def matrices_with(self, found: BearingCoefficients) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping as `matrices`, those of its law in their places.

        `found`: coefficients of the law at a speed.
        """
        stiffness, damping = self.matrices()
        at = list(bearing_laws.law_motions(self.speed_law)) if self.speed_law else []
        for matrix, own in zip((stiffness, damping), found, strict=True):
            matrix[:2, :2] = 0.0
            matrix[np.ix_(at, at)] += own
        return stiffness, damping


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Couple the torsion of two bodies by a gear.

    Kinematically rz of `second` is ratio · rz of `first`; torques follow from the virtual work.

    `name`: unique within the system. `first`, `second`: the two gear seats; both need rz, and ux,
    uy where the mesh has a line of action. `ratio`: speed of `second` over that of `first`,
    negative for an external pair of spur gears. It must be that of the bodies' speed ratios.
    `mesh_stiffness_n_per_m`: along the line of action; None is a rigid mesh, which is eliminated
    exactly. `mesh_damping_n_s_per_m`: along the line of action. `base_radius_first_m`: base circle
    of the first wheel; needed with a mesh stiffness or a line of action. `line_of_action_rad`:
    angle of the line of action across the axis, from +x towards +y, taken in the sense in which a
    positive turn of `first` moves its contact point. None couples torsion alone, as in a planetary
    gear whose planets balance each other.

    The relative motion of the teeth is δ = n·(u1 − u2) + r1 rz1 − (r1 / ratio) rz2, n = (cos, sin)
    of the line of action (Rao, Shiau and Chang 1998; r2 = −r1/ratio for an external pair).
    """

    name: str
    first: End
    second: End
    ratio: float
    mesh_stiffness_n_per_m: float | None = None
    mesh_damping_n_s_per_m: float = 0.0
    base_radius_first_m: float | None = None
    line_of_action_rad: float | None = None

    @property
    def ends(self) -> tuple[End, End]:
        """Both gear seats."""
        return (self.first, self.second)

    def tooth_motion(self) -> tuple[FloatArray, FloatArray]:
        """Return the relative motion of the teeth per motion of the two seats.

        Returns `first`, `second`: shape (6,): factors of ux to rz at the seats.
        """
        radius = 1.0 if self.base_radius_first_m is None else self.base_radius_first_m
        first, second = np.zeros(6), np.zeros(6)
        first[5], second[5] = radius, -radius / self.ratio
        if self.line_of_action_rad is not None:
            direction = np.array([np.cos(self.line_of_action_rad), np.sin(self.line_of_action_rad)])
            first[:2], second[:2] = direction, -direction
        return first, second


@dataclass(frozen=True, kw_only=True)
class InternalDamping:
    """Give a body's material viscous damping, which turns with it.

    C = stiffness_coefficient_s · K + Σ 2 modal_ratio ω (Mφ)(Mφ)ᵀ over the body's free modes at
    rest; the force is C (q' − Ω L q), whose second part drives forward whirl above a threshold
    speed (Genta 2005, Dynamics of Rotating Systems, section 2.5).

    `stiffness_coefficient_s`: β of C = β K, s; `modal_ratio`: fraction of critical damping of each
    elastic free mode.
    """

    stiffness_coefficient_s: float = 0.0
    modal_ratio: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Rotor:
    """Place a superelement in a system.

    `speed_ratio`: its spin speed is speed_ratio · Ω: 1 for the reference shaft, negative for a
    counter-rotating one, 0 for a casing. `internal_damping`: of the body's material; None without.
    """

    element: Superelement
    speed_ratio: float
    internal_damping: InternalDamping | None = None

    def __repr__(self) -> str:
        damped = ", internal damping" if self.internal_damping is not None else ""
        return f"Rotor {self.element.name!r}: {_rotor_facts(self)}{damped}"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class System:
    """Collect the rotors and bearings of an engine.

    `bearings`: between interfaces and the ground. `reference`: name of the shaft whose speed is Ω
    (its ratio must be 1); None when Ω is only a parameter. `gears`: between bodies.
    """

    rotors: Mapping[str, Rotor]
    bearings: tuple[Bearing, ...]
    reference: str | None = None
    gears: tuple[Gear, ...] = ()

    def __repr__(self) -> str:
        return lines_of("System of " + body_count(self), parts_lines(self))


def _rotor_facts(rotor: Rotor) -> str:
    mass = rotor.element.mass_kg
    return f"{rotor.element.level}, {mass:.5g} kg, speed ratio {rotor.speed_ratio:g}"


def _told(name: str, value: Any, unit: str) -> str:
    """A coefficient of a bearing, a number or (2, 2); empty if it is zero."""
    if not np.any(value):
        return ""
    if np.ndim(value) == 0:
        return f"{name} {value:.4g} {unit}"
    (xx, xy), (yx, yy) = value
    if xy or yx:
        return f"{name} [{xx:.4g} {xy:.4g}; {yx:.4g} {yy:.4g}] {unit}"
    return f"{name} {xx:.4g} {unit}" if xx == yy else f"{name} {xx:.4g} in x, {yy:.4g} in y {unit}"


def parts_lines(system: System) -> list[str]:
    """Return bodies and joints, a line each, the last bodies counted where there are many."""
    joints = [_named("bearing", [b.name for b in system.bearings])]
    joints += [_named("gear", [g.name for g in system.gears])] if system.gears else []
    rotors = [f"{name}: {_rotor_facts(rotor)}" for name, rotor in system.rotors.items()]
    more = len(rotors) - MOST_LINES + len(joints)
    if more > 0:
        rotors = [*rotors[: -more - 1], f"and {more + 1} more bodies"]
    return rotors + joints


def _named(what: str, names: Sequence[str]) -> str:
    return f"{count_of(len(names), what)}: {row(names)}" if names else f"no {what}s"


def body_count(system: System) -> str:
    """Return the number of bodies in words."""
    number = len(system.rotors)
    return f"{number} {'body' if number == 1 else 'bodies'}"


def find_problems(system: System) -> tuple[str, ...]:
    """Return one sentence for each fault of a system.

    Returns empty if the system can be assembled.
    """
    problems = list(_rotor_problems(system))
    problems += _repeated("bearing", [bearing.name for bearing in system.bearings])
    for bearing in system.bearings:
        found = list(_number_problems(bearing))
        if not found:
            found += _end_problems(system, bearing)
            found += _rigid_problems(bearing)
            found += _torsion_problems(system, bearing)
        problems += [f"bearing {bearing.name!r}: {text}" for text in found]
    problems += _repeated("gear", [gear.name for gear in system.gears])
    for gear in system.gears:
        found = [*_gear_number_problems(gear), *_gear_end_problems(system, gear)]
        problems += [f"gear {gear.name!r}: {text}" for text in found]
    return tuple(problems)


def _repeated(what: str, names: list[str]) -> Iterator[str]:
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"{what} name {name!r} occurs {names.count(name)} times; use it once"


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
    for name in _COUPLED:
        value = getattr(bearing, name)
        if value.shape != (2, 2):
            yield f"{name} has shape {value.shape}, allowed is (2, 2)"
        elif not np.issubdtype(value.dtype, np.number) or not np.isfinite(value).all():
            yield f"{name} is {value.tolist()}; all numbers must be finite"
    for name in _SCALAR:
        if not np.isfinite(getattr(bearing, name)):
            yield f"{name} is {getattr(bearing, name)}; it must be finite"
    allowed = get_args(CrossCoupling)
    if bearing.cross_coupling not in allowed:
        yield f"cross_coupling is {bearing.cross_coupling!r}; use {list(allowed)}"


def _end_problems(system: System, bearing: Bearing) -> Iterator[str]:
    if bearing.second == bearing.first:
        yield f"both ends are {bearing.first.label}; they must differ"
    stiffness, damping = bearing.matrices()
    used = (stiffness != 0) | (damping != 0)
    needed = [c for i, c in enumerate(MOTIONS) if used[i].any() or used[:, i].any()]
    needed += [c for c in bearing.rigid if c in MOTIONS and c not in needed]
    if bearing.speed_law is not None:
        held = [MOTIONS[at] for at in bearing_laws.law_motions(bearing.speed_law)]
        needed += [c for c in held if c not in needed]
    for end in bearing.ends:
        yield from _seat_problems(system, end, needed)
    if bearing.sensor is not None:
        yield from _seat_problems(system, bearing.sensor, ("ux", "uy"))
        if not hasattr(bearing.speed_law, "sensed_apart"):
            yield f"sensor is {bearing.sensor.label}, but its law is none of a magnetic bearing"


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
