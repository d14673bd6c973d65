"""A mode of an engine in space: surfaces of all bodies, their motion, orbits along the axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.pictures.cuts import SECTORS, BodyInSpace, encloses, opened
from solidwhirl.pictures.outlines import Outline, outlines_of
from solidwhirl.pipeline import Results
from solidwhirl.rotordyn import Modes, modes_at_speed
from solidwhirl.rotordyn.coordinates import body_rows
from solidwhirl.rotordyn.mode_shapes import BodyShape, mode_shapes, orbits
from solidwhirl.surface_files import shown_surface, surface_displacement, surface_grid
from solidwhirl.vtk_files import LINE, QUADRANGLE, TRIANGLE

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
_RPM = 30.0 / np.pi
# Largest displacement as a part of the engine's length.
_LARGEST = 0.055
# Orbits flatter than this, minor over major, turn in no direction that could be seen; orbits
# smaller than this part of the largest are not drawn.
_FLAT, _SMALL = 0.03, 0.02
# Orbits along one body at most, beside those of its interfaces.
_ORBITS = 5
# Pieces along an outline that is turned about the axis.
_STEPS = 60
_AROUND = 64
# Modes whose frequencies differ by less than this, relative, are a pair.
_PAIR = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class OrbitInSpace:
    """The path of a point of the axis over one period: (64, 3) [m] from phase 0, and its sense."""

    points_m: FloatArray
    whirl: str


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineShape:
    """A mode of an engine, scaled to be seen.

    Attributes
    ----------
    bodies, orbits
        What is drawn; points move by Re(motion e^{iφ}).
    frequency_hz, speed_rpm, whirl
        Of the mode.
    largest_m
        Largest displacement as drawn.
    """

    bodies: tuple[BodyInSpace, ...]
    orbits: tuple[OrbitInSpace, ...]
    frequency_hz: float
    speed_rpm: float
    whirl: str
    largest_m: float

    @property
    def text(self) -> str:
        """Frequency, speed and whirl."""
        return f"{self.frequency_hz:.4g} Hz at {self.speed_rpm:.0f} rpm, {self.whirl}"


@dataclass(frozen=True, kw_only=True)
class ChosenMode:
    """Which mode is shown: by its place at a speed, with a name for its file."""

    name: str
    speed_rad_s: float
    frequency_hz: float
    whirl: str = ""


def chosen_modes(results: Results, count: int) -> tuple[ChosenMode, ...]:
    """Return the modes that pictures show: those of the lowest critical speeds, else at the top.

    Parameters
    ----------
    results
        The run.
    count
        How many at most.
    """
    critical = sorted((c.critical for c in results.critical_speeds), key=lambda c: c.speed_rad_s)
    if critical:
        return tuple(
            ChosenMode(
                name=f"mode_critical_{k + 1}",
                speed_rad_s=float(c.speed_rad_s),
                frequency_hz=float(c.frequency_hz),
                whirl=str(c.whirl or ""),
            )
            for k, c in enumerate(critical[:count])
        )
    last = results.campbell.frequency_hz[:, -1]
    speed = float(results.campbell.speeds_rad_s[-1])
    found = np.sort(last[np.isfinite(last)])[:count]
    return tuple(
        ChosenMode(name=f"mode_{k + 1}", speed_rad_s=speed, frequency_hz=float(f))
        for k, f in enumerate(found)
    )


def _nearest(frequency_hz: FloatArray, whirl: NDArray[np.str_], chosen: ChosenMode) -> int:
    """The mode that is chosen; of a pair with one frequency the one with its whirl."""
    away = np.abs(frequency_hz - chosen.frequency_hz)
    near = np.flatnonzero(away <= away.min() + _PAIR * chosen.frequency_hz)
    same = [int(k) for k in near if whirl[k] == chosen.whirl]
    return same[0] if same else int(away.argmin())


def engine_shape(results: Results, chosen: ChosenMode) -> EngineShape:
    """Return a mode of a run in space.

    Parameters
    ----------
    results
        The run.
    chosen
        The mode nearest to its frequency is taken, of equal ones that with its whirl.
    """
    system = results.system
    below = int((results.campbell.frequency_hz <= 1.05 * chosen.frequency_hz).any(axis=1).sum())
    modes = modes_at_speed(system, chosen.speed_rad_s, below + 6)
    shapes = mode_shapes(system, modes)
    at = _nearest(modes.frequency_hz, shapes.whirl, chosen)
    outlines = {o.body: o for o in outlines_of(results)}
    length = _length(results, outlines)
    raw = [_body(results, name, modes, at) for name in results.elements]
    shown = [b for b in raw if b is not None]
    turned = [_turned(outlines[s.body], s, at) for s in shapes.bodies if _is_drawn(results, s.body)]
    disks = _disks(shapes.bodies, outlines, at)
    turn = _turn(results, modes, shapes.bodies, at)
    largest = max((_largest(b.motion_m) for b in shown), default=0.0) * abs(turn or 1.0)
    largest = max([largest, *(_largest(b.motion_m) for b in turned + disks)])
    unit = _LARGEST * length / largest if largest > 0.0 else 0.0
    bodies = [_scaled(b, unit * (turn or 1.0)) for b in shown]
    bodies += [_scaled(b, unit) for b in turned]
    bodies = [
        opened(b, outlines[b.body]) if encloses(outlines[b.body], [*outlines.values()]) else b
        for b in bodies
    ]
    bodies += [_scaled(b, unit) for b in disks]
    return EngineShape(
        bodies=tuple(bodies),
        orbits=tuple(_orbits(shapes.bodies, outlines, at, unit)),
        frequency_hz=float(modes.frequency_hz[at]),
        speed_rpm=chosen.speed_rad_s * _RPM,
        whirl=str(shapes.whirl[at]),
        largest_m=_LARGEST * length,
    )


def _length(results: Results, outlines: dict[str, Outline]) -> float:
    """Length of the engine, or its width where that is larger."""
    z = [node.position_m[2] for e in results.elements.values() for node in e.interfaces]
    z += [p for o in outlines.values() for a in o.areas for p in a[:, 0]]
    return max(float(np.ptp(z)), *(2.0 * o.reach_m for o in outlines.values()), 1e-6)


def _body(results: Results, name: str, modes: Modes, at: int) -> BodyInSpace | None:
    """Surface and unscaled motion of one body; None of one that has no points."""
    element = results.elements[name]
    if _is_drawn(results, name):
        return None
    if shown_surface(element) is None and not len(element.recovery_points_m):
        return None
    grid, _ = surface_grid(element, SECTORS)
    own = body_rows(results.system, name) @ modes.shapes[:, at]
    cells = dict(grid.cells)
    return BodyInSpace(
        body=name,
        points_m=np.asarray(grid.points_m, dtype=float),
        motion_m=np.asarray(surface_displacement(element, own, SECTORS), dtype=complex),
        quadrangles=cells.get(QUADRANGLE, np.empty((0, 4), dtype=np.int64)),
        triangles=cells.get(TRIANGLE, np.empty((0, 3), dtype=np.int64)),
        lines=cells.get(LINE, np.empty((0, 2), dtype=np.int64)),
    )


def _largest(motion: ComplexArray) -> float:
    """Largest displacement over the cycle."""
    square = (np.abs(motion) ** 2).sum(axis=1)
    cycle = 0.5 * (square + np.abs((motion**2).sum(axis=1)))
    return float(np.sqrt(cycle.max(initial=0.0)))


def _turn(results: Results, modes: Modes, shapes: Sequence[BodyShape], at: int) -> complex:
    """Factor from the mode's coordinates to its scaled shapes; 0 if it has no lateral motion."""
    raw, scaled = [], []
    for shape in shapes:
        element = results.elements[shape.body]
        own = body_rows(results.system, shape.body) @ modes.shapes[:, at]
        for name, motion in zip(shape.interfaces, shape.interface_motion[:, :, at], strict=True):
            for component, value in zip(("ux", "uy"), motion, strict=True):
                if component in element.components_at(name):
                    raw.append(own[element.interface_index(name, component)])
                    scaled.append(value)
    a, b = np.array(raw, dtype=complex), np.array(scaled, dtype=complex)
    weight = float(np.vdot(a, a).real)
    return complex(np.vdot(a, b) / weight) if weight > 0.0 else 0j


