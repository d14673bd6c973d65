"""Operating speeds of the shafts of a scene, and the distance of critical speeds from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from solidwhirl.analyses.base import Operating
from solidwhirl.scene.records import Scene


def operating_speeds(scene: Scene) -> tuple[Operating, ...]:
    """Return the operating speeds that a scene and its analyses give, each once.

    Only of shafts that turn; single speeds within a range of the same shaft are left out.
    """
    found: list[Operating] = []
    named = (entry for analysis in scene.analyses for entry in analysis.operating_named())
    # ranges before single speeds, which they may hold
    entries = [*scene.operating, *named]
    entries = sorted(entries, key=lambda o: o.from_rpm == o.to_rpm)
    for shaft, low, high in ((o.shaft, o.from_rpm, o.to_rpm) for o in entries):
        ratio = abs(scene.speed_ratio(shaft))
        inside = any(o.shaft == shaft and o.from_rpm <= low and high <= o.to_rpm for o in found)
        if ratio > 0.0 and not inside:
            found.append(Operating(shaft, low, high, ratio))
    return tuple(found)


def margin_of(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> tuple[float, str] | None:
    """Return the distance of a critical speed from the operating speeds of the exciting shafts.

    Returns (N_c - N_op) / N_op for the nearer end of the range, 0 inside, and the shaft; the
    smallest of all shafts. None if none of them has an operating speed.
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

    At most so many entries of `critical_speeds` in `results.json`, in the order of their speed;
    compared as speeds of the reference shaft.
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


def excited_critical_speeds(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return those of `critical_speeds_that_count` that unbalance excites."""
    return [c for c in critical_speeds_that_count(document) if c["excited"]]
