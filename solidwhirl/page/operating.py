"""Operating speeds that a scene names in its analyses, for charts over the speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from solidwhirl.page.traces import Trace, analyses_of_kind, band

if TYPE_CHECKING:
    from solidwhirl.pipeline import Results

_RAD_S = math.pi / 30.0


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


def operating_of(results: Results) -> tuple[Operating, ...]:
    """Return the operating speeds that the analyses of a run name.

    Parameters
    ----------
    results
        Of the run.
    """
    analyses = {name: {**o.document, "kind": o.kind} for name, o in results.analyses.items()}
    return operating_speeds({"analyses": analyses}, results.scene.speed_ratios())


def operating_rad_s(results: Results) -> dict[str, tuple[float, float]]:
    """Return the operating speeds as speeds of the reference shaft, for static diagrams.

    Parameters
    ----------
    results
        Of a run.

    Returns
    -------
    dict
        Lowest and highest speed, rad/s, by what a legend says.
    """
    return {
        o.text: (o.from_rpm / o.ratio * _RAD_S, o.to_rpm / o.ratio * _RAD_S)
        for o in operating_of(results)
    }


def margin_words(margin: float) -> str:
    """Return the distance of a critical speed from operating speeds in words.

    Parameters
    ----------
    margin
        (N_c − N_op) / N_op, 0 inside.

    Returns
    -------
    str
        Such as "66.3 % below", or "inside".
    """
    if margin == 0.0:
        return "inside"
    size = 100.0 * abs(margin)
    said = f"{size:.1f}" if round(size, 1) > 0.0 else "less than 0.1"
    return f"{said} % {'above' if margin > 0.0 else 'below'}"


def margin_of(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> tuple[float, str] | None:
    """Return the distance of a critical speed from the operating speeds of the exciting shafts.

    Parameters
    ----------
    speed_rpm
        Of the reference shaft.
    shafts
        That excite it.
    operating
        From `operating_speeds`.

    Returns
    -------
    tuple or None
        (N_c - N_op) / N_op for the nearer end of the range, 0 inside, and the shaft; the smallest
        of all shafts. None if none of them has an operating speed.
    """
    found = []
    for own in operating:
        if own.shaft in shafts:
            speed = speed_rpm * own.ratio
            end = min(max(speed, own.from_rpm), own.to_rpm)
            found.append(((speed - end) / end, own.shaft))
    return min(found, key=lambda pair: abs(pair[0])) if found else None


def margin_text(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> str | None:
    """Return the distance of `margin_of` in words; arguments as there."""
    found = margin_of(speed_rpm, shafts, operating)
    if found is None:
        return None
    margin, shaft = found
    return f"**inside** {shaft}" if margin == 0.0 else f"{margin_words(margin)} {shaft}"


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
