"""Critical speed map: undamped critical speeds over the stiffness of chosen bearings."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.bearing_laws import PolynomialLaw
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    LawJoint,
    assemble,
    bearing_matrices,
)
from solidwhirl.rotordyn.core.arrays import (
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
    StringArray,
)
from solidwhirl.rotordyn.core.errors import AnalysisError, AssemblyError
from solidwhirl.rotordyn.core.reprs import row
from solidwhirl.rotordyn.critical_speeds.map_supports import uncoupled_supports
from solidwhirl.rotordyn.critical_speeds.search import checked_excitation
from solidwhirl.rotordyn.critical_speeds.speed_roots import speed_roots
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    ALONG_AXIS,
    Pencil,
    direct_speeds,
    whirl_pencils,
)
from solidwhirl.rotordyn.modes.kinds import energy_shares, moves_laterally
from solidwhirl.rotordyn.modes.whirl import separated_whirl, whirl_direction

# Below this MAC a step of stiffness is halved, and two shapes are not the same branch.
_GOOD, _POOR = 0.8, 0.4
# Halvings of one step, and of one on which branches begin or end, which no step is too small for.
_HALVINGS, _HALVINGS_AT_ENDS = 5, 1
# Speeds closer than this (relative) are one cluster, whose shapes are free to turn.
_SAME_SPEED = 1e-7


class MapPoint(NamedTuple):
    """Critical speeds at one stiffness, rising, shape (r,), and their shapes, (m, r)."""

    stiffness: float
    speeds: FloatArray
    shapes: FloatArray | ComplexArray


class MapBranches(NamedTuple):
    """Column of each branch at each stiffness, −1 where there is none, and its MAC.

    Both have shape (b, s); the MAC to the previous stiffness is 1 where a branch begins.
    """

    columns: IntArray
    mac: FloatArray


class _Pairs(NamedTuple):
    """Partner of each column of the first point in the second (−1: none), and the MAC."""

    second: MapPoint
    partner: IntArray
    mac: FloatArray


def follow_branches(
    points: list[MapPoint],
    solve: Callable[[float], MapPoint],
    metric: Callable[[float], FloatArray],
    wanted: int,
) -> tuple[list[MapPoint], MapBranches]:
    """Pair the critical speeds of successive stiffness values.

    `points`: at rising stiffness; `solve`: gives a point between two others, for steps on which
    shapes change much; `metric`: stiffness matrix (m, m) in whose energy product shapes are
    compared, at a stiffness; `wanted`: steps are halved for the sake of this many of the lowest
    speeds. Returns `points`: those given, with shapes of equal speeds turned to match their
    neighbours. Returns `branches`: all branches, also those that begin or end on the way.
    """
    turned = [points[0]]
    columns = [[int(c)] for c in range(points[0].speeds.size)]
    mac = [[1.0] for _ in columns]
    for place, point in enumerate(points[1:], start=1):
        pairs = _advance(turned[-1], point, solve, metric, wanted, _HALVINGS)
        turned.append(pairs.second)
        taken = set()
        for branch, score in zip(columns, mac, strict=True):
            here = branch[-1]
            there = int(pairs.partner[here]) if here >= 0 else -1
            branch.append(there)
            score.append(float(pairs.mac[here]) if there >= 0 else 0.0)
            taken.add(there)
        for new in sorted(set(range(point.speeds.size)) - taken):
            columns.append([-1] * place + [new])
            mac.append([0.0] * place + [1.0])
    shape = (len(columns), len(points))
    return turned, MapBranches(
        np.array(columns, dtype=int).reshape(shape), np.array(mac).reshape(shape)
    )


def _advance(
    first: MapPoint,
    second: MapPoint,
    solve: Callable[[float], MapPoint],
    metric: Callable[[float], FloatArray],
    wanted: int,
    halvings: int,
) -> _Pairs:
    """Pair two points, by way of the middle where shapes change much."""
    middle = float(np.sqrt(first.stiffness * second.stiffness))
    pairs = _paired(first, second, metric(middle))
    if first.speeds.size != second.speeds.size:
        halvings = min(halvings, _HALVINGS_AT_ENDS)
    if halvings == 0 or not _doubtful(pairs, wanted):
        return pairs
    before = _advance(first, solve(middle), solve, metric, wanted, halvings - 1)
    after = _advance(before.second, second, solve, metric, wanted, halvings - 1)
    partner, mac = np.full(first.speeds.size, -1), np.zeros(first.speeds.size)
    for here, between in enumerate(before.partner):
        if between >= 0 and after.partner[between] >= 0:
            partner[here] = after.partner[between]
            mac[here] = min(before.mac[here], after.mac[between])
    return _Pairs(after.second, partner, mac)


def _doubtful(pairs: _Pairs, wanted: int) -> bool:
    """Whether one of the lowest speeds of either point has no good partner."""
    unmatched = np.setdiff1d(np.arange(pairs.second.speeds.size), pairs.partner)
    return bool((pairs.mac[:wanted] < _GOOD).any() or (unmatched < wanted).any())


def _paired(first: MapPoint, second: MapPoint, metric: FloatArray) -> _Pairs:
    """Pair by the best total MAC; among equal shapes the nearer speed is preferred."""
    one, two = _unit(first.shapes, metric), _unit(second.shapes, metric)
    product = one.conj().T @ metric @ two
    for cluster in _clusters(second.speeds):
        if first.speeds.size < cluster.size:
            continue
        rows = np.argsort(-(np.abs(product[:, cluster]) ** 2).sum(axis=1), kind="stable")
        left, _, right = la.svd(product[np.sort(rows[: cluster.size])][:, cluster])
        turn = (left @ right).conj().T
        two[:, cluster] = two[:, cluster] @ turn
        product[:, cluster] = product[:, cluster] @ turn
    mac = np.minimum(np.abs(product) ** 2, 1.0)
    distance = np.abs(np.log(np.divide.outer(first.speeds, second.speeds)))
    rows, columns = scipy.optimize.linear_sum_assignment(-mac * np.exp(-distance))
    partner, found = np.full(first.speeds.size, -1), np.zeros(first.speeds.size)
    for left, right in zip(rows, columns, strict=True):
        if mac[left, right] > _POOR:
            partner[left], found[left] = right, mac[left, right]
    return _Pairs(second._replace(shapes=two), partner, found)


def _unit(shapes: FloatArray | ComplexArray, metric: FloatArray) -> FloatArray | ComplexArray:
    """Return shapes of unit energy."""
    energy = np.einsum("im,im->m", shapes.conj(), metric @ shapes).real
    return np.asarray(shapes / np.sqrt(energy))


def _clusters(speeds: FloatArray) -> list[IntArray]:
    """Return groups of two and more columns of equal speed."""
    ends = np.flatnonzero(np.diff(speeds) > _SAME_SPEED * speeds[1:]) + 1
    groups = np.split(np.arange(speeds.size), ends)
    return [group for group in groups if group.size > 1]


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


class _Family(NamedTuple):
    """The system with the stiffness of the named bearings left open, for a range of stiffness.

    `change` takes its coordinates to those of the first family, shape (n, n).
    """

    assembled: AssembledSystem
    pencils: tuple[Pencil, ...]
    change: FloatArray


class MapSolver:
    """Solve the points of one map, assembling once for each order of the bearing stiffness."""

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
        return tuple(p for p in self.reference.pencils if p.whirl != ALONG_AXIS)

    def _family(self, stiffness: float) -> _Family:
        """Return the family to which a stiffness belongs."""
        key = int(np.searchsorted(self._steps, stiffness))
        if key not in self._families:
            self._families[key] = self._assembled_family(stiffness)
        return self._families[key]

    def _assembled_family(self, stiffness: float) -> _Family:
        assembled = _opened(self.assembled, self.request.names, stiffness)
        change = np.eye(assembled.size)
        if self._first is not None:
            start = self._first.assembled.transformation
            change = la.lstsq(start, assembled.transformation)[0]
        family = _Family(assembled, whirl_pencils(assembled, self.request.ratio), change)
        self._first = self._first or family
        return family

    def point(self, place: int, stiffness: float) -> MapPoint:
        """Return the critical speeds of one pencil, with shapes in the first family's x."""
        family = self._family(stiffness)
        pencil = _closed(family, place, self.request.names, stiffness)
        speeds, shapes = _solved(pencil, family.assembled.body_rate, self.request.limit)
        full = family.change @ pencil.expand(shapes)
        if pencil.whirl == "":
            moves = moves_laterally(energy_shares(self.reference.assembled, full))
            speeds = speeds[moves]
            full = separated_whirl(self.reference.assembled, speeds, full[:, moves])
        here = self.reference.pencils[place].reduced(full)
        return MapPoint(stiffness, speeds, here if here.imag.any() else here.real)

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
    return _reassembled(
        assembled,
        names,
        lambda bearing: dataclasses.replace(
            bearing,
            stiffness_n_per_m=stiffness * np.eye(2),
            damping_n_s_per_m=np.zeros((2, 2)),
            # a table has its own values, which the map replaces
            speed_law=bearing.speed_law if _scales(bearing) else _OPEN,
            sensor=None,
        ),
    )


