"""Nodes of a beam model: where columns are cut, where plates and interfaces attach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.beams.profile import (
    BeamLevelError,
    Column,
    Place,
    Plate,
    Skeleton,
    grouped,
    skeleton_of,
)
from solidwhirl.geometry import Body, Interface, Subdivision, subdivide
from solidwhirl.rotordyn.beams.families import BeamNodes, Mean
from solidwhirl.rotordyn.core.arrays import FloatArray

# Elements are no longer than this share of the body's axial length unless the caller says so.
DEFAULT_ELEMENTS = 60
_SAME = 1e-9
_SIMPSON = (1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0)
# Radii over the length along which stresses decay that have no resultant.
_DECAY = 2.7
# Ratio of radii below which a tube is solid around a bore (as of roots of plates).
_THICK = 0.5


class Element(NamedTuple):
    """A piece of a column between two nodes."""

    column: int
    ends_m: tuple[float, float]
    nodes: tuple[int, int]


class Rim(NamedTuple):
    """The free edge of a plate that an interface sits on, with a node of its own."""

    plate: int
    outer: bool
    node: int
    rigid: bool


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Layout:
    """Hold nodes and elements of a beam model."""

    skeleton: Skeleton
    nodes_m: FloatArray  #: Axial place of each node, shape (N,), m
    elements: tuple[Element, ...]
    #: Node under the inner and over the outer edge of each plate; −1 for a free edge
    plate_nodes: tuple[tuple[int, int], ...]
    rims: tuple[Rim, ...]  #: Free edges with a node, which `plate_nodes` names too
    #: Node of each interface by its position in the body; several may share one
    interfaces: tuple[int, ...]
    #: Nodes that follow another node as rigid pieces: (node, leader)
    ties: tuple[tuple[int, int], ...]
    means: tuple[Mean, ...]  #: Surfaces that distributing interfaces follow

    @property
    def beam_nodes(self) -> BeamNodes:
        """The nodes, those of the interfaces, each once in the order of the body, and the rest."""
        nodes = tuple(dict.fromkeys(self.interfaces))
        return BeamNodes(self.nodes_m, nodes, self.ties, self.means)


class _Ring(NamedTuple):
    """A ring of a surface, with its area and the second moment of that about y."""

    place: Place
    area_m2: float
    second_m4: float


class _Seat(NamedTuple):
    """Where an interface sits: on columns, or on a free edge of a plate (plate, outer).

    A distributing one follows its rings.
    """

    place: Place | None
    columns: tuple[int, ...]
    edge: tuple[int, bool] | None
    rings: tuple[_Ring, ...] = ()


def layout_of(body: Body, element_length_m: float | None, *, blurred: bool = False) -> Layout:
    """Place the nodes of the beam model of a body.

    `body`: with at least one interface. `element_length_m`: longest element; None is a sixtieth of
    the body's axial length. `blurred`: distributing interfaces reach further, by `decay_length_m`
    at both ends. Raises BeamLevelError for a body that is none of beams and plates, and an
    interface on several of its parts.
    """
    if not body.interfaces:
        raise BeamLevelError(f"body '{body.name}': the beam level needs at least one interface")
    skeleton = skeleton_of(body)
    start = min(c.start_m for c in skeleton.columns)
    end = max(c.end_m for c in skeleton.columns)
    longest = (end - start) / DEFAULT_ELEMENTS if element_length_m is None else element_length_m
    if not (math.isfinite(longest) and longest > 0.0):
        raise BeamLevelError(
            f"body '{body.name}': element_length_m is {longest}, must be finite and positive"
        )
    subdivision = subdivide(body)
    seats = [_seat(body, skeleton, subdivision, item, blurred) for item in body.interfaces]
    cuts = _cuts(skeleton, body.interfaces, seats)
    places = [
        _stations(column, cuts[k], longest, _SAME * (end - start))
        for k, column in enumerate(skeleton.columns)
    ]
    return _numbered(body, skeleton, seats, places)


def _cuts(
    skeleton: Skeleton, interfaces: Sequence[Interface], seats: Sequence[_Seat]
) -> list[list[float]]:
    """Return the places in each column that need a node."""
    cuts: list[list[float]] = [[] for _ in skeleton.columns]
    for plate in skeleton.plates:
        for place in (plate.inner, plate.outer):
            if place is not None:
                cuts[place.column].append(place.z_m)
    for interface, seat in zip(interfaces, seats, strict=True):
        if seat.place is not None:
            for place in (seat.place, *(ring.place for ring in seat.rings)):
                cuts[place.column].append(place.z_m)
            if interface.coupling == "rigid":
                for k in seat.columns:
                    cuts[k] += [interface.start_m, interface.end_m]
    return cuts


def _stations(column: Column, cuts: list[float], longest: float, same: float) -> list[float]:
    """Return the nodes of a column: its ends, the places asked for, and even steps between."""
    wanted = [column.start_m]
    inside = [z for z in sorted(cuts) if column.start_m + same < z < column.end_m - same]
    for z in [*inside, column.end_m]:
        if z - wanted[-1] > same:
            wanted.append(z)
    out = [wanted[0]]
    for low, high in pairwise(wanted):
        count = math.ceil((high - low) / longest * (1.0 - 1e-12))
        out += list(np.linspace(low, high, max(count, 1) + 1)[1:])
    return out


def _numbered(
    body: Body, skeleton: Skeleton, seats: Sequence[_Seat], places: Sequence[Sequence[float]]
) -> Layout:
    first = np.concatenate(([0], np.cumsum([len(p) for p in places])))
    joined = [(first[i + 1] - 1, first[j]) for i, j in skeleton.contacts]
    labels = grouped(int(first[-1]), joined)
    _, kept, number = np.unique(labels, return_index=True, return_inverse=True)
    place_of = np.concatenate([np.array(p) for p in places])
    nodes = list(place_of[kept])

    def node_at(place: Place) -> int:
        own = np.array(places[place.column])
        return int(number[first[place.column] + int(np.abs(own - place.z_m).argmin())])

    elements = [
        Element(k, (own[e], own[e + 1]), (int(number[first[k] + e]), int(number[first[k] + e + 1])))
        for k, own in enumerate(places)
        for e in range(len(own) - 1)
    ]
    held = [[node_at(p) if p else -1 for p in (q.inner, q.outer)] for q in skeleton.plates]
    rims: list[Rim] = []
    of_interface: list[int] = []
    means: list[Mean] = []
    for interface, seat in zip(body.interfaces, seats, strict=True):
        if seat.place is not None:
            own = node_at(seat.place)
            if seat.rings and own not in of_interface:
                under, area, second = zip(*seat.rings, strict=True)
                means.append(Mean(own, tuple(map(node_at, under)), area, second))
            of_interface.append(own)
            continue
        assert seat.edge is not None
        plate, outer = seat.edge
        own = held[plate][outer]
        if own >= 0 and nodes[own] != interface.position_m[2]:
            raise BeamLevelError(
                f"body '{body.name}': interface '{interface.name}' sits on the rim of a disk that "
                "has another interface; the beam level has one place there"
            )
        if own < 0:
            nodes.append(interface.position_m[2])
            own = held[plate][outer] = len(nodes) - 1
            rims.append(Rim(plate, outer, own, interface.coupling == "rigid"))
        of_interface.append(own)
    layout = Layout(
        skeleton=skeleton,
        nodes_m=np.array(nodes),
        elements=tuple(elements),
        plate_nodes=tuple((a, b) for a, b in held),
        rims=tuple(rims),
        interfaces=tuple(of_interface),
        ties=(),
        means=tuple(means),
    )
    return _with_ties(body, layout, seats)


def _with_ties(body: Body, layout: Layout, seats: Sequence[_Seat]) -> Layout:
    """Return the layout with the pieces under rigid interfaces made rigid."""
    ties: dict[int, int] = {}
    for interface, seat, leader in zip(body.interfaces, seats, layout.interfaces, strict=True):
        if interface.coupling != "rigid" or not seat.columns:
            continue
        low, high = interface.start_m, interface.end_m
        slack = layout.skeleton.tolerance_m
        for element in layout.elements:
            inside = low - slack <= element.ends_m[0] and element.ends_m[1] <= high + slack
            if element.column not in seat.columns or not inside:
                continue
            for node in element.nodes:
                if node == leader:
                    continue
                if ties.get(node, leader) != leader or node in layout.interfaces:
                    raise BeamLevelError(
                        f"body '{body.name}': the rigid interface '{interface.name}' meets another "
                        f"interface at z = {layout.nodes_m[node]:.6g} m; the beam level can not "
                        "hold both rigid"
                    )
                ties[node] = leader
    return replace(layout, ties=tuple(sorted(ties.items())))


def _seat(
    body: Body, skeleton: Skeleton, subdivision: Subdivision, interface: Interface, blurred: bool
) -> _Seat:
    """Find the columns, or else the rim of a disk, that the curves of an interface lie on."""
    curves = [subdivision.curves[k] for k in subdivision.interfaces[interface.name]]
    lines = [subdivision.points[[c.start, c.end]] for c in curves]
    slack = 1e3 * skeleton.tolerance_m
    hit = [
        k
        for k, column in enumerate(skeleton.columns)
        if any(_on_column(column, line, slack) for line in lines)
    ]
    if not hit:
        return _Seat(None, (), _edge(body, skeleton.plates, interface, lines, slack))
    z = interface.position_m[2]
    pairs = [(hit.index(i), hit.index(j)) for i, j in skeleton.contacts if i in hit and j in hit]
    under = [k for k in hit if skeleton.columns[k].start_m <= z <= skeleton.columns[k].end_m]
    if len(set(grouped(len(hit), pairs))) > 1 or not under:
        names = {layer.name for k in hit for layer in skeleton.columns[k].layers}
        raise BeamLevelError(
            f"body '{body.name}': interface '{interface.name}' lies on parts that bend apart "
            f"({', '.join(sorted(names))}); limit it to one of them with its radial range"
        )
    place = Place(under[0], z)
    column = skeleton.columns[under[0]]
    if interface.kind == "inner" and column.inner_m(z) < _THICK * column.outer_m(z):
        raise BeamLevelError(
            f"body '{body.name}': interface '{interface.name}' sits in a bore of "
            f"{column.inner_m(z):.4g} m in a shaft of {column.outer_m(z):.4g} m radius; the wall "
            f"gives way around a bore below {_THICK:g} of the radius, which beams do not know; "
            "choose level harmonic"
        )
    reach = decay_length_m(column, z) if blurred else 0.0
    flat = interface.start_m == interface.end_m
    # a whole section is moved by the stresses of a beam, which have nothing to settle to
    radii = [r for line in lines for _, r in line.tolist()]
    whole = min(radii) <= column.inner_m(z) + slack and max(radii) >= column.outer_m(z) - slack
    if interface.coupling == "rigid" or (flat and (whole or not blurred)):
        return _Seat(place, tuple(hit), None)
    stretch = 1.0 if flat else 1.0 + 2.0 * reach / (interface.end_m - interface.start_m)
    rings = [
        _Ring(_reached(skeleton, hit, z + stretch * (at - z) + step), share * area, share * second)
        for line in lines
        for at, area, second in _rings_of(line)
        for step, share in (
            zip((-reach, 0.0, reach), _SIMPSON, strict=True) if flat else ((0.0, 1.0),)
        )
    ]
    return _Seat(place, tuple(hit), None, tuple(rings))


def decay_length_m(column: Column, z_m: float) -> float:
    """Return the length along which stresses settle to those of a beam, m.

    Those of lateral loads without resultant decay in a round bar as exp(−2.7 z / R) and faster
    (Little and Childs, Q. Appl. Math. 25, 1967, end loads of a cylinder).
    """
    return column.outer_m(z_m) / _DECAY


def _rings_of(line: FloatArray) -> list[tuple[float, float, float]]:
    """Return place, area and second moment of three rings that stand for a conical surface."""
    length = float(np.hypot(*(line[1] - line[0])))
    middles = (line[0], line.mean(axis=0), line[1])
    areas = [
        2.0 * np.pi * float(r) * length * w for (_, r), w in zip(middles, _SIMPSON, strict=True)
    ]
    return [
        (float(z), area, 0.5 * area * float(r) ** 2)
        for (z, r), area in zip(middles, areas, strict=True)
    ]


def _reached(skeleton: Skeleton, hit: Sequence[int], z_m: float) -> Place:
    """Return the place on columns, or on what follows them, that is nearest to z."""
    columns = skeleton.columns
    joined = grouped(len(columns), skeleton.contacts)
    near = [k for k in range(len(columns)) if joined[k] == joined[hit[0]]]

    def apart(k: int) -> tuple[float, bool]:
        return max(columns[k].start_m - z_m, z_m - columns[k].end_m, 0.0), k not in hit

    found = min(near, key=apart)
    return Place(found, min(max(z_m, columns[found].start_m), columns[found].end_m))


def _on_column(column: Column, line: FloatArray, slack: float) -> bool:
    """Return whether a line (2, 2) shares more than a point with the section of a column."""
    (z0, r0), (z1, r1) = line
    if abs(z1 - z0) <= slack:
        if not column.start_m - slack <= z0 <= column.end_m + slack:
            return False
        z = min(max(z0, column.start_m), column.end_m)
        return bool(min(r0, r1) < column.outer_m(z) - slack) and bool(
            max(r0, r1) > column.inner_m(z) + slack
        )
    low, high = max(min(z0, z1), column.start_m), min(max(z0, z1), column.end_m)
    if high - low <= slack:
        return False
    z = 0.5 * (low + high)
    r = r0 + (r1 - r0) * (z - z0) / (z1 - z0)
    return bool(column.inner_m(z) - slack <= r <= column.outer_m(z) + slack)


def _edge(
    body: Body,
    plates: Sequence[Plate],
    interface: Interface,
    lines: Sequence[FloatArray],
    slack: float,
) -> tuple[int, bool]:
    for k, plate in enumerate(plates):
        ends = (plate.cells[0], plate.cells[0].inner_m), (plate.cells[-1], plate.cells[-1].outer_m)
        for outer, (cell, radius) in enumerate(ends):
            for z, r in (line.mean(axis=0) for line in lines):
                inside = cell.start_m - slack <= z <= cell.end_m + slack
                if inside and abs(r - radius) <= slack:
                    return k, bool(outer)
    raise BeamLevelError(
        f"body '{body.name}': interface '{interface.name}' lies on the flat of a disk; the beam "
        "level has places on the shaft and on rims only"
    )
