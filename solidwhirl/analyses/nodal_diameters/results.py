"""Numbers of an analysis of nodal diameters as results.json holds them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.analyses.base import Engine, Operating
from solidwhirl.analyses.nodal_diameters.shapes import DIRECTIONS
from solidwhirl.core.blocks import margin_words
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn import nodal_diameters as nd
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S

# Highest nodal diameter where a scene does not say: of a body of revolution, of sectors.
_ROUND, _MOST = 8, 20
# Highest engine order where a scene does not say, and no more than one turn of the zigzag.
_ORDERS = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicSource:
    """A meshed body whose cyclic indices can be reduced."""

    #: N; None of a body of revolution
    sectors: int | None
    #: Rigid disks of the body by the interface that they are fixed to
    rigid_disks: tuple[tuple[str, str], ...]
    #: Takes held interfaces, indices, and modes of each; returns `CyclicBody` and its shapes
    reduce: Callable[[Sequence[str], Sequence[int], int], tuple[nd.CyclicBody, Any]]


class Asked(NamedTuple):
    """What a scene asks of one body."""

    body: str
    #: (s,) of the reference shaft
    speeds_rad_s: FloatArray
    held: tuple[str, ...]
    modes: int
    #: Relative
    margin: float
    engine_orders: tuple[int, ...]


def chosen_indices(
    given: Sequence[int] | None, sectors: int | None, held: Sequence[str], *, every: bool
) -> tuple[tuple[int, ...], list[str]]:
    """Return the nodal diameters to look at, and notes on what is left out.

    `sectors`: None of a body of revolution. `every`: whether none may be left out. Raises
    AnalysisError: a diameter that the body has not.
    """
    first = 0 if held else 2
    highest = _ROUND if sectors is None else sectors // 2
    if given is not None:
        wrong = [h for h in given if sectors is not None and h > highest]
        if wrong:
            raise AnalysisError(
                f"nodal_diameters: {wrong[0]}, but a body of {sectors} sectors has 0 to {highest}"
            )
        return tuple(sorted(set(given))), []
    notes = []
    if first:
        notes.append(
            "nodal diameters 0 and 1 of a body that nothing holds move it as a whole; they are in "
            "the modes of the engine"
        )
    last = highest if every else min(highest, _MOST)
    if sectors is None or last < highest:
        end = "more" if sectors is None else f"{last + 1} to {highest}"
        notes.append(f"nodal diameters {first} to {last}; name others to see {end}")
    return tuple(range(first, last + 1)), notes


def disks_left_out(source: CyclicSource, held: Sequence[str], indices: Sequence[int]) -> list[str]:
    """Return notes on rigid disks that the fields of an interface would move: those of 0 and 1."""
    free = [disk for disk, interface in source.rigid_disks if interface not in held]
    if not free or min(indices) > 1:
        return []
    return [f"nodal diameters 0 and 1 are without the rigid disks {', '.join(free)}"]


def chosen_orders(
    given: Sequence[int], sectors: int | None, indices: Sequence[int]
) -> tuple[int, ...]:
    """Return the engine orders to look at: by default one turn of the zigzag, up to 60."""
    if given:
        return tuple(sorted(set(given)))
    last = max(indices) if sectors is None else sectors
    return tuple(range(1, min(last, _ORDERS) + 1))


def modes_document(modes: nd.NodalDiameterModes, asked: Asked, ratio: float) -> dict[str, Any]:
    """Return frequencies in the turning frame and their errors by direction, (h, s, m).

    A standing wave (h = 0, N/2) has both directions in one.
    """
    body = modes.body
    indices = [m.index for m in body.indices]
    document: dict[str, Any] = {
        "body": body.name,
        "sectors": body.sectors,
        "held": list(asked.held),
        "speed_rpm": (asked.speeds_rad_s * RPM_PER_RAD_S).tolist(),
        "body_speed_rpm": (ratio * asked.speeds_rad_s * RPM_PER_RAD_S).tolist(),
        "nodal_diameter": indices,
        "standing": [body.is_standing(h) for h in indices],
    }
    document["frequency_hz"], document["frequency_error_estimate"] = {}, {}
    for direction in DIRECTIONS:
        families = [modes.family(h, direction) for h in indices]
        for key, blocks in (
            ("frequency_hz", [f.frequency_hz for f in families]),
            ("frequency_error_estimate", [f.error for f in families]),
        ):
            document[key][direction] = _stacked(blocks, asked.modes)
    return document


def fixed_frame_document(modes: nd.NodalDiameterModes, asked: Asked) -> dict[str, Any]:
    """Return what a probe at rest sees of the h + kN waves of every mode, (k, h, s, m)."""
    body = modes.body
    turns = (0,) if body.sectors is None else (-1, 0, 1)
    document: dict[str, Any] = {"k": list(turns)}
    for direction in DIRECTIONS:
        sign = -1.0 if direction == "forward" else 1.0
        document[direction] = []
        for k in turns:
            seen = []
            for own in body.indices:
                found = modes.family(own.index, direction).frequency_hz
                waves = own.index + k * (body.sectors or 0)
                seen.append(nd.fixed_frame_hz(sign * found, modes.speeds_rad_s[:, None], waves))
            document[direction].append(_stacked(seen, asked.modes))
    return document


def _stacked(blocks: Iterable[FloatArray], count: int) -> list[Any]:
    """Blocks (s, m) of few modes filled up with nan."""
    filled = [np.pad(b, ((0, 0), (0, count - b.shape[1])), constant_values=np.nan) for b in blocks]
    return [block.tolist() for block in filled]


def crossings_document(
    found: Sequence[nd.Crossing], asked: Asked, ratio: float, operating: Sequence[Operating]
) -> list[dict[str, Any]]:
    """Return the crossings with their margins to the nearest operating speed."""
    rows = []
    for crossing in found:
        rpm = crossing.speed_rad_s / ratio * RPM_PER_RAD_S
        margins = [(nd.margin(rpm, *o.reference_rpm), o) for o in operating]
        nearest = min(margins, key=lambda pair: abs(pair[0]), default=None)
        rows.append(
            {
                "engine_order": crossing.engine_order,
                "nodal_diameter": crossing.index,
                "direction": crossing.direction,
                "mode": crossing.mode + 1,
                "speed_rpm": rpm,
                "body_speed_rpm": ratio * rpm,
                "frequency_hz": crossing.frequency_hz,
                "frequency_error_estimate": crossing.error,
                "operating": None if nearest is None else nearest[1].text,
                "margin": None if nearest is None else nearest[0],
                "too_near": nearest is not None and abs(nearest[0]) < asked.margin,
            }
        )
    return rows


def veerings_document(found: Sequence[nd.Veering], ratio: float) -> list[dict[str, Any]]:
    """Return where modes of one nodal diameter come close."""
    return [
        {
            "kind": v.kind,
            "nodal_diameter": v.index,
            "direction": v.direction,
            "modes": [k + 1 for k in v.modes],
            "speed_rpm": v.speed_rad_s / ratio * RPM_PER_RAD_S,
            "frequency_hz": v.frequency_hz,
            "gap_hz": v.gap_hz,
            "exchanged": v.exchanged,
        }
        for v in found
    ]


def operating_of(engine: Engine, body: str) -> tuple[Operating, ...]:
    """Return the operating speeds of what turns as fast as a body; of all if there are none."""
    own = abs(engine.speed_ratios[body])
    alike = tuple(o for o in engine.operating if o.ratio == own)
    return alike or engine.operating


def interference_document(
    body: nd.CyclicBody, asked: Asked, ratio: float, operating: Sequence[Operating]
) -> dict[str, Any]:
    """Return frequencies over the diameters at the highest operating speed, else the last one."""
    first, last = asked.speeds_rad_s[0], asked.speeds_rad_s[-1]
    highest = [
        o.reference_rpm[1] * RAD_S_PER_RPM
        for o in operating
        if first <= o.reference_rpm[1] * RAD_S_PER_RPM <= last
    ]
    speed = float(max(highest, default=last))
    modes = nd.nodal_diameter_modes(body, np.array([ratio * speed]), asked.modes)
    own = modes_document(modes, asked._replace(speeds_rad_s=np.array([speed])), ratio)
    return {
        "speed_rpm": speed * RPM_PER_RAD_S,
        "frequency_hz": {d: [h[0] for h in own["frequency_hz"][d]] for d in DIRECTIONS},
    }


class MistuningAsked(NamedTuple):
    """Which mode, excited by what, with which blades."""

    mode: int
    engine_order: int
    damping_ratio: float
    blade_deviations: tuple[float, ...] | None
    #: Standard deviation, samples, seed
    random: tuple[float, int, int] | None


def refuse_mistuning(wanted: MistuningAsked, sectors: int | None, body: str) -> None:
    """Refuse what blades of a body can not be asked, before it is reduced. Raises AnalysisError."""
    if sectors is None:
        raise AnalysisError(
            f"mistuning: {body!r} is of revolution; it has no blades to be mistuned"
        )
    given = wanted.blade_deviations
    if given is not None and len(given) != sectors:
        raise AnalysisError(
            f"mistuning.blade_deviations: {len(given)} given, but {body!r} has {sectors} sectors, "
            "and one is needed for each"
        )


def mistuning_document(
    body: nd.CyclicBody, wanted: MistuningAsked, crossings: Sequence[nd.Crossing], ratio: float,
    last_rad_s: float,
) -> dict[str, Any]:  # fmt: skip
    """Return mistuned modes and amplification at the first crossing, else at the last speed.

    Raises AnalysisError: a body of revolution, or as many deviations as it has no blades.
    """
    met = [
        c.speed_rad_s
        for c in crossings
        if c.engine_order == wanted.engine_order and c.mode == wanted.mode - 1
    ]
    speed = met[0] if met else ratio * last_rad_s
    tuned = nd.tuned_frequencies(body, speed, wanted.mode - 1)
    document: dict[str, Any] = {
        "mode": wanted.mode,
        "engine_order": wanted.engine_order,
        "damping_ratio": wanted.damping_ratio,
        "speed_rpm": speed / ratio * RPM_PER_RAD_S,
        "at_crossing": bool(met),
        "tuned_hz": tuned.tolist(),
        "neighbour_hz": _neighbour(body, speed, wanted.mode, tuned),
        "bound": nd.whitehead_bound(len(tuned)),
        "amplification": None,
    }
    pattern: Any = wanted.blade_deviations
    if wanted.random is not None:
        deviation, samples, seed = wanted.random
        patterns = nd.random_deviations(len(tuned), deviation, samples, seed)
        found = nd.amplification_statistics(
            tuned, patterns, wanted.engine_order, wanted.damping_ratio
        )
        document["amplification"] = {
            "standard_deviation": deviation,
            "seed": seed,
            "factors": found.factors.tolist(),
            "quantiles": {f"{100.0 * q:g} %": value for q, value in found.quantiles.items()},
            "worst": float(found.factors[-1]),
        }
        pattern = found.worst_deviations
    return {**document, "pattern": _pattern(tuned, np.asarray(pattern, dtype=float), wanted)}


def _neighbour(body: nd.CyclicBody, speed: float, mode: int, tuned: FloatArray) -> float:
    """Frequency of another mode that is nearest to the family [Hz]; nan: there is none."""
    others = []
    for other in (mode - 2, mode):
        if 0 <= other < min(len(m.mass) for m in body.indices):
            others.append(nd.tuned_frequencies(body, speed, other))
    if not others:
        return float("nan")
    found = np.concatenate(others)
    gap = np.maximum(tuned.min() - found, found - tuned.max())
    return float(found[int(gap.argmin())])


def _pattern(tuned: FloatArray, deviations: FloatArray, wanted: MistuningAsked) -> dict[str, Any]:
    """One pattern of blades: its modes and what every blade does."""
    modes = nd.mistuned_modes(tuned, deviations)
    forced = nd.forced_response(tuned, modes, wanted.engine_order, wanted.damping_ratio)
    return {
        "deviations": deviations.tolist(),
        "frequency_hz": modes.frequency_hz.tolist(),
        "amplitudes": np.abs(modes.sectors.T).tolist(),
        "blade_amplification": forced.amplification.tolist(),
        "peak_hz": forced.frequency_hz.tolist(),
        "amplification_factor": forced.factor,
    }


def headline_of(document: Mapping[str, Any]) -> str:
    """Return what an engineer acts on: the crossing nearest to an operating speed."""
    found = document["crossings"]
    if not found:
        return f"no engine order meets a mode of {document['body']} in the range"
    judged = [c for c in found if c["margin"] is not None]
    nearest = min(judged, key=lambda c: abs(c["margin"]), default=found[0])
    said = crossing_text(nearest)
    if nearest["margin"] is None:
        return f"{len(found)} crossings, the first: {said}"
    where = margin_words(nearest["margin"])
    near = sum(c["too_near"] for c in found)
    share = f"{near} of {len(found)} crossings nearer than {document['margin_percent']:g} %"
    return f"{said}, {where} the operating speed; {share}"


def crossing_text(crossing: Mapping[str, Any]) -> str:
    """Return a crossing in words."""
    direction = "" if crossing["direction"] == "standing" else f"{crossing['direction']} "
    return (
        f"engine order {crossing['engine_order']} meets {direction}nodal diameter "
        f"{crossing['nodal_diameter']}, mode {crossing['mode']}, at {crossing['speed_rpm']:.1f} "
        f"rpm ({crossing['frequency_hz']:.4g} Hz)"
    )
