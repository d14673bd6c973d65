"""Campbell diagrams: natural frequencies and damping of the branches over the speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.modes.kinds import motion_words
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

UNSTABLE = charts.Look("@bad", "")
# Decrements below this are those of no damping; above this, close to critical damping, they would
# flatten all others.
UNDAMPED, _LARGEST_DECREMENT = 1e-9, 2.0
# Critical speeds listed beside the diagram.
_LISTED = 14
# Error bands may be drawn wider than they are, as most would not be seen.
_WIDER = (1, 10, 100)
_DAMPED = "critically damped"
# Marks of notes on branches, whether they show at the start, and words of notes on all of them.
_NOTES = {
    "crossing": (charts.Look("@muted", "", "x-thin-open", 11), False),
    "veering": (charts.Look("@c3", "", "square-open", 11), True),
    "ambiguous": (charts.Look("@bad", "", "star-open", 11), True),
    "begun": (charts.Look("@ink", "", "triangle-left-open", 11), True),
    "ended": (charts.Look("@ink", "", "triangle-right-open", 11), True),
}
_ACROSS = {"range": "end of the basis", "indefinite": "a mode stands still in space"}


@dataclass(frozen=True, kw_only=True, eq=False)
class CampbellView:
    """What a Campbell diagram shows beside its branches."""

    #: Marked by rings
    critical_speeds: Sequence[CriticalSpeed] = ()
    #: What a reader is told at each of them; empty: how it moves alone
    critical_texts: Sequence[str] = ()
    #: Crossings that nothing excites, small marks that wait to be asked for, and their texts
    crossings: Sequence[CriticalSpeed] = ()
    crossing_texts: Sequence[str] = ()
    #: Ratio of each excitation line by name, such as the speed ratio of each shaft; the line is
    #: |ratio| · Ω, drawn once for equal |ratio|
    excitation_ratios: Mapping[str, float]
    #: Lowest and highest operating speed by what a reader is told, as Ω of the reference shaft
    operating_rad_s: Mapping[str, tuple[float, float]]
    #: Relative errors of the frequencies, shape (b, s), drawn as bands; None draws none
    errors: FloatArray | None = None
    #: Where a branch is critically damped, that is no resonance, shape (b, s); None: nowhere
    damped: BoolArray | None = None
    #: Lowest and highest Ω of unstable ranges
    unstable_rad_s: Sequence[tuple[float, float]] = ()

    def where_damped(self, campbell: Campbell) -> BoolArray:
        """Return where branches are critically damped, shape (b, s)."""
        shape = campbell.frequency_hz.shape
        return np.zeros(shape, dtype=bool) if self.damped is None else self.damped


def campbell_chart(campbell: Campbell, view: CampbellView) -> charts.Chart:
    """Return the diagram of frequencies with its excitation lines, critical speeds and notes.

    The whirl of branches shows by colour, dashes and marks.
    """
    rpm, damped = campbell.speeds_rad_s * RPM_PER_RAD_S, view.where_damped(campbell)
    hertz = np.where(damped, np.nan, campbell.frequency_hz)
    # of what is a resonance; without a branch the excitation lines make the frame
    counting = hertz if np.isfinite(hertz).any() else campbell.frequency_hz
    highest = float(np.nanmax(counting, initial=0.0))
    top = 1.08 * (highest or max(float(rpm.max()) / 60.0, 1.0))
    first, last = float(rpm.min()), float(rpm.max())
    words = _point_texts(campbell, view)
    whirl = np.where(damped, "", campbell.whirl)
    faint = _damped_curves(campbell, damped, words)
    excited = excitation_lines(view.excitation_ratios, last, top)
    parts: list[charts.Part] = [
        *_error_bands(campbell, view),
        *charts.operating_toggle(view.operating_rad_s),
        *([excited] if excited.marks else []),
        *charts.branch_curves(rpm, hertz, whirl, words),
        *([charts.Toggle(label=_DAMPED, marks=faint)] if faint else []),
        *_rings(view, last, top),
        *_crossings(view, last, top),
        *_note_marks(campbell),
        *unstable_spans(view.unstable_rad_s),
    ]
    return charts.Chart(
        name="campbell-frequency",
        title="Natural frequencies over the speed",
        caption=_caption(campbell, view),
        alt=f"Campbell diagram of {len(hertz)} branches from {first:g} to {last:g} rpm, "
        f"frequencies up to {highest:.4g} Hz. The numbers are in the tables of modes and "
        "critical speeds.",
        x=charts.speed_axis(first, last),
        y=charts.Axis(label="natural frequency", unit="Hz", low=0.0, high=top, digits=".6g"),
        parts=parts,
        notes=_listed(view.critical_speeds),
        height_px=560,
    )


def damping_chart(campbell: Campbell) -> charts.Chart:
    """Return the logarithmic decrements over the speed; below zero it is unstable.

    Decrements above 2 leave the frame, which says so.
    """
    rpm = campbell.speeds_rad_s * RPM_PER_RAD_S
    decrement = campbell.log_decrement
    largest, smallest = (float(f(decrement, initial=0.0)) for f in (np.nanmax, np.nanmin))
    top = 1.08 * min(max(largest, 1e-3), _LARGEST_DECREMENT)
    bottom = min(1.2 * smallest, -0.08 * top)
    first, last = float(rpm.min()), float(rpm.max())
    texts = [
        [f"branch {b + 1}, {_how(campbell, b, s)}\n{f:.6g} Hz" for s, f in enumerate(hertz)]
        for b, hertz in enumerate(campbell.frequency_hz.tolist())
    ]
    parts: list[charts.Part] = [
        charts.Span(low=bottom, high=0.0, along="y", text="unstable", look=UNSTABLE),
        *charts.branch_curves(rpm, decrement, campbell.whirl.tolist(), texts),
        charts.Rule(at=0.0, along="y", look=charts.Look("@ink", "solid", width=1.0)),
    ]
    caption = "Damping of the branches; the shaded range below zero is unstable."
    notes: tuple[str, ...] = ()
    if largest > top:
        caption += (
            f" Decrements above {_LARGEST_DECREMENT:g} leave the frame (up to {largest:.3g}): "
            "double-click shows them."
        )
        notes = (f"decrements up to {largest:.3g}, above {_LARGEST_DECREMENT:g} not shown",)
    return charts.Chart(
        name="campbell-damping",
        title="Damping over the speed",
        caption=caption,
        alt=f"Logarithmic decrements of {len(decrement)} branches, {smallest:.3g} to "
        f"{largest:.3g}.",
        x=charts.speed_axis(first, last),
        y=charts.Axis(label="logarithmic decrement", unit="1", low=bottom, high=top, digits=".4g"),
        parts=parts,
        notes=notes,
        height_px=360,
    )


def draw_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw a Campbell diagram to a picture file, whose suffix chooses the kind (.png, .svg, .pdf).

    Parameters
    ----------
    critical_speeds
        Marked by circles and listed beside the diagram with their speed in rpm.
    excitation_ratios
        Ratio of each excitation line by name, such as the speed ratio of each shaft; the line is
        |ratio| · Ω. Lines of equal |ratio| are drawn once with all their names.
    operating_rad_s
        Lowest and highest operating speed by name, as speeds of the reference shaft, drawn as
        hatched bands; equal ones as a line. None draws none.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    plain = replace(campbell, notes=())
    draw_annotated_campbell(plain, critical_speeds, path, title, excitation_ratios, operating_rad_s)


def draw_annotated_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw a Campbell diagram with marks where branches cross, veer, end or are ambiguous.

    Arguments and errors as in `draw_campbell`; the marks are those of `campbell.notes`.
    """
    view = _view(critical_speeds, excitation_ratios, operating_rad_s)
    draw_charts([campbell_chart(campbell, view)], path, title)


