"""Whirl of modes, from their kind and the orbits of the interface nodes; what excites them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import Placed, seat_motion
from solidwhirl.rotordyn.assembly.parts import End, System
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    StringArray,
    real_times,
    together,
)
from solidwhirl.rotordyn.modes.kinds import (
    energy_shares,
    kind_words,
    kinds,
    moves_laterally,
    moves_torsionally,
)

# Orbits smaller than this fraction of the largest of the mode do not decide.
_SMALL_ORBIT = 1e-2
# An orbit whose minor axis is below this fraction of the major one is a line.
_LINE = 1e-3
# Translations below this fraction of what the tilt would give over the rotor's length are none.
_NO_TRANSLATION = 1e-9
# Eigenvalues closer than this (relative) are one.
_EQUAL = 1e-8
# Shapes of equal eigenvalues nearer to dependent than this (squared) are one shape.
_DEPENDENT = 1e-8
# Lateral motion below this fraction of axial motion and torsion is none.
_NO_LATERAL = 1e-6
# Circles below this fraction of the largest orbit of the mode are rounding.
_NO_CIRCLE = 1e-6


class Orbits(NamedTuple):
    """Complex amplitudes of the interface nodes along x and y, each (nodes, m), in metres."""

    x: ComplexArray
    y: ComplexArray


class Motion(NamedTuple):
    """How modes move: `whirl` of m modes, and `shares` of their energy by family, (m, 4)."""

    whirl: StringArray
    shares: FloatArray


def whirl_direction(assembled: AssembledSystem, shapes: ComplexArray) -> StringArray:
    """Tell whether the orbits of each mode turn with the reference shaft or against it.

    `shapes`: modes φ of q = φ e^{iωt}, ω > 0, in its independent coordinates, shape (n, m). Shape
    (m,): "forward" if all orbits turn with +Ω, "backward" if all turn against it, "mixed" if some
    do either, "straight" if all are lines. Modes without lateral motion have none of these but
    their kind: "torsional", "axial", "disk", or "coupled" of these.

    An orbit is the sum of a forward circle of radius |X + iY|/2 and a backward one of |X − iY|/2.
    Orbits at all interface nodes count, save those below 1/100 of the largest; a line is one with
    an axis ratio below 1/1000. Where no interface node translates, the path of the tilting axis
    is taken.
    """
    return motion_of(assembled, shapes).whirl


def motion_of(assembled: AssembledSystem, shapes: ComplexArray) -> Motion:
    """Return `whirl_direction` and `energy_shares` of modes; `shapes`: as there, (n, m)."""
    shares = energy_shares(assembled, shapes)
    orbits = interface_orbits(assembled, shapes)
    forward = 0.5 * np.abs(orbits.x + 1j * orbits.y)
    backward = 0.5 * np.abs(orbits.x - 1j * orbits.y)
    major = forward + backward
    counts = (major >= _SMALL_ORBIT * major.max(axis=0, initial=0.0)) & (major > 0)
    round_orbit = counts & (np.abs(forward - backward) >= _LINE * major)
    any_forward = (round_orbit & (forward > backward)).any(axis=0)
    any_backward = (round_orbit & (forward < backward)).any(axis=0)
    sense = np.select(
        [any_forward & any_backward, any_forward, any_backward],
        ["mixed", "forward", "backward"],
        default="straight",
    )
    return Motion(np.where(moves_laterally(shares), sense, kinds(shares)), shares)


def motion_at_speed(
    assembled: AssembledSystem,
    shapes: ComplexArray,
    eigenvalues: ComplexArray,
    speed_rad_s: float,
) -> Motion:
    """Return how modes move relative to the turning reference shaft, as `motion_of`.

    `shapes`, `eigenvalues`: modes at the speed, shapes (n, m) and (m,). `speed_rad_s`: Ω, rad/s. At
    rest lateral motion of a system without damping, or that shares its eigenvalue with another, is
    "straight": any orbit is made of lines there, and none has a sense.
    """
    found = motion_of(assembled, shapes)
    return found._replace(whirl=turned_with_speed(assembled, found.whirl, eigenvalues, speed_rad_s))


def turned_with_speed(
    assembled: AssembledSystem,
    directions: StringArray,
    eigenvalues: ComplexArray,
    speed_rad_s: float,
) -> StringArray:
    """Return `whirl_direction` of all modes at a speed as `motion_at_speed` tells it, (m,)."""
    if speed_rad_s == 0:
        near = _equal(eigenvalues)
        lines = (near.sum(axis=1) > 1) | assembled.is_conservative
        whirls = np.isin(directions, ("forward", "backward", "mixed"))
        return np.where(lines & whirls, "straight", directions)
    if speed_rad_s < 0:
        swap = {"forward": "backward", "backward": "forward"}
        return np.array([swap.get(str(d), str(d)) for d in directions], dtype=directions.dtype)
    return directions


def separated_whirl(
    assembled: AssembledSystem,
    values: FloatArray | ComplexArray,
    shapes: ComplexArray,
) -> ComplexArray:
    """Turn modes of equal eigenvalues into those that whirl forward and backward the most.

    Any combination of equal modes is a mode, and an eigensolver returns any. Where the system is
    isotropic these are circles: a forward and a backward one of each pair.

    `shapes`: in its independent coordinates, shape (n, m). `values`: eigenvalues, or critical
    speeds, shape (m,); those closer than 1e-8 (relative) are equal. Returns shape (n, m). Each in
    the column of the mode that it has most of.

    The circles of all interface nodes, Σ |X + iY|² − |X − iY|² of translation and tilt, are
    diagonalised in the span of the group, with M as its metric, in which modes of opposite whirl
    are orthogonal. A mode that is there twice (one that touches the excitation) is left alone.
    """
    result = shapes.astype(complex)
    for group in together(_equal(values)):
        if group.size == 1:
            continue
        own = result[:, group]
        own = own / np.sqrt((own.conj() * (assembled.mass @ own)).sum(axis=0).real)
        metric = own.conj().T @ (assembled.mass @ own)
        if la.eigvalsh(metric)[0] < _DEPENDENT:
            continue
        turns = la.eigh(_net_circles(assembled, own), metric)[1]
        _, order = scipy.optimize.linear_sum_assignment(-np.abs(turns))
        result[:, group] = own @ turns[:, order]
    return result


def _equal(values: FloatArray | ComplexArray) -> BoolArray:
    return np.asarray(np.abs(values[:, None] - values) <= _EQUAL * np.abs(values))


def _net_circles(assembled: AssembledSystem, shapes: ComplexArray) -> ComplexArray:
    """Return the form of forward less backward circles of all interface nodes, (m, m)."""
    translation, tilt = _translation_and_tilt(assembled, shapes)
    x, y = np.concatenate((translation, tilt)).swapaxes(0, 1)
    forward, backward = x + 1j * y, x - 1j * y
    return np.asarray(forward.conj().T @ forward - backward.conj().T @ backward)


def interface_orbits(assembled: AssembledSystem, shapes: ComplexArray) -> Orbits:
    """Return the motion of the interface nodes in the plane across the axis.

    `shapes`: modes in its independent coordinates, shape (n, m). The result is of the nodes, body
    by body; of the tilting axis at one rotor length for modes in which no node translates; zero for
    modes without lateral motion.
    """
    translation, tilt = _translation_and_tilt(assembled, shapes)
    motion, length = _interface_motion(assembled, shapes), rotor_length(assembled.system)
    largest = np.abs(translation).max(axis=(0, 1), initial=0.0)
    tilted = np.abs(tilt).max(axis=(0, 1), initial=0.0)
    other = np.maximum(
        np.abs(motion[:, 2]).max(axis=0, initial=0.0),
        length * np.abs(motion[:, 5]).max(axis=0, initial=0.0),
    )
    path = np.where(largest > _NO_TRANSLATION * tilted, translation, tilt)
    lateral = np.maximum(largest, tilted) > _NO_LATERAL * other
    path = np.where(lateral, path, 0.0)
    return Orbits(path[:, 0], path[:, 1])


def _translation_and_tilt(
    assembled: AssembledSystem, shapes: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return (x, y) of all interface nodes and of the tilting axis at one rotor length.

    Each (nodes, 2, m), in metres.
    """
    motion = _interface_motion(assembled, shapes)
    tip = motion[:, [4, 3]] * np.array([[1], [-1]])
    return motion[:, :2], rotor_length(assembled.system) * tip


