"""Lateral analysis of one shaft clause by clause of API 617, and zones and grades of ISO."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.api617 import told
from solidwhirl.analyses.api617.clauses import clause_rows, verdict_of
from solidwhirl.analyses.api617.records import (
    ClearanceSpec,
    Machine,
    OverhangSpec,
    ProbeSpec,
    SourceSpec,
    StageSpec,
)
from solidwhirl.analyses.api617.response import COUNT, Asked, case_document
from solidwhirl.analyses.api617.stability import (
    level_1_document,
    level_2_document,
    middle_of,
    without,
)
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock
from solidwhirl.core.fields import MOST, Name, Place, Positive
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.lateral.rigid_supports import (
    axial_m,
    first_critical_speed_rad_s,
    journal_loads_kg,
    journal_seats,
    on_rigid_supports,
    overhung_masses_kg,
)
from solidwhirl.rotordyn.lateral.unbalance_cases import (
    Journals,
    PlacementRules,
    unbalance_cases,
)
from solidwhirl.rotordyn.standards.iso_balance import (
    grade_of_unbalance_mm_per_s,
    in_two_planes,
    permissible_unbalance_kg_m,
)
from solidwhirl.rotordyn.standards.iso_vibration import vibration_zone, zone_borders_m

# Trip speed over maximum continuous speed, where none is given.
_TRIP = 1.05
# Eigenproblems of the stability analysis, and cases of unbalance, about.
_FOLLOWED, _CASES = 15.0, 3.0
_Part = Annotated[float, Field(gt=0, le=1, strict=True)]


class Api617Spec(base.Analysis):
    """Lateral analysis of API 617: margins, clearances and stability of one shaft, by clause."""

    section = PageSection(
        "api-617",
        "API 617 lateral analysis",
        "What the clauses ask and what the model gives. It certifies nothing: a review against the "
        "standard itself, its tests and its data of the machine is for those who answer for it.",
        110,
    )
    turning: ClassVar = {"shaft": "it has no operating speed"}
    suffixes: ClassVar = (".png", "_stability.png")
    sees_operating = True

    kind: Literal["api617"]
    edition: Literal["8th", "9th", "legacy"] = "9th"
    shaft: Name | None = None
    minimum_speed_rpm: Positive | None = None
    maximum_continuous_rpm: Positive | None = None
    trip_rpm: Positive | None = None
    probes: Annotated[tuple[ProbeSpec, ...], Field(min_length=1, max_length=MOST)]
    clearances: Annotated[tuple[ClearanceSpec, ...], Field(max_length=MOST)] = ()
    stages: Annotated[tuple[StageSpec, ...], Field(max_length=MOST)] = ()
    applied_at: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    level_2: Annotated[tuple[SourceSpec, ...], Field(max_length=MOST)] = ()
    journals: Annotated[tuple[Name, ...], Field(max_length=MOST)] = ()
    overhangs: Annotated[tuple[OverhangSpec, ...], Field(max_length=2)] = ()
    unbalance_factor: Positive = 2.0
    inboard_threshold: _Part = 0.1
    outboard_threshold: _Part = 0.5
    range_factor: Annotated[float, Field(ge=1, le=10, strict=True)] = 1.5
    balance_grade: Positive = 2.5

    @model_validator(mode="after")
    def _rising(self) -> Api617Spec:
        keys = ("minimum_speed_rpm", "maximum_continuous_rpm", "trip_rpm")
        given = [(key, getattr(self, key)) for key in keys if getattr(self, key) is not None]
        for (low, lower), (high, higher) in pairwise(given):
            if higher < lower:
                raise ValueError(f"{high} = {higher:g} is below {low} = {lower:g}")
        return self

    def missing(self, operating: Sequence[base.OperatingSpec]) -> str | None:
        """Return what it is not told of its shaft and speeds; None if nothing is missing.

        `operating`: `[[operating]]` of the scene.
        """
        shafts = list(dict.fromkeys(o.shaft for o in operating))
        if self.shaft is None and len(shafts) != 1:
            return f"shaft: missing; [[operating]] has {shafts or 'no shaft'}, one would do"
        known = (self.shaft or shafts[0]) in shafts
        for key in ("minimum_speed_rpm", "maximum_continuous_rpm"):
            if getattr(self, key) is None and not known:
                return f"{key}: missing; give it here or as [[operating]] of the scene"
        machine = self.machine(operating, lambda _: 1.0)
        if not machine.low_rpm <= machine.high_rpm <= machine.trip_rpm:
            return (
                f"maximum_continuous_rpm: {machine.high_rpm:g} rpm is not between the minimum "
                f"speed, {machine.low_rpm:g} rpm, and the trip speed, {machine.trip_rpm:g} rpm"
            )
        return None

    def machine(
        self, operating: Sequence[base.OperatingSpec], ratio: Callable[[str], float]
    ) -> Machine:
        """Return the shaft and its speeds, from its own keys or those of the scene."""
        shaft = self.shaft or operating[0].shaft
        own = [o for o in operating if o.shaft == shaft]
        low = self.minimum_speed_rpm or min(o.from_rpm for o in own)
        high = self.maximum_continuous_rpm or max(o.to_rpm for o in own)
        return Machine(shaft, low, high, self.trip_rpm or _TRIP * high, ratio(shaft))

    def shaft_speeds(
        self, operating: Sequence[base.OperatingSpec], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield the speed up to which responses are computed."""
        if self.missing(operating) is None:
            machine = self.machine(operating, ratio)
            yield (
                self.range_factor * machine.high_rpm / machine.ratio,
                f"{self.range_factor:g} times the maximum continuous speed of {machine.shaft!r}, "
                f"{machine.high_rpm:g} rpm, to which {where} looks (range_factor)",
            )

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        solved = Work(
            solves=_CASES * 2.0 * COUNT, factorisations=40.0, eigenproblems=_FOLLOWED,
            undamped=4.0, results=_CASES * COUNT,
        )  # fmt: skip
        return solved.and_also(size.search.times(_CASES))

    def run(self, engine: base.Engine) -> Outcome:
        """All clauses, from the responses and modes that they ask for."""
        machine = self.machine(engine.operating_entries, lambda s: abs(engine.speed_ratios[s]))
        system, shaft = engine.system, machine.shaft
        top = machine.reference_rad_s(machine.high_rpm)
        seats = journal_seats(system, shaft, top, self.journals)
        rigid = on_rigid_supports(system, shaft, seats)
        journals = Journals(
            seats=seats,
            loads_kg=journal_loads_kg(rigid, list(seats)),
            overhung_kg=self._overhung(system, shaft, seats),
        )
        rules = PlacementRules(
            speed_max_rpm=machine.high_rpm,
            factor=self.unbalance_factor,
            inboard=self.inboard_threshold,
            outboard=self.outboard_threshold,
        )
        limit = self.range_factor * machine.high_rpm * RAD_S_PER_RPM
        cases = unbalance_cases(system, shaft, journals, rules, limit)
        asked = Asked(
            machine=machine, edition=self.edition, range_factor=self.range_factor,
            probes=self.probes, clearances=self.clearances,
        )  # fmt: skip
        first = first_critical_speed_rad_s(rigid, shaft, machine.high_rpm * RAD_S_PER_RPM)
        document: dict[str, Any] = {
            "note": "computed in the manner of API 617; it certifies nothing",
            "edition": self.edition,
            "shaft": shaft,
            "speeds": {
                "minimum_rpm": machine.low_rpm,
                "maximum_continuous_rpm": machine.high_rpm,
                "trip_rpm": machine.trip_rpm,
            },
            "assumptions": list(self._assumptions(machine)),
            "journals": [
                {"bearing": n, "at": end.label, "axial_m": axial_m(system, end),
                 "load_kg": journals.loads_kg[n]}
                for n, end in seats.items()
            ],
            "overhung_kg": list(journals.overhung_kg),
            "first_critical_on_rigid_supports_rpm": first * RPM_PER_RAD_S,
            "stability_is_asked": machine.high_rpm * RAD_S_PER_RPM > first,
            "cases": {case.name: case_document(system, case, asked) for case in cases},
            **self._stability(system, machine, seats, first * RPM_PER_RAD_S),
        }  # fmt: skip
        document["iso"] = self._iso(document, rigid, machine)
        rows = clause_rows(document)
        verdict = verdict_of(rows)
        word = {"fail": "FAIL"}.get(verdict["verdict"], verdict["verdict"])
        return Outcome(
            kind=self.kind,
            document={"verdict": verdict, "clauses": rows, **document},
            headline=f"{word} by API 617, {told.edition_text(self.edition)}: {verdict['why']}",
        )

    def _overhung(
        self, system: AssembledSystem, shaft: str, seats: Mapping[str, Any]
    ) -> tuple[float, float]:
        """Masses beyond the outer journals, those that are given in place of computed ones."""
        masses = dict(zip(("first", "last"), overhung_masses_kg(system, shaft, seats), strict=True))
        names = list(seats)
        for own in self.overhangs:
            if own.bearing in (names[0], names[-1]):
                masses["first" if own.bearing == names[0] else "last"] = own.mass_kg
        return masses["first"], masses["last"]

    def _stability(
        self,
        system: AssembledSystem,
        machine: Machine,
        seats: Mapping[str, Any],
        first_critical_rpm: float,
    ) -> dict[str, Any]:
        names = [name for source in self.level_2 for name in source.bearings or ()]
        base_rotor = without(system, names)
        places = [end_of(place) for place in self.applied_at] or [
            middle_of(system, machine.shaft, seats)
        ]
        level_1 = level_2 = None
        if self.stages:
            level_1 = level_1_document(base_rotor, machine, self.stages, places, first_critical_rpm)
        if self.level_2:
            level_2 = level_2_document(system, base_rotor, machine, self.level_2)
        return {"level_1": level_1, "level_2": level_2}

    def _iso(
        self, document: Mapping[str, Any], rigid: AssembledSystem, machine: Machine
    ) -> dict[str, Any]:
        """Zones of the largest vibration, and what a grade of balance permits."""
        cases = document["cases"].values()
        largest = max((case["largest_m"] for case in cases), default=0.0)
        elements = [rotor.element for rotor in rigid.system.rotors.values()]
        mass = sum(e.mass_kg for e in elements)
        middle = sum(e.mass_kg * e.center_of_gravity_m[2] for e in elements) / mass
        whole = permissible_unbalance_kg_m(mass, self.balance_grade, machine.high_rpm)
        ends = [journal["axial_m"] for journal in document["journals"]]
        is_between = len(ends) > 1 and ends[0] < middle < ends[-1]
        planes = in_two_planes(whole, middle - ends[0], ends[-1] - middle) if is_between else None
        placed = max((u["moment_kg_m"] for c in cases for u in c["unbalances"]), default=0.0)
        return {
            "zone_borders_m": list(zone_borders_m(machine.high_rpm)),
            "largest_m": largest,
            "zone": vibration_zone(largest, machine.high_rpm),
            "mass_kg": mass,
            "grade_mm_per_s": self.balance_grade,
            "permissible_kg_m": whole,
            "in_planes_kg_m": None if planes is None else list(planes),
            "largest_placed_kg_m": placed,
            "grade_of_placed_mm_per_s": grade_of_unbalance_mm_per_s(placed, mass, machine.high_rpm),
        }

    def _assumptions(self, machine: Machine) -> Iterator[str]:
        """Yield what was not seen in the standard itself, and what the model leaves out."""
        yield (
            f"unbalance is {self.unbalance_factor:g} times 6350 W/N g mm (unbalance_factor; "
            "reports to editions before the 9th also have 4)"
        )
        yield (
            f"antinodes count from {100.0 * self.inboard_threshold:g} % of the largest amplitude "
            f"on between journals, {100.0 * self.outboard_threshold:g} % beyond "
            "(inboard_threshold, outboard_threshold); they are sought at interfaces"
        )
        yield (
            "masses beyond outer journals are what weighs on interfaces there, without what lies "
            "next to the journal (overhangs)"
        )
        if self.trip_rpm is None:
            yield f"trip speed {machine.trip_rpm:g} rpm, 1.05 times the maximum (trip_rpm)"
        yield "numbers of clauses, and that probes must keep to the limit without scaling"
        yield "seals with floating rings keep no clearance (floating_ring)"
        yield "stability is asked for above the first undamped critical speed on rigid supports"
        yield "level II asks for a log decrement of 0.1 at least"
        yield "borders of region B as read off the figure; zones of ISO 20816-3 as of 7919-3"
        yield (
            "bearings as the scene gives them, one set: smallest and largest clearance are cases "
            "of a sweep; tilting pads with synchronous coefficients"
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Responses of every case; damping over applied cross-coupling where it was computed."""
        document = found.document
        pictures: dict[str, base.Charts] = {}
        if document["cases"]:
            pictures[""] = lambda: told.response_charts(document)
        if document["level_1"]:
            pictures["_stability"] = lambda: [
                told.cross_coupling_chart(document),
                *told.region_charts(document),
            ]
        return pictures

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Verdict, clauses, responses, stability, ISO, and what is assumed."""
        return told.blocks(found.document)

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """One row for each thing that a clause asks."""
        rows = document["clauses"]
        kinds: dict[str, type] = dict.fromkeys(
            ("value", "limit", "value_m", "limit_m", "to_spare", "error_estimate"), float
        )
        kinds |= dict.fromkeys(("clause", "what", "where", "verdict"), str)
        return Labels(
            {k: ("row", np.array([row[k] for row in rows], kind)) for k, kind in kinds.items()}
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield whether it passes, what is least to spare, and the damping of both levels."""
        yield "passed", float(document["verdict"]["passed"])
        yield "undecided", float(document["verdict"]["verdict"] == "undecided")
        yield "worst_to_spare", document["verdict"]["worst_to_spare"]
        if document["level_1"]:
            yield "level_1.log_decrement", document["level_1"]["log_decrement_at_expected"]
            yield "level_1.times_expected", document["level_1"]["times_expected"]
        if document["level_2"]:
            yield "level_2.log_decrement", document["level_2"]["log_decrement"]
