"""One mode of an engine in space: surfaces, centre lines and joints, and how they move in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solidwhirl.drawing.bodies import silhouettes_of
from solidwhirl.drawing.modes import ShownModes
from solidwhirl.drawing.surfaces import Piece, pieces_of, thinned
from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn import AssembledSystem, Superelement
from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.mode_shapes import orbits
from solidwhirl.rotordyn.superelement.centreline import centreline_motion, interface_rows

# Points of a centre line with an orbit, and points of the line itself.
_ORBITS, _LINE = 9, 60
#: Angles at which the displacement of a ring is sought.
SECTORS = 72
# An orbit smaller than this part of the largest, or than this part of the largest displacement, is
# not drawn; a flatter one is a line.
_SMALL, _UNSEEN, _FLAT = 0.01, 0.003, 0.02
# Distance of points along an outline that is thinned, over the length of the engine.
_SPACING = 0.035


class Station(NamedTuple):
    """A point of the axis: body, place, whether it has an orbit.

    `rows` maps the body's coordinates to ux, uy, shape (2, n of that body).
    """

    body: str
    axial_m: float
    has_orbit: bool
    rows: FloatArray


class DrawnJoint(NamedTuple):
    """A bearing or a gear between stations, with the radii of the bodies there."""

    name: str
    kind: str
    ends: list[int]
    radii: list[float]


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineInSpace:
    """What moves in a mode: surfaces, points of the axis, bearings and gears.

    `lines` has the centre line of each body by the numbers of its stations, `bare` the bodies
    without a surface, of which the points for pictures are drawn.
    """

    system: AssembledSystem
    pieces: tuple[Piece, ...]
    bare: Mapping[str, Superelement]
    stations: tuple[Station, ...]
    lines: Mapping[str, list[int]]
    joints: tuple[DrawnJoint, ...]

    @property
    def reach_m(self) -> tuple[float, float, float]:
        """First and last z and largest radius."""
        axial = np.concatenate([[s.axial_m for s in self.stations] or [0.0],
                                *(places(p)[0] for p in self.pieces)])  # fmt: skip
        radius = max([1e-3, *(float(places(p)[1].max(initial=0.0)) for p in self.pieces)])
        return float(axial.min()), float(axial.max()), radius


@dataclass(frozen=True, kw_only=True, eq=False)
class ModeInSpace:
    """A mode whose largest displacement is 1, at the phase 0."""

    #: Of each body, shape (n,); points move by Re(amplitude e^{iφ})
    coordinates: Mapping[str, ComplexArray]
    #: ux, uy of the stations, shape (s, 2)
    center: ComplexArray
    #: Direction of the orbit of each station: "forward", "backward", "straight", or "" where none
    #: is drawn
    senses: tuple[str, ...]


def engine_in_space(results: Results) -> EngineInSpace:
    """Return what moves in the modes of a run."""
    system = results.system
    pieces = pieces_of(results.elements, silhouettes_of(results))
    stations: list[Station] = []
    lines: dict[str, list[int]] = {}
    nodes: dict[tuple[str, str], int] = {}
    for name, rotor in system.system.rotors.items():
        line = centreline_motion(rotor.element)
        order = np.argsort(line.axial_m, kind="stable")
        order = order[_spread(line.axial_m[order], _LINE)]
        with_orbit = _spread(line.axial_m[order], _ORBITS)
        lines[name] = list(range(len(stations), len(stations) + order.size))
        stations += [
            Station(name, float(line.axial_m[k]), at in with_orbit, line.modes[k])
            for at, k in enumerate(order)
        ]
        ends = interface_rows(rotor.element)
        for k, interface in enumerate(ends.names):
            nodes[name, interface] = len(stations)
            stations.append(Station(name, float(ends.axial_m[k]), False, ends.modes[k]))
    return EngineInSpace(
        system=system,
        pieces=pieces,
        bare={
            name: element
            for name, element in results.elements.items()
            if len(element.recovery_points_m) and all(p.body != name for p in pieces)
        },
        stations=tuple(stations),
        lines=lines,
        joints=tuple(_joints(system, pieces, nodes)),
    )


def with_few_points(engine: EngineInSpace) -> EngineInSpace:
    """Return the engine with thinned surfaces alone, for what is drawn again and again."""
    ends = [places(p)[0] for p in engine.pieces if not p.disk]
    length = float(np.ptp(np.concatenate(ends))) if ends else 1.0
    return replace(
        engine,
        bare={},
        pieces=tuple(
            p if p.disk else p._replace(surface=thinned(p.surface, _SPACING * length))
            for p in engine.pieces
        ),
    )


def mode_in_space(engine: EngineInSpace, shown: ShownModes, number: int) -> ModeInSpace:
    """Return one of the shown modes, by its place among them."""
    shape = shown.modes.shapes[:, number]
    own = {name: body_rows(engine.system, name) @ shape for name in engine.system.system.rotors}
    center = np.array([s.rows @ own[s.body] for s in engine.stations]).reshape(-1, 2)
    fields = [np.column_stack([center, np.zeros(len(center))])]
    fields += [p.surface.displacement(own[p.body], SECTORS) for p in engine.pieces]
    fields += [e.recovery_modes @ own[name] for name, e in engine.bare.items()]
    factor = unit_factor(fields)
    return ModeInSpace(
        coordinates={name: factor * q for name, q in own.items()},
        center=factor * center,
        senses=tuple(_senses(factor * center, [s.has_orbit for s in engine.stations])),
    )


def unit_factor(fields: Sequence[ComplexArray]) -> complex:
    """Return the factor of amplitudes (p, 3) that makes the largest displacement 1, at phase 0."""
    moved = np.concatenate([np.empty((0, 3), dtype=complex), *fields])
    squares = (moved**2).sum(axis=1)
    size = np.sqrt(0.5 * ((np.abs(moved) ** 2).sum(axis=1) + np.abs(squares)))
    at = int(size.argmax()) if size.size else -1
    if at < 0 or size[at] == 0.0:
        return 0j
    return complex(np.exp(-0.5j * np.angle(squares[at])) / size[at])


def places(piece: Piece) -> tuple[FloatArray, FloatArray]:
    """Return z and radius of the points of a surface."""
    points = piece.surface.points_m
    if piece.surface.kind == "meridian":
        return points[:, 0], points[:, 1]
    return points[:, 2], np.asarray(np.hypot(points[:, 0], points[:, 1]))


def _spread(places: FloatArray, most: int) -> IntArray:
    """Numbers of some places, evenly along the axis, the ends among them."""
    if places.size <= most:
        return np.arange(places.size)
    wanted = np.linspace(places[0], places[-1], most)
    return np.asarray(np.unique(np.abs(places[None, :] - wanted[:, None]).argmin(axis=1)))


def _joints(
    system: AssembledSystem, pieces: Sequence[Piece], nodes: Mapping[tuple[str, str], int]
) -> Iterator[DrawnJoint]:
    for kind, joints in (("bearing", system.system.bearings), ("gear", system.system.gears)):
        for joint in joints:
            ends = [nodes.get((end.body, end.interface), -1) for end in joint.ends]
            if min(ends) < 0:
                continue  # a joint of axial motion or torsion alone
            radii = []
            for end in joint.ends:
                node = system.system.rotors[end.body].element.interface_node(end.interface)
                radii.append(_radius_at(pieces, end.body, float(node.position_m[2])))
            yield DrawnJoint(joint.name, kind, ends, radii)


def _radius_at(pieces: Sequence[Piece], body: str, place: float) -> float:
    """Outer radius of the shaft of a body at a place."""
    own = [radii_at(p, place) for p in pieces if p.body == body and not p.disk]
    return max((reach[1] for reach in own if reach), default=0.0)


def radii_at(piece: Piece, place: float) -> tuple[float, float] | None:
    """Return least and largest radius of the faces that a plane across the axis meets."""
    z, r = (values[piece.surface.cells] for values in places(piece))
    met = r[(z.min(axis=1) <= place + 1e-9) & (z.max(axis=1) >= place - 1e-9)]
    return (float(met.min()), float(met.max())) if met.size else None


def _senses(center: ComplexArray, has_orbit: Sequence[bool]) -> list[str]:
    if not len(center):
        return []
    found = orbits(center[:, :, None])
    major, minor = found.major[:, 0], found.minor[:, 0]
    largest = float(major.max(initial=0.0))
    out = []
    for big, small, wanted in zip(major, minor, has_orbit, strict=True):
        if not wanted or not big > max(_SMALL * largest, _UNSEEN):
            out.append("")
        elif abs(small) < _FLAT * big:
            out.append("straight")
        else:
            out.append("forward" if small > 0.0 else "backward")
    return out
