"""Assembly of rotors and bearings into the matrices of one system.

Joined coordinates are written as "that of the neighbour plus a relative motion", along the stiffest
path. A rigid joint drops the relative motion; a stiff bearing acts on it alone, so that its number
is never added to, and never swallows, the stiffness of the bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.errors import AssemblyError
from solidwhirl.rotordyn.free_body import free_body_matrices, free_body_problems
from solidwhirl.rotordyn.parts import Bearing, End, Rotor, System
from solidwhirl.rotordyn.parts_checks import find_problems
from solidwhirl.rotordyn.superelement_checks import MOTIONS

__all__ = [
    "AssembledSystem",
    "Bearing",
    "End",
    "Rotor",
    "SpeedMatrices",
    "System",
    "assemble",
    "matrices_at_speed",
]

GROUND = -1


class SpeedMatrices(NamedTuple):
    """M, C, Ω-scaled G and K of the system at one speed, each (n, n)."""

    mass: FloatArray
    damping: FloatArray
    gyroscopic: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class AssembledSystem:
    """Hold the matrices of a system in n independent coordinates, affine in the speed Ω.

    M q'' + (C + Ω G) q' + (K + Ω² K2) q = f in the inertial frame.

    Attributes
    ----------
    system
        What was assembled.
    mass, stiffness, damping
        M, K (elastic, with bearings) and C, shape (n, n).
    gyroscopic
        Σ n_i G_i with the speed ratios n_i, shape (n, n).
    centrifugal_stiffness
        K2 = Σ n_i² (Kgeo − S)_i, shape (n, n).
    transformation
        Coordinates of all bodies from the n independent ones, shape (N, n), entries 0 and 1.
    body_slices
        Rows of `transformation` that belong to each body.
    speed_limit_rad_s
        Largest |Ω| at which no body runs faster than its basis was made for.
    body_rate
        Largest K_ii / M_ii of the bodies without bearings, (rad/s)²; the rounding in K is of the
        order of eps times that.
    """

    system: System
    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    centrifugal_stiffness: FloatArray
    damping: FloatArray
    transformation: FloatArray
    body_slices: Mapping[str, slice]
    speed_limit_rad_s: float
    body_rate: float

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "mass",
            "stiffness",
            "gyroscopic",
            "centrifugal_stiffness",
            "damping",
            "transformation",
        )

    @property
    def size(self) -> int:
        """Number of independent coordinates n."""
        return int(self.mass.shape[0])

    @property
    def is_conservative(self) -> bool:
        """Whether there is no damping and K is symmetric."""
        symmetric = np.array_equal(self.stiffness, self.stiffness.T)
        return symmetric and not self.damping.any()


def assemble(
    rotors: Mapping[str, Rotor], bearings: tuple[Bearing, ...], reference: str | None = None
) -> AssembledSystem:
    """Assemble rotors and bearings.

    Parameters
    ----------
    rotors
        By name.
    bearings
        Joints between them and to the ground.
    reference
        Name of the shaft whose speed is Ω; None when Ω is only a parameter.

    Returns
    -------
    AssembledSystem
        All matrices; exact constraints are eliminated.

    Raises
    ------
    AssemblyError
        If names, components or shapes do not fit; all faults are listed at once.
    """
    system = System(rotors=dict(rotors), bearings=tuple(bearings), reference=reference)
    problems = find_problems(system)
    for name, rotor in system.rotors.items():
        problems += tuple(f"rotor {name!r}: {text}" for text in free_body_problems(rotor.element))
    if problems:
        raise AssemblyError(problems)
    slices = _body_slices(system)
    transformation = _transformation(system, slices)
    if transformation.shape[1] == 0:
        raise AssemblyError(("the rigid bearings hold every coordinate; nothing can move",))

    bodies = {name: free_body_matrices(rotor.element) for name, rotor in system.rotors.items()}

    def joined(name: str, power: int) -> FloatArray:
        blocks = [
            rotor.speed_ratio**power * getattr(bodies[key], name)
            for key, rotor in system.rotors.items()
        ]
        return np.asarray(transformation.T @ la.block_diag(*blocks) @ transformation)

    supports, damping = _bearing_matrices(system, slices, transformation)
    gyroscopic = joined("gyroscopic", 1)
    limits = [
        rotor.element.maximum_speed_rad_s / abs(rotor.speed_ratio)
        for rotor in system.rotors.values()
        if rotor.speed_ratio != 0
    ]
    return AssembledSystem(
        system=system,
        mass=_even(joined("mass", 0)),
        stiffness=_even(joined("stiffness", 0)) + supports,
        gyroscopic=0.5 * (gyroscopic - gyroscopic.T),
        centrifugal_stiffness=_even(joined("centrifugal_stiffness", 2)),
        damping=damping,
        transformation=transformation,
        body_slices=slices,
        speed_limit_rad_s=min(limits, default=np.inf),
        body_rate=max(
            float(np.max(np.diag(r.element.stiffness) / np.diag(r.element.mass)))
            for r in system.rotors.values()
        ),
    )


def matrices_at_speed(assembled: AssembledSystem, speed_rad_s: float) -> SpeedMatrices:
    """Return the matrices of a system at one speed.

    Parameters
    ----------
    assembled
        The system.
    speed_rad_s
        Ω, rad/s.

    Returns
    -------
    SpeedMatrices
        M, C, ΩG and K + Ω²K2.
    """
    return SpeedMatrices(
        mass=assembled.mass,
        damping=assembled.damping,
        gyroscopic=speed_rad_s * assembled.gyroscopic,
        stiffness=assembled.stiffness + speed_rad_s**2 * assembled.centrifugal_stiffness,
    )


def _even(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (matrix + matrix.T))


def _body_slices(system: System) -> dict[str, slice]:
    slices: dict[str, slice] = {}
    start = 0
    for name, rotor in system.rotors.items():
        slices[name] = slice(start, start + rotor.element.size)
        start += rotor.element.size
    return slices


def _coordinate(system: System, slices: Mapping[str, slice], body: str, at: str, c: str) -> int:
    return int(slices[body].start) + system.rotors[body].element.interface_index(at, c)


class _Link(NamedTuple):
    """An edge between two coordinates (or the ground) of a given strength; inf is rigid."""

    strength: float
    first: int
    second: int


def _links(system: System, slices: Mapping[str, slice]) -> list[_Link]:
    """Return all joints between coordinates, strongest first."""
    links = []
    for bearing in system.bearings:
        stiffness, _ = bearing.matrices()
        for at, component in enumerate(MOTIONS):
            strength = np.inf if component in bearing.rigid else abs(stiffness[at, at])
            if strength == 0:
                continue
            ends = [
                _coordinate(system, slices, e.body, e.interface, component) for e in bearing.ends
            ]
            links.append(_Link(strength, ends[0], ends[1] if len(ends) == 2 else GROUND))
    return sorted(links, key=lambda link: -link.strength)


def _transformation(system: System, slices: Mapping[str, slice]) -> FloatArray:
    """Return the matrix from independent to body coordinates, shape (N, n).

    Each coordinate is that of its neighbour in a maximum spanning tree of the links plus, unless
    the link is rigid, a relative motion of its own, which is the independent coordinate.
    """
    total = max(at.stop for at in slices.values())
    tree = _spanning_tree(total, _links(system, slices))
    parents: dict[int, tuple[int, float]] = {}
    order = []
    # The ground comes first, so that a tree that reaches it starts there.
    for start in range(GROUND, total):
        if start in parents:
            continue
        parents[start] = (GROUND, 0.0)
        waiting = [start]
        while waiting:
            here = waiting.pop()
            order.append(here)
            for there, strength in tree[here]:
                if there not in parents:
                    parents[there] = (here, strength)
                    waiting.append(there)
    moving = [i for i in range(total) if np.isfinite(parents[i][1])]
    columns = {coordinate: column for column, coordinate in enumerate(moving)}
    matrix = np.zeros((total + 1, len(moving)))
    # Row −1 is the ground and stays zero.
    for i in order[1:]:
        matrix[i] = matrix[parents[i][0]]
        if i in columns:
            matrix[i, columns[i]] = 1.0
    return matrix[:total]


def _spanning_tree(total: int, links: list[_Link]) -> dict[int, list[tuple[int, float]]]:
    """Return the neighbours of each coordinate and of the ground in the strongest tree."""
    group = {i: i for i in range(GROUND, total)}
    tree: dict[int, list[tuple[int, float]]] = {i: [] for i in range(GROUND, total)}

    def root(i: int) -> int:
        while group[i] != i:
            group[i] = group[group[i]]
            i = group[i]
        return i

    for link in links:
        first, second = root(link.first), root(link.second)
        if first != second:
            group[first] = second
            tree[link.first].append((link.second, link.strength))
            tree[link.second].append((link.first, link.strength))
    return tree


def _bearing_matrices(
    system: System, slices: Mapping[str, slice], transformation: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the stiffness and damping of all bearings in the independent coordinates."""
    n = transformation.shape[1]
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    for bearing in system.bearings:
        relative = np.zeros((6, n))
        for side, end in enumerate(bearing.ends):
            sign = 1.0 if side == 0 else -1.0
            has = system.rotors[end.body].element.components_at(end.interface)
            for at, component in enumerate(MOTIONS):
                if component in has:
                    row = _coordinate(system, slices, end.body, end.interface, component)
                    relative[at] += sign * transformation[row]
        k, c = bearing.matrices()
        stiffness += relative.T @ k @ relative
        damping += relative.T @ c @ relative
    return stiffness, damping
