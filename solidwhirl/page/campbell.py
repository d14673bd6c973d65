"""The Campbell diagram of a page: frequencies and damping of the branches over the speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.operating import critical_speeds_that_count
from solidwhirl.page.campbell_damping import damping_chart
from solidwhirl.page.campbell_lines import UNDAMPED, Lines, branches, point_texts
from solidwhirl.page.operating import operating_bands, operating_speeds, unstable_shapes
from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Table, Text, Toggle
from solidwhirl.page.traces import (
    SPEED_AXIS,
    FloatArray,
    Trace,
    axis,
    branch_lines,
    line,
    marks,
    percent,
    style_of,
)

# Error bands may be drawn wider than they are, as most would not be seen.
_WIDER = (1, 10, 100)
# Marks of notes on branches, and whether they show at the start.
_NOTES = {
    "veering": ("square-open", "@c3", True),
    "ambiguous": ("star-open", "@bad", True),
    "begun": ("triangle-left-open", "@ink", True),
    "ended": ("triangle-right-open", "@ink", True),
    "crossing": ("x-thin-open", "@muted", False),
}
_DAMPED = "critically damped"
# The small diagram reaches this many times as far as excitation by unbalance.
_ROOM = 2.5
_ACROSS = ("range", "indefinite")


def section(run: Run) -> Section | None:
    """Return the Campbell diagram with its damping and notes; notes alone without branches."""
    lines = branches(run.document)
    if not lines.hertz.size or not np.isfinite(lines.hertz).any():
        notes = _notes_table(run.document)
        title = "Campbell diagram"
        text = Text(text="The engine has no oscillatory mode in this range.")
        return Section(name="campbell", title=title, blocks=[text, *notes]) if notes else None
    blocks: list[Any] = [frequency_chart(run.document, run.results.scene.speed_ratios())]
    if np.nanmax(np.abs(lines.decrement), initial=0.0) > UNDAMPED:
        blocks.append(damping_chart(run.document))
    else:
        blocks.append(Text(text="There is no damping: all decrements are zero."))
    blocks += _notes_table(run.document)
    return Section(
        name="campbell",
        title="Campbell diagram",
        blocks=blocks,
        note="Natural frequencies in the inertial frame over the speed of the reference shaft.",
    )


def frequency_chart(document: Mapping[str, Any], ratios: Mapping[str, float]) -> Chart:
    """Return the diagram of frequencies with error bands, excitations and critical speeds.

    Parameters
    ----------
    document
        The contents of `results.json`.
    ratios
        Speed ratio of every body.
    """
    lines = branches(document)
    top = 1.08 * lines.top_hz
    first, last = float(lines.rpm.min()), float(lines.rpm.max())
    traces: list[Trace] = []
    controls: list[Toggle | Choice] = []
    if lines.error is not None and np.isfinite(lines.error).any():
        options = []
        for wider in _WIDER:
            name = "error band" + ("" if wider == 1 else f", {wider} times as wide")
            options.append(
                Option(
                    label="as estimated" if wider == 1 else f"drawn {wider} times as wide",
                    traces=[len(traces)],
                )
            )
            traces.append(error_band(lines, float(wider), name))
        controls.append(
            Choice(label="error bands", options=[*options, Option(label="none", traces=())])
        )
    operating = operating_bands(operating_speeds(document, ratios), 0.0, top)
    if operating:
        at = range(len(traces), len(traces) + len(operating))
        controls.append(Toggle(label="operating speeds", traces=list(at)))
        traces += operating
    excited, annotations = excitation_lines(ratios, last, top)
    if excited:
        at = range(len(traces), len(traces) + len(excited))
        controls.append(Toggle(label="excitation lines", traces=list(at)))
        traces += excited
    traces += resonant_lines(lines)
    faint = damped_lines(lines)
    if faint:
        controls.append(Toggle(label=_DAMPED, traces=[len(traces)]))
        traces += faint
    traces += critical_marks(document)
    for kind, trace, shown in note_marks(document, lines):
        controls.append(Toggle(label=kind, traces=[len(traces)], shown=shown))
        traces.append(trace)
    return Chart(
        name="campbell-frequency",
        title="Natural frequencies over the speed",
        caption=_caption(lines),
        alt=f"Campbell diagram of {len(lines.hertz)} branches from {first:g} to {last:g} rpm, "
        f"frequencies up to {lines.top_hz:.4g} Hz. The numbers are in the tables of "
        "modes and critical speeds.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[first, max(last, first + 1.0)]),
            "yaxis": axis("natural frequency [Hz]", range=[0.0, top]),
            "annotations": annotations,
            "shapes": [*_limits(document), *unstable_shapes(_unstable(document))],
            "hovermode": "closest",
        },
        height_px=560,
        controls=controls,
    )


def small_chart(document: Mapping[str, Any], ratios: Mapping[str, float]) -> Chart | None:
    """Return the diagram without bands, notes and controls; None without branches.

    Parameters
    ----------
    document
        The contents of `results.json`.
    ratios
        Speed ratio of every body.
    """
    lines = branches(document)
    if not np.isfinite(lines.hertz).any():
        return None
    whole = frequency_chart(document, ratios)
    top = _top_of_small(lines, ratios)
    traces = [
        *operating_bands(operating_speeds(document, ratios), 0.0, top),
        *excitation_lines(ratios, float(lines.rpm.max()), top)[0],
        *resonant_lines(lines),
        *damped_lines(lines),
        *critical_marks(document),
    ]
    layout = dict(whole.layout) | {
        "yaxis": axis("natural frequency [Hz]", range=[0.0, top]),
        "annotations": excitation_lines(ratios, float(lines.rpm.max()), top)[1],
        "margin": {"l": 56, "r": 16, "t": 8, "b": 44},
    }
    above = bool((np.nan_to_num(lines.hertz) > top).any())
    return replace(
        whole,
        name="campbell-small",
        title="Campbell diagram",
        caption="Higher modes are in the diagram further down." if above else "",
        traces=traces,
        layout=layout,
        height_px=360,
        controls=(),
    )


def _top_of_small(lines: Lines, ratios: Mapping[str, float]) -> float:
    """Highest frequency of the small diagram: what unbalance may reach, and room above it."""
    excited = max(map(abs, ratios.values()), default=0.0) * float(lines.rpm.max()) / 60.0
    counting = np.where(lines.damped, np.nan, lines.hertz)
    lowest = float(np.nanmin(counting if np.isfinite(counting).any() else lines.hertz))
    return min(1.08 * lines.top_hz, _ROOM * max(excited, lowest))


def resonant_lines(lines: Lines) -> list[Trace]:
    """Return the branches where they are resonances, one trace for each direction of whirl.

    Parameters
    ----------
    lines
        The branches.
    """
    whirl = [
        [None if d else w for w, d in zip(words, damped, strict=True)]
        for words, damped in zip(lines.whirl, lines.damped.tolist(), strict=True)
    ]
    return branch_lines(
        lines.rpm,
        np.where(lines.damped, np.nan, lines.hertz),
        whirl,
        point_texts(lines),
        "%{x:,.0f} rpm<br><b>%{y:.6g} Hz</b><br>%{text}",
    )


def damped_lines(lines: Lines) -> list[Trace]:
    """Return the branches where they are critically damped as one faint trace, if any are.

    Parameters
    ----------
    lines
        The branches; a line reaches to the neighbouring resonance.
    """
    if not (lines.damped & np.isfinite(lines.hertz)).any():
        return []
    near = lines.damped.copy()
    near[:, 1:] |= lines.damped[:, :-1]
    near[:, :-1] |= lines.damped[:, 1:]
    gap = np.full((len(lines.hertz), 1), np.nan)
    texts = np.array([[*row, ""] for row in point_texts(lines)], dtype=object)
    rpm = np.tile([*lines.rpm, np.nan], len(lines.hertz))
    hertz = np.hstack([np.where(near, lines.hertz, np.nan), gap]).ravel()
    faint = line(
        rpm,
        hertz,
        _DAMPED,
        style_of("planar")._replace(color="@muted/0.55", dash="dot"),
        text=texts.ravel().tolist(),
        hovertemplate="%{x:,.0f} rpm<br><b>%{y:.6g} Hz</b><br>%{text}<extra></extra>",
        connectgaps=False,
    )
    faint["line"]["width"] = 1
    return [faint]


def _caption(lines: Lines) -> str:
    text = (
        "Whirl shows by colour, dashes and mark: forward full lines with filled circles, backward "
        "dashed lines with open squares. Thin lines are the frequency at which the unbalance of a "
        "shaft turns; where one meets a branch is a critical speed (ring)."
    )
    if lines.damped.any():
        text += (
            " Faint dotted lines are critically damped: no resonance, and no critical speed where "
            "an excitation meets them."
        )
    if lines.error is not None and np.isfinite(lines.error).any():
        largest = float(np.nanmax(lines.error))
        text += f" The band around a branch is its estimated error, {100 * largest:.2g} % at most."
    return text


def error_band(lines: Lines, wider: float, name: str) -> Trace:
    """Return the bands f (1 ± error) of all branches as one trace.

    Parameters
    ----------
    lines
        Branches with errors.
    wider
        Factor on the errors.
    name
        In the legend.
    """
    assert lines.error is not None
    xs: list[FloatArray] = []
    ys: list[FloatArray] = []
    for hertz, error in zip(lines.hertz, lines.error, strict=True):
        for known in _stretches(np.isfinite(hertz) & np.isfinite(error)):
            x, y, e = lines.rpm[known], hertz[known], wider * error[known]
            xs += [x, x[::-1], x[:1], np.array([np.nan])]
            low = np.maximum(y * (1.0 - e), 0.0)
            high = y * (1.0 + e)
            ys += [high, low[::-1], high[:1], np.array([np.nan])]
    return {
        "type": "scatter",
        "mode": "lines",
        "x": np.concatenate(xs[:-1]),
        "y": np.concatenate(ys[:-1]),
        "fill": "toself",
        "fillcolor": "@band",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "name": name,
    }


def _stretches(known: NDArray[np.bool_]) -> list[slice]:
    """Runs of points that are known: a band ends where its branch does."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
    return [slice(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def excitation_lines(
    ratios: Mapping[str, float], last_rpm: float, top_hz: float
) -> tuple[list[Trace], list[dict[str, Any]]]:
    """Return the lines |ratio| · Ω, one for each |ratio|, and their names where they end.

    Parameters
    ----------
    ratios
        Speed ratio of every body.
    last_rpm, top_hz
        End of the axes.
    """
    named: dict[float, list[str]] = {}
    for name, ratio in ratios.items():
        if ratio != 0.0:
            named.setdefault(abs(ratio), []).append(name)
    traces, annotations = [], []
    for ratio, names in named.items() if last_rpm > 0.0 else ():
        end = min(last_rpm, 60.0 * top_hz / ratio)
        text = f"{ratio:.5g}× " + ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": np.array([0.0, end]),
                "y": np.array([0.0, ratio * end / 60.0]),
                "line": {"color": "@ink", "width": 1, "dash": "solid"},
                "name": f"unbalance of {', '.join(names)}",
                "text": f"turns {ratio:.5g} times per turn of the reference shaft: "
                + ", ".join(names),
                "hovertemplate": "%{text}<br>%{x:,.0f} rpm, %{y:.5g} Hz<extra></extra>",
                "showlegend": False,
            }
        )
        annotations.append(
            {
                "x": end,
                "y": ratio * end / 60.0,
                "text": text,
                "showarrow": False,
                "xanchor": "right",
                "yanchor": "bottom" if end == last_rpm else "top",
                "font": {"color": "@ink", "size": 11},
                "bgcolor": "@paper",
                "opacity": 0.85,
            }
        )
    return traces, annotations


