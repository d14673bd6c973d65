"""Response to one unbalance at each place in turn, over its frequency."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import (
    PEAK_HEAD,
    end_of,
    peak_documents,
    peak_row,
    unbalance_at,
)
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, numbers
from solidwhirl.core.fields import Count, NotNegative, Place, Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.response_maps import place_chart
from solidwhirl.rotordyn.response.maps import place_map
from solidwhirl.rotordyn.response.resonance_samples import resolving_samples
from solidwhirl.rotordyn.response.unbalance import (
    frequency_ratio,
    orbit_peaks,
    response_pieces,
)


class PlaceMapSpec(base.Frequencies):
    """Response to one unbalance at each place in turn, over its frequency."""

    section = base.RESPONSE_MAPS
    turning: ClassVar = {"places": base.UNBALANCE_TURNS}

    kind: Literal["place_map"]
    frequency_count: Annotated[Count, Field(ge=3, le=20001)] = 500
    places: base.Places
    moment_kg_m: Positive
    observe: Place | None = None
    speed_rpm: NotNegative | None = None

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield the speed of the highest frequency, where the unbalance turns at each of them."""
        if self.speed_rpm is not None:
            return
        yield from base.synchronous_speed(self.places[0], self.frequency_max_hz, ratio, where)

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        solved = len(self.places) * self.frequency_count
        # every place has peaks of its own
        return Work(
            eigenproblems=15.0,
            factorisations=30.0,
            solves=1.7 * solved,
            results=len(self.places),
            values=2.0 * solved,
        )

    def run(self, engine: base.Engine) -> Outcome:
        """Response over the place of an unbalance and its frequency."""
        places = [end_of(place) for place in self.places]
        unbalances = [unbalance_at(place, self.moment_kg_m) for place in self.places]
        ratio = frequency_ratio(engine.system, unbalances[0])
        spin = base.spin_of(self.speed_rpm)
        speeds = _map_speeds(self, engine.system, ratio)
        found = place_map(engine.system, places, self.moment_kg_m, speeds, spin)
        observe = end_of(self.observe) if self.observe else None
        major = found.major_m()
        at = [found.nodes.index(place) for place in places]
        seen = (
            major[:, :, found.nodes.index(observe)]
            if observe is not None
            else np.stack([major[k, :, own] for k, own in enumerate(at)])
        )
        peaks = {}
        for k, place in enumerate(places):
            own_ratio = float(found.frequencies_rad_s[k, -1] / found.speeds_rad_s[-1])
            rates = found.frequencies_rad_s[k]
            asked = engine.system, [unbalances[k]], observe or place, rates, seen[k]
            turning = orbit_peaks(*asked, spin_rad_s=spin)
            peaks[place.label] = peak_documents(turning, own_ratio)
        largest = self.places[int(np.unravel_index(seen.argmax(), seen.shape)[0])]
        said = ", ".join(f"{p['frequency_hz']:.2f}" for p in peaks[largest])
        return Outcome(
            kind=self.kind,
            document={
                "moment_kg_m": self.moment_kg_m,
                "places": list(self.places),
                "observed": self.observe or "each place itself",
                "spin_rpm": self.speed_rpm,
                "speed_rpm": (found.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
                "amplitude_m": seen.tolist(),
                "peaks": peaks,
                "most_sensitive_place": largest,
            },
            headline=f"largest at {largest}: {f'{said} Hz' if said else 'none'}",
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The response, if there is any."""
        moved = numbers(found.document["amplitude_m"]).any()
        return {"": lambda: [self._chart(found.document)]} if moved else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The response and its peaks."""
        rows = [
            [place, *peak_row(p)] for place, peaks in found.document["peaks"].items() for p in peaks
        ]
        head = ["unbalance at", *PEAK_HEAD]
        table = Table(head=head, rows=rows, folded=f"Peaks ({len(rows)})")
        return [self._chart(found.document), *([table] if rows else [])]

    def _chart(self, document: Mapping[str, Any]) -> Chart:
        rpm = numbers(document["speed_rpm"])
        shape = (len(self.places), rpm.size)
        hertz, size = (numbers(document[k]).reshape(shape) for k in ("frequency_hz", "amplitude_m"))
        caption = (
            f"Displacement (major semi-axis) of {document['observed']} for {self.moment_kg_m:g} "
            f"kg m at each place. Most sensitive: {document['most_sensitive_place']}."
        )
        chart = replace(place_chart(self.places, rpm, hertz, size), caption=caption)
        return base.over_speed_of_force(chart, self.speed_rpm)

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Amplitude over place and speed."""
        over = ("place", "speed_rpm")
        return Labels(
            {"amplitude_m": (over, document["amplitude_m"])},
            {
                "place": ("place", document["places"]),
                "speed_rpm": ("speed_rpm", document["speed_rpm"]),
                "frequency_hz": (over, document["frequency_hz"]),
            },
        )

    @classmethod
    def peaks(cls, document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        """Yield its resonance peaks."""
        for place, peaks in document["peaks"].items():
            yield from ({"place": place, "exciter": place.partition(".")[0], **p} for p in peaks)

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest amplitude and the highest peak of each place."""
        for place, amplitudes in zip(document["places"], document["amplitude_m"], strict=True):
            yield f"{place}.largest_amplitude_m", base.largest_of(amplitudes)
            yield from base.peak_scalars(place, document["peaks"].get(place, ()))


def _map_speeds(spec: PlaceMapSpec, system: AssembledSystem, ratio: float) -> NDArray[np.float64]:
    """Speeds [rad/s] of a place map, with further ones around its resonances."""
    places = [end_of(place) for place in spec.places]

    def respond(speeds: NDArray[np.float64]) -> NDArray[np.complex128]:
        found = place_map(system, places, spec.moment_kg_m, speeds, base.spin_of(spec.speed_rpm))
        motion = found.translation_m / (found.frequencies_rad_s**2)[:, :, None, None]
        shown = np.nan_to_num(np.moveaxis(motion, 1, 0))
        return np.asarray(shown.reshape(speeds.size, -1))

    speeds = spec.frequencies_rad_s / ratio
    pieces = response_pieces(system, ratio, float(speeds[-1]), base.spin_of(spec.speed_rpm))
    return resolving_samples(speeds, respond, pieces)
