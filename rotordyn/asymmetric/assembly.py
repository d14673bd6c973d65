"""Assembly of engines with asymmetric bodies, in the frame of these.

Coordinates of every body of revolution turn with the frame too, q_fixed = e^{θL} q, which leaves
its matrices constant, and those of an asymmetric body are constant there as they are. A body at
rest of any other shape keeps its fixed coordinates. Only joints then see the angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import Rows, seat_motion
from solidwhirl.rotordyn.assembly.internal_damping import body_damping
from solidwhirl.rotordyn.assembly.joints import independent_coordinates
from solidwhirl.rotordyn.assembly.parts import Bearing, End, Gear, Rotor, System, parts_lines
from solidwhirl.rotordyn.assembly.system import (
    body_slices_of,
    checked_system,
    law_joints,
    law_speed_ratio,
    speed_limit,
)
from solidwhirl.rotordyn.asymmetric.periodic import (
    Harmonics,
    PeriodicSystem,
    Term,
    TurnedLaw,
    in_fixed_axes,
    joint_terms,
    lean,
)
from solidwhirl.rotordyn.asymmetric.standing import PAIRS, interface_turn
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AssemblyError
from solidwhirl.rotordyn.core.reprs import lines_of
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices
from solidwhirl.rotordyn.superelement.record import Superelement

# What a turn may change of matrices of a body of revolution, in coordinates of unit diagonal.
_EVEN = 1e-9
# Smallest diagonal over the largest that is told from rounding.
_ROUNDING = 1e-5
# Speed ratios that differ by less are one.
_SAME_RATIO = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingSystem(ReadOnlyArrays):
    """Hold an engine in the frame that turns with its asymmetric bodies.

    `system`: what was assembled. `periodic`: its matrices; their speed is that of the frame, |m| Ω,
    not negative. `frame_ratio`: m, speed ratio of the asymmetric bodies. `turned`: bodies whose
    coordinates turn with the frame. `transformation`, `body_slices`: as of `AssembledSystem`.
    `speed_limit_rad_s`: largest speed of the frame at which no body runs faster than its basis was
    made for.
    """

    system: System
    periodic: PeriodicSystem
    frame_ratio: float
    turned: frozenset[str]
    transformation: FloatArray
    body_slices: Mapping[str, slice]
    speed_limit_rad_s: float

    def __repr__(self) -> str:
        stride = self.periodic.stride
        kind = f"{stride} periods in a turn" if stride else "constant matrices"
        head = f"RotatingSystem: {self.periodic.size} coordinates, {kind}"
        return lines_of(head, parts_lines(self.system))

    @property
    def sense(self) -> int:
        """1 where the frame turns about +z, −1 about −z."""
        return 1 if self.frame_ratio > 0 else -1

    def keeps_step(self, body: str) -> bool:
        """Whether a body turns with the frame, so that what is fixed to it stands still there."""
        return _same_ratio(self.system.rotors[body].speed_ratio, self.frame_ratio)

    def seat(self, end: End) -> Harmonics:
        """Return ux to rz of an interface in fixed axes by harmonic, (6, n) each."""
        motion = seat_motion(self, end)
        return in_fixed_axes(motion, self.sense) if end.body in self.turned else {0: motion}

    def turning_ends(self) -> list[End]:
        """Return the interfaces with ux and uy of all bodies that turn."""
        return [
            End(body=name, interface=node.name)
            for name, rotor in self.system.rotors.items()
            if rotor.speed_ratio != 0
            for node in rotor.element.interfaces
            if {"ux", "uy"} <= set(rotor.element.components_at(node.name))
        ]

    def relative(self, bearing: Bearing) -> Harmonics:
        """Return ux to rz of a bearing's first side relative to its second, as `seat`."""
        motion = self.seat(bearing.first)
        if bearing.second is not None:
            for harmonic, part in self.seat(bearing.second).items():
                motion[harmonic] = motion[harmonic] - part if harmonic in motion else -part
        return motion

    def fixed(self, rows: FloatArray) -> Harmonics:
        """Return ux to rz of something in fixed axes, as `seat`.

        `rows`: the same in the axes of each body per its coordinates, shape (6, N).
        """
        turned = np.zeros(self.transformation.shape[0], dtype=bool)
        for body in self.turned:
            turned[self.body_slices[body]] = True
        found = in_fixed_axes((rows * turned) @ self.transformation, self.sense)
        still = (rows * ~turned) @ self.transformation
        return {**found, 0: found.get(0, 0.0) + still}


