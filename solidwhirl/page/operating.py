"""Operating speeds that a scene names in its analyses, for charts over the speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from solidwhirl.page.traces import Trace, analyses_of_kind, band


class Operating(NamedTuple):
    """Speeds of a shaft itself between which it runs, rpm, and its ratio to the reference."""

    shaft: str
    from_rpm: float
    to_rpm: float
    ratio: float

    @property
    def text(self) -> str:
        """What a legend says."""
        same = self.from_rpm == self.to_rpm
        speeds = f"{self.to_rpm:g}" if same else f"{self.from_rpm:g} to {self.to_rpm:g}"
        return f"operating speed of {self.shaft}, {speeds} rpm"


def operating_speeds(
    document: Mapping[str, Any], ratios: Mapping[str, float]
) -> tuple[Operating, ...]:
    """Return the operating speeds of shafts, each once.

    Parameters
    ----------
    document
        The contents of `results.json`.
    ratios
        Speed ratio of every body.
    """
    found: list[Operating] = []
    for entry in analyses_of_kind(document, "separation_margins").values():
        found += [
            Operating(o["shaft"], o["from_rpm"], o["to_rpm"], abs(ratios[o["shaft"]]))
            for o in entry["operating"]
        ]
    single = [
        (entry[key].partition(".")[0], entry["operating_speed_rpm"])
        for kind, key in (("critical_speed_map", "excited_by"), ("stiffness_study", "excited"))
        for entry in analyses_of_kind(document, kind).values()
        if entry["operating_speed_rpm"] is not None
    ]
    for shaft, rpm in single:
        inside = any(o.shaft == shaft and o.from_rpm <= rpm <= o.to_rpm for o in found)
        if not inside:
            found.append(Operating(shaft, rpm, rpm, abs(ratios[shaft])))
    return tuple(o for o in found if o.ratio > 0.0)


def operating_bands(speeds: tuple[Operating, ...], bottom: float, top: float) -> list[Trace]:
    """Return operating speeds as hatched bands over the speed of the reference shaft.

    Parameters
    ----------
    speeds
        From `operating_speeds`.
    bottom, top
        Of the bands along y.
    """
    return [
        band(
            o.from_rpm / o.ratio,
            o.to_rpm / o.ratio,
            bottom,
            top,
            "operating speed",
            text=o.text,
            legendgroup="operating",
            showlegend=k == 0,
        )
        for k, o in enumerate(speeds)
    ]
