"""Where and how much unbalance excites the modes of a shaft the most, by the rules of API 617."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.lateral.rigid_supports import (
    axial_m,
    excited_critical_speeds,
    shaft_bodies,
)
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.standards.api617_lateral import residual_unbalance_kg_m

CaseKind = Literal["static", "couple", "overhung"]


@dataclass(frozen=True, kw_only=True)
class Journals:
    """Hold what the journals of a shaft carry.

    `seats`, `loads_kg`: by name of the bearing, along the axis; `overhung_kg`: masses beyond the
    first and beyond the last one.
    """

    seats: Mapping[str, End]
    loads_kg: Mapping[str, float]
    overhung_kg: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class PlacementRules:
    """Say how much unbalance is placed, and at which antinodes.

    `speed_max_rpm`: maximum continuous speed of the shaft; `factor`: k of U_a = k U_r; `inboard`,
    `outboard`: antinodes between the journals and beyond them count from this part of the largest
    amplitude on, outboard ones also where they are the largest.
    """

    speed_max_rpm: float
    factor: float = 2.0
    inboard: float = 0.1
    outboard: float = 0.5


@dataclass(frozen=True, kw_only=True)
class UnbalanceCase:
    """Hold the unbalances of one run.

    `kind`: "static": one between the journals; "couple": several there, opposed as the mode is;
    "overhung": one beyond a journal. `loads_kg`: W of each; `modes_rad_s`: undamped critical speeds
    of the shaft itself whose shape asks for it.
    """

    kind: CaseKind
    unbalances: tuple[Unbalance, ...]
    loads_kg: tuple[float, ...]
    modes_rad_s: tuple[float, ...]

    @property
    def name(self) -> str:
        """Kind and places."""
        return f"{self.kind} at {', '.join(u.end.label for u in self.unbalances)}"


class _Antinode(NamedTuple):
    end: End
    axial_m: float
    height: float


def unbalance_cases(
    assembled: AssembledSystem,
    shaft: str,
    journals: Journals,
    rules: PlacementRules,
    limit_rad_s: float,
) -> tuple[UnbalanceCase, ...]:
    """Return the unbalances that excite the modes of a shaft up to a speed the most.

    `limit_rad_s`: of the shaft itself. Modes are undamped critical speeds that its unbalance
    excites, the first one beyond the limit if there is none below it; weights stand at the
    interfaces where they move most. Each case is of all modes that ask for the same weights.
    """
    bodies = shaft_bodies(assembled, shaft)
    found: dict[tuple[tuple[str, bool], ...], UnbalanceCase] = {}
    for speed, shape in excited_critical_speeds(assembled, shaft, limit_rad_s):
        antinodes = _shape_along(assembled, bodies, shape)
        for case in _cases_of(antinodes, assembled, journals, rules):
            key = tuple((u.end.label, u.phase_rad > 0.0) for u in case.unbalances)
            known = found.get(key, case)
            found[key] = replace(known, modes_rad_s=(*known.modes_rad_s, speed))
    return tuple(found.values())


def _shape_along(
    assembled: AssembledSystem, bodies: Sequence[str], shape: ComplexArray
) -> list[_Antinode]:
    """Return the interfaces along the axis with the part of their motion that turns with the shaft.

    Without damping all of these are in phase or opposed; the largest is 1.
    """
    rotors = assembled.system.rotors
    sense = np.sign(rotors[bodies[0]].speed_ratio)
    ends = [
        End(body=body, interface=node.name)
        for body in bodies
        for node in rotors[body].element.interfaces
        if {"ux", "uy"} <= set(rotors[body].element.components_at(node.name))
    ]
    circles = np.array([_circle(assembled, end, sense) @ shape for end in ends])
    heights = (circles / circles[np.abs(circles).argmax()]).real
    found = [_Antinode(e, axial_m(assembled, e), h) for e, h in zip(ends, heights, strict=True)]
    return sorted(found, key=lambda a: a.axial_m)


def _circle(assembled: AssembledSystem, end: End, sense: float) -> ComplexArray:
    x, y = (interface_row(assembled, end.body, end.interface, c) for c in ("ux", "uy"))
    return np.asarray(x + 1j * sense * y)


def _cases_of(
    along: Sequence[_Antinode],
    assembled: AssembledSystem,
    journals: Journals,
    rules: PlacementRules,
) -> list[UnbalanceCase]:
    """Return the cases of one mode: of its antinodes between the journals, and of each beyond."""
    places = {name: axial_m(assembled, seat) for name, seat in journals.seats.items()}
    low, high = min(places.values()), max(places.values())
    cases = []
    inner = [a for a in _tops(along, low, high) if abs(a.height) >= rules.inboard]
    if len(inner) == 1:
        cases.append(_case("static", inner, [sum(journals.loads_kg.values())], rules))
    elif inner:
        near = [_nearest(places, a.axial_m) for a in inner]
        # a journal that an overhang lifts carries a load as well
        loads = [abs(journals.loads_kg[n]) for n in near]
        cases.append(_case("couple", inner, loads, rules))
    sides = ([a for a in along if a.axial_m < low], [a for a in along if a.axial_m > high])
    for side, mass in zip(sides, journals.overhung_kg, strict=True):
        top = max(side, key=lambda a: abs(a.height), default=None)
        if top is not None and abs(top.height) >= min(rules.outboard, 1.0) and mass > 0.0:
            cases.append(_case("overhung", [top], [mass], rules))
    return cases


def _nearest(places: Mapping[str, float], axial: float) -> str:
    return min(places, key=lambda name: abs(places[name] - axial))


def _tops(along: Sequence[_Antinode], low: float, high: float) -> list[_Antinode]:
    """Return the largest of each run of one sign between the journals."""
    runs: list[list[_Antinode]] = []
    for antinode in (a for a in along if low <= a.axial_m <= high and a.height != 0.0):
        if runs and runs[-1][-1].height * antinode.height > 0.0:
            runs[-1].append(antinode)
        else:
            runs.append([antinode])
    return [max(run, key=lambda a: abs(a.height)) for run in runs]


def _case(
    kind: CaseKind, antinodes: Sequence[_Antinode], loads: Sequence[float], rules: PlacementRules
) -> UnbalanceCase:
    weights = tuple(
        Unbalance(
            body=a.end.body,
            interface=a.end.interface,
            moment_kg_m=rules.factor * residual_unbalance_kg_m(load, rules.speed_max_rpm),
            phase_rad=0.0 if a.height * antinodes[0].height > 0.0 else float(np.pi),
        )
        for a, load in zip(antinodes, loads, strict=True)
    )
    return UnbalanceCase(kind=kind, unbalances=weights, loads_kg=tuple(loads), modes_rad_s=())
