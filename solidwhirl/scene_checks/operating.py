"""Operating speeds of the shafts of a scene, and the distance of critical speeds from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from solidwhirl.analyses.base import Operating, OperatingSpec
from solidwhirl.scene.records import Scene

# Speeds of two shafts that a gear joins are given in whole numbers: they may differ by so much.
_ROUNDED = 5e-3


def operating_speeds(scene: Scene) -> tuple[Operating, ...]:
    """Return the operating speeds that a scene and its analyses give, and those that follow."""
    named = (entry for analysis in scene.analyses for entry in analysis.operating_named())
    return running_speeds(scene, [*scene.operating, *named])


def running_speeds(scene: Scene, entries: Sequence[OperatingSpec] = ()) -> tuple[Operating, ...]:
    """Return operating speeds of all shafts that turn, from those of some; each once.

    `entries`: what is given, that of the scene if nothing is. Single speeds within a range of the
    same shaft are left out. A shaft without its own follows the first one of its gear train that
    has some, else the first one of every train.
    """
    found: list[Operating] = []
    trains, ratios = scene.gear_trains(), scene.speed_ratios()
    # ranges before single speeds, which they may hold
    entries = sorted(entries or scene.operating, key=lambda o: o.from_rpm == o.to_rpm)
    for shaft, low, high in ((o.shaft, o.from_rpm, o.to_rpm) for o in entries):
        inside = any(o.shaft == shaft and o.from_rpm <= low and high <= o.to_rpm for o in found)
        if ratios[shaft] != 0.0 and not inside:
            found.append(Operating(shaft, low, high, abs(ratios[shaft]), _alike(ratios, shaft)))
    first = {trains[o.shaft]: o.shaft for o in reversed(found)}
    given = tuple(found)
    for name, ratio in ratios.items():
        if not given or ratio == 0.0 or any(o.is_of([name]) for o in found):
            continue
        leaders = [first[trains[name]]] if trains[name] in first else first.values()
        for o in given:
            if o.shaft in leaders:
                low, high = (abs(ratio) * rpm for rpm in o.reference_rpm)
                own = Operating(name, low, high, abs(ratio), _alike(ratios, name), o.shaft)
                found.append(own)
    return tuple(found)


def _alike(ratios: Mapping[str, float], shaft: str) -> tuple[str, ...]:
    """Bodies that turn as a shaft does: their unbalance is one with its own."""
    return tuple(name for name, ratio in ratios.items() if ratio == ratios[shaft])


def conflicts(scene: Scene, entries: Sequence[OperatingSpec]) -> Iterator[tuple[int, str]]:
    """Yield the numbers of entries against those of another shaft of a gear train, and why.

    `entries`: of shafts that turn.
    """
    trains, known = scene.gear_trains(), dict[int, tuple[str, float, float]]()
    ends: dict[str, tuple[float, float]] = {}
    for o in entries:
        low, high = ends.get(o.shaft, (o.from_rpm, o.to_rpm))
        ends[o.shaft] = min(low, o.from_rpm), max(high, o.to_rpm)
    for shaft, (low, high) in ends.items():
        other, first, last = known.setdefault(trains[shaft], (shaft, low, high))
        ratio = abs(scene.speed_ratio(shaft) / scene.speed_ratio(other))
        if max(abs(low / ratio / first - 1.0), abs(high / ratio / last - 1.0)) > _ROUNDED:
            place = next(k for k, o in enumerate(entries) if o.shaft == shaft)
            yield (
                place,
                f"{shaft!r} runs at {low:g} to {high:g} rpm, but {other!r}, with which it turns at "
                f"a fixed ratio of {ratio:g}, at {first:g} to {last:g} rpm, which makes "
                f"{ratio * first:g} to {ratio * last:g} rpm; give one, the other follows",
            )


def margin_of(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> tuple[float, str] | None:
    """Return the distance of a critical speed from the operating speeds of the exciting shafts.

    Returns (N_c - N_op) / N_op for the nearer end of the range, 0 inside, and the shaft; the
    smallest of all shafts. None if none of them has an operating speed.
    """
    found = []
    for own in operating:
        if own.is_of(shafts):
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
