"""Charts of the unbalance response: amplitude and phase, orbits, bearing forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.orbits import elliptic_orbits

# Part of the largest amplitude below which an amplitude is rounding.
_ROUNDING = 1e-9
_LEFT_OUT = "What is below 1e-9 of the largest is rounding, and not drawn."
# Points of an orbit; names of smaller ones than this part of the largest would lie on each other.
_POINTS, _NAMED = 73, 0.1


class Peak(NamedTuple):
    """A resonance peak of a curve, and what a reader is told there."""

    speed_rpm: float
    height: float
    text: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class ExciterCurves:
    """Steady response to the unbalance that turns at one frequency, over the speed."""

    #: Those with this unbalance
    bodies: Sequence[str]
    #: Its frequency over Ω
    frequency_ratio: float
    #: Of the reference shaft, rising, shape (s,)
    speed_rpm: FloatArray
    #: Complex amplitudes along x and y by place, shape (s, 2)
    motion_m: Mapping[str, ComplexArray]
    #: Largest lateral force by bearing, shape (s,)
    force_n: Mapping[str, FloatArray] = field(default_factory=dict)
    #: Of the major semi-axis in m, by place
    peaks: Mapping[str, Sequence[Peak]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What it is called."""
        return f"unbalance of {', '.join(self.bodies)}"

    def major_m(self) -> dict[str, FloatArray]:
        """Return the major semi-axes by place, without rounding."""
        return moving({p: elliptic_orbits(*m.T).major_m for p, m in self.motion_m.items()})


