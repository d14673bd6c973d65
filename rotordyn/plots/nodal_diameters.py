"""Charts of nodal-diameter modes: over the speed, over the diameters, and mistuned blades."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts

# Over the highest branch.
_ROOM = 1.12
_LOOKS = {
    "backward": charts.WHIRL_LOOKS["backward"],
    "forward": charts.WHIRL_LOOKS["forward"],
    "standing": charts.WHIRL_LOOKS["straight"],
}
_NAMES = {
    "backward": "backward",
    "forward": "forward",
    "standing": "standing (forward and backward in one)",
}
# Engine orders in an interference diagram that are told by name.
_LABELS = 40
_NEAR = charts.Look("@bad", "", "circle-open", 15, 2.5)


@dataclass(frozen=True, kw_only=True, eq=False)
class FamilyCurves:
    """Branches of one nodal diameter and direction."""

    index: int
    direction: str
    #: (s, m) in the frame of the body, nan where there is none
    frequency_hz: FloatArray
    #: Relative, (s, m); nan: not known
    error: FloatArray


@dataclass(frozen=True, kw_only=True)
class CrossingMark:
    """An engine order that meets a mode."""

    engine_order: int
    index: int
    rpm: float
    hertz: float
    text: str
    #: Whether it is nearer to an operating speed than is allowed
    is_near: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeCampbell:
    """What a Campbell diagram of blades and disks shows."""

    #: (s,) of the reference shaft, and of the body over it
    rpm: FloatArray
    speed_ratio: float
    families: Sequence[FamilyCurves]
    crossings: Sequence[CrossingMark]
    #: Engine orders by the nodal diameter that they excite
    engine_orders: Mapping[int, Sequence[int]]
    operating_rad_s: Mapping[str, tuple[float, float]]


def blade_campbell_chart(view: BladeCampbell) -> charts.Chart:
    """Return frequencies over the speed with engine orders, one nodal diameter at a time or all."""
    own = [f.frequency_hz for f in view.families]
    top = _ROOM * max((float(np.nanmax(f, initial=0.0)) for f in own), default=1.0)
    by_index = {k: [*g] for k, g in groupby(view.families, lambda f: f.index)}
    options = [charts.Option(label="all", marks=_campbell_marks(view, view.families, top))]
    if len(by_index) > 1:
        options += [
            charts.Option(label=str(index), marks=_campbell_marks(view, families, top))
            for index, families in by_index.items()
        ]
    first, last = float(view.rpm[0]), float(view.rpm[-1])
    return charts.Chart(
        name="blade-campbell",
        title="Nodal-diameter modes over the speed",
        caption="Frequencies in the frame that turns with the body: what a strain gauge on it "
        "sees. Backward waves run against the spin, forward ones with it. Thin lines are engine "
        "orders; a ring marks where one meets a mode of the nodal diameter and direction that it "
        "excites, a thick red one where that is nearer to an operating speed than is allowed.",
        alt=f"Campbell diagram of {len(by_index)} nodal diameters from {first:g} to {last:g} rpm; "
        "the table of crossings has the numbers.",
        x=charts.speed_axis(first, last),
        y=charts.Axis(label="frequency on the body", unit="Hz", low=0.0, high=top, digits=".6g"),
        parts=[
            *charts.operating_toggle(view.operating_rad_s),
            charts.Choice(label="nodal diameters", options=options),
        ],
        notes=[f"{c.rpm:.0f}  {c.text.splitlines()[0]}" for c in view.crossings if c.is_near],
        height_px=560,
    )


def _campbell_marks(
    view: BladeCampbell, families: Sequence[FamilyCurves], top: float
) -> list[charts.Mark]:
    """Branches, engine orders that excite them, and their crossings."""
    shown = {f.index for f in families}
    marks: list[charts.Mark] = []
    orders = sorted({e for h in shown for e in view.engine_orders.get(h, ())})
    for order in orders:
        marks += _order_line(order, view, top)
    marks += _branches(view.rpm, families)
    for near, look, name in (
        (False, charts.RING, "engine order meets a mode"),
        (True, _NEAR, "too near to an operating speed"),
    ):
        own = [c for c in view.crossings if c.index in shown and c.is_near == near]
        if own:
            marks.append(
                charts.Curve(
                    x=np.array([c.rpm for c in own]),
                    y=np.array([c.hertz for c in own]),
                    name=name,
                    look=look,
                    texts=[c.text for c in own],
                )
            )
    return marks


def _branches(rpm: FloatArray, families: Sequence[FamilyCurves]) -> list[charts.Mark]:
    """All branches, those of one direction together, which have one entry in the legend."""
    return [
        charts.Curve(
            x=rpm,
            y=family.frequency_hz[:, mode],
            name=_NAMES[family.direction],
            look=replace(_LOOKS[family.direction], size=4.0, width=1.5),
            texts=[_point_text(family, mode, e) for e in family.error[:, mode].tolist()],
        )
        for family in sorted(families, key=lambda f: [*_NAMES].index(f.direction))
        for mode in range(family.frequency_hz.shape[1])
        if np.isfinite(family.frequency_hz[:, mode]).any()
    ]


def _point_text(family: FamilyCurves, mode: int, error: float) -> str:
    text = f"nodal diameter {family.index}, {family.direction}, mode {mode + 1}"
    return text if not np.isfinite(error) else f"{text}\nerror ±{100.0 * error:.2g} %"


def _order_line(order: int, view: BladeCampbell, top: float) -> list[charts.Mark]:
    """One engine order from the origin to where it leaves the frame."""
    slope = order * view.speed_ratio / 60.0
    end = min(float(view.rpm[-1]), top / slope)
    if end <= view.rpm[0]:
        return []
    told = f"engine order {order}"
    x = np.array([float(view.rpm[0]), end])
    look = charts.Look("@ink/0.6", "solid", width=1.0)
    side = "right" if end == view.rpm[-1] else "above"
    return [
        charts.Curve(x=x, y=slope * x, look=look, texts=(told, told)),
        charts.Label(x=end, y=slope * end, text=f"EO {order}", side=side),
    ]


def fixed_frame_chart(view: BladeCampbell, sectors: int | None) -> charts.Chart:
    """Return what a probe at rest sees of the waves with h diameters, |ω ∓ hΩ|, and of h ± N.

    `sectors`: N; None of a body of revolution, which has no waves but h.
    """
    seen = _as_seen(view, 0)
    top = _ROOM * max((float(np.nanmax(f.frequency_hz, initial=0.0)) for f in seen), default=1.0)
    by_index = {k: [*g] for k, g in groupby(seen, lambda f: f.index)}
    options = [charts.Option(label="all", marks=_branches(view.rpm, seen))]
    for index, own in by_index.items():
        marks = _branches(view.rpm, own)
        for shift in (-sectors, sectors) if sectors else ():
            more = [f for f in _as_seen(view, shift) if f.index == index]
            marks += _further_waves(view.rpm, more, index + shift)
        options.append(charts.Option(label=str(index), marks=marks))
    return charts.Chart(
        name="blade-campbell-fixed",
        title="Nodal-diameter modes as a probe at rest sees them",
        caption="The part of each mode with as many waves around as it has nodal diameters. Of N "
        "sectors a mode has parts with h + kN waves too, with smaller amplitudes as a rule: thin "
        "lines for one nodal diameter are those of h - N and h + N waves. Where a backward wave "
        "comes down to zero it stands still, and a steady load meets it.",
        alt="Frequencies of the nodal diameters in the fixed frame over the speed.",
        x=charts.speed_axis(float(view.rpm[0]), float(view.rpm[-1])),
        y=charts.Axis(label="frequency at rest", unit="Hz", low=0.0, high=top, digits=".6g"),
        parts=[
            *charts.operating_toggle(view.operating_rad_s),
            charts.Choice(label="nodal diameters", options=options),
        ],
        height_px=480,
    )


def _as_seen(view: BladeCampbell, more: int) -> list[FamilyCurves]:
    """Families as their waves h + more are seen at rest; a standing one has both directions."""
    hertz = view.rpm * view.speed_ratio / 60.0
    seen = []
    for f in view.families:
        for direction in ("backward", "forward") if f.direction == "standing" else (f.direction,):
            shift = (f.index + more) * (hertz if direction == "forward" else -hertz)[:, None]
            name = f.direction if f.index + more == 0 else direction
            seen.append(replace(f, frequency_hz=np.abs(f.frequency_hz + shift), direction=name))
    return seen


def _further_waves(
    rpm: FloatArray, families: Sequence[FamilyCurves], waves: int
) -> list[charts.Mark]:
    """Thin lines of the parts of modes with other numbers of waves."""
    look = charts.Look("@ink/0.5", "dot", width=1.0)
    return [
        charts.Curve(
            x=rpm,
            y=family.frequency_hz[:, mode],
            look=look,
            texts=[f"{abs(waves)} waves around, of {family.direction} mode {mode + 1}"] * len(rpm),
        )
        for family in families
        for mode in range(family.frequency_hz.shape[1])
        if np.isfinite(family.frequency_hz[:, mode]).any()
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class Interference:
    """What an interference diagram shows at one speed."""

    #: Of the reference shaft
    rpm: float
    #: (h,) and by direction (h, m) [Hz]
    index: Sequence[int]
    frequency_hz: Mapping[str, FloatArray]
    #: (orders, 2) index and frequency of the line of engine orders
    zigzag: FloatArray
    #: Engine orders at whole points of that line, their indices and frequencies
    engine_orders: Sequence[tuple[int, int, float]]


def interference_chart(view: Interference) -> charts.Chart:
    """Return frequencies over the nodal diameters with the line of engine orders (SAFE)."""
    parts: list[charts.Part] = []
    highest = max(
        (float(np.nanmax(f, initial=0.0)) for f in view.frequency_hz.values()), default=1.0
    )
    top, line = _ROOM * highest, view.zigzag
    sizes = {"backward": 12.0}  # open, around the others of nearly the same frequency
    looks = {d: replace(_LOOKS[d], dash="", size=sizes.get(d, 8.0)) for d in _LOOKS}
    parts.append(
        charts.Curve(
            x=line[:, 0],
            y=line[:, 1],
            name="line of engine orders",
            look=charts.Look("@ink", width=1.0),
        )
    )
    shown = [e for e in view.engine_orders if e[2] <= top]
    if shown:
        parts.append(
            charts.Curve(
                x=np.array([float(index) for _, index, _ in shown]),
                y=np.array([hertz for *_, hertz in shown]),
                name="engine orders that are looked at",
                look=charts.Look("@ink", "", "x", 7.0),
                texts=[f"engine order {order}" for order, *_ in shown],
            )
        )
        if len(shown) <= _LABELS:
            parts += [
                charts.Label(x=index - 0.06, y=hertz, text=f"EO {order}", side="left")
                for order, index, hertz in shown
            ]
    x = np.array(view.index, dtype=float)
    for direction, hertz in view.frequency_hz.items():
        for mode in range(hertz.shape[1]):
            texts = [f"nodal diameter {h}, {direction}, mode {mode + 1}" for h in view.index]
            if np.isfinite(hertz[:, mode]).any():
                parts.append(
                    charts.Curve(
                        x=x, y=hertz[:, mode], name=_NAMES[direction], look=looks[direction],
                        texts=texts,
                    )
                )  # fmt: skip
    last = max(float(x.max(initial=1.0)), 1.0)
    return charts.Chart(
        name="interference",
        title=f"Interference diagram at {view.rpm:.0f} rpm",
        caption="A mode is excited where the line of engine orders passes through it. The line "
        "rises from nodal diameter 0, and of N sectors is folded at N/2 and at 0: rising pieces "
        "excite backward waves, falling ones forward waves.",
        alt="Frequencies over the nodal diameters with the zigzag line of the engine orders.",
        x=charts.Axis(label="nodal diameters", low=-0.3, high=last + 0.3, step=1.0, digits=".0f"),
        y=charts.Axis(label="frequency on the body", unit="Hz", low=0.0, high=top, digits=".6g"),
        parts=parts,
        height_px=480,
    )


def amplification_chart(
    factors: FloatArray, quantiles: Mapping[str, float], bound: float
) -> charts.Chart:
    """Return how large the amplification of random patterns of blades is.

    `factors`: rising. `quantiles`: by what they are called, such as "95 %".
    """
    share = 100.0 * (np.arange(len(factors)) + 0.5) / len(factors)
    last = 1.03 * max(bound, float(factors[-1]))
    at = np.array([*quantiles.values()])
    parts: list[charts.Part] = [
        charts.Curve(x=factors, y=share, name="random patterns", look=charts.Look("@c0")),
        charts.Curve(
            x=at,
            y=np.interp(at, factors, share),
            name="quantiles",
            look=charts.Look("@c3", "", "diamond", 9.0),
            texts=[f"{name} of the patterns stay below {q:.3f}" for name, q in quantiles.items()],
        ),
        charts.Rule(at=bound, name="(1 + √N) / 2", text="bound"),
    ]
    return charts.Chart(
        name="amplification",
        title="Amplification by mistuned blades",
        caption="Part of the random patterns whose largest blade amplitude stays below a multiple "
        "of the tuned one, and the largest multiple that any pattern can have.",
        alt="Cumulative distribution of the amplification factor; the table has its quantiles.",
        x=charts.Axis(
            label="amplification factor", unit="1", low=min(1.0, float(factors[0])), high=last
        ),
        y=charts.Axis(label="part of the patterns", unit="%", low=0.0, high=100.0),
        parts=parts,
        notes=[f"{name}: {q:.3f}" for name, q in quantiles.items()],
        height_px=360,
    )