def assemble_rotating(
    rotors: Mapping[str, Rotor],
    bearings: tuple[Bearing, ...],
    reference: str | None = None,
    gears: tuple[Gear, ...] = (),
) -> RotatingSystem:
    """Assemble an engine of which one or more bodies, on one speed, are asymmetric.

    Arguments as of `assemble`. Raises AssemblyError: as there; no such body, or two that turn at
    different speeds; a rigid joint that holds one direction of what turns, or joins it to a body at
    rest that is not of revolution.
    """
    system = checked_system(
        System(
            rotors=dict(rotors), bearings=tuple(bearings), reference=reference, gears=tuple(gears)
        )
    )
    ratio = _frame_ratio(system)
    generators = {name: _generator(rotor) for name, rotor in system.rotors.items()}
    turned = frozenset(name for name, found in generators.items() if found is not None)
    slices = body_slices_of(system)
    _refuse_half_held(system, turned)
    transformation = independent_coordinates(_with_rigid_joints(system), slices)
    _refuse_uneven(transformation, _turns(system, generators))
    rows = Rows(system, slices, transformation)
    velocity, stiffness, acceleration, mass = _body_terms(rows, generators, ratio)
    found = RotatingSystem(
        system=system,
        periodic=PeriodicSystem(mass=mass, velocity=(), stiffness=()),
        frame_ratio=ratio,
        turned=turned,
        transformation=transformation,
        body_slices=slices,
        speed_limit_rad_s=abs(ratio) * speed_limit(system),
    )
    joints = [_bearing_terms(found, bearing) for bearing in system.bearings]
    joints += [_gear_terms(found, gear) for gear in system.gears]
    periodic = PeriodicSystem(
        mass=mass,
        velocity=lean([*velocity, *(t for joint in joints for t in joint[0])]),
        stiffness=lean([*stiffness, *(t for joint in joints for t in joint[1])]),
        acceleration=lean(acceleration),
        laws=tuple(
            law for b in system.bearings if b.speed_law is not None for law in _laws(found, b)
        ),
    )
    return replace(found, periodic=periodic)


def _frame_ratio(system: System) -> float:
    """Speed ratio of the asymmetric bodies."""
    ratios = {n: r.speed_ratio for n, r in system.rotors.items() if r.element.frame == "rotating"}
    if not ratios:
        raise AssemblyError(("no body is asymmetric; `assemble` is for these",))
    still = [name for name, ratio in ratios.items() if ratio == 0]
    if still:
        raise AssemblyError((f"rotors {still} stand still; reduce them as bodies of any shape",))
    first, ratio = next(iter(ratios.items()))
    for name, other in ratios.items():
        if not _same_ratio(other, ratio):
            raise AssemblyError(
                (
                    f"rotors {first!r} and {name!r} are asymmetric and turn at "
                    f"{ratio:g} and {other:g} times the reference speed: no frame leaves both "
                    "constant, and their matrices have no common period; reduce one of them as a "
                    "body of revolution, the one that is nearer to it, and then the other",
                )
            )
    return ratio


def _same_ratio(first: float, second: float) -> bool:
    return abs(first - second) <= _SAME_RATIO * abs(second)


def _generator(rotor: Rotor) -> FloatArray | None:
    """Turn L of the coordinates of a body that turn with the frame; None: they stay."""
    turn = rotor.element.turn
    return None if turn is None or not _is_even(rotor.element, turn) else turn


def _is_even(element: Superelement, turn: FloatArray) -> bool:
    """Whether the matrices of a body are the same after a turn."""
    tie = np.eye(element.size) if element.constraint is None else element.constraint
    own = la.lstsq(tie, turn @ tie)[0]
    names = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    for matrix in (tie.T @ getattr(element, name) @ tie for name in names):
        size = np.maximum(np.abs(np.diag(matrix)), np.abs(matrix).max(axis=1))
        # a row of nothing but rounding has no size of its own
        root = np.sqrt(np.maximum(size, _ROUNDING * size.max()))
        root[root == 0.0] = 1.0
        change = (own.T @ matrix + matrix @ own) / np.outer(root, root)
        if np.abs(change).max() > _EVEN:
            return False
    return True


def _turns(system: System, generators: Mapping[str, FloatArray | None]) -> FloatArray:
    """Turn of the coordinates of all bodies as their interfaces have it, (N, N)."""
    blocks = []
    for name, rotor in system.rotors.items():
        element, turn = rotor.element, generators[name]
        if element.frame == "rotating":
            turn = interface_turn(element)
        blocks.append(np.zeros((element.size,) * 2) if turn is None else turn)
    return np.asarray(la.block_diag(*blocks))


def _refuse_half_held(system: System, turned: frozenset[str]) -> None:
    """Refuse rigid joints that a turn of one of their sides would break."""
    problems = []
    for bearing in system.bearings:
        sides = {end.body in turned for end in bearing.ends}
        if True not in sides:
            continue
        for pair in PAIRS:
            held = [c for c in pair if c in bearing.rigid]
            if len(held) == 1:
                problems.append(
                    f"bearing {bearing.name!r} holds {held[0]} rigidly and not the other of "
                    f"{list(pair)}, at {bearing.first.label}, which turns; give both, or stiffness"
                )
            if held and sides == {True, False}:
                problems.append(
                    f"bearing {bearing.name!r} joins {held} rigidly, of a body that turns and an "
                    "anisotropic one at rest; give it a stiffness"
                )
    if problems:
        raise AssemblyError(tuple(problems))


