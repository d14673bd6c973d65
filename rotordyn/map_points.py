"""The points of a critical speed map: one system solved for many stiffness values of bearings."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray, StringArray
from solidwhirl.rotordyn.bearing_laws import PolynomialLaw
from solidwhirl.rotordyn.direct_speeds import direct_speeds
from solidwhirl.rotordyn.errors import AnalysisError, AssemblyError
from solidwhirl.rotordyn.law_pieces import LawPieces
from solidwhirl.rotordyn.map_branches import MapPoint
from solidwhirl.rotordyn.speed_roots import speed_roots
from solidwhirl.rotordyn.system import AssembledSystem, LawJoint, assemble
from solidwhirl.rotordyn.whirl import interface_orbits, whirl_direction
from solidwhirl.rotordyn.whirl_pencils import Pencil, separated_whirl, whirl_pencils

# Stands for "any stiffness" in a bearing without a law, so that the assembly keeps it apart.
_OPEN = PolynomialLaw(
    name="open",
    argument_unit="rad/s",
    argument_range=(0.0, 1.0),
    stiffness_x=(1.0,),
    stiffness_y=(1.0,),
    damping_x=(1.0,),
    damping_y=(1.0,),
)


class MapRequest(NamedTuple):
    """What is wanted: names of bearings, |α|, branches for each whirl, largest Ω."""

    names: tuple[str, ...]
    ratio: float
    branch_count: int | None
    limit: float


class _Factor(NamedTuple):
    """Stiffness (2, 2) of a law over Ω for a base of one, and its pieces."""

    stiffness: Callable[[float], FloatArray]
    pieces: LawPieces | None


class _Family(NamedTuple):
    """The system with the stiffness of the named bearings left open, for a range of stiffness.

    `change` takes its coordinates to those of the first family, shape (n, n); `factors` are the
    laws of its bearings for a base stiffness of one.
    """

    assembled: AssembledSystem
    pencils: tuple[Pencil, ...]
    change: FloatArray
    factors: Mapping[str, _Factor]


class MapSolver:
    """Solve the points of one map, assembling once for each order of the bearing stiffness.

    Parameters
    ----------
    assembled, request
        The system and what is wanted.
    """

    def __init__(self, assembled: AssembledSystem, request: MapRequest) -> None:
        self.assembled, self.request = assembled, request
        others = [b for b in assembled.system.bearings if b.name not in request.names]
        found = {abs(float(k)) for b in others for k in stiffness_at_rest(assembled, b.name)}
        self._steps = np.array(sorted(found - {0.0}))
        self._families: dict[int, _Family] = {}
        self._first: _Family | None = None
        self.reference = self._family(float(self._steps[0]) if self._steps.size else 1.0)

    @property
    def lateral(self) -> tuple[Pencil, ...]:
        """Pencils of the first family but that of axial motion and torsion."""
        return tuple(p for p in self.reference.pencils if p.whirl != "planar")

    def _family(self, stiffness: float) -> _Family:
        """Return the family to which a stiffness belongs."""
        key = int(np.searchsorted(self._steps, stiffness))
        if key not in self._families:
            self._families[key] = self._assembled_family(stiffness)
        return self._families[key]

    def _assembled_family(self, stiffness: float) -> _Family:
        assembled = _opened(self.assembled, self.request.names, stiffness)
        if self._first is None:
            change = np.eye(assembled.size)
        else:
            start = self._first.assembled.transformation
            change = la.lstsq(start, assembled.transformation)[0]
        pencils = whirl_pencils(assembled, self.request.ratio)
        if self._first is None:
            factors = {j.bearing: _factor(j) for j in assembled.law_joints if self._varies(j)}
        else:
            factors = dict(self._first.factors)
        family = _Family(assembled, pencils, change, factors)
        self._first = self._first or family
        return family

    def _varies(self, joint: LawJoint) -> bool:
        return joint.bearing in self.request.names

    def point(self, place: int, stiffness: float) -> MapPoint:
        """Return the critical speeds of one pencil, with shapes in the first family's x."""
        family = self._family(stiffness)
        pencil = _closed(family, place, self.request.names, stiffness)
        speeds, shapes = _solved(pencil, family.assembled.body_rate, self.request.limit)
        full = family.change @ pencil.expand(shapes)
        if pencil.whirl == "":
            moves = _is_lateral(self.reference.assembled, full)
            speeds = speeds[moves]
            full = separated_whirl(self.reference.assembled, speeds, full[:, moves])
        here = full[self.reference.pencils[place].first]
        return MapPoint(stiffness, speeds, here.real if np.isrealobj(shapes) else here)

    def metric(self, place: int, stiffness: float) -> FloatArray:
        """Return the stiffness at rest of one pencil, in the first family's x."""
        return _closed(self.reference, place, self.request.names, stiffness).stiffness_at(0.0)

    def free(self) -> tuple[FloatArray, StringArray]:
        """Return the critical speeds and whirl without the bearings."""
        pencils = [
            _closed(self.reference, place, self.request.names, 0.0)
            for place in range(len(self.lateral))
        ]
        try:
            return _asymptote(self.reference.assembled, pencils, self.request)
        except AnalysisError:
            # A free thin disk may whirl at any speed; then there is no asymptote.
            return np.empty(0), np.empty(0, dtype="<U8")


