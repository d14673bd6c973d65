"""Steady motion of an asymmetric rotor, by multiples of the speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import UnbalanceSpec, end_of, unbalance_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import MOST, Count, Finite, Name, Place, Positive, Record
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn.asymmetric import RotatingSystem
from solidwhirl.rotordyn.asymmetric.loads import (
    Bow,
    bow_force,
    gravity_force,
    own_unbalance,
    unbalance_force,
)
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics
from solidwhirl.rotordyn.asymmetric.resonances import (
    Resonance,
    critical_speeds,
    gravity_critical_speeds,
)
from solidwhirl.rotordyn.asymmetric.response import SteadyResponse, speeds_with, steady_response
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.asymmetric import multiples_chart

# Speeds beside a resonance, in half widths; and the least damping that makes it one to look at.
_BESIDE, _DAMPED = (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0), 1e-5
# Motion below this part of the largest is not shown.
_SEEN = 1e-6
# And of the headline.
_TOLD = 1e-2
# Systems of equations of harmonics of the turn that are coupled, in those of one.
_COUPLED = 600.0


class BowSpec(Record):
    """A shaft that is bent at rest: how far, measured from the line between two interfaces."""

    at: Place
    between: tuple[Name, Name]
    bow_m: Positive
    phase_deg: Finite = 0.0


class AsymmetricResponseSpec(base.Sweep):
    """Steady motion of an asymmetric rotor over the speed, by multiples of the speed."""

    section = PageSection(
        "asymmetric-response",
        "Response of the asymmetric rotor",
        "Unbalance at a fixed angle of the body and a bow act once per turn, weight twice; "
        "anisotropic supports add further multiples.",
        82,
    )
    turning: ClassVar = {"at": "an unbalance and a bow turn with their body"}
    of_bodies = "asymmetric"

    kind: Literal["asymmetric_response"]
    count: Annotated[Count, Field(ge=4, le=20001)] = 201
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(max_length=MOST)] = ()
    own_unbalance: bool = True
    gravity_m_per_s2: tuple[Finite, Finite, Finite] | None = None
    bows: Annotated[tuple[BowSpec, ...], Field(max_length=MOST)] = ()
    observe: base.Places

    @model_validator(mode="after")
    def _loaded(self) -> AsymmetricResponseSpec:
        if not (self.unbalances or self.own_unbalance or self.gravity_m_per_s2 or self.bows):
            raise ValueError(
                "nothing acts: give unbalances, gravity_m_per_s2 or bows, or own_unbalance = true"
            )
        return self

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return a picture for each place."""
        return tuple(f"{self.label}{suffix}.png" for suffix in self._suffixes())

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve: anisotropic supports couple harmonics of the turn."""
        solved = self.count * (_COUPLED if size.uneven else 1.0)
        return Work(solves=solved, results=20.0, values=30.0 * self.count * len(self.observe))

    def run(self, engine: base.Engine) -> Outcome:
        """Motion and bearing forces over the speed, by multiples of the speed."""
        rotating = engine.rotating
        assert rotating is not None
        ratio = abs(rotating.frame_ratio)
        asked = self.speeds_rad_s * ratio
        asked = asked[asked > 0.0]
        span = (float(asked.min()), float(asked.max()))
        found = (*critical_speeds(rotating, *span), *gravity_critical_speeds(rotating, *span))
        speeds = speeds_with(asked, _beside(found))
        constant, turning = self._loads(rotating)
        motion = steady_response(rotating, speeds, constant=constant, centrifugal=turning)
        rpm = speeds / ratio * RPM_PER_RAD_S
        motion = _without_rounding(motion)
        places = {place: _place_document(motion, place) for place in self.observe}
        first = places[self.observe[0]]["major_m"]
        largest = {h: float(np.nanmax(first[h])) for h in first if h != "0"}
        seen = _TOLD * max(largest.values(), default=0.0)
        said = ", ".join(f"{h} × speed {size:.3g} m" for h, size in largest.items() if size > seen)
        return Outcome(
            kind=self.kind,
            document={
                "speed_rpm": rpm.tolist(),
                "multiples": motion.multiples.tolist(),
                "unbalances": [u.model_dump() for u in self.unbalances],
                "own_unbalance": self.own_unbalance,
                "gravity_m_per_s2": self.gravity_m_per_s2,
                "bows": [b.model_dump() for b in self.bows],
                "places": {
                    place: {key: {h: v.tolist() for h, v in own.items()} for key, own in d.items()}
                    for place, d in places.items()
                },
                "bearing_force_n": {
                    name: {
                        str(h): _major(force[:, k, :2], is_constant=h == 0).tolist()
                        for k, h in enumerate(motion.multiples)
                    }
                    for name, force in motion.bearing_forces.items()
                },
            },
            headline=f"largest at {self.observe[0]}: {said or 'no motion'}",
        )

    def _loads(self, rotating: RotatingSystem) -> tuple[Harmonics, FloatArray]:
        """Constant loads by harmonic, and the load that grows with the square of the speed."""
        constant: Harmonics = {}
        if self.gravity_m_per_s2 is not None:
            constant |= gravity_force(rotating, self.gravity_m_per_s2)
        if self.bows:
            bows = [
                Bow(
                    body=end_of(b.at).body,
                    interface=end_of(b.at).interface,
                    between=b.between,
                    bow_m=b.bow_m,
                    phase_rad=float(np.radians(b.phase_deg)),
                )
                for b in self.bows
            ]
            constant[0] = constant.get(0, 0.0) + bow_force(rotating, bows)
        turning = unbalance_force(rotating, [unbalance_of(u) for u in self.unbalances])
        return constant, turning + own_unbalance(rotating) if self.own_unbalance else turning

    def _suffixes(self) -> list[str]:
        return [f"_{k + 1}" if k else "" for k in range(len(self.observe))]

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The motion of each place."""
        return {
            suffix: partial(_charts, found.document, place)
            for suffix, place in zip(self._suffixes(), self.observe, strict=True)
        }

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The motion of all places."""
        return [chart for place in self.observe for chart in _charts(found.document, place)]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Semi-axes over place, multiple and speed."""
        over = ("place", "multiple", "speed_rpm")
        places, multiples = document["places"], document["multiples"]
        sizes = [[own["major_m"][str(h)] for h in multiples] for own in places.values()]
        return Labels(
            {"major_m": (over, sizes)},
            {
                "place": ("place", list(places)),
                "multiple": ("multiple", multiples),
                "speed_rpm": ("speed_rpm", document["speed_rpm"]),
            },
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest motion of each place by multiples of the speed."""
        for place, own in document["places"].items():
            for h, sizes in own["major_m"].items():
                yield f"{place}.largest_{h}x_m", base.largest_of(sizes)


def _without_rounding(motion: SteadyResponse) -> SteadyResponse:
    """The motion without multiples that are nowhere more than a millionth of the largest."""
    sizes = np.abs(motion.translation_m).max(axis=(0, 2, 3))
    last = int(np.flatnonzero(sizes > _SEEN * sizes.max())[-1]) if sizes.any() else 0
    return replace(
        motion,
        multiples=motion.multiples[: last + 1],
        translation_m=motion.translation_m[:, : last + 1],
        tilt_rad=motion.tilt_rad[:, : last + 1],
        bearing_forces={n: f[:, : last + 1] for n, f in motion.bearing_forces.items()},
    )


def _beside(found: Sequence[Resonance]) -> list[float]:
    """Speeds at which peaks with damping are seen."""
    return [
        one.speed_rad_s * (1.0 + side * one.damping_ratio)
        for one in found
        if one.damping_ratio > _DAMPED
        for side in _BESIDE
    ]


def _place_document(motion: SteadyResponse, place: str) -> dict[str, dict[str, FloatArray]]:
    """Semi-axes and circles of a place by multiple, (s,) each."""
    node = motion.nodes.index(end_of(place))
    out: dict[str, dict[str, FloatArray]] = {"major_m": {}, "forward_m": {}, "backward_m": {}}
    for k, h in enumerate(motion.multiples):
        own = motion.translation_m[:, k, node]
        out["major_m"][str(h)] = _major(own, is_constant=h == 0)
        out["forward_m"][str(h)] = 0.5 * np.abs(own[:, 0] + 1j * own[:, 1])
        out["backward_m"][str(h)] = 0.5 * np.abs(own[:, 0] - 1j * own[:, 1])
    return out


def _major(amplitudes: Any, *, is_constant: bool) -> FloatArray:
    """Major semi-axis of amplitudes along x and y, (s, 2); the size of what is constant."""
    if is_constant:
        return np.asarray(np.hypot(*np.moveaxis(amplitudes.real, -1, 0)))
    x, y = np.moveaxis(amplitudes, -1, 0)
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)))


def _charts(document: Mapping[str, Any], place: str) -> list[Any]:
    own = {h: numbers(v) for h, v in document["places"][place]["major_m"].items()}
    largest = max((float(np.nanmax(v, initial=0.0)) for v in own.values()), default=0.0)
    shown = {
        f"{h} × speed" if h != "0" else "constant": v
        for h, v in own.items()
        if float(np.nanmax(v, initial=0.0)) > _SEEN * largest
    }
    return [multiples_chart(numbers(document["speed_rpm"]), shown, place)]
