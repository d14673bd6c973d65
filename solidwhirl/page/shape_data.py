"""What the viewer of mode shapes is given: surfaces, centre lines, joints, motions of modes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solidwhirl.page.shape_pieces import BeamDisk, Piece, pieces_of
from solidwhirl.page.shape_states import ShownModes
from solidwhirl.rotordyn import AssembledSystem, Superelement
from solidwhirl.rotordyn.centreline import centreline_motion, interface_rows
from solidwhirl.rotordyn.coordinates import body_rows
from solidwhirl.rotordyn.mode_shapes import orbits
from solidwhirl.rotordyn.surface import around_axis

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# Points of a centre line with an orbit, and points of the line itself.
_ORBITS, _LINE = 9, 60
# Angles at which the largest displacement of a ring is sought.
_ANGLES = 12
# An orbit smaller than this part of the largest is not drawn; a flatter one is a line.
_SMALL, _FLAT = 0.01, 0.02
_WHOLE = 32767
# Numbers below this are zero; a step of them could not be represented.
_NOTHING = 1e-290


class Stations(NamedTuple):
    """Points of the axis: body of each, place, radius of the body, whether it has an orbit.

    `modes` maps the body's coordinates to ux, uy, shape (p, 2, n of that body).
    """

    body: list[str]
    axial_m: list[float]
    has_orbit: list[bool]
    rows: list[FloatArray]

    def add(self, body: str, axial_m: float, rows: FloatArray, has_orbit: bool) -> int:
        """Add a point and return its number."""
        self.body.append(body)
        self.axial_m.append(axial_m)
        self.has_orbit.append(has_orbit)
        self.rows.append(rows)
        return len(self.body) - 1


class _Lines(NamedTuple):
    """Stations, the centre line of each body as their numbers, and the joints."""

    stations: Stations
    lines: dict[str, list[int]]
    joints: list[dict[str, Any]]


def viewer_data(
    system: AssembledSystem,
    shown: Sequence[ShownModes],
    disks: Mapping[str, Sequence[BeamDisk]],
) -> dict[str, Any]:
    """Return the data of the viewer, as `shapes.js` reads them.

    Parameters
    ----------
    system
        The engine.
    shown
        Its modes.
    disks
        Rigid disks of its beams.

    Notes
    -----
    A mode is scaled to a largest displacement of 1 over the surface and the cycle, and turned so
    that this place is at its largest at the phase 0. Motions are whole numbers of 16 bits, real
    and imaginary part of each amplitude in turn, times ``scale``.
    """
    rotors = system.system.rotors
    elements = {name: rotor.element for name, rotor in rotors.items()}
    pieces = pieces_of(elements, disks)
    lines = _lines(system, pieces)
    radius = max([1e-3, *(_outer_radius(p) for p in pieces)])
    axial = np.concatenate(
        [[0.0] if not lines.stations.axial_m else lines.stations.axial_m, *map(_axial, pieces)]
    )
    return {
        "bodies": [{"name": n, "ratio": r.speed_ratio} for n, r in rotors.items()],
        "pieces": [_piece_data(piece, list(rotors)) for piece in pieces],
        "stations": {
            "body": np.array([list(rotors).index(b) for b in lines.stations.body]),
            "z": np.array(lines.stations.axial_m),
            "orbit": np.array(lines.stations.has_orbit, dtype=int),
        },
        "lines": [np.array(at) for at in lines.lines.values()],
        "joints": lines.joints,
        "reach": {"first": float(axial.min()), "last": float(axial.max()), "radius": radius},
        "states": [
            {"label": s.label, "modes": [*_modes_data(system, pieces, lines.stations, s)]}
            for s in shown
        ],
    }


def _axial(piece: Piece) -> FloatArray:
    points = piece.surface.points_m
    return points[:, 0] if piece.surface.kind == "meridian" else points[:, 2]


def _radial(piece: Piece) -> FloatArray:
    points = piece.surface.points_m
    if piece.surface.kind == "meridian":
        return points[:, 1]
    return np.asarray(np.hypot(points[:, 0], points[:, 1]))


def _outer_radius(piece: Piece) -> float:
    return float(_radial(piece).max(initial=0.0))


def _piece_data(piece: Piece, bodies: list[str]) -> dict[str, Any]:
    return {
        "body": bodies.index(piece.body),
        "kind": piece.surface.kind,
        "disk": piece.is_disk,
        "points": piece.surface.points_m,
        "cells": piece.surface.cells,
    }


def _lines(system: AssembledSystem, pieces: Sequence[Piece]) -> _Lines:
    """Centre lines of the bodies, and what joins them."""
    stations = Stations([], [], [], [])
    lines: dict[str, list[int]] = {}
    nodes: dict[tuple[str, str], int] = {}
    for name, rotor in system.system.rotors.items():
        line = centreline_motion(rotor.element)
        order = np.argsort(line.axial_m, kind="stable")
        kept = _spread(line.axial_m[order], _LINE)
        with_orbit = set(_spread(line.axial_m[order][kept], _ORBITS).tolist())
        lines[name] = [
            stations.add(
                name, float(line.axial_m[order[k]]), line.modes[order[k]], at in with_orbit
            )
            for at, k in enumerate(kept)
        ]
        ends = interface_rows(rotor.element)
        for k, interface in enumerate(ends.names):
            nodes[name, interface] = stations.add(
                name, float(ends.axial_m[k]), ends.modes[k], has_orbit=False
            )
    return _Lines(stations, lines, _joints(system, pieces, nodes))


def _spread(places: FloatArray, most: int) -> NDArray[np.int64]:
    """Numbers of some places, evenly along the axis, the ends among them."""
    if places.size <= most:
        return np.arange(places.size)
    wanted = np.linspace(places[0], places[-1], most)
    return np.asarray(np.unique(np.abs(places[None, :] - wanted[:, None]).argmin(axis=1)))


def _joints(
    system: AssembledSystem, pieces: Sequence[Piece], nodes: dict[tuple[str, str], int]
) -> list[dict[str, Any]]:
    """Bearings and gears between stations, with the radii of the bodies there."""
    found = []
    for kind, joints in (("bearing", system.system.bearings), ("gear", system.system.gears)):
        for joint in joints:
            ends = [nodes.get((end.body, end.interface), -1) for end in joint.ends]
            if min(ends) < 0:
                continue  # a joint of axial motion or torsion alone
            places = [_place(system.system.rotors[e.body].element, e.interface) for e in joint.ends]
            radii = [_radius_at(pieces, e.body, z) for e, z in zip(joint.ends, places, strict=True)]
            found.append({"name": joint.name, "kind": kind, "ends": ends, "radii": radii})
    return found


def _place(element: Superelement, interface: str) -> float:
    return float(element.interface_node(interface).position_m[2])


def _radius_at(pieces: Sequence[Piece], body: str, place: float) -> float:
    """Outer radius of the shaft of a body at a place: the smallest outline near it."""
    found = []
    for piece in pieces:
        if piece.body != body or piece.is_disk:
            continue
        z, r = _axial(piece), _radial(piece)
        cells = piece.surface.cells
        low, high = z[cells].min(axis=1), z[cells].max(axis=1)
        near = (low <= place + 1e-9) & (high >= place - 1e-9)
        if near.any():
            found.append(float(r[cells[near]].max(axis=1).max()))
    return max(found, default=0.0)


def _modes_data(
    system: AssembledSystem, pieces: Sequence[Piece], stations: Stations, shown: ShownModes
) -> Iterator[dict[str, Any]]:
    modes = shown.modes
    own = {name: body_rows(system, name) @ modes.shapes for name in system.system.rotors}
    for k, text in enumerate(shown.texts):
        terms = [piece_terms(piece, own[piece.body][:, k]) for piece in pieces]
        center = np.array(
            [
                rows @ own[body][:, k]
                for body, rows in zip(stations.body, stations.rows, strict=True)
            ]
        ).reshape(-1, 2)
        factor = unit_factor(pieces, terms, center)
        hertz = float(modes.eigenvalues[k].imag / (2.0 * np.pi))
        yield {
            "label": text,
            "hertz": hertz,
            "rpm": float(shown.rpm[k]),
            "whirl": shown.whirl[k],
            "growth": float(modes.eigenvalues[k].real),
            "terms": [
                {
                    "order": [order for order, _, _ in found],
                    "family": [family for _, family, _ in found],
                    **packed(np.array([factor * values for _, _, values in found])),
                }
                for found in terms
            ],
            "center": packed(factor * center),
            "sense": _senses(factor * center, stations.has_orbit),
        }


def piece_terms(piece: Piece, motion: ComplexArray) -> list[tuple[int, int, ComplexArray]]:
    """Return the motion of a surface by circumferential order and family.

    Parameters
    ----------
    piece
        The surface.
    motion
        Coordinates of its body, shape (n,).

    Returns
    -------
    list
        Order, family and amplitudes (p, 3) of what moves; of a solid order 0, family 0 and the
        displacement along x, y, z.
    """
    surface = piece.surface
    q = motion[surface.coordinate]
    found = []
    for order in np.unique(surface.order):
        for family in (0, 1):
            own = (surface.order == order) & (surface.family == family)
            if own.any() and np.any(q[own]):
                found.append((int(order), family, surface.amplitudes[:, :, own] @ q[own]))
    return found


def unit_factor(
    pieces: Sequence[Piece],
    terms: Sequence[Sequence[tuple[int, int, ComplexArray]]],
    center: ComplexArray,
) -> complex:
    """Return the factor that makes the largest displacement of a mode 1, at the phase 0.

    Parameters
    ----------
    pieces
        The surfaces.
    terms
        Motion of each (`piece_terms`).
    center
        Motion of points of the axis, shape (p, 2).
    """
    largest, factor = 0.0, 0.0 + 0.0j
    theta = 2.0 * np.pi * np.arange(_ANGLES) / _ANGLES
    fields = [np.column_stack([center, np.zeros(len(center))])]
    for piece, found in zip(pieces, terms, strict=True):
        for_all: Any = 0.0
        for order, family, values in found:
            if piece.surface.kind == "solid":
                for_all = for_all + values
            else:
                for_all = for_all + around_axis(values, order, family, theta)
        if np.ndim(for_all):
            fields.append(for_all.reshape(-1, 3))
    for field in fields:
        if not field.size:
            continue
        squares = (field**2).sum(axis=1)
        size = np.sqrt(0.5 * ((np.abs(field) ** 2).sum(axis=1) + np.abs(squares)))
        at = int(size.argmax())
        if size[at] > largest:
            largest = float(size[at])
            factor = complex(np.exp(-0.5j * np.angle(squares[at])) / largest)
    return factor


def packed(values: ComplexArray) -> dict[str, Any]:
    """Return complex numbers as whole ones of 16 bits, two to a number of 32, and their scale.

    Parameters
    ----------
    values
        Of any shape; real and imaginary parts follow each other.
    """
    flat = np.ascontiguousarray(values, dtype=complex).view(float).ravel()
    largest = float(np.abs(flat).max(initial=0.0))
    scale = largest / _WHOLE if largest > _NOTHING else 1.0
    whole = np.round(flat / scale).astype("<i2")
    return {"scale": scale, "packed": whole.view("<i4")}


def _senses(center: ComplexArray, has_orbit: Sequence[bool]) -> list[str]:
    """Direction of each orbit: "forward", "backward", "planar", or "" where none is drawn."""
    if not len(center):
        return []
    found = orbits(center[:, :, None])
    major, minor = found.major[:, 0], found.minor[:, 0]
    largest = float(major.max(initial=0.0))
    out = []
    for big, small, wanted in zip(major, minor, has_orbit, strict=True):
        if not wanted or not big > _SMALL * largest:
            out.append("")
        elif abs(small) < _FLAT * big:
            out.append("planar")
        else:
            out.append("forward" if small > 0.0 else "backward")
    return out