def critical_marks(document: Mapping[str, Any]) -> list[Trace]:
    """Return the critical speeds that are resonances as rings, with what is known on hover."""
    found = critical_speeds_that_count(document)
    if not found:
        return []
    texts = []
    for c in found:
        words = [f"{c['whirl']}, excited by {', '.join(c['excited_by'])}"]
        if c["log_decrement"]:
            words.append(f"log. decrement {c['log_decrement']:.4g}")
        if c.get("amplification_factor"):
            words.append(f"amplification {c['amplification_factor']:.3g}")
        if "frequency_error_estimate" in c:
            words.append(f"error {percent(c['frequency_error_estimate'])}")
        texts.append("<br>".join(words))
    ring = style_of("planar")._replace(color="@ink", symbol="circle-open")
    return [
        marks(
            [c["speed_rpm"] for c in found],
            [c["frequency_hz"] for c in found],
            "critical speed",
            ring,
            14,
            text=texts,
            hovertemplate="<b>critical speed %{x:,.1f} rpm</b><br>%{y:.6g} Hz<br>%{text}"
            "<extra></extra>",
        )
    ]


def note_marks(document: Mapping[str, Any], lines: Lines) -> list[tuple[str, Trace, bool]]:
    """Return the notes on branches by kind: its name, its marks, whether they show.

    Parameters
    ----------
    document
        The contents of `results.json`.
    lines
        Its branches.
    """
    order = np.argsort(lines.rpm)
    found = []
    for kind, (symbol, color, shown) in _NOTES.items():
        own = [n for n in document["campbell"]["notes"] if n["kind"] == kind and n["branches"]]
        if not own:
            continue
        at = [
            float(
                np.mean([_near(lines.rpm[order], lines.hertz[b][order], n) for b in n["branches"]])
            )
            for n in own
        ]
        trace = marks(
            [n["speed_rpm"] for n in own],
            at,
            kind,
            style_of("planar")._replace(color=color, symbol=symbol),
            11,
            text=[n["text"] for n in own],
            hovertemplate="%{text}<extra></extra>",
        )
        found.append((kind, trace, shown))
    return found