def _with_rigid_joints(system: System) -> System:
    """The joints that are eliminated, without stiffness."""
    rigid = [
        Bearing(name=b.name, first=b.first, second=b.second, rigid=b.rigid)
        for b in system.bearings
        if b.rigid
    ]
    gears = tuple(g for g in system.gears if g.mesh_stiffness_n_per_m is None)
    return replace(system, bearings=tuple(rigid), gears=gears)


def _refuse_uneven(transformation: FloatArray, turns: FloatArray) -> None:
    """Refuse rigid joints that are not the same in all directions."""
    wanted = turns @ transformation
    found = la.lstsq(transformation, wanted)[0]
    if np.abs(transformation @ found - wanted).max(initial=0.0) > _EVEN:
        raise AssemblyError(
            (
                "rigid joints and gears hold what turns in one direction only; give bearings a "
                "stiffness, and gears a mesh stiffness or no line of action",
            )
        )


class _Spun(NamedTuple):
    """V, K, E and M of a body in its coordinates, by powers of the speed of the frame."""

    velocity: tuple[Matrix, ...]
    stiffness: tuple[Matrix, ...]
    acceleration: Matrix
    mass: Matrix


def _spun(rotor: Rotor, turn: FloatArray | None, frame_ratio: float) -> _Spun:
    """Return the matrices of a body with q_fixed = e^{θL} q, θ' = sp at the speed p of the frame.

    M q'' + [C + p (r G + 2 s M L)] q' + [K + p (s C L + r N) + p² (r² K2 + r s G L + M L²)] q with
    its own speed ratio r over |m|, and p' (½ r G + s M L) q.
    """
    body = free_body_matrices(rotor.element)
    damped = body_damping(rotor, body)
    sense, r = np.sign(frame_ratio), rotor.speed_ratio / abs(frame_ratio)
    own = np.zeros_like(body.mass) if turn is None else turn
    carried = sense * body.mass @ own
    return _Spun(
        velocity=(damped.damping, r * body.gyroscopic + 2.0 * carried),
        stiffness=(
            body.stiffness,
            sense * damped.damping @ own + r * damped.circulatory,
            r**2 * body.centrifugal_stiffness
            + r * sense * body.gyroscopic @ own
            + sense * carried @ own,
        ),
        acceleration=0.5 * r * body.gyroscopic + carried,
        mass=body.mass,
    )


def _body_terms(
    rows: Rows, generators: Mapping[str, FloatArray | None], frame_ratio: float
) -> tuple[list[Term], list[Term], list[Term], FloatArray]:
    """V, K and E of all bodies, and M."""
    n = rows.transformation.shape[1]
    velocity, stiffness, acceleration = ([] for _ in range(3))
    mass = np.zeros((n, n))
    for name, rotor in rows.system.rotors.items():
        at = rows.transformation[rows.body_slices[name]]
        found = _spun(rotor, generators[name], frame_ratio)
        velocity += [Term(0, k, at.T @ a @ at) for k, a in enumerate(found.velocity)]
        stiffness += [Term(0, k, at.T @ a @ at) for k, a in enumerate(found.stiffness)]
        acceleration.append(Term(0, 0, at.T @ found.acceleration @ at))
        mass += at.T @ found.mass @ at
    return velocity, stiffness, acceleration, 0.5 * (mass + mass.T)


def _bearing_terms(found: RotatingSystem, bearing: Bearing) -> tuple[list[Term], list[Term]]:
    """V and K of a bearing, without its speed law."""
    spring, drag = bearing.matrices()
    if bearing.speed_law is not None:
        spring[:2, :2] = drag[:2, :2] = 0.0
    return joint_terms(found.relative(bearing), spring, drag)


def _gear_terms(found: RotatingSystem, gear: Gear) -> tuple[list[Term], list[Term]]:
    """V and K of the teeth of a gear that is not rigid."""
    if gear.mesh_stiffness_n_per_m is None:
        return [], []
    motion: Harmonics = {}
    for end, factor in zip(gear.ends, gear.tooth_motion(), strict=True):
        for harmonic, part in found.seat(end).items():
            seen = (factor @ part)[None, :]
            motion[harmonic] = motion[harmonic] + seen if harmonic in motion else seen
    spring, drag = gear.mesh_stiffness_n_per_m, gear.mesh_damping_n_s_per_m
    return joint_terms(motion, np.array([[spring]]), np.array([[drag]]))


def _laws(found: RotatingSystem, bearing: Bearing) -> Iterator[TurnedLaw]:
    """Yield what the law of a bearing is made of, over the speed of the frame."""
    assert bearing.speed_law is not None
    if bearing.sensor is not None:
        raise AssemblyError(
            (
                f"bearing {bearing.name!r}: beside an asymmetric body the "
                "sensors of a magnetic bearing must be at its magnets",
            )
        )
    motion = found.relative(bearing)
    ratio = law_speed_ratio(found.system, bearing) / abs(found.frame_ratio)
    constant = motion.get(0, np.zeros((6, found.periodic.size))).real
    for joint in law_joints(bearing, ratio, constant):
        seen = {h: joint.rows @ part for h, part in motion.items()}
        yield TurnedLaw(joint, {h: part for h, part in seen.items() if part.any()})
