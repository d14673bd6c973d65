"""Charts of asymmetric rotors: lines in two frames, motion by multiples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, StringArray
from solidwhirl.rotordyn.plots import chart as charts

# Widths of lines by their part of the motion; those with less are not drawn.
_WIDTHS = ((0.5, 3.0), (0.1, 1.8), (0.01, 0.9))


@dataclass(frozen=True, kw_only=True, eq=False)
class FrequencyLines:
    """Lines that branches are seen at, over the speed.

    `rpm`: (s,). `multiples`: k, (k,). `hertz`: (b, k, s). `share`, `forward`: part of each line in
    the motion of its branch, and of its circles about +z in it, (b, k, s); None: not told. `kind`:
    of the branches, (b, s).
    """

    rpm: FloatArray
    multiples: Sequence[int]
    hertz: FloatArray
    share: FloatArray
    forward: FloatArray | None
    kind: StringArray


def lines_chart(
    lines: FrequencyLines, frame: str, unstable_rpm: Sequence[tuple[float, float]]
) -> charts.Chart:
    """Return the frequencies of all branches in one frame, as wide as their part of the motion.

    `frame`: "fixed axes" or "axes of the body".
    """
    top = 1.08 * float(np.max(np.where(lines.share > 0.5, lines.hertz, 0.0), initial=1e-9))
    parts: list[charts.Part] = []
    for least, width in _WIDTHS:
        most = next((w for w, _ in reversed(_WIDTHS) if w > least), np.inf)
        shown = (lines.share >= least) & (lines.share < most)
        whirls = _whirls(lines)
        for whirl in ("lateral", *charts.WHIRL_LOOKS):
            parts += _curves(lines, shown & (whirls == whirl), whirl, least, width)
    low, high = float(lines.rpm.min()), float(lines.rpm.max())
    if frame == "fixed axes":
        for factor in (1, 2):
            x = np.array([0.0, min(high, 60.0 * top / factor)])
            look = charts.Look("@muted", "dot", width=1.2)
            parts.append(
                charts.Curve(x=x, y=factor * x / 60.0, name=f"{factor} × speed", look=look)
            )
    for start, end in unstable_rpm:
        parts.append(
            charts.Span(low=start, high=end, name="unstable", look=charts.Look("@bad/0.2"))
        )
    return charts.Chart(
        name=f"lines-in-{frame.replace(' ', '-')}",
        title=f"Frequencies in {frame}",
        caption="Each motion is seen at several frequencies at once; lines are as wide as their "
        f"part of the motion (over {_WIDTHS[0][0]:.0%}, {_WIDTHS[1][0]:.0%}, {_WIDTHS[2][0]:.0%}). "
        "Sidebands lie whole multiples of the speed from the strong lines.",
        alt=f"Frequencies of {len(lines.hertz)} motions in {frame} over the speed.",
        x=charts.speed_axis(low, high),
        y=charts.Axis(label=f"frequency in {frame}", unit="Hz", low=0.0, high=top, digits=".6g"),
        parts=parts,
        height_px=520,
    )


def _whirls(lines: FrequencyLines) -> StringArray:
    """How circles of a line turn; of branches without lateral motion their kind, (b, k, s)."""
    whirl = np.full(lines.share.shape, "lateral", dtype="<U9")
    if lines.forward is not None:
        part = np.divide(lines.forward, lines.share, out=np.full_like(lines.share, 0.5),
                         where=lines.share > 0)  # fmt: skip
        whirl = np.where(part > 0.5, "forward", "backward").astype("<U9")
        whirl[np.abs(part - 0.5) <= 0.01] = "straight"
    kind = np.broadcast_to(lines.kind[:, None], whirl.shape)
    return np.where(np.isin(kind, ("lateral", "coupled")), whirl, kind)


def _curves(
    lines: FrequencyLines, shown: BoolArray, whirl: str, least: float, width: float
) -> list[charts.Part]:
    """One curve through all pieces of lines of a kind, with gaps between them."""
    x, y, texts = [], [], []
    for branch in range(lines.hertz.shape[0]):
        for k, multiple in enumerate(lines.multiples):
            own = shown[branch, k]
            if not own.any():
                continue
            # a piece goes on to the next point of its line
            reached = own | np.append(False, own[:-1])
            x += [*lines.rpm, np.nan]
            y += [*np.where(reached, lines.hertz[branch, k], np.nan), np.nan]
            shares = lines.share[branch, k]
            sign = f"{multiple:+d} × speed" if multiple else "own frequency"
            texts += [*(f"motion {branch + 1}, {sign}, {s:.0%}" for s in shares), ""]
    if not x:
        return []
    name = f"{charts.whirl_name(whirl)}, over {least:.0%}"
    look = replace(charts.whirl_look(whirl), mark="", width=width)
    return [charts.Curve(x=np.array(x), y=np.array(y), name=name, look=look, texts=texts)]


def multiples_chart(rpm: FloatArray, size_m: Mapping[str, FloatArray], place: str) -> charts.Chart:
    """Return the size of motion of a place over the speed, by multiples of the speed.

    `size_m`: major semi-axis by name of the multiple, (s,) each.
    """
    largest = max((float(np.nanmax(v, initial=0.0)) for v in size_m.values()), default=0.0) or 1.0
    least = min(
        (float(np.nanmin(v[v > 0.0], initial=largest)) for v in size_m.values()), default=largest
    )
    unit, factor = charts.metric(largest, "m")[0], charts.metric(largest, "m")[1]
    parts: list[charts.Part] = [
        charts.Curve(
            x=rpm,
            y=factor * np.where(v > 0.0, v, np.nan),
            name=name,
            look=replace(charts.series_look(k), mark=""),
        )
        for k, (name, v) in enumerate(size_m.items())
    ]
    return charts.Chart(
        name=f"multiples-{place.replace('.', '-')}",
        title=f"Motion of {place}",
        caption="Major semi-axis of the orbit in fixed axes at whole multiples of the speed; 0 is "
        "the constant deflection.",
        alt=f"Motion of {place} over the speed by multiples of the speed.",
        x=charts.speed_axis(float(rpm.min()), float(rpm.max())),
        y=charts.size_axis("semi-axis of the orbit", unit, factor * least, factor * largest),
        parts=parts,
    )