def _is_drawn(results: Results, name: str) -> bool:
    """Whether a body is known by its profile only, so that sections square to its axis stand in.

    Bodies of the beam level hold no surface.
    """
    return name in results.scene.bodies and shown_surface(results.elements[name]) is None


def _turned(outline: Outline, shape: BodyShape, at: int) -> BodyInSpace:
    """The outline turned about the axis, its sections square to the centre line of the mode."""
    step = float(np.ptp(np.vstack(outline.lines)[:, 0])) / _STEPS
    rings: list[tuple[float, float]] = []
    pairs: list[tuple[int, int]] = []
    for line in outline.lines:
        for (z0, r0), (z1, r1) in pairwise(line):
            count = max(1, int(np.ceil(abs(z1 - z0) / step)))
            first = len(rings)
            part = np.linspace(0.0, 1.0, count + 1)
            rings += [(z0 + t * (z1 - z0), r0 + t * (r1 - r0)) for t in part]
            pairs += [(first + k, first + k + 1) for k in range(count)]
    z, r = np.array(rings).T
    theta = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    x, y = (np.outer(f(theta), r).ravel() for f in (np.cos, np.sin))
    moved = np.array([np.concatenate(_axis_motion(shape, float(p), at)) for p in z])
    across = np.tile(moved[:, :2], (SECTORS, 1))
    slope = np.tile(moved[:, 2:], (SECTORS, 1))
    along = -(x * slope[:, 0] + y * slope[:, 1])
    here = np.arange(SECTORS)[:, None] * len(z)
    there = (np.arange(SECTORS)[:, None] + 1) % SECTORS * len(z)
    a, b = np.array(pairs).T
    faces = np.stack([here + a, here + b, there + b, there + a], axis=2).reshape(-1, 4)
    return BodyInSpace(
        body=outline.body,
        points_m=np.column_stack((x, y, np.tile(z, SECTORS))),
        motion_m=np.column_stack((across, along)),
        quadrangles=faces.astype(np.int64),
        triangles=np.empty((0, 3), dtype=np.int64),
        lines=np.empty((0, 2), dtype=np.int64),
    )


