"""The Campbell diagram of a page as bodies see it that turn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.page.records import Chart, Choice, Option, Run, Section
from solidwhirl.page.traces import (
    FloatArray,
    Trace,
    analyses_of_kind,
    axis,
    line,
    numbers,
    series_style,
    slug,
    style_of,
)

# Components and bodies with a smaller part of a branch are not drawn.
_SMALL = 0.05


def section(run: Run) -> Section | None:
    """Return the diagrams in the frames of bodies; None where the scene asks for none."""
    found = analyses_of_kind(run.document, "rotating_campbell")
    if not found:
        return None
    return Section(
        name="rotating-frames",
        title="Frequencies that the bodies see",
        blocks=[frame_chart(name, entry) for name, entry in found.items()],
        note="What a strain gauge on a turning body would measure.",
    )


def frame_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return the frequencies in the frames of bodies over their own speeds.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    rpm = numbers(entry["speed_rpm"])
    traces: list[Trace] = []
    options: list[Option] = []
    for body, frame in entry["bodies"].items():
        own = np.abs(frame["speed_ratio"]) * rpm
        before = len(traces)
        traces += frame_lines(frame, rpm)
        seen = [np.nanmax(t["y"], initial=0.0) for t in traces[before:]]
        top = 1.05 * float(max(seen, default=1.0)) or 1.0
        last = float(own.max(initial=1.0)) or 1.0
        traces.append(
            line(
                [0.0, min(last, 60.0 * top)],
                [0.0, min(last / 60.0, top)],
                "a force at rest",
                series_style(6)._replace(dash="dot"),
                hovertemplate="a force at rest, once per turn<br>%{y:.4g} Hz<extra></extra>",
            )
        )
        options.append(
            Option(
                label=f"{body} (speed ratio {frame['speed_ratio']:.5g})",
                traces=list(range(before, len(traces))),
                layout={"yaxis.range": [0.0, top], "xaxis.range": [0.0, last]},
            )
        )
    return Chart(
        name=f"frame-{slug(name)}",
        title=f"Campbell diagram in the frame of a body ({name})",
        caption="A component is drawn where it and the body have 5 % or more of the branch. Full "
        "lines turn with the spin of the body in its own frame, broken ones against it: a forward "
        "whirl slower than the body is broken, after its mirror at zero.",
        alt="Frequencies that a turning body sees over its speed.",
        traces=traces,
        layout={
            "xaxis": axis("speed of the body [rpm]"),
            "yaxis": axis("frequency in the frame of the body [Hz]"),
        },
        height_px=440,
        controls=[Choice(label="seen by", options=options)],
    )


def frame_lines(frame: Mapping[str, Any], rpm: Any) -> list[Trace]:
    """Return the drawn components, one trace for those with the spin and one against it.

    Parameters
    ----------
    frame
        Of one body, in `results.json`.
    rpm
        Speeds of the reference shaft, shape (s,).
    """
    own = np.abs(frame["speed_ratio"]) * numbers(rpm)
    hertz = numbers(frame["frequency_hz"])
    share = np.nan_to_num(numbers(frame["share"]), nan=1.0)
    part = np.nan_to_num(numbers(frame["share_of_kinetic_energy"]), nan=1.0)
    drawn = (share >= _SMALL) & (part >= _SMALL)[None] & np.isfinite(hertz)
    orders = np.array(frame["orders"])
    # a positive order turns with +z, and so does a body with a positive ratio, until mirrored
    against = np.array(frame["mirrored"], dtype=bool) ^ (
        orders[:, None, None] * np.sign(frame["speed_ratio"]) < 0
    )
    signed = np.where(against, -hertz, hertz)
    traces = []
    for side, text, style in (
        (1.0, "turns with the spin", style_of("forward")),
        (-1.0, "turns against it", style_of("backward")),
    ):
        xs: list[float] = []
        ys: list[float] = []
        words: list[str] = []
        for c, b in np.ndindex(hertz.shape[:2]):
            x, y = with_zero(own, np.where(drawn[c, b], signed[c, b], np.nan))
            seen = side * y >= 0.0
            if not (side * y > 0.0).any():
                continue
            xs += [*x, np.nan]
            ys += [*np.where(seen, np.abs(y), np.nan), np.nan]
            words += [f"branch {b + 1}, order {orders[c]:+d}"] * (x.size + 1)
        if xs:
            traces.append(
                line(
                    xs[:-1],
                    ys[:-1],
                    text,
                    style,
                    mode="lines+markers",
                    marker={"size": 5, "symbol": style.symbol, "color": style.color},
                    text=words[:-1],
                    hovertemplate=f"%{{x:,.0f}} rpm<br><b>%{{y:.5g}} Hz</b><br>%{{text}}, {text}"
                    "<extra></extra>",
                    connectgaps=False,
                )
            )
    return traces


def with_zero(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line with the points added at which it passes zero.

    Parameters
    ----------
    x, y
        Points, shape (s,); nan in y is a gap.
    """
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    part = y[at] / (y[at] - y[at + 1])
    return (
        np.insert(x, at + 1, x[at] + part * (x[at + 1] - x[at])),
        np.insert(y, at + 1, 0.0),
    )
