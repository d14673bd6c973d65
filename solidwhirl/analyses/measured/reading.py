"""What was measured at the points of a scene, from whichever files hold it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from itertools import chain, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from solidwhirl.analyses.measured.csv_files import read_functions, read_modes
from solidwhirl.analyses.measured.records import (
    Freedom,
    Measured,
    MeasuredFileError,
    MeasuredFunction,
    MeasuredMode,
)
from solidwhirl.analyses.measured.spec import MeasuredSpec, MeasuringPointSpec
from solidwhirl.analyses.measured.universal_files import FileMode, UniversalFile, read_universal
from solidwhirl.rotordyn.core.arrays import FloatArray

_AXES = {"x": 1, "y": 2, "z": 3}
# Distances of nodes and of places in the scene that differ by more than this part are others.
_APART = 0.02
_CSV = (".csv", ".txt")


class _Points(NamedTuple):
    hammers: Sequence[MeasuringPointSpec]
    sensors: Sequence[MeasuringPointSpec]


def read_measured(
    spec: MeasuredSpec, hammers: Sequence[MeasuringPointSpec], sensors: Sequence[MeasuringPointSpec]
) -> Measured:
    """Read what was measured between hammers and at sensors.

    Raises MeasuredFileError: a file can not be taken, or holds nothing of these points.
    """
    points = _Points(hammers, sensors)
    functions: tuple[MeasuredFunction, ...] = ()
    modes = tuple(MeasuredMode(frequency_hz=f) for f in sorted(spec.frequencies_hz or ()))
    notes: list[str] = []
    names = [p.name for p in hammers], [p.name for p in sensors]
    universal = cache(partial(_universal, spec=spec, points=points))
    if spec.functions is not None:
        path = Path(spec.functions)
        if path.suffix.lower() in _CSV:
            functions = read_functions(path, *names)
        else:
            file = universal(path)
            functions, said = _functions(path, file, spec, points)
            notes += [*file.notes, *said]
    if spec.modes is not None:
        path = Path(spec.modes)
        if path.suffix.lower() in _CSV:
            modes = read_modes(path, names[1])
        else:
            modes = _modes(path, universal(path), spec, points)
    return Measured(functions=functions, modes=modes, notes=tuple(dict.fromkeys(notes)))


def freedom(point: MeasuringPointSpec, spec: MeasuredSpec) -> tuple[Freedom, int]:
    """Return the freedom of a file that a point is, along the positive axis, and its sign."""
    along = point.vector @ _file_axes(spec)
    number = int(np.abs(along).argmax())
    return Freedom(point.node or 0, number + 1), int(along[number])


def _universal(path: Path, spec: MeasuredSpec, points: _Points) -> UniversalFile:
    """Read a universal file whose nodes the points name, and which fits to their places."""
    for key, group in zip(("hammers", "sensors"), points, strict=True):
        for point in group:
            if point.node is None:
                raise MeasuredFileError(
                    path, f"{key}: {point.name!r} has no node; universal files know places by it"
                )
    file = read_universal(path, spec.units, spec.quantity)
    _check_distances(path, file, spec, points)
    return file


def _check_distances(path: Path, file: UniversalFile, spec: MeasuredSpec, points: _Points) -> None:
    """Refuse nodes that are farther apart along the axis than in the scene: other units."""
    axis = next(k for name, k in _AXES.items() if name not in {d[-1] for d in spec.directions}) - 1
    known = {
        p.node: p.at_m
        for p in chain(*points)
        if p.at_m is not None and p.node is not None and p.node in file.nodes_m
    }
    if len(known) < 2:
        return
    first, *_, last = sorted(known, key=known.__getitem__)
    here = known[last] - known[first]
    there = abs(float(file.nodes_m[last][axis] - file.nodes_m[first][axis]))
    if abs(there - here) > _APART * here:
        raise MeasuredFileError(
            path,
            f"nodes {first} and {last} are {there:g} m apart along its "
            f"{'xyz'[axis]} axis, {here:g} m in the scene; its units, directions or the nodes of "
            "the points are wrong",
        )


def _functions(
    path: Path, file: UniversalFile, spec: MeasuredSpec, points: _Points
) -> tuple[tuple[MeasuredFunction, ...], list[str]]:
    found: dict[tuple[str, str], MeasuredFunction] = {}
    left = 0
    for function in file.functions:
        hammers = _at(function.reference, spec, points.hammers)
        sensors = _at(function.response, spec, points.sensors)
        left += int(not (hammers and sensors))
        for (hammer, one), (sensor, other) in product(hammers, sensors):
            if (hammer, sensor) in found:
                raise MeasuredFileError(
                    path, f"two functions from {hammer!r} to {sensor!r}; allowed is one"
                )
            found[hammer, sensor] = MeasuredFunction(
                hammer=hammer,
                sensor=sensor,
                quantity=function.quantity,
                frequency_hz=function.frequency_hz,
                values=one * other * function.values,
            )
    if not file.functions:
        raise MeasuredFileError(
            path,
            "; ".join(
                ("no frequency response function (dataset 58 of function type 4)", *file.notes)
            ),
        )
    if not found:
        there = sorted({(*f.response, *f.reference) for f in file.functions})[:8]
        raise MeasuredFileError(
            path,
            "no function between the points of the scene; (node, direction) of responses and "
            f"references are {[((a, b), (c, d)) for a, b, c, d in there]}",
        )
    return tuple(found.values()), [f"{left} functions of other points are left out"] if left else []


def _at(
    end: Freedom, spec: MeasuredSpec, points: Sequence[MeasuringPointSpec]
) -> list[tuple[str, int]]:
    """Return names of points at an end of a function, 1 along it and -1 against it."""
    found = []
    for point in points:
        own, sign = freedom(point, spec)
        if own == Freedom(end.node, abs(end.direction)):
            found.append((point.name, sign * (1 if end.direction > 0 else -1)))
    return found


def _modes(
    path: Path, file: UniversalFile, spec: MeasuredSpec, points: _Points
) -> tuple[MeasuredMode, ...]:
    if not file.modes:
        raise MeasuredFileError(path, "no modes (dataset 55 of normal or complex modes)")
    nodes = set[int]().union(*(mode.motion for mode in file.modes))
    for point in points.sensors:
        if point.node not in nodes:
            raise MeasuredFileError(
                path, f"no mode has node {point.node} of sensor {point.name!r}; "
                f"there are {sorted(nodes)[:20]}"
            )  # fmt: skip
    modes = [_mode(mode, spec, points.sensors) for mode in file.modes]
    return tuple(sorted(modes, key=lambda mode: mode.frequency_hz))


def _mode(
    mode: FileMode, spec: MeasuredSpec, sensors: Sequence[MeasuringPointSpec]
) -> MeasuredMode:
    shape = {}
    for sensor in sensors:
        own, sign = freedom(sensor, spec)
        motion = mode.motion.get(own.node)  # nodes that do not move may be left out
        shape[sensor.name] = complex(sign * motion[own.direction - 1]) if motion is not None else 0j
    moving = any(shape.values())
    return MeasuredMode(
        frequency_hz=mode.frequency_hz,
        damping_ratio=mode.damping_ratio,
        shape=shape if moving else None,
    )


def file_place(at_m: float, spec: MeasuredSpec) -> FloatArray:
    """Return a place along the axis in the axes of a file, (3,), m."""
    return np.asarray(at_m * _file_axes(spec)[2])


def _file_axes(spec: MeasuredSpec) -> FloatArray:
    """Return x, y and z of the scene in the axes of a file, one each row, (3, 3)."""
    first, second = (
        (-1.0 if d.startswith("-") else 1.0) * np.eye(3)[_AXES[d[-1]] - 1] for d in spec.directions
    )
    return np.array([first, second, np.cross(first, second)])
