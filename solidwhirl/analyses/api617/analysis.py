"""Lateral analysis of one shaft clause by clause of API 617, and zones and grades of ISO."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.api617 import pictures, told
from solidwhirl.analyses.api617.bearing_cases import (
    OWN,
    LateralAsked,
    StabilityAsked,
    bearing_case_document,
)
from solidwhirl.analyses.api617.clauses import clause_rows, verdict_of
from solidwhirl.analyses.api617.iso import iso_document
from solidwhirl.analyses.api617.records import (
    BearingCaseSpec,
    ClearanceSpec,
    Machine,
    OverhangSpec,
    ProbeSpec,
    SourceSpec,
    StageSpec,
)
from solidwhirl.analyses.api617.response import COUNT, Asked
from solidwhirl.analyses.api617.stability import Coefficients, middle_of
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock
from solidwhirl.core.fields import MOST, Name, Place, Positive
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import End
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.lateral.rigid_supports import (
    axial_m,
    first_critical_speed_rad_s,
    journal_loads_kg,
    journal_seats,
    on_rigid_supports,
    overhung_masses_kg,
)
from solidwhirl.rotordyn.lateral.unbalance_cases import Journals, PlacementRules

# Trip speed over maximum continuous speed, where none is given.
_TRIP = 1.05
_LEVEL_1: dict[Coefficients, str] = {
    "synchronous": "level I takes bearings whose coefficients depend on the frequency at the "
    'synchronous one (level_1_coefficients = "synchronous")',
    "own_frequency": "level I takes bearings whose coefficients depend on the frequency at that of "
    'the mode (level_1_coefficients = "own_frequency")',
}
# What the table of a batch has of both levels, the least of all sets of bearing laws.
_LEVELS = {
    "level_1": {"log_decrement_at_expected": "log_decrement", "times_expected": "times_expected"},
    "level_2": {"log_decrement": "log_decrement"},
}
# Eigenproblems of the stability analysis, and cases of unbalance, about.
_FOLLOWED, _CASES = 15.0, 3.0
# Names of pictures, and of the laws of the scene.
_TAKEN = ("stability", OWN.replace(" ", "_"))
# Sets of bearing laws beside that of the scene.
_MOST_CASES = 20
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
    level_1_coefficients: Coefficients = "synchronous"
    level_2: Annotated[tuple[SourceSpec, ...], Field(max_length=MOST)] = ()
    cases: Annotated[tuple[BearingCaseSpec, ...], Field(max_length=_MOST_CASES)] = ()
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

    @model_validator(mode="after")
    def _unlike(self) -> Api617Spec:
        files = [case.file_part.lower() for case in self.cases]
        again = sorted({part for part in files if files.count(part) > 1 or part in _TAKEN})
        if again:
            raise ValueError(
                f"cases: {again[0]!r} would name a picture twice; give each case a name of its own"
            )
        return self

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return the names of its pictures: responses of each set of bearing laws, and damping."""
        endings = (*self._endings.values(), "_stability")
        return tuple(f"{self.label}{ending}.png" for ending in endings)

    @property
    def _endings(self) -> dict[str, str]:
        """What the picture of each set of bearing laws has after the name."""
        return {OWN: "", **{case.name: f"_{case.file_part}" for case in self.cases}}

    def missing(self, operating: Sequence[base.Operating]) -> str | None:
        """Return what it is not told of its shaft and speeds; None if nothing is missing.

        `operating`: of all shafts, by `[[operating]]` of the scene.
        """
        shafts = list(dict.fromkeys(o.shaft for o in base.given_speeds(operating)))
        if self.shaft is None and len(shafts) != 1:
            return f"shaft: missing; [[operating]] has {shafts or 'no shaft'}, one would do"
        known = any(o.is_of([self.shaft or shafts[0]]) for o in operating)
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
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float]
    ) -> Machine:
        """Return the shaft and its speeds, from its own keys or those of the scene."""
        shaft = self.shaft or operating[0].shaft
        own = [o for o in operating if o.is_of([shaft])]
        low = self.minimum_speed_rpm or min(o.from_rpm for o in own)
        high = self.maximum_continuous_rpm or max(o.to_rpm for o in own)
        return Machine(shaft, low, high, self.trip_rpm or _TRIP * high, ratio(shaft))

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
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
        return solved.and_also(size.search.times(_CASES)).times(1.0 + len(self.cases))

    def run(self, engine: base.Engine) -> Outcome:
        """All clauses, from the responses and modes that they ask for."""
        machine = self.machine(engine.running(()), lambda s: abs(engine.speed_ratios[s]))
        system, shaft = engine.system, machine.shaft
        top = machine.reference_rad_s(machine.high_rpm)
        seats = journal_seats(system, shaft, top, self.journals)
        rigid = on_rigid_supports(system, shaft, seats)
        first = first_critical_speed_rad_s(rigid, shaft, machine.high_rpm * RAD_S_PER_RPM)
        journals = Journals(
            seats=seats,
            loads_kg=journal_loads_kg(rigid, list(seats)),
            overhung_kg=self._overhung(engine, shaft, seats),
        )
        asked = self._asked(engine, machine, journals, first * RPM_PER_RAD_S)
        found = {OWN: bearing_case_document(system, {}, asked)}
        for case in self.cases:
            changed = engine.with_laws(case.laws)
            found[case.name] = bearing_case_document(changed, case.laws, asked)
        document = self._machine_document(engine, machine, journals) | {
            "assumptions": list(self._assumptions(machine)),
            "first_critical_on_rigid_supports_rpm": first * RPM_PER_RAD_S,
            "stability_is_asked": machine.high_rpm * RAD_S_PER_RPM > first,
            "bearing_cases": found,
        }
        places = [journal["axial_m"] for journal in document["journals"]]
        bodies = [rotor.element for rotor in rigid.system.rotors.values()]
        document["iso"] = iso_document(found, places, bodies, machine, self.balance_grade)
        rows = clause_rows(document)
        ratios = engine.speed_ratios
        own = [name for name, ratio in ratios.items() if ratio == ratios[machine.shaft]]
        speeds = base.Operating(shaft, machine.low_rpm, machine.high_rpm, machine.ratio, (*own,))
        verdict = verdict_of(rows) | {
            "judged": own,
            "not_judged": [n for n, ratio in ratios.items() if ratio != 0.0 and n not in own],
            "judged_text": base.judged_text([speeds], ratios),
        }
        word = {"fail": "FAIL"}.get(verdict["verdict"], verdict["verdict"])
        return Outcome(
            kind=self.kind,
            document={"verdict": verdict, "clauses": rows, **document},
            headline="; ".join(
                text
                for text in (
                    f"{word} by API 617, {told.edition_text(self.edition)}: {verdict['why']}",
                    verdict["judged_text"],
                )
                if text
            ),
        )

    def _asked(
        self, engine: base.Engine, machine: Machine, journals: Journals, first_critical_rpm: float
    ) -> LateralAsked:
        """What every set of bearing laws is asked."""
        middle = middle_of(engine.system, machine.shaft, journals.seats)
        return LateralAsked(
            journals=journals,
            rules=PlacementRules(
                speed_max_rpm=machine.high_rpm,
                factor=self.unbalance_factor,
                inboard=self.inboard_threshold,
                outboard=self.outboard_threshold,
            ),
            response=Asked(
                machine=machine, edition=self.edition, range_factor=self.range_factor,
                probes=self.probes, clearances=self.clearances,
            ),
            stability=StabilityAsked(
                stages=self.stages,
                sources=self.level_2,
                applied_at=[end_of(place) for place in self.applied_at] or [middle],
                coefficients=self.level_1_coefficients,
                first_critical_rpm=first_critical_rpm,
            ),
        )  # fmt: skip

    def _machine_document(
        self, engine: base.Engine, machine: Machine, journals: Journals
    ) -> dict[str, Any]:
        return {
            "note": "computed in the manner of API 617; it certifies nothing",
            "edition": self.edition,
            "shaft": machine.shaft,
            "speeds": {
                "minimum_rpm": machine.low_rpm,
                "maximum_continuous_rpm": machine.high_rpm,
                "trip_rpm": machine.trip_rpm,
            },
            "journals": [
                {
                    "bearing": name,
                    "at": end.label,
                    "axial_m": axial_m(engine.system, end),
                    "load_kg": journals.loads_kg[name],
                }
                for name, end in journals.seats.items()
            ],
            "overhung_kg": list(journals.overhung_kg),
        }

    def _overhung(
        self, engine: base.Engine, shaft: str, seats: Mapping[str, End]
    ) -> tuple[float, float]:
        """Masses beyond the outer journals, those that are given in place of computed ones."""
        below, above = overhung_masses_kg(engine.system, shaft, seats, engine.masses_beyond)
        names = list(seats)
        given = {own.bearing: own.mass_kg for own in self.overhangs}
        return given.get(names[0], below), given.get(names[-1], above)

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
            "masses beyond outer journals are those of the drawn body beyond the middle of the "
            "journal, with the disks there; of a body without a drawing what weighs on interfaces "
            "(overhangs)"
        )
        if self.trip_rpm is None:
            yield f"trip speed {machine.trip_rpm:g} rpm, 1.05 times the maximum (trip_rpm)"
        yield "numbers of clauses, and that probes must keep to the limit without scaling"
        yield "seals with floating rings keep no clearance (floating_ring)"
        yield "stability is asked for above the first undamped critical speed on rigid supports"
        yield "level II asks for a log decrement of 0.1 at least"
        yield "borders of region B as read off the figure; zones of ISO 20816-3 as of 7919-3"
        if not self.cases:
            yield (
                "one set of bearing laws, that of the scene: smallest and largest clearance, "
                "preload and oil temperature are further sets (cases)"
            )
        if self.stages:
            yield _LEVEL_1[self.level_1_coefficients]
            left_out = [name for source in self.level_2 for name in source.bearings or ()]
            yield (
                f"level I leaves out {', '.join(left_out) or 'no bearing'} (level_2 names what it "
                "leaves out); level II takes each bearing at the frequency of the mode"
            )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Responses of every case; damping over applied cross-coupling where it was computed."""
        document = found.document
        drawn: dict[str, base.Charts] = {}
        for name, ending in self._endings.items():
            if document["bearing_cases"][name]["cases"]:
                drawn[ending] = partial(pictures.response_charts, document, name)
        if self.stages:
            drawn["_stability"] = partial(pictures.stability_charts, document)
        return drawn

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
        kinds |= dict.fromkeys(("bearings", "clause", "what", "where", "verdict"), str)
        return Labels(
            {k: ("row", np.array([row[k] for row in rows], kind)) for k, kind in kinds.items()}
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield whether it passes, what is least to spare, and the damping of both levels."""
        yield "passed", float(document["verdict"]["passed"])
        yield "undecided", float(document["verdict"]["verdict"] == "undecided")
        yield "worst_to_spare", document["verdict"]["worst_to_spare"]
        for level, keys in _LEVELS.items():
            own = [found[level] for found in document["bearing_cases"].values() if found[level]]
            for key, name in keys.items():
                yield f"{level}.{name}", base.smallest_of(one[key] for one in own)
