"""What a run finds of an engine with asymmetric bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.analyses.asymmetric import resonance_document
from solidwhirl.analyses.base import Operating, Stability
from solidwhirl.analyses.stability_summary import covering, whirl_document
from solidwhirl.estimates.results import Estimates, free_errors, unestimated
from solidwhirl.rotordyn import AssembledSystem, Campbell, CriticalSpeed, Modes, Superelement
from solidwhirl.rotordyn.asymmetric import (
    RotatingSystem,
    UnstableRange,
    closed_by_damping,
    unstable_ranges,
)
from solidwhirl.rotordyn.asymmetric.diagram import RotatingDiagram, as_campbell, rotating_diagram
from solidwhirl.rotordyn.asymmetric.parametric.instability import growth_over_speed
from solidwhirl.rotordyn.asymmetric.resonances import (
    Resonance,
    critical_speeds,
    gravity_critical_speeds,
)
from solidwhirl.rotordyn.asymmetric.response import held_where_free
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors
from solidwhirl.rotordyn.estimates.critical_speed_errors import CriticalSpeedErrors
from solidwhirl.rotordyn.estimates.eigenvalue_errors import error_scale, frequency_errors
from solidwhirl.rotordyn.modes.damping import DampingRule
from solidwhirl.rotordyn.modes.kinds import kinds
from solidwhirl.rotordyn.stability.intervals import StabilityChart, UnstableInterval
from solidwhirl.rotordyn.stability.whirl_decrements import FirstMode
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared

# Part of the highest speed from which on unstable ranges are searched: the slower the turn, the
# higher the order of what could meet, and the narrower its range.
_SLOWEST = 0.05
# Growth by Hill's method and by multipliers, relative to it, or to this part of the speed: the
# multipliers are those of motions up to twice the fastest change of the matrices, the others bend
# as springs [2.1e-3, two_bladed_fan; 3e-10 where all motions are taken].
_SAME_GROWTH, _NO_GROWTH = 1e-2, 1e-3
# Damping ratio of a resonance below which it is rounding of a root without damping.
_UNDAMPED = 1e-9
# A range that ends this near to the highest speed ends there.
_WHOLE = 1.0 - 1e-9
# Circles that differ by less than this part of their sum make a line.
_ROUND = 1e-2
# Logarithmic decrement of a motion that hardly swings, ζ = 0.71.
_CREEPS = 6.3


@dataclass(frozen=True, kw_only=True, eq=False)
class Asymmetry:
    """Hold what the frame of asymmetric bodies shows; speeds are those of the frame.

    `frame_ratio`: speed ratio of these bodies; `periods_per_turn`: of the matrices; 0: they are
    constant. `excited_by`: bodies whose unbalance keeps step with the frame.
    """

    frame_ratio: float
    periods_per_turn: int
    excited_by: tuple[str, ...]
    diagram: RotatingDiagram
    critical: tuple[Resonance, ...]
    gravity: tuple[Resonance, ...]
    ranges: tuple[UnstableRange, ...]
    #: Ranges that there would be without damping
    closed: tuple[UnstableRange, ...]
    departures: Mapping[str, Departure]

    @property
    def lateral(self) -> tuple[Resonance, ...]:
        """Critical speeds of lateral motion that is mostly seen once per turn."""
        return tuple(one for one in self.critical if one.moves_laterally and abs(one.multiple) == 1)


@dataclass(frozen=True, kw_only=True)
class Departure:
    """Hold how far a body is from one of revolution.

    `offset_m`, `offset_deg`: of the centre of gravity from the axis, and its direction from x
    towards y of the body. `static_unbalance_kg_m`: mass times offset. `diametral_kg_m2`: smallest
    and largest moment of inertia across the axis, about the centre of gravity. `plane_deg`:
    direction of the smallest. `product_kg_m2`: √(Ixz² + Iyz²), which is couple unbalance.
    `frequency_split`: of the first pairs of free modes in bending, relative to their mean.
    """

    offset_m: float
    offset_deg: float
    static_unbalance_kg_m: float
    diametral_kg_m2: tuple[float, float]
    plane_deg: float
    product_kg_m2: float
    frequency_split: tuple[float, ...]


def departure_of(element: Superelement) -> Departure:
    """Measure how far a body is from one of revolution."""
    x, y = (float(v) for v in element.center_of_gravity_m[:2])
    inertia = np.asarray(element.inertia_kg_m2)
    values, vectors = np.linalg.eigh(inertia[:2, :2])
    free = element.free_frequencies_hz
    pairs = zip(free[0::2], free[1::2], strict=False)
    offset = float(np.hypot(x, y))
    size = float(np.abs(element.surface.points_m).max()) if element.surface is not None else 1.0
    offset = offset if offset > 1e-12 * size else 0.0
    return Departure(
        offset_m=offset,
        offset_deg=float(np.degrees(np.arctan2(y, x))) if offset else 0.0,
        static_unbalance_kg_m=element.mass_kg * offset,
        diametral_kg_m2=(float(values[0]), float(values[1])),
        plane_deg=float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])) % 180.0),
        product_kg_m2=float(np.hypot(inertia[0, 2], inertia[1, 2])),
        frequency_split=tuple(float(2.0 * (b - a) / (a + b)) for a, b in pairs),
    )


def asymmetry_of(
    rotating: RotatingSystem, speeds_rad_s: FloatArray, top_rad_s: float, branch_count: int
) -> Asymmetry:
    """Compute the diagram, the resonances and the unstable ranges of an engine.

    `speeds_rad_s`: of the diagram, and those between which resonances are sought, rising, (s,);
    `top_rad_s`: up to which unstable ranges are. All are speeds of the reference shaft.
    """
    ratio = abs(rotating.frame_ratio)
    speeds, top = ratio * np.asarray(speeds_rad_s), ratio * top_rad_s
    span = (max(_SLOWEST * float(speeds.max()), float(speeds.min())), float(speeds.max()))
    turns = span[1] > 0.0
    searched = (_SLOWEST * top, top)
    # the drive keeps the speed, whatever torsion does
    driven = held_where_free(rotating, max(top, 1.0))
    ranges = unstable_ranges(driven, *searched) if top > 0.0 else ()
    return Asymmetry(
        frame_ratio=rotating.frame_ratio,
        periods_per_turn=rotating.periodic.stride,
        excited_by=tuple(n for n in rotating.system.rotors if rotating.keeps_step(n)),
        diagram=rotating_diagram(rotating, speeds, branch_count),
        critical=critical_speeds(rotating, *span) if turns else (),
        gravity=gravity_critical_speeds(rotating, *span) if turns else (),
        ranges=ranges,
        closed=closed_by_damping(driven, *searched, ranges)
        if top > 0.0 and rotating.periodic.is_damped
        else (),
        departures={
            name: departure_of(rotor.element)
            for name, rotor in rotating.system.rotors.items()
            if rotor.element.frame == "rotating"
        },
    )


def diagram_in_fixed_axes(found: Asymmetry) -> Campbell:
    """Return the strongest lines of all branches over the speed of the reference shaft."""
    return as_campbell(found.diagram, found.frame_ratio)[0]


def frame_estimates(
    found: Asymmetry,
    standing: AssembledSystem,
    elements: Mapping[str, Superelement],
    at_rest: Modes,
    rule: DampingRule,
) -> Estimates:
    """Return the errors of what the frame shows, and of the modes of the engine standing still."""
    without = unestimated(elements)
    diagram, moved = as_campbell(found.diagram, found.frame_ratio)
    scale = error_scale(standing, diagram.eigenvalues)
    # there may be no critical speed
    named = dict.fromkeys(["eigen_solver", *(part for one in found.lateral for part in one.errors)])
    return Estimates(
        at_rest=replace(frequency_errors(standing, at_rest), bodies_without_estimate=without),
        campbell=CampbellErrors(
            parts={part: change / scale for part, change in moved.items()},
            bodies_without_estimate=without,
            campbell=diagram,
        ),
        critical_speeds=CriticalSpeedErrors(
            parts={p: np.array([one.errors.get(p, 0.0) for one in found.lateral]) for p in named},
            bodies_without_estimate=without,
        ),
        free_frequencies=free_errors(elements, without),
        comparisons=(),
        critical=critical_records(found),
        rule=rule,
        resonances=tuple(r.error for r in (*found.critical, *found.gravity) if _counts(r, rule)),
    )


def critical_records(found: Asymmetry) -> tuple[CriticalSpeed, ...]:
    """Return the critical speeds of lateral motion as those of the reference shaft."""
    return tuple(
        CriticalSpeed(
            speed_rad_s=one.speed_rad_s / abs(found.frame_ratio),
            frequency_hz=one.speed_rad_s / (2.0 * np.pi),
            whirl="forward" if one.multiple > 0 else "backward",
            shares=one.shares,
            shape=np.zeros(0, dtype=complex),
            log_decrement=_log_decrement(one),
        )
        for one in found.lateral
    )


def _log_decrement(one: Resonance) -> float:
    ratio = one.damping_ratio
    return 2.0 * np.pi * ratio / np.sqrt(1.0 - ratio**2) if ratio > _UNDAMPED else 0.0


def _counts(one: Resonance, rule: DampingRule) -> bool:
    """Whether a resonance is one of lateral motion, with errors, that is not critically damped."""
    limit = 0.5 / rule.amplification_min if rule.amplification_min > 0 else np.inf
    return one.moves_laterally and one.damping_ratio <= limit and one.is_estimated


def stability_in_ranges(
    found: Asymmetry,
    rotating: RotatingSystem,
    high_rpm: float,
    operating: Sequence[Operating],
    branch_count: int,
) -> Stability:
    """Return the stability of an engine up to a speed from its unstable ranges."""
    ratio = abs(found.frame_ratio)
    intervals = tuple(
        UnstableInterval(
            low_rad_s=one.low_rad_s / ratio,
            high_rad_s=one.high_rad_s / ratio,
            opens=one.opens,
            closes=one.closes,
            kind=one.kind,
            growth_1_s=one.growth_1_s,
            speed_rad_s=one.speed_rad_s / ratio,
            eigenvalue=1j * one.frequency_rad_s,
            frequency_hz=one.frequency_rad_s / (2.0 * np.pi),
            frequency_end_hz=one.frequency_rad_s / (2.0 * np.pi),
            whirl="",
            shape=np.zeros(0, dtype=complex),
        )
        for one in unstable_up_to(found, rotating, high_rpm)
    )
    ends = [(o, rpm) for o in operating for rpm in dict.fromkeys((o.from_rpm, o.to_rpm))]
    return Stability(
        low_rpm=_SLOWEST * high_rpm,
        high_rpm=high_rpm,
        intervals=intervals,
        at_operating=tuple(_at(rotating, o, rpm, intervals, branch_count) for o, rpm in ends),
    )


def unstable_up_to(
    found: Asymmetry, rotating: RotatingSystem, high_rpm: float
) -> tuple[UnstableRange, ...]:
    """Return the unstable ranges up to a speed of the reference shaft, of those up to a higher one.

    Searched again where that speed parts one.
    """
    top = abs(found.frame_ratio) * high_rpm * RAD_S_PER_RPM
    if any(one.low_rad_s < top * _WHOLE < one.high_rad_s for one in found.ranges):
        return unstable_ranges(held_where_free(rotating, max(top, 1.0)), _SLOWEST * top, top)
    return tuple(one for one in found.ranges if one.low_rad_s < top)


def damping_in_frame(
    rotating: RotatingSystem, speeds_rad_s: FloatArray, highest_hz: float, branch_count: int
) -> StabilityChart:
    """Return the damping of branches by their strongest line in fixed axes, and growth of all.

    `speeds_rad_s`: of the reference shaft, rising, (s,); `highest_hz`: of lines that are looked at
    for the least damping. At rest a motion whirls neither way.
    """
    speeds = abs(rotating.frame_ratio) * speeds_rad_s
    driven = held_where_free(rotating, max(float(speeds.max()), 1.0))
    growth, growing = growth_over_speed(driven, speeds)
    found = rotating_diagram(rotating, speeds, branch_count)
    pick = found.strongest()[:, None, :]
    hertz, forward, backward = (
        np.take_along_axis(lines, pick, axis=1)[:, 0]
        for lines in (found.line_rad_s / (2.0 * np.pi), found.forward, found.backward)
    )
    lateral = ((found.forward + found.backward).sum(axis=1) > 0.5) & (hertz > 0.0)
    decrement = np.divide(-found.eigenvalues.real, hertz, where=hertz > 0, out=np.zeros_like(hertz))
    decrement[np.abs(decrement) <= 2.0 * np.pi * _UNDAMPED] = 0.0
    ahead, turns = forward - backward, lateral & (decrement < _CREEPS)
    least = _least(np.where(lateral & (hertz <= highest_hz), decrement, np.nan))
    first = [
        FirstMode(log_decrement=_taken(decrement, at), frequency_hz=_taken(hertz, at))
        for sense in (ahead, -ahead)
        for at in [_least(np.where(turns & (sense > _ROUND * (forward + backward)), hertz, np.nan))]
    ]
    return StabilityChart(
        speeds_rad_s=speeds_rad_s,
        log_decrement=_taken(decrement, least),
        frequency_hz=_taken(hertz, least),
        growth_rate_1_s=growth,
        unstable_count=growing,
        first_forward=first[0],
        first_backward=first[1],
    )


def _least(values: FloatArray) -> IntArray:
    """Row of the least number of each column, −1 where there is none."""
    known = np.isfinite(values)
    rows = np.where(known, values, np.inf).argmin(axis=0)
    return np.where(known.any(axis=0), rows, -1)


def _taken(values: FloatArray, rows: IntArray) -> FloatArray:
    """One number of each column, nan of the row −1."""
    return np.where(rows < 0, np.nan, values[rows, np.arange(rows.size)])


def _at(
    rotating: RotatingSystem,
    operating: Operating,
    rpm: float,
    intervals: tuple[UnstableInterval, ...],
    branch_count: int,
) -> dict[str, Any]:
    """Damping of the first whirl either way at an operating speed."""
    speed = rpm / operating.ratio
    found = damping_in_frame(rotating, np.array([speed * RAD_S_PER_RPM]), np.inf, branch_count)
    first = whirl_document(found)
    return {
        "shaft": operating.shaft,
        "shaft_speed_rpm": rpm,
        "speed_rpm": speed,
        "stable": not covering(intervals, speed, speed),
        **{key: {name: values[0] for name, values in own.items()} for key, own in first.items()},
    }


def asymmetry_checks(found: Asymmetry) -> tuple[Invariant, ...]:
    """Check growth by Hill's method against the multipliers of a period."""
    return tuple(
        compared(
            "growth is that of the multipliers of a period",
            f"unstable range from {one.low_rad_s * RPM_PER_RAD_S:.6g} rpm of the body",
            abs(one.growth_1_s - one.floquet_1_s)
            / max(abs(one.growth_1_s), _NO_GROWTH * one.speed_rad_s),
            _SAME_GROWTH,
            "unstable ranges",
        )
        for one in found.ranges
    )


