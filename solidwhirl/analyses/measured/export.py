"""Computed functions and modes of a hammer test as a universal file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solidwhirl.analyses.measured.reading import file_place, freedom
from solidwhirl.analyses.measured.records import Freedom
from solidwhirl.analyses.measured.spec import MeasuredSpec, MeasuringPointSpec
from solidwhirl.analyses.measured.universal_files import FileFunction, FileMode, write_universal
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.modal_test.assurance import seen_directions


@dataclass(frozen=True, kw_only=True, eq=False)
class ComputedTest:
    """What a hammer test would find."""

    hammers: Sequence[MeasuringPointSpec]
    sensors: Sequence[MeasuringPointSpec]
    quantity: str
    #: In equal steps, (f,)
    frequency_hz: FloatArray
    #: (hammer, sensor, frequency)
    values: ComplexArray
    #: Of the families that are written
    natural_hz: Sequence[float]
    damping_ratio: Sequence[float]
    #: Of the sensors in the modes of each, (s, modes)
    motions: Sequence[FloatArray | ComplexArray]


def exported(
    test: ComputedTest, system: AssembledSystem, measured: MeasuredSpec | None, path: Path
) -> None:
    """Write functions and modes as the sensors see them, in the directions of measured files.

    Points without a node get numbers that are free, one for each place. A family whose modes the
    sensors see in two planes is written as two modes.
    """
    own = measured or MeasuredSpec.model_construct()
    points = dict.fromkeys([*test.hammers, *test.sensors])
    places = {point: _place(system, point) for point in points}
    nodes = _numbers(places)
    ends = {p: freedom(p.model_copy(update={"node": nodes[p]}), own) for p in places}
    functions = [
        FileFunction(
            ends[sensor][0],
            ends[hammer][0],
            test.quantity,
            test.frequency_hz,
            ends[sensor][1] * ends[hammer][1] * test.values[h, s],
        )
        for h, hammer in enumerate(test.hammers)
        for s, sensor in enumerate(test.sensors)
    ]
    families = zip(test.natural_hz, test.damping_ratio, test.motions, strict=True)
    modes = [
        FileMode(hertz, ratio, _motion(shape, test.sensors, ends))
        for hertz, ratio, motions in families
        for shape in _shapes(motions)
    ]
    at = {nodes[point]: file_place(at_m, own) for point, (_, at_m) in places.items()}
    write_universal(path, functions, modes, at)


def _place(system: AssembledSystem, point: MeasuringPointSpec) -> tuple[str, float]:
    """Return body and place along the axis of a point."""
    if point.at is None:
        return str(point.body), float(point.at_m or 0.0)
    end = end_of(point.at)
    nodes = system.system.rotors[end.body].element.interfaces
    return end.body, next(float(n.position_m[2]) for n in nodes if n.name == end.interface)


def _numbers(places: dict[MeasuringPointSpec, tuple[str, float]]) -> dict[MeasuringPointSpec, int]:
    """Return node numbers: those that are given, and free ones, the same at the same place."""
    given = {place: point.node for point, place in places.items() if point.node is not None}
    used, following = {p.node for p in places}, 1
    found = {}
    for point, place in places.items():
        if point.node is None and place not in given:
            while following in used:
                following += 1
            given[place] = following
            used.add(following)
        found[point] = point.node or given[place]
    return found


def _shapes(motions: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
    """Return the independent motions of the sensors in a family, one each row."""
    directions, size = seen_directions(motions)
    return np.asarray((directions * size).T)


def _motion(
    shape: FloatArray | ComplexArray,
    sensors: Sequence[MeasuringPointSpec],
    ends: dict[MeasuringPointSpec, tuple[Freedom, int]],
) -> dict[int, ComplexArray]:
    found: dict[int, ComplexArray] = {}
    for value, sensor in zip(shape, sensors, strict=True):
        (node, direction), sign = ends[sensor]
        found.setdefault(node, np.zeros(3, dtype=complex))[direction - 1] = sign * value
    return found