def _scaled(body: BodyInSpace, factor: complex) -> BodyInSpace:
    return BodyInSpace(
        body=body.body,
        points_m=body.points_m,
        motion_m=body.motion_m * factor,
        quadrangles=body.quadrangles,
        triangles=body.triangles,
        lines=body.lines,
    )


def _axis_motion(shape: BodyShape, axial_m: float, at: int) -> tuple[ComplexArray, ComplexArray]:
    """Motion of the centre line at a place, and its slope, each (2,)."""
    z, moved = shape.axial_m, shape.motion[:, :, at]
    if len(z) < 2:
        return moved.mean(axis=0), np.zeros(2, dtype=complex)
    slope = np.gradient(moved, z, axis=0)
    found = [[_interpolated(axial_m, z, f[:, c]) for c in (0, 1)] for f in (moved, slope)]
    return np.array(found[0]), np.array(found[1])


def _interpolated(place: float, z: FloatArray, values: ComplexArray) -> complex:
    return complex(np.interp(place, z, values.real), np.interp(place, z, values.imag))


def _disks(shapes: Sequence[BodyShape], outlines: dict[str, Outline], at: int) -> list[BodyInSpace]:
    """Rigid disks as flat rings of triangles about the axis, square to the centre line."""
    theta = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    number = np.arange(SECTORS)
    faces = np.column_stack((np.zeros_like(number), 1 + number, 1 + (number + 1) % SECTORS))
    out = []
    for shape in shapes:
        for disk in outlines[shape.body].disks:
            x = np.append(0.0, disk.radius_m * np.cos(theta))
            y = np.append(0.0, disk.radius_m * np.sin(theta))
            moved, slope = _axis_motion(shape, disk.axial_m, at)
            across = np.broadcast_to(moved, (SECTORS + 1, 2))
            along = -(x * slope[0] + y * slope[1])
            out.append(
                BodyInSpace(
                    body=f"{shape.body}: {disk.name}",
                    points_m=np.column_stack((x, y, np.full_like(x, disk.axial_m))),
                    motion_m=np.column_stack((across, along)),
                    quadrangles=np.empty((0, 4), dtype=np.int64),
                    triangles=faces.astype(np.int64),
                    lines=np.empty((0, 2), dtype=np.int64),
                )
            )
    return out


def _orbits(
    shapes: Sequence[BodyShape], outlines: dict[str, Outline], at: int, unit: float
) -> list[OrbitInSpace]:
    """Orbits of places of the axis of all bodies, without those that could not be seen."""
    turn = np.exp(2j * np.pi * np.arange(_AROUND) / _AROUND)
    out = []
    for shape in shapes:
        z = [*shape.interface_axial_m]
        if len(shape.axial_m) > 1:
            z += np.linspace(shape.axial_m[0], shape.axial_m[-1], _ORBITS).tolist()
        gap = 0.04 * float(np.ptp(shape.axial_m)) if len(shape.axial_m) > 1 else 0.0
        drawn: list[float] = []
        for place in z:
            if any(abs(place - other) <= gap for other in drawn):
                continue
            drawn.append(float(place))
            moved, _ = _axis_motion(shape, float(place), at)
            ellipse = orbits(moved[None, :, None])
            major, minor = float(ellipse.major[0, 0]), float(ellipse.minor[0, 0])
            if not major > _SMALL:
                continue
            path = unit * np.real(moved[:, None] * turn)
            points = np.column_stack((*path, np.full(_AROUND, place)))
            out.append(OrbitInSpace(points_m=points, whirl=sense(major, minor)))
    return out


def sense(major: float, minor: float) -> str:
    """Return the direction of an orbit: "forward", "backward", or "planar" if it is flat.

    Parameters
    ----------
    major, minor
        Its semi-axes; minor is negative for a turn against the reference shaft.
    """
    if abs(minor) <= _FLAT * major:
        return "planar"
    return "forward" if minor > 0.0 else "backward"


def displaced(body: BodyInSpace, phase_rad: float) -> tuple[Any, Any]:
    """Return points (p, 3) [m] of a body at a phase and the length of their displacement (p,).

    Parameters
    ----------
    body
        The body.
    phase_rad
        φ of Re(motion e^{iφ}).
    """
    moved = np.real(body.motion_m * np.exp(1j * phase_rad))
    return body.points_m + moved, np.sqrt((moved**2).sum(axis=1))
