"""Response to unbalances over the speed: amplitude, phase, orbits and bearing forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import (
    PEAK_HEAD,
    ROUNDING,
    UnbalanceSpec,
    amplitudes_of,
    end_of,
    listed_peaks,
    numbered,
    parts,
    peak_documents,
    peak_row,
    turning_at,
    unbalance_of,
)
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, numbers
from solidwhirl.core.fields import MOST, Count, NotNegative, Positive
from solidwhirl.core.outcome import MOST_CURVES, MOST_ORBITS, Outcome, PageSection
from solidwhirl.core.plain_data import Labelled, Labels
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Chart, operating_toggle

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem, End
    from solidwhirl.rotordyn.plots.response import ExciterCurves
    from solidwhirl.rotordyn.response.unbalance import ExciterResponse, Unbalance

# Speeds at which it is checked by other means, where bearings follow the speed.
_CHECKED = 100.0
# Frequencies at which the response is solved for its peaks, beside those asked for.
_RESOLVED = 2500.0
# Speeds whose orbits can be chosen.
_MOST_ORBITS = 12


class UnbalanceResponseSpec(base.Sweep):
    """Response to unbalances over the speed: amplitude, phase, orbits and bearing forces."""

    section = PageSection(
        "unbalance",
        "Unbalance response",
        "Steady motion and bearing forces while the shafts turn with the unbalances of the scene.",
        80,
    )
    turning: ClassVar = {"at": base.UNBALANCE_TURNS}

    kind: Literal["unbalance_response"]
    count: Annotated[Count, Field(ge=4, le=20001)] = 201
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(min_length=1, max_length=MOST)]
    observe: base.Places
    orbits_at_rpm: Annotated[tuple[Positive, ...], Field(max_length=64)] = ()
    speed_rpm: NotNegative | None = None

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return pictures, each with the curves that have room in it."""
        places = len(parts(list(self.observe), MOST_CURVES))
        counts = {
            "": places,
            "_bearing_forces": len(parts(list(bearings), MOST_CURVES)),
            "_orbits": places * len(parts(list(self.orbits_at_rpm), MOST_ORBITS)),
        }
        return tuple(
            f"{self.label}{what}{suffix}.png"
            for what, count in counts.items()
            for suffix, _ in numbered(list(range(count)))
        )

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        solved = size.shafts * (self.count + _RESOLVED)
        peaks = Work(eigenproblems=20.0, factorisations=12.0)
        if size.kind == "isotropic" and size.whole:
            peaks = Work(eigenproblems=200.0, factorisations=120.0, checks=_CHECKED)
        elif size.kind == "isotropic":
            peaks = Work(eigenproblems=90.0, continued=280.0, factorisations=200.0, checks=_CHECKED)
        elif size.laws:
            each = Work(eigenproblems=0.9, continued=0.6, factorisations=1.65)
            peaks = each.times(self.count).and_also(Work(checks=_CHECKED))
        elif size.kind == "hermitian":
            peaks = Work()
        values = 12.0 * size.bodies * solved
        return peaks.and_also(Work(solves=float(solved), results=self.count, values=values))

    def run(self, engine: base.Engine) -> Outcome:
        """Unbalance response over the speed at the places that the engine observes."""
        from solidwhirl.rotordyn.response.unbalance import resolving_speeds, unbalance_response

        unbalances = [unbalance_of(u) for u in self.unbalances]
        system, spin = engine.system, base.spin_of(self.speed_rpm)
        speeds = resolving_speeds(system, unbalances, self.speeds_rad_s, spin)
        response = unbalance_response(system, unbalances, speeds, spin)
        nodes = [end_of(place) for place in self.observe]
        exciters = [
            _exciter_document(
                e, nodes, system, turning_at(system, unbalances, e.frequency_ratio), spin
            )
            for e in response.exciters
        ]
        first = self.observe[0]
        said = [
            (f"excited by {', '.join(e['bodies'])}: " if len(exciters) > 1 else "")
            + listed_peaks(e["peaks"][first])
            for e in exciters
        ]
        return Outcome(
            kind=self.kind,
            document={
                "speed_rpm": (response.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "spin_rpm": self.speed_rpm,
                "unbalances": [u.model_dump() for u in self.unbalances],
                "exciters": exciters,
            },
            headline=f"peaks at {first}: " + "; ".join(said),
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Each with as many curves as can be told apart, the others in further ones."""
        exciters = exciters_of(found.document)
        places = parts(list(dict.fromkeys(self.observe)), MOST_CURVES)
        pictures: dict[str, base.Charts] = {}
        for suffix, own in numbered([_at_places(exciters, some) for some in places]):
            pictures[suffix] = partial(self._motion_charts, own)
        for suffix, some in numbered(parts(list(exciters[0].force_n), MOST_CURVES)):
            own = [replace(e, force_n={n: e.force_n[n] for n in some}) for e in exciters]
            pictures[f"_bearing_forces{suffix}"] = partial(self._force_charts, own)
        speeds = parts(sorted(set(self.orbits_at_rpm)), MOST_ORBITS)
        for suffix, asked in numbered([(some, at) for some in places for at in speeds]):
            pictures[f"_orbits{suffix}"] = partial(self._orbits, found.engine, *asked)
        return pictures

    def _motion_charts(self, exciters: Sequence[ExciterCurves]) -> list[Chart]:
        from solidwhirl.rotordyn.plots.response import amplitude_chart, phase_chart

        drawn = amplitude_chart(exciters), phase_chart(exciters)
        return [base.over_speed_of_force(chart, self.speed_rpm) for chart in drawn]

    def _force_charts(self, exciters: Sequence[ExciterCurves]) -> list[Chart]:
        from solidwhirl.rotordyn.plots.response import force_chart

        return [base.over_speed_of_force(force_chart(exciters), self.speed_rpm)]

    def _orbits(
        self, engine: base.Engine, places: list[str], speeds_rpm: list[float]
    ) -> list[Chart]:
        """Orbits of some places at exactly these speeds."""
        from solidwhirl.rotordyn.plots.response import ExciterCurves, orbit_chart
        from solidwhirl.rotordyn.response.unbalance import unbalance_response

        unbalances = [unbalance_of(u) for u in self.unbalances]
        speeds = [rpm * RAD_S_PER_RPM for rpm in speeds_rpm]
        found = unbalance_response(engine.system, unbalances, speeds, base.spin_of(self.speed_rpm))
        exciters = [
            ExciterCurves(
                bodies=e.bodies,
                frequency_ratio=e.frequency_ratio,
                speed_rpm=np.array(speeds_rpm),
                motion_m={p: e.at_node(end_of(p).body, end_of(p).interface) for p in places},
            )
            for e in found.exciters
        ]
        chart = orbit_chart([(e, range(len(speeds))) for e in exciters])
        return [] if chart is None else [chart]

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Unbalances, motion and forces over the speed, orbits and peaks."""
        from solidwhirl.rotordyn.plots.response import orbit_chart

        exciters = exciters_of(found.document)
        amplitude, phase = self._motion_charts(exciters)
        drawn = [amplitude]
        if any(e.force_n for e in exciters):
            drawn += self._force_charts(exciters)
        shades = operating_toggle(base.reference_ranges_rad_s(found.engine.operating))
        drawn = [replace(chart, parts=[*shades, *chart.parts]) for chart in drawn]
        drawn.insert(1, phase)
        orbits = orbit_chart([(e, _rows(e, self.orbits_at_rpm)) for e in exciters])
        unbalances = Table(
            title="Unbalances",
            head=["at", "mass times distance [kg m]", "angle [°]"],
            rows=[
                [u["at"], float(u["moment_kg_m"]), float(u["phase_deg"])]
                for u in found.document["unbalances"]
            ],
        )
        peaks = _peak_table(found.document)
        return [
            unbalances,
            *drawn,
            *([] if orbits is None else [orbits]),
            *([peaks] if peaks.rows else []),
        ]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Motion of places and forces in bearings, exciter by exciter."""
        exciters = document["exciters"]
        places, bearings = list(exciters[0]["places"]), list(exciters[0]["bearing_force_n"])
        at_place = ("exciter", "place", "speed_rpm")
        variables: dict[str, Labelled] = {
            key: (at_place, [[e["places"][place][key] for place in places] for e in exciters])
            for key in exciters[0]["places"][places[0]]
        }
        if bearings:
            forces = [[e["bearing_force_n"][name] for name in bearings] for e in exciters]
            variables["bearing_force_n"] = (("exciter", "bearing", "speed_rpm"), forces)
        return Labels(
            variables,
            {
                "exciter": ("exciter", [", ".join(e["bodies"]) for e in exciters]),
                "place": ("place", places),
                **({"bearing": ("bearing", bearings)} if bearings else {}),
                "speed_rpm": ("speed_rpm", document["speed_rpm"]),
                "frequency_hz": (("exciter", "speed_rpm"), [e["frequency_hz"] for e in exciters]),
            },
        )

    @classmethod
    def peaks(cls, document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        """Yield its resonance peaks."""
        for e in document["exciters"]:
            for place, peaks in e["peaks"].items():
                exciter = ", ".join(e["bodies"])
                yield from ({"place": place, "exciter": exciter, **peak} for peak in peaks)

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest amplitudes, peaks and forces.

        Bodies of other speeds excite apart: their names tell the responses from each other.
        """
        exciters = document["exciters"]
        for exciter in exciters:
            mark = f"{'+'.join(exciter['bodies'])}." if len(exciters) > 1 else ""
            for place, orbit in exciter["places"].items():
                yield f"{mark}{place}.largest_amplitude_m", base.largest_of(orbit["major_m"])
                yield from base.peak_scalars(f"{mark}{place}", exciter["peaks"].get(place, ()))
            for bearing, force in exciter["bearing_force_n"].items():
                yield f"{mark}{bearing}.largest_force_n", base.largest_of(force)


def _exciter_document(
    exciter: ExciterResponse,
    nodes: list[End],
    system: AssembledSystem,
    unbalances: list[Unbalance],
    spin_rad_s: float | None,
) -> dict[str, Any]:
    from solidwhirl.rotordyn.response.orbits import elliptic_orbits
    from solidwhirl.rotordyn.response.unbalance import orbit_peaks

    ratio = exciter.frequency_ratio
    moving = exciter.frequencies_rad_s > 0.0
    documents, peaks = {}, {}
    orbits = exciter.orbits()
    rates, largest = exciter.frequencies_rad_s[moving], np.nanmax(orbits.major_m[moving], axis=1)
    for node in nodes:
        at = exciter.nodes.index(node)
        amplitude = exciter.translation_m[:, at]
        documents[node.label] = {
            "amplitude_x_m": np.abs(amplitude[:, 0]).tolist(),
            "amplitude_y_m": np.abs(amplitude[:, 1]).tolist(),
            "phase_x_deg": np.degrees(np.angle(amplitude[:, 0])).tolist(),
            "phase_y_deg": np.degrees(np.angle(amplitude[:, 1])).tolist(),
            "major_m": orbits.major_m[:, at].tolist(),
            "minor_m": orbits.minor_m[:, at].tolist(),
            "orbit": orbits.direction[:, at].tolist(),
        }
        found = orbit_peaks(
            *(system, unbalances, node, rates, orbits.major_m[moving, at]),
            least_m=ROUNDING * largest,
            spin_rad_s=spin_rad_s,
        )
        peaks[node.label] = peak_documents(found, ratio)
    return {
        "bodies": list(exciter.bodies),
        "frequency_ratio": ratio,
        "frequency_hz": (exciter.frequencies_rad_s / (2.0 * np.pi)).tolist(),
        "places": documents,
        "peaks": peaks,
        "bearing_force_n": {
            name: elliptic_orbits(force[:, 0], force[:, 1]).major_m.tolist()
            for name, force in exciter.bearing_forces.items()
        },
        "largest_relative_residual": float(np.max(exciter.relative_residual)),
    }


def exciters_of(document: Mapping[str, Any]) -> list[ExciterCurves]:
    """Return the curves of an unbalance response from its document."""
    from solidwhirl.rotordyn.plots.response import ExciterCurves, Peak

    return [
        ExciterCurves(
            bodies=e["bodies"],
            frequency_ratio=e["frequency_ratio"],
            speed_rpm=numbers(document["speed_rpm"]),
            motion_m={place: amplitudes_of(motion) for place, motion in e["places"].items()},
            force_n={name: numbers(f) for name, f in e["bearing_force_n"].items()},
            peaks={
                place: [Peak(p["speed_rpm"], p["amplitude_m"], _peak_text(p)) for p in peaks]
                for place, peaks in e["peaks"].items()
            },
        )
        for e in document["exciters"]
    ]


def _at_places(exciters: Sequence[ExciterCurves], places: list[str]) -> list[ExciterCurves]:
    """The exciters with the motion of some places only."""
    return [replace(e, motion_m={p: e.motion_m[p] for p in places}) for e in exciters]


def _peak_text(peak: Mapping[str, Any]) -> str:
    from solidwhirl.rotordyn.plots.campbell import error_words

    words = [f"{peak['frequency_hz']:.6g} Hz"]
    if peak["amplification"] is not None:
        words.append(f"amplification factor {peak['amplification']:.3g}")
    if peak.get("frequency_error_estimate") is not None:
        words.append(f"error of the speed {error_words(peak['frequency_error_estimate'])}")
    return "\n".join(words)


def _rows(exciter: ExciterCurves, wanted: Sequence[float]) -> list[int]:
    """Numbers of the speeds that are wanted and of the highest peaks of all places."""
    peaks = sorted(chain.from_iterable(exciter.peaks.values()), key=lambda p: -p.height)
    speeds = [*wanted, *(p.speed_rpm for p in peaks[:_MOST_ORBITS])]
    near = (int(np.abs(exciter.speed_rpm - speed).argmin()) for speed in speeds)
    return sorted(list(dict.fromkeys(near))[:_MOST_ORBITS])


def _peak_table(document: Mapping[str, Any]) -> Table:
    rows = [
        [place, ", ".join(exciter["bodies"]), *peak_row(p)]
        for exciter in document["exciters"]
        for place, peaks in exciter["peaks"].items()
        for p in peaks
    ]
    return Table(
        head=["place", "unbalance of", *PEAK_HEAD],
        rows=rows,
        folded=f"Resonance peaks ({len(rows)})",
        caption="Without damping a peak has no height; its place is a critical speed.",
    )
