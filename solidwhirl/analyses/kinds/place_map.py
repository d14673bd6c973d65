"""Response to one unbalance at each place in turn, over its frequency."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    Field,
)

from solidwhirl.analyses.base import (
    Engine,
    Frequencies,
    Places,
)
from solidwhirl.analyses.unbalances import (
    end_of,
    list_hz,
    peak_documents,
)
from solidwhirl.core.fields import (
    Count,
    Place,
    Positive,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.response_maps import (
    draw_place_map,
)
from solidwhirl.rotordyn.response.maps import place_map
from solidwhirl.rotordyn.response.resonance_samples import resolving_samples
from solidwhirl.rotordyn.response.unbalance import (
    Unbalance,
    frequency_ratio,
    orbit_peaks,
    response_pieces,
)


class PlaceMapSpec(Frequencies):
    """Response to one unbalance at each place in turn, over its frequency."""

    kind: Literal["place_map"]
    frequency_count: Annotated[Count, Field(ge=3, le=20001)] = 500
    places: Places
    moment_kg_m: Positive
    observe: Place | None = None

    def run(self, engine: Engine) -> Outcome:
        """Response over the place of an unbalance and its frequency."""
        places = [end_of(place) for place in self.places]
        ratio = frequency_ratio(
            engine.system,
            Unbalance(
                body=places[0].body, interface=places[0].interface, moment_kg_m=self.moment_kg_m
            ),
        )
        found = place_map(
            engine.system, places, self.moment_kg_m, _map_speeds(self, engine.system, ratio)
        )
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
            own = [
                Unbalance(body=place.body, interface=place.interface, moment_kg_m=self.moment_kg_m)
            ]
            turning = orbit_peaks(
                engine.system, own, observe or place, found.frequencies_rad_s[k], seen[k]
            )
            peaks[place.label] = peak_documents(turning, own_ratio)
        largest = int(np.unravel_index(seen.argmax(), seen.shape)[0])
        shown = observe or places[largest]
        return Outcome(
            kind=self.kind,
            document={
                "moment_kg_m": self.moment_kg_m,
                "places": list(self.places),
                "observed": self.observe or "each place itself",
                "speed_rpm": (found.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
                "amplitude_m": seen.tolist(),
                "peaks": peaks,
                "most_sensitive_place": self.places[largest],
            },
            files={
                f"{self.label}.png": lambda path: draw_place_map(found, shown, path, engine.title)
            }
            if major[:, :, found.nodes.index(shown)].any()
            else {},
            headline=f"largest at {self.places[largest]}: "
            + list_hz([p["frequency_hz"] for p in peaks[self.places[largest]]]),
        )


def _map_speeds(spec: PlaceMapSpec, system: AssembledSystem, ratio: float) -> NDArray[np.float64]:
    """Speeds [rad/s] of a place map, with further ones around its resonances."""
    places = [end_of(place) for place in spec.places]

    def respond(speeds: NDArray[np.float64]) -> NDArray[np.complex128]:
        found = place_map(system, places, spec.moment_kg_m, speeds)
        motion = found.translation_m / (found.frequencies_rad_s**2)[:, :, None, None]
        shown = np.nan_to_num(np.moveaxis(motion, 1, 0))
        return np.asarray(shown.reshape(speeds.size, -1))

    speeds = spec.frequencies_rad_s / ratio
    pieces = response_pieces(system, ratio, float(speeds[-1]))
    return resolving_samples(speeds, respond, pieces)