def _near(rpm: FloatArray, hertz: FloatArray, note: Mapping[str, Any]) -> float:
    """Frequency of a branch at a note, its last one where it has ended."""
    alive = np.isfinite(hertz)
    return float(np.interp(note["speed_rpm"], rpm[alive], hertz[alive])) if alive.any() else np.nan


def _unstable(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(document["verdict"]["unstable_intervals"])


def _limits(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Lines across the diagram where a note is on all of it."""
    return [
        {
            "type": "line",
            "x0": n["speed_rpm"],
            "x1": n["speed_rpm"],
            "yref": "paper",
            "y0": 0.0,
            "y1": 1.0,
            "line": {"color": "@muted", "width": 1.5, "dash": "longdashdot"},
            "label": {
                "text": {"range": "end of the basis", "indefinite": "stiffness indefinite"}[
                    n["kind"]
                ],
                "font": {"color": "@muted", "size": 10},
                "textposition": "end",
            },
        }
        for n in document["campbell"]["notes"]
        if n["kind"] in _ACROSS
    ]


def _notes_table(document: Mapping[str, Any]) -> list[Table]:
    notes = document["campbell"]["notes"]
    if not notes:
        return []
    return [
        Table(
            head=["speed [rpm]", "kind", "branches", "what it says"],
            rows=[
                [
                    float(n["speed_rpm"]),
                    n["kind"],
                    ", ".join(str(b + 1) for b in n["branches"]) or "all",
                    n["text"],
                ]
                for n in notes
            ],
            folded=f"Notes on the branches ({len(notes)})",
            caption="Veering: two branches come close, exchange their shapes and part. Crossing: "
            "they pass through each other.",
        )
    ]