def _scales(bearing: Bearing) -> bool:
    return isinstance(bearing.speed_law, PolynomialLaw)


def _reassembled(
    assembled: AssembledSystem, names: Sequence[str], change: Callable[[Bearing], Bearing]
) -> AssembledSystem:
    """Assemble again with the named bearings changed."""
    system = assembled.system
    bearings = tuple(change(b) if b.name in names else b for b in system.bearings)
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
            constant = constant + stiffness * (law.motion.conj().T @ law.motion)
        elif stiffness > 0:
            unit = dataclasses.replace(
                joints[law.bearing], stiffness_n_per_m=np.eye(2), damping_n_s_per_m=np.zeros((2, 2))
            )
            scaled = partial(_scaled_law, unit, stiffness)
            pieces = None if unit.pieces is None else unit.pieces.times(stiffness)
            laws.append(law._replace(stiffness=scaled, pieces=pieces))
    return pencil._replace(stiffness=constant, laws=tuple(laws))


def _scaled_law(unit: LawJoint, stiffness: float, speed_rad_s: float) -> FloatArray:
    return stiffness * unit.coefficients(speed_rad_s)[0]


def _solved(
    pencil: Pencil, body_rate: float, limit: float
) -> tuple[FloatArray, FloatArray | ComplexArray]:
    """Return critical speeds and shapes: all for constant bearings, else up to the limit."""
    if pencil.laws:
        roots = speed_roots(pencil, body_rate, limit)
        return roots.speeds_rad_s, roots.shapes
    found = direct_speeds(pencil, pencil.stiffness, body_rate, np.inf)
    return found.speeds_rad_s, found.shapes