def asymmetry_document(found: Asymmetry) -> dict[str, Any]:
    """Return what the frame shows as plain data; speeds are those of the reference shaft."""
    ratio, diagram = abs(found.frame_ratio), found.diagram
    return {
        "frame_speed_ratio": found.frame_ratio,
        "constant_in_the_frame": found.periods_per_turn == 0,
        "periods_per_turn": found.periods_per_turn,
        "critical_speeds": [resonance_document(r, ratio) for r in found.critical],
        "gravity_critical_speeds": [resonance_document(r, ratio) for r in found.gravity],
        "unstable_ranges": [range_document(r, ratio, found.periods_per_turn) for r in found.ranges],
        "closed_by_damping": [
            range_document(r, ratio, found.periods_per_turn) for r in found.closed
        ],
        "bodies": {
            name: {
                "center_of_gravity_offset_m": d.offset_m,
                "offset_direction_deg": d.offset_deg,
                "static_unbalance_kg_m": d.static_unbalance_kg_m,
                "diametral_inertia_kg_m2": list(d.diametral_kg_m2),
                "plane_of_smallest_deg": d.plane_deg,
                "product_of_inertia_kg_m2": d.product_kg_m2,
                "free_frequency_split": list(d.frequency_split),
            }
            for name, d in found.departures.items()
        },
        "lines": {
            "speed_rpm": (diagram.speeds_rad_s / ratio * RPM_PER_RAD_S).tolist(),
            "multiples": diagram.multiples.tolist(),
            "frequency_hz": (diagram.line_rad_s / (2.0 * np.pi)).tolist(),
            "share_forward": diagram.forward.tolist(),
            "share_backward": diagram.backward.tolist(),
            "share_axial": diagram.axial.tolist(),
            "share_in_the_frame": diagram.inside.tolist(),
            "kind": kinds(diagram.shares).tolist(),
            "growth_rate_per_s": diagram.eigenvalues.real.tolist(),
        },
    }


def range_document(one: UnstableRange, ratio: float, stride: int) -> dict[str, Any]:
    """Return an unstable range as plain data; `stride`: periods of the matrices in a turn."""
    return {
        "from_rpm": one.low_rad_s / ratio * RPM_PER_RAD_S,
        "to_rpm": one.high_rad_s / ratio * RPM_PER_RAD_S,
        "opens": one.opens,
        "closes": one.closes,
        "kind": one.kind,
        "largest_growth_rate_per_s": one.growth_1_s,
        "largest_growth_at_rpm": one.speed_rad_s / ratio * RPM_PER_RAD_S,
        "growth_rate_by_multipliers_per_s": one.floquet_1_s,
        "frequency_in_the_frame_hz": one.frequency_rad_s / (2.0 * np.pi),
        "meeting": None
        if one.meeting is None
        else {
            "relation": one.meeting.relation,
            "turns": one.meeting.order * stride,
            "first_hz": one.meeting.first_rad_s / (2.0 * np.pi),
            "second_hz": one.meeting.second_rad_s / (2.0 * np.pi),
        },
        "end_error_rpm": one.error_rad_s / ratio * RPM_PER_RAD_S,
    }