def _interface_motion(assembled: AssembledSystem, shapes: ComplexArray) -> ComplexArray:
    """Return ux, uy, uz, rx, ry, rz of all interface nodes, shape (nodes, 6, m)."""
    rows = interface_rows_of_all(assembled)
    return np.asarray(real_times(rows, shapes).reshape(len(rows) // 6, 6, shapes.shape[1]))


# Wanted at every speed of a diagram, and the same for all of them.
@lru_cache(maxsize=4)
def interface_rows_of_all(assembled: Placed) -> FloatArray:
    """Return the motions of all interface nodes per independent coordinate, (6 nodes, n)."""
    nodes = [
        seat_motion(assembled, End(body=name, interface=node.name))
        for name, rotor in assembled.system.rotors.items()
        for node in rotor.element.interfaces
    ]
    return np.array(nodes).reshape(-1, assembled.transformation.shape[1])


def rotor_length(system: System) -> float:
    """Return the length of the longest body between its interfaces, or of its gyration, m."""
    lengths = []
    for rotor in system.rotors.values():
        positions = [node.position_m[2] for node in rotor.element.interfaces]
        gyration = np.sqrt(np.abs(rotor.element.inertia_kg_m2).max() / rotor.element.mass_kg)
        lengths.append(max(float(np.ptp(positions)) if positions else 0.0, float(gyration)))
    return max(lengths)


class Excitation(NamedTuple):
    """What of some bodies can excite a mode.

    `exciters`: "unbalance", "torque"; empty: neither. `bodies`: those whose unbalance does. `why`:
    why an unbalance does or does not.
    """

    exciters: tuple[str, ...]
    bodies: tuple[str, ...]
    why: str

    @property
    def excited(self) -> bool:
        """Whether an unbalance of one of the bodies excites the mode."""
        return "unbalance" in self.exciters


def excitation_by(
    assembled: AssembledSystem, shape: ComplexArray, bodies: Sequence[str]
) -> Excitation:
    """Tell what of some bodies that turn can excite a mode.

    `shape`: mode φ of q = φ e^{iωt}, ω > 0, in its independent coordinates, shape (n,).

    Unbalance acts on lateral motion of its body, and of coupled modes on their lateral part; a
    torque on torsion. What else a mode of another kind moves is too little to be excited by it.

    An unbalance turns with its body. In an isotropic system orbits of modes are circles, and those
    that turn the other way take no energy from it; otherwise orbits are ellipses, which hold a
    circle of either direction.

    The work of the rotating force on q = φ e^{iωt} is proportional to the part of the orbit that
    turns with it, |X + iY|/2 for a body that turns with the reference shaft and |X − iY|/2 for
    one that turns against it (Genta 2005, Dynamics of Rotating Systems, section 5.7).
    """
    shares = energy_shares(assembled, shape[:, None])[0]
    turning = [b for b in bodies if assembled.system.rotors[b].speed_ratio != 0]
    twisted: tuple[str, ...] = ()
    if moves_torsionally(shares) and _twists(assembled, shape, turning):
        twisted = ("torque",)
    if not moves_laterally(shares):
        why = f"{kind_words(shares)}: unbalance excites lateral motion"
        return Excitation(twisted, (), why)
    with_shaft = tuple(b for b in turning if _circle(assembled, shape, b, 1.0))
    if with_shaft:
        why = "orbits have a part that turns with the shaft"
        return Excitation(("unbalance", *twisted), with_shaft, why)
    if any(_circle(assembled, shape, body, -1.0) for body in turning):
        return Excitation(twisted, (), "orbits are circles that turn against the shaft")
    return Excitation(twisted, (), "the mode does not move the shaft")


def _twists(assembled: AssembledSystem, shape: ComplexArray, bodies: Sequence[str]) -> bool:
    """Whether an interface of one of some bodies turns about the axis."""
    turn = np.abs(_interface_motion(assembled, shape[:, None])[:, 5, 0])
    own = np.isin(_owners(assembled), bodies)
    return bool(turn[own].max(initial=0.0) > _NO_CIRCLE * turn.max(initial=0.0))


def _owners(assembled: AssembledSystem) -> list[str]:
    """Return the body of each interface node."""
    rotors = assembled.system.rotors
    return [name for name, rotor in rotors.items() for _ in rotor.element.interfaces]


def _circle(assembled: AssembledSystem, shape: ComplexArray, body: str, turn: float) -> bool:
    """Whether the orbits of a body have a part that turns with it (turn 1) or against it (−1)."""
    orbits = interface_orbits(assembled, shape[:, None])
    own = np.isin(_owners(assembled), body)
    sense = turn * np.sign(assembled.system.rotors[body].speed_ratio)
    circles = 0.5 * np.abs(orbits.x + 1j * sense * orbits.y)[own]
    largest = np.maximum(np.abs(orbits.x), np.abs(orbits.y)).max()
    return bool(circles.max(initial=0.0) > _NO_CIRCLE * largest)