def _asymptote(
    assembled: AssembledSystem, pencils: Sequence[Pencil], request: MapRequest
) -> tuple[FloatArray, StringArray]:
    """Return the lowest lateral critical speeds of a system without open bearings."""
    speeds, whirl = [], []
    for pencil in pencils:
        found, shapes = _solved(pencil, assembled.body_rate, request.limit)
        full = pencil.expand(shapes)
        lateral = moves_laterally(energy_shares(assembled, full))
        kept = np.flatnonzero(lateral & (found <= request.limit))
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
    zero = np.zeros((2, 2))

    def made_rigid(bearing: Bearing) -> Bearing:
        return dataclasses.replace(
            bearing,
            stiffness_n_per_m=zero,
            damping_n_s_per_m=zero,
            speed_law=None,
            sensor=None,
            rigid=tuple(dict.fromkeys((*bearing.rigid, "ux", "uy"))),
        )

    try:
        held = _reassembled(assembled, request.names, made_rigid)
    except AssemblyError:
        # Rigid joints leave nothing that can move.
        return np.empty(0), np.empty(0, dtype="<U8")
    pencils = [p for p in whirl_pencils(held, request.ratio) if p.whirl != ALONG_AXIS]
    return _asymptote(held, pencils, request)


def stiffness_at_rest(assembled: AssembledSystem, name: str) -> FloatArray:
    """Return k_xx and k_yy of a bearing at rest, shape (2,)."""
    bearing = next(b for b in assembled.system.bearings if b.name == name)
    return np.diag(bearing_matrices(assembled, bearing, 0.0)[0])[:2].astype(float)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeedMap(ReadOnlyArrays):
    """Hold undamped critical speeds over the stiffness of some bearings.

    `bearings`: names of the bearings that were varied, all to the same stiffness k·I.
    `stiffness_n_per_m`: k, rising, shape (s,), N/m; the stiffness at rest times a factor where a
    law depends on the speed. `excitation_ratio`: α: frequency of the excitation over Ω.
    `speed_rad_s`: Ω of each branch, shape (b, s), rad/s; nan where a branch is above the limit or
    absent. `whirl`: "forward", "backward", "mixed" or "straight", shape (b, s); empty where the
    speed is nan. `likeness`: of the shape to that at the previous stiffness, 0 to 1: the smallest
    on the way, shape (b, s); 1 where a branch begins, 0 where there is none.
    `chosen_stiffness_n_per_m`: k_xx and k_yy at rest of the bearings as the system has them, shape
    (len(bearings), 2). `free_rad_s`, `free_whirl`: critical speeds without the bearings, shape
    (f,): where the branches come from. Empty as well if a free body then whirls without force at
    any speed. `rigid_rad_s`, `rigid_whirl`: critical speeds with ux and uy joined rigidly, shape
    (r,): where the branches go to.
    """

    bearings: tuple[str, ...]
    stiffness_n_per_m: FloatArray
    excitation_ratio: float
    speed_rad_s: FloatArray
    whirl: StringArray
    likeness: FloatArray
    chosen_stiffness_n_per_m: FloatArray
    free_rad_s: FloatArray
    free_whirl: StringArray
    rigid_rad_s: FloatArray
    rigid_whirl: StringArray

    def __repr__(self) -> str:
        k = self.stiffness_n_per_m
        return (
            f"CriticalSpeedMap of {row(self.bearings)}: {len(self.speed_rad_s)} branches, "
            f"{k.size} stiffnesses from {k[0]:.4g} to {k[-1]:.4g} N/m"
        )