def _opened(assembled: AssembledSystem, names: Sequence[str], stiffness: float) -> AssembledSystem:
    """Assemble again with a law, and without damping, in the named bearings."""
    system = assembled.system
    bearings = tuple(
        dataclasses.replace(
            bearing,
            stiffness_n_per_m=stiffness * np.eye(2),
            damping_n_s_per_m=np.zeros((2, 2)),
            speed_law=bearing.speed_law or _OPEN,
        )
        if bearing.name in names
        else bearing
        for bearing in system.bearings
    )
    return assemble(system.rotors, bearings, system.reference, system.gears)


def _closed(family: _Family, place: int, names: Sequence[str], stiffness: float) -> Pencil:
    """Return one pencil of a family with a stiffness of the named bearings."""
    pencil = family.pencils[place]
    joints = {joint.bearing: joint for joint in family.assembled.law_joints}
    constant, laws = pencil.stiffness, []
    for law in pencil.laws:
        if law.bearing not in names:
            laws.append(law)
        elif joints[law.bearing].law is _OPEN:
            constant = constant + stiffness * (law.motion.T @ law.motion)
        elif stiffness > 0:
            factor = family.factors[law.bearing]
            scaled = partial(_scaled_law, factor.stiffness, stiffness)
            pieces = None if factor.pieces is None else factor.pieces.times(stiffness)
            laws.append(law._replace(stiffness=scaled, pieces=pieces))
    return pencil._replace(stiffness=constant, laws=tuple(laws))


def _scaled_law(
    factor: Callable[[float], FloatArray], stiffness: float, speed_rad_s: float
) -> FloatArray:
    return stiffness * factor(speed_rad_s)


def _factor(joint: LawJoint) -> _Factor:
    """Return the stiffness of a law for a base of one, computed once for each speed."""
    one = dataclasses.replace(
        joint, stiffness_n_per_m=np.eye(2), damping_n_s_per_m=np.zeros((2, 2))
    )

    @cache
    def stiffness(speed_rad_s: float) -> FloatArray:
        return one.coefficients(speed_rad_s)[0]

    return _Factor(stiffness, one.pieces)


def _solved(
    pencil: Pencil, body_rate: float, limit: float
) -> tuple[FloatArray, FloatArray | ComplexArray]:
    """Return critical speeds and shapes: all for constant bearings, else up to the limit."""
    if pencil.laws:
        roots = speed_roots(pencil, body_rate, limit)
        return roots.speeds_rad_s, roots.shapes
    found = direct_speeds(pencil, pencil.stiffness, body_rate, np.inf)
    return found.speeds_rad_s, found.shapes


def _is_lateral(assembled: AssembledSystem, shapes: ComplexArray) -> npt.NDArray[np.bool_]:
    orbits = interface_orbits(assembled, shapes)
    return np.asarray((np.abs(orbits.x) + np.abs(orbits.y)).max(axis=0) > 0)


def _asymptote(
    assembled: AssembledSystem, pencils: Sequence[Pencil], request: MapRequest
) -> tuple[FloatArray, StringArray]:
    """Return the lowest lateral critical speeds of a system without open bearings."""
    speeds, whirl = [], []
    for pencil in pencils:
        found, shapes = _solved(pencil, assembled.body_rate, request.limit)
        full = pencil.expand(shapes)
        kept = np.flatnonzero(_is_lateral(assembled, full) & (found <= request.limit))
        if request.branch_count is not None:
            kept = kept[: request.branch_count * (1 if pencil.whirl else 2)]
        speeds.append(found[kept])
        direction = whirl_direction(
            assembled, separated_whirl(assembled, found[kept], full[:, kept])
        )
        whirl.append(np.full(kept.size, pencil.whirl) if pencil.whirl else direction)
    together = np.concatenate(speeds)
    order = np.argsort(together, kind="stable")
    return together[order], np.concatenate(whirl)[order]


def rigid_speeds(assembled: AssembledSystem, request: MapRequest) -> tuple[FloatArray, StringArray]:
    """Return the critical speeds and whirl with the named bearings rigid."""
    system = assembled.system
    zero = np.zeros((2, 2))
    bearings = tuple(
        dataclasses.replace(
            bearing,
            stiffness_n_per_m=zero,
            damping_n_s_per_m=zero,
            speed_law=None,
            rigid=tuple(dict.fromkeys((*bearing.rigid, "ux", "uy"))),
        )
        if bearing.name in request.names
        else bearing
        for bearing in system.bearings
    )
    try:
        held = assemble(system.rotors, bearings, system.reference, system.gears)
    except AssemblyError:
        # Rigid joints leave nothing that can move.
        return np.empty(0), np.empty(0, dtype="<U8")
    pencils = [p for p in whirl_pencils(held, request.ratio) if p.whirl != "planar"]
    return _asymptote(held, pencils, request)


def stiffness_at_rest(assembled: AssembledSystem, name: str) -> FloatArray:
    """Return k_xx and k_yy of a bearing at rest, shape (2,)."""
    bearing = next(b for b in assembled.system.bearings if b.name == name)
    stiffness = bearing.stiffness_n_per_m
    for joint in assembled.law_joints:
        if joint.bearing == name:
            stiffness = joint.coefficients(0.0)[0]
    return np.diag(stiffness).astype(float)