def moving(curves: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return what is more than rounding of curves of one excitation; the rest of them is nan.

    `curves`: amplitudes by name, shape (s,); those that are rounding all along are left out.
    """
    largest = max((float(np.nanmax(v, initial=0.0)) for v in curves.values()), default=0.0)
    kept = {name: np.where(v > _ROUNDING * largest, v, np.nan) for name, v in curves.items()}
    return {name: v for name, v in kept.items() if np.isfinite(v).any()}


def amplitude_chart(exciters: Sequence[ExciterCurves]) -> charts.Chart:
    """Return the major semi-axis of the orbit of each place over the speed, with its peaks."""
    every = [m for e in exciters for m in e.major_m().values()]
    unit, factor, low, high = _extent(every, "m")

    def curves(exciter: ExciterCurves) -> list[charts.Mark]:
        major, marks = exciter.major_m(), list[charts.Mark]()
        hertz = exciter.frequency_ratio * exciter.speed_rpm / 60.0
        for k, (place, motion) in enumerate(exciter.motion_m.items()):
            if place not in major:
                continue
            orbit = elliptic_orbits(*motion.T)
            texts = [
                f"{f:.5g} Hz, {sense}, minor semi-axis {factor * m:.4g} {unit}"
                for f, sense, m in zip(hertz, orbit.direction, orbit.minor_m, strict=True)
            ]
            marks.append(_curve(exciter, factor * major[place], place, k, texts))
        rings = ((k, p) for k, p in enumerate(exciter.motion_m) if p in major)
        return marks + [
            _rings(place, exciter.peaks[place], factor, k)
            for k, place in rings
            if exciter.peaks.get(place)
        ]

    return charts.Chart(
        name="amplitude",
        title="Displacement",
        caption="Major semi-axis of the orbit at each place over the speed. Rings mark the "
        "resonance peaks; their amplification factor is that of API 617 from the half-power "
        f"points. {_LEFT_OUT}",
        alt=f"Displacement at {', '.join(exciters[0].motion_m)} over the speed; the table of "
        "peaks has the numbers.",
        x=_speeds(exciters),
        y=charts.size_axis("largest displacement", unit, low, high),
        parts=[*_by_exciter(exciters, curves), _scale(unit, high)],
        height_px=460,
    )


def phase_chart(exciters: Sequence[ExciterCurves]) -> charts.Chart:
    """Return the phase of the displacement along x and y over the speed, cut at ±180°."""

    def curves(exciter: ExciterCurves) -> list[charts.Mark]:
        marks = list[charts.Mark]()
        for column, direction in enumerate("xy"):
            shown = moving({p: np.abs(m[:, column]) for p, m in exciter.motion_m.items()})
            for k, (place, motion) in enumerate(exciter.motion_m.items()):
                if place not in shown:
                    continue
                phase = np.degrees(np.angle(motion[:, column]))
                phase = np.where(np.isfinite(shown[place]), phase, np.nan)
                x, y = unwrapped(exciter.speed_rpm, phase)
                look = replace(
                    charts.series_look(k), dash="solid" if column == 0 else "dot", mark=""
                )
                name = f"{place}, along {direction}"
                marks.append(
                    charts.Curve(x=x, y=y, name=name, look=look, is_quiet=charts.is_quiet(k))
                )
        return marks

    return charts.Chart(
        name="phase",
        title="Phase",
        caption="Phase of the displacement against the unbalance at angle zero: along x full "
        "lines, along y dotted. It turns by 180° where a resonance is passed. Lines are cut where "
        "they leave ±180°.",
        alt="Phase of the displacement along x and y over the speed.",
        x=_speeds(exciters),
        y=charts.Axis(label="phase", unit="°", low=-185.0, high=185.0, step=90.0, digits=".1f"),
        parts=_by_exciter(exciters, curves),
        height_px=360,
    )


def force_chart(exciters: Sequence[ExciterCurves]) -> charts.Chart:
    """Return the largest lateral force through each bearing over the speed."""
    every = [f for e in exciters for f in moving(e.force_n).values()]
    unit, factor, low, high = _extent(every, "N")

    def curves(exciter: ExciterCurves) -> list[charts.Mark]:
        shown = moving(exciter.force_n)
        return [
            _curve(exciter, factor * shown[bearing], bearing, k)
            for k, bearing in enumerate(exciter.force_n)
            if bearing in shown
        ]

    return charts.Chart(
        name="forces",
        title="Bearing forces",
        caption="Largest lateral force through each bearing over the speed: the major semi-axis "
        f"of the ellipse that the force draws. {_LEFT_OUT}",
        alt=f"Forces through the bearings up to {high:.4g} {unit}.",
        x=_speeds(exciters),
        y=charts.size_axis("largest lateral force", unit, low, high),
        parts=[*_by_exciter(exciters, curves), _scale(unit, high, "largest lateral force")],
    )


def orbit_chart(shown: Sequence[tuple[ExciterCurves, Sequence[int]]]) -> charts.Chart | None:
    """Return the orbits at some speeds; None where nothing moves.

    `shown`: exciters, and which of their speeds are shown.
    """
    options = []
    for exciter, rows in shown:
        for row in rows:
            motions = {place: m[row] for place, m in exciter.motion_m.items()}
            major = {p: float(elliptic_orbits(*m).major_m) for p, m in motions.items()}
            largest = max((m for m in major.values() if np.isfinite(m)), default=0.0)
            if not largest > 0.0:
                continue
            unit, factor = charts.metric(largest, "m")
            reach = 1.25 * factor * largest  # room for the names
            marks = [
                mark
                for k, (place, motion) in enumerate(motions.items())
                for mark in _orbit(place, factor * motion, k, major[place] >= _NAMED * largest)
            ]
            axes = [
                charts.Axis(label=d, unit=unit, low=-reach, high=reach,
                     digits=".4g")
                for d in "xy"
            ]  # fmt: skip
            label = f"{exciter.speed_rpm[row]:.0f} rpm, {exciter.name}"
            options.append(charts.Option(label=label, marks=marks, x=axes[0], y=axes[1]))
    if not options:
        return None
    return charts.Chart(
        name="orbits",
        title="Orbits",
        caption="Paths of the shaft at the speeds of the peaks and those that the scene asks for, "
        "displacement along x and y. Forward orbits are full lines with a filled circle, backward "
        "ones dashed with an open square; the mark is where the point is when the unbalance at "
        "angle zero points along +x.",
        alt="Elliptic orbits of the observed places at a chosen speed.",
        x=charts.Axis(label="x"),
        y=charts.Axis(label="y"),
        parts=[charts.Choice(label="at", options=options, on_paper="each")],
        height_px=480,
        is_to_scale=True,
    )


def _speeds(exciters: Sequence[ExciterCurves]) -> charts.Axis:
    rpm = exciters[0].speed_rpm
    return replace(
        charts.speed_axis(float(rpm.min()), float(rpm.max()), charts.SPEED_LABEL), digits=",.1f"
    )


def _extent(curves: Sequence[FloatArray], unit: str) -> tuple[str, float, float, float]:
    """Unit with a prefix, the factor to it, and the least and the largest value in it."""
    largest = max((float(np.nanmax(c)) for c in curves), default=1.0)
    prefixed, factor = charts.metric(largest, unit)
    least = min((float(np.nanmin(c)) for c in curves), default=1.0)
    return prefixed, factor, factor * least, factor * largest


def _by_exciter(
    exciters: Sequence[ExciterCurves], curves: Callable[[ExciterCurves], list[charts.Mark]]
) -> list[charts.Part]:
    """The curves of the exciters, as a choice where there are several."""
    if len(exciters) == 1:
        return [*curves(exciters[0])]
    options = [
        charts.Option(label=f"{e.name} ({e.frequency_ratio:.4g}×)", marks=curves(e))
        for e in exciters
    ]
    return [charts.Choice(label="excited by", options=options, on_paper="each")]


def _scale(unit: str, high: float, label: str = "largest displacement") -> charts.Choice:
    linear = charts.Axis(label=label, unit=unit, low=0.0, high=1.05 * high, digits=".4g")
    return charts.Choice(
        label="scale",
        options=[charts.Option(label="logarithmic"), charts.Option(label="linear", y=linear)],
    )


def _curve(
    exciter: ExciterCurves, values: FloatArray, name: str, number: int, texts: Sequence[str] = ()
) -> charts.Curve:
    return charts.Curve(
        x=exciter.speed_rpm,
        y=values,
        name=name,
        look=replace(charts.series_look(number), mark=""),
        texts=texts,
        is_quiet=charts.is_quiet(number),
    )


def _rings(place: str, peaks: Sequence[Peak], factor: float, number: int) -> charts.Curve:
    return charts.Curve(
        x=np.array([p.speed_rpm for p in peaks]),
        y=factor * np.array([p.height for p in peaks]),
        look=charts.Look(charts.series_look(number).color, "", "circle-open", 12),
        texts=[f"peak at {place}\n{p.text}" for p in peaks],
        is_quiet=charts.is_quiet(number),
        is_numbered=True,
    )


def unwrapped(x: FloatArray, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a phase in degrees over x with a gap where it jumps by more than half a turn."""
    jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    return np.insert(x, jumps, np.nan), np.insert(phase, jumps, np.nan)


def _orbit(place: str, motion: ComplexArray, number: int, named: bool) -> list[charts.Curve]:
    """The path of amplitudes (x, y), and the place on it at the time zero with its name."""
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, _POINTS))
    x, y = (turn * motion[0]).real, (turn * motion[1]).real
    if not np.isfinite(x).all():
        return []
    direction = str(elliptic_orbits(*motion).direction)
    sense = direction if direction in ("forward", "backward") else "straight"
    style, color = charts.whirl_look(sense), charts.series_look(number).color
    name = f"{place} ({sense})"
    mark = charts.Look(color, "", style.mark, 10)
    return [
        charts.Curve(x=x, y=y, name=name, look=charts.Look(color, style.dash)),
        charts.Curve(x=x[:1], y=y[:1], look=mark, texts=(name,), written=place if named else ""),
    ]