def critical_speed_map(
    assembled: AssembledSystem,
    bearings: Sequence[str],
    stiffnesses_n_per_m: npt.ArrayLike,
    *,
    excitation_ratio: float = 1.0,
    branch_count: int | None = None,
    speed_max_rad_s: float | None = None,
) -> CriticalSpeedMap:
    """Compute the undamped critical speeds over the stiffness of some bearings.

    `assembled`: the system; its damping is left out; `bearings`: names of the bearings that get the
    stiffness k·I on (ux, uy) instead of their own. One with a `PolynomialLaw` keeps it: k is its
    stiffness before the factor of the law. Of the other ones the symmetric part of the stiffness
    counts, and of bearings that depend on the frequency that at αΩ. `stiffnesses_n_per_m`: k,
    positive, strictly rising, shape (s,), N/m. Spaced by equal factors as a rule.
    `excitation_ratio`: α, as for `critical_speeds`; `branch_count`: lowest branches wanted of each
    whirl direction; twice that number in all where directions cannot be told apart beforehand
    (anisotropic supports). None is all below the limit. `speed_max_rad_s`: leave out what lies
    above; None is the range the bodies were made for. Lateral critical speeds only. Branches by
    rising speed where they begin. Where a bearing stiffens faster than Ω² a curve may turn back
    over k: it is then cut into branches that begin or end there, and all of them are found if no
    `branch_count` is given. Raises AnalysisError if the arguments have no meaning, a bearing to
    vary is rigid, the law of another one does not tell its polynomials, or neither a limit nor a
    number of branches is known.

    Each point is solved directly (see `critical_speeds`), forward and backward whirl apart where
    the system is isotropic; nothing is assembled anew but where k passes the stiffness of
    another bearing, because the coordinates follow the stiffest path of joints. Branches are
    paired by the MAC of shapes in the energy product of the stiffness. See Müller and
    Hennings, section 5.3 and figure 9.
    """
    stiffness = _checked_stiffness(stiffnesses_n_per_m)
    request = _checked_request(assembled, bearings, excitation_ratio, branch_count, speed_max_rad_s)
    assembled = uncoupled_supports(assembled, request.names, request.ratio)
    return _solved_map(MapSolver(assembled, request), stiffness)


def _solved_map(solver: MapSolver, stiffness: FloatArray) -> CriticalSpeedMap:
    assembled, request = solver.assembled, solver.request
    found = [
        branch
        for place in range(len(solver.lateral))
        for branch in _branches(solver, place, stiffness)
    ]
    found.sort(key=lambda branch: branch.speeds[np.isfinite(branch.speeds)][0])
    shape = (len(found), stiffness.size)
    free, free_whirl = solver.free()
    rigid, rigid_whirl = rigid_speeds(assembled, request)
    chosen = [stiffness_at_rest(assembled, name) for name in request.names]
    return CriticalSpeedMap(
        bearings=request.names,
        stiffness_n_per_m=stiffness,
        excitation_ratio=request.ratio,
        speed_rad_s=np.array([branch.speeds for branch in found]).reshape(shape),
        whirl=np.array([branch.whirl for branch in found], dtype="<U8").reshape(shape),
        likeness=np.array([branch.mac for branch in found]).reshape(shape),
        chosen_stiffness_n_per_m=np.array(chosen),
        free_rad_s=free,
        free_whirl=free_whirl,
        rigid_rad_s=rigid,
        rigid_whirl=rigid_whirl,
    )