def draw_damped_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw an annotated Campbell diagram with the logarithmic decrements below it.

    Arguments and errors as in `draw_campbell`. Decrements above 2 leave the strip, which says so;
    the range below zero, where a mode is unstable, is shaded.
    """
    view = _view(critical_speeds, excitation_ratios, operating_rad_s)
    draw_charts([campbell_chart(campbell, view), damping_chart(campbell)], path, title)


def _view(
    critical_speeds: Sequence[CriticalSpeed],
    ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None,
) -> CampbellView:
    return CampbellView(
        critical_speeds=critical_speeds,
        excitation_ratios=ratios,
        operating_rad_s=operating_rad_s or {},
    )


def unstable_spans(ranges_rad_s: Sequence[tuple[float, float]]) -> list[charts.Span]:
    """Return unstable ranges of Ω as shaded speeds."""
    return [
        charts.Span(low=a * RPM_PER_RAD_S, high=b * RPM_PER_RAD_S, text="unstable", look=UNSTABLE)
        for a, b in ranges_rad_s
    ]


def error_words(value: float | None) -> str:
    """Return a relative error as text; below 1e-6 it is that of rounding."""
    if value is None or not np.isfinite(value):
        return "not known"
    return "below ±0.0001 %" if value < 1e-6 else f"±{100.0 * value:.2g} %"


def _point_texts(campbell: Campbell, view: CampbellView) -> list[list[str]]:
    """What a reader is told at every point beside its coordinates, b × s."""
    damped = view.where_damped(campbell)
    out = []
    for b, branch in enumerate(campbell.log_decrement):
        row = []
        for s, decrement in enumerate(branch):
            words = [f"branch {b + 1}, {_how(campbell, b, s)}"]
            if abs(decrement) > UNDAMPED:
                words.append(f"log. decrement {decrement:.4g}")
            if damped[b, s]:
                words.append("critically damped: no resonance")
            elif view.errors is not None:
                words.append(f"error {error_words(float(view.errors[b, s]))}")
            row.append("\n".join(words))
        out.append(row)
    return out


def _how(campbell: Campbell, b: int, s: int) -> str:
    """How a branch moves at a speed."""
    whirl = str(campbell.whirl[b, s])
    return motion_words(whirl, campbell.shares[b, s]) if whirl else "none"


def _damped_curves(
    campbell: Campbell, damped: BoolArray, texts: Sequence[Sequence[str]]
) -> list[charts.Curve]:
    """Branches where they are critically damped, faint; they reach to the next resonance."""
    near = damped.copy()
    near[:, 1:] |= damped[:, :-1]
    near[:, :-1] |= damped[:, 1:]
    rpm = campbell.speeds_rad_s * RPM_PER_RAD_S
    look = charts.Look("@muted/0.55", "dot", width=1.0)
    return [
        charts.Curve(x=rpm, y=np.where(own, hertz, np.nan), name=_DAMPED, look=look, texts=words)
        for hertz, own, counts, words in zip(
            campbell.frequency_hz, near, damped & np.isfinite(campbell.frequency_hz), texts,
            strict=True,
        )
        if counts.any()
    ]  # fmt: skip


def _error_bands(campbell: Campbell, view: CampbellView) -> list[charts.Choice]:
    """The bands f (1 ± error), as they are and wider."""
    if view.errors is None:
        return []
    error = np.where(view.where_damped(campbell), np.nan, view.errors)
    if not np.isfinite(error).any():
        return []
    rpm = campbell.speeds_rad_s * RPM_PER_RAD_S
    options = []
    for wider in _WIDER:
        name = "error band" + ("" if wider == 1 else f", {wider} times as wide")
        bands = [
            charts.Fill(
                x=rpm, low=np.maximum(f * (1 - wider * e), 0.0), high=f * (1 + wider * e), name=name
            )
            for f, e in zip(campbell.frequency_hz, error, strict=True)
        ]
        label = "as estimated" if wider == 1 else f"drawn {wider} times as wide"
        options.append(charts.Option(label=label, marks=bands))
    return [charts.Choice(label="error bands", options=[*options, charts.Option(label="none")])]


def excitation_lines(ratios: Mapping[str, float], last: float, top: float) -> charts.Toggle:
    """Return the lines |ratio| · Ω, named where they leave the frame at `last` rpm, `top` Hz."""
    marks: list[charts.Mark] = []
    look = charts.Look("@ink", "solid", width=1.0)
    for ratio, names in charts.same_ratios(ratios).items() if last > 0.0 else ():
        end = min(last, 60.0 * top / ratio)
        height, listed = ratio * end / 60.0, ", ".join(names)
        told = f"turns {ratio:.5g} times per turn of the reference shaft: {listed}"
        x, y = np.array([0.0, end]), np.array([0.0, height])
        text = f"{ratio:.5g}× " + ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
        marks.append(charts.Curve(x=x, y=y, look=look, texts=(told, told)))
        marks.append(
            charts.Label(x=end, y=height, text=text, side="right" if end == last else "above")
        )
    return charts.Toggle(label="excitation lines", marks=marks)


def _rings(view: CampbellView, last: float, top: float) -> list[charts.Curve]:
    """Critical speeds inside the frame."""
    found = (view.critical_speeds, view.critical_texts, "critical speed", charts.RING)
    return _meetings(*found, last, top)


def _crossings(view: CampbellView, last: float, top: float) -> list[charts.Toggle]:
    """Crossings that nothing excites."""
    name = "crossing, not excited"
    look = charts.Look("@muted", "", "circle-open", 6)
    marks = _meetings(view.crossings, view.crossing_texts, name, look, last, top)
    return [charts.Toggle(label=name, marks=marks, is_shown=False)] if marks else []


def _meetings(
    found: Sequence[CriticalSpeed],
    texts: Sequence[str],
    name: str,
    look: charts.Look,
    last: float,
    top: float,
) -> list[charts.Curve]:
    """Marks where branches meet the excitation, inside the frame."""
    told = texts or [motion_words(c.whirl, c.shares) for c in found]
    rows = [
        (c.speed_rad_s * RPM_PER_RAD_S, c.frequency_hz, text)
        for c, text in zip(found, told, strict=True)
    ]
    shown = [row for row in rows if row[0] <= last * (1.0 + 1e-9) and row[1] <= top]
    if not shown:
        return []
    x, y, said = zip(*shown, strict=True)
    return [charts.Curve(x=np.array(x), y=np.array(y), name=name, look=look, texts=said)]


def _note_marks(campbell: Campbell) -> list[charts.Part]:
    """Notes at the mean of their branches by kind, or as a line across where all are meant."""
    order = np.argsort(campbell.speeds_rad_s)
    speeds = campbell.speeds_rad_s[order]
    parts: list[charts.Part] = []
    for kind, (look, is_shown) in _NOTES.items():
        own = [note for note in campbell.notes if note.kind == kind and note.branches]
        if not own:
            continue
        height = [
            np.mean([_near(speeds, campbell.frequency_hz[b][order], n.speed_rad_s)
                     for b in n.branches])
            for n in own
        ]  # fmt: skip
        mark = charts.Curve(
            x=np.array([n.speed_rad_s * RPM_PER_RAD_S for n in own]),
            y=np.array(height),
            name=kind,
            look=look,
            texts=[n.text for n in own],
        )
        parts.append(charts.Toggle(label=kind, marks=[mark], is_shown=is_shown))
    look = charts.Look("@muted", "longdashdot", width=1.5)
    parts += [
        charts.Rule(at=n.speed_rad_s * RPM_PER_RAD_S, text=_ACROSS[n.kind], look=look)
        for n in campbell.notes
        if n.kind in _ACROSS
    ]
    return parts


def _near(speeds: FloatArray, frequency: FloatArray, speed: float) -> float:
    """Frequency of a branch at a speed, its last one where it has ended."""
    alive = np.isfinite(frequency)
    return float(np.interp(speed, speeds[alive], frequency[alive])) if alive.any() else np.nan


def _listed(critical_speeds: Sequence[CriticalSpeed]) -> tuple[str, ...]:
    """The list of critical speeds beside the diagram on paper."""
    if not critical_speeds:
        return ()
    rows = [
        f"{c.speed_rad_s * RPM_PER_RAD_S:.0f}  {motion_words(c.whirl, c.shares)}"
        for c in sorted(critical_speeds, key=lambda c: c.speed_rad_s)[:_LISTED]
    ]
    more = len(critical_speeds) - _LISTED
    return ("critical speeds [rpm]", *rows, *([f"and {more} more"] if more > 0 else []))


def _caption(campbell: Campbell, view: CampbellView) -> str:
    text = (
        "Whirl shows by colour, dashes and mark: forward full lines with filled circles, backward "
        "dashed lines with open squares. Thin lines are the frequency at which the unbalance of a "
        "shaft turns; where it meets a branch that it excites is a critical speed (ring)."
    )
    damped = view.where_damped(campbell)
    if damped.any():
        text += (
            " Faint dotted lines are critically damped: no resonance, and no critical speed where "
            "an excitation meets them."
        )
    if view.errors is not None and np.isfinite(view.errors[~damped]).any():
        largest = float(np.nanmax(view.errors[~damped]))
        text += f" The band around a branch is its estimated error, {100 * largest:.2g} % at most."
    return text
