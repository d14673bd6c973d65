"""Operating speeds of the shafts of a scene, and the distance of critical speeds from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import (
    CriticalSpeedMapSpec,
    OperatingSpec,
    SeparationMarginsSpec,
    StiffnessStudySpec,
)


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

    @property
    def reference_rpm(self) -> tuple[float, float]:
        """Lowest and highest speed of the reference shaft, rpm."""
        return self.from_rpm / self.ratio, self.to_rpm / self.ratio


def operating_of_margins(scene: Scene, spec: SeparationMarginsSpec) -> tuple[OperatingSpec, ...]:
    """Return the operating speeds of a margin analysis: its own, or those of the scene."""
    return spec.operating or scene.operating


def operating_speeds(scene: Scene) -> tuple[Operating, ...]:
    """Return the operating speeds that a scene gives, each once.

    Parameters
    ----------
    scene
        Its `[[operating]]` and its analyses of margins, maps and studies are looked at.

    Returns
    -------
    tuple of Operating
        Of shafts that turn; single speeds within a range of the same shaft are left out.
    """
    found: list[Operating] = []
    for shaft, low, high in (*_ranges(scene), *_single(scene)):
        ratio = abs(scene.speed_ratio(shaft))
        inside = any(o.shaft == shaft and o.from_rpm <= low and high <= o.to_rpm for o in found)
        if ratio > 0.0 and not inside:
            found.append(Operating(shaft, low, high, ratio))
    return tuple(found)


def _ranges(scene: Scene) -> Iterator[tuple[str, float, float]]:
    given = [*scene.operating]
    for spec in scene.analyses:
        if isinstance(spec, SeparationMarginsSpec):
            given += spec.operating
    yield from ((o.shaft, o.from_rpm, o.to_rpm) for o in given)


def _single(scene: Scene) -> Iterator[tuple[str, float, float]]:
    """Yield the operating speeds of maps and studies."""
    for spec in scene.analyses:
        rpm = None
        if isinstance(spec, CriticalSpeedMapSpec):
            shaft, rpm = spec.excited_by, spec.operating_speed_rpm
        elif isinstance(spec, StiffnessStudySpec):
            shaft, rpm = spec.excite.partition(".")[0], spec.operating_speed_rpm
        if rpm is not None:
            yield shaft, rpm, rpm


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


def nearest(
    found: Sequence[Mapping[str, Any]], operating: Sequence[Operating], most: int
) -> tuple[list[Mapping[str, Any]], str]:
    """Return the critical speeds nearest to operating speeds, or the lowest, and which they are.

    Parameters
    ----------
    found
        Entries with `speed_rpm` of the reference shaft, `critical_speeds` of `results.json`.
    operating
        From `operating_speeds`; speeds are compared as those of the reference shaft.
    most
        How many to return at most, in the order of their speed.
    """
    if len(found) <= most:
        return list(found), ""

    def distance(c: Mapping[str, Any]) -> float:
        rpm = float(c["speed_rpm"])
        edges = (o.reference_rpm for o in operating)
        return min(max(a - rpm, rpm - b, 0.0) for a, b in edges)

    chosen = sorted(found, key=distance if operating else lambda c: c["speed_rpm"])[:most]
    which = "nearest to the operating speeds" if operating else "lowest"
    said = f"These are the {most} of {len(found)} that are {which}; all are under Critical speeds. "
    return sorted(chosen, key=lambda c: c["speed_rpm"]), said


def critical_speeds_that_count(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the entries of `critical_speeds` in `results.json` that are no critically damped."""
    return [c for c in document["critical_speeds"] if not c.get("critically_damped")]