class _Branch(NamedTuple):
    """Critical speed (nan where absent), whirl and MAC over the stiffness, each (s,)."""

    speeds: FloatArray
    whirl: list[str]
    mac: FloatArray


def _branches(solver: MapSolver, place: int, stiffness: FloatArray) -> Iterator[_Branch]:
    """Follow the branches of one pencil that are among those wanted at some stiffness."""
    pencil, request = solver.lateral[place], solver.request
    points = [solver.point(place, float(k)) for k in stiffness]
    wanted = _wanted(points, request, pencil)
    points, branches = follow_branches(
        points, partial(solver.point, place), partial(solver.metric, place), wanted
    )
    for columns, mac in zip(branches.columns, branches.mac, strict=True):
        if not ((columns >= 0) & (columns < wanted)).any():
            continue
        speeds = np.array(
            [p.speeds[c] if c >= 0 else np.nan for p, c in zip(points, columns, strict=True)]
        )
        speeds[~(speeds <= request.limit)] = np.nan
        if np.isfinite(speeds).any():
            whirl = _branch_whirl(solver, pencil, points, columns, speeds)
            yield _Branch(speeds, whirl, mac)


def _wanted(points: Sequence[MapPoint], request: MapRequest, pencil: Pencil) -> int:
    """Return how many of the lowest critical speeds of a pencil are looked at."""
    below = max(int(np.count_nonzero(point.speeds <= request.limit)) for point in points)
    if request.branch_count is None:
        return below
    return min(below, request.branch_count * (1 if pencil.whirl else 2))


def _branch_whirl(
    solver: MapSolver,
    pencil: Pencil,
    points: Sequence[MapPoint],
    columns: IntArray,
    speeds: FloatArray,
) -> list[str]:
    """Return the whirl of one branch at each stiffness."""
    if pencil.whirl:
        return [pencil.whirl if np.isfinite(speed) else "" for speed in speeds]
    return [
        str(
            whirl_direction(solver.reference.assembled, pencil.expand(point.shapes[:, [column]]))[0]
        )
        if np.isfinite(speed)
        else ""
        for point, column, speed in zip(points, columns, speeds, strict=True)
    ]


def _checked_stiffness(stiffnesses_n_per_m: npt.ArrayLike) -> FloatArray:
    values = np.array(stiffnesses_n_per_m, dtype=float)
    fits = values.ndim == 1 and values.size > 0 and np.isfinite(values).all()
    if not fits or not values[0] > 0 or not (np.diff(values) > 0).all():
        raise AnalysisError(
            "stiffnesses_n_per_m needs positive, finite, strictly rising values; found shape "
            f"{values.shape}"
        )
    return values


def _checked_request(
    assembled: AssembledSystem,
    names: Sequence[str],
    excitation_ratio: float,
    branch_count: int | None,
    speed_max_rad_s: float | None,
) -> MapRequest:
    known = {bearing.name: bearing for bearing in assembled.system.bearings}
    if isinstance(names, str) or not names or any(name not in known for name in names):
        raise AnalysisError(f"bearings is {names!r}; one or more of {list(known)} are allowed")
    for name in names:
        if {"ux", "uy"} & set(known[name].rigid):
            raise AnalysisError(f"bearing {name!r} is rigid; its stiffness cannot be varied")
    ratio, limit = checked_excitation(assembled, excitation_ratio, speed_max_rad_s)
    if branch_count is not None and branch_count < 1:
        raise AnalysisError(f"branch_count is {branch_count}; it must be 1 or more, or None")
    depends = any(known[j.bearing].speed_law is not None for j in assembled.law_joints)
    if not np.isfinite(limit) and (branch_count is None or depends):
        raise AnalysisError(
            "speed_max_rad_s is needed: there is no limit of the bodies, and "
            + ("bearings depend on the speed" if depends else "no branch_count is given")
        )
    return MapRequest(tuple(names), ratio, branch_count, limit)
