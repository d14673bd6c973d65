"""Recovered displacement and stress of a page: the largest values of every state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.page.frame.records import Chart, Run, Section, Table
from solidwhirl.page.frame.traces import Trace, analyses_of_kind, axis, numbers, series_style, slug

_MPA = 1e-6
_KINDS = (
    ("dynamic", "of the state", "/"),
    ("steady", "centrifugal", ""),
    ("total", "both together", "x"),
)


def section(run: Run) -> Section | None:
    """Return the recovered states; None where the scene has none."""
    found = analyses_of_kind(run.document, "recovery")
    if not found:
        return None
    blocks: list[Any] = []
    for name, entry in found.items():
        files = sorted(run.results.analyses[name].files)
        blocks += recovery_blocks(name, entry, [f for f in files if f.endswith((".vtu", ".pvd"))])
    return Section(
        name="recovery",
        title="Stress and displacement in the bodies",
        blocks=blocks,
        note="Fields in the solid bodies in modes, responses and instants of run-ups.",
    )


def recovery_blocks(name: str, entry: Mapping[str, Any], files: list[str]) -> list[Any]:
    """Return chart and tables of one recovery.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    files
        Names of its files for ParaView.
    """
    blocks: list[Any] = []
    if any(b.get("dynamic") for s in entry["states"] for b in s["bodies"].values()):
        blocks += [stress_chart(name, entry), _stress_table(name, entry)]
    blocks.append(_state_table(name, entry))
    if files:
        blocks.append(
            Table(
                head=["file"],
                rows=[[f"`{file}`"] for file in files],
                folded=f"Fields as files for ParaView ({len(files)})",
            )
        )
    return blocks


def stress_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return the largest von Mises stresses as bars; arguments as `recovery_blocks`."""
    labels = [f"{s['state']}<br>{body}" for s in entry["states"] for body in s["bodies"]]
    bodies = [body for s in entry["states"] for body in s["bodies"].values()]
    traces: list[Trace] = []
    for number, (kind, text, shape) in enumerate(_KINDS):
        found = [b.get(kind) for b in bodies]
        if not any(found):
            continue
        values = numbers([np.nan if f is None else f["largest_von_mises_pa"] for f in found])
        traces.append(
            {
                "type": "bar",
                "x": labels,
                "y": _MPA * values,
                "name": text,
                "text": ["" if f is None else _where(f) for f in found],
                "textposition": "none",
                "marker": {
                    "color": series_style((5, 7, 3)[number]).color,
                    "pattern": {"shape": shape, "fillmode": "overlay", "fgcolor": "@paper"},
                },
                "hovertemplate": f"<b>{text}</b>: %{{y:.5g}} MPa<br>%{{text}}<extra></extra>",
            }
        )
    return Chart(
        name=f"stress-{slug(name)}",
        title=f"Largest von Mises stress ({name})",
        caption="Over the body and the cycle: of the state alone, of the centrifugal load at its "
        "speed, and of both together. A mode without a given amplitude is scaled to 1 mm, so its "
        "stress is no stress of the engine and has no sum.",
        alt="Bars of the largest von Mises stress of each state; the table has the numbers.",
        traces=traces,
        layout={
            "xaxis": axis("state and body", type="category"),
            "yaxis": axis("von Mises stress [MPa]", rangemode="tozero"),
            "barmode": "group",
        },
        height_px=420,
    )


def _where(found: Mapping[str, Any]) -> str:
    x, y, z = (1e3 * v for v in found["at_m"])
    return f"at x {x:.1f}, y {y:.1f}, z {z:.1f} mm, {found['material']}"


def _stress_table(name: str, entry: Mapping[str, Any]) -> Table:
    rows = []
    for state in entry["states"]:
        for body, found in state["bodies"].items():
            for kind, text, _ in _KINDS:
                own = found.get(kind)
                if own is None:
                    continue
                rows.append(
                    [
                        state["state"],
                        body,
                        text,
                        _MPA * own["largest_von_mises_pa"],
                        _where(own),
                        _MPA * own["largest_principal_pa"],
                        _MPA * own["smallest_principal_pa"],
                    ]
                )
    return Table(
        head=[
            "state",
            "body",
            "load",
            "von Mises [MPa]",
            "where",
            "largest principal [MPa]",
            "smallest principal [MPa]",
        ],
        rows=rows,
        folded=f"Stresses in numbers ({name}, {len(rows)})",
    )


def _state_table(name: str, entry: Mapping[str, Any]) -> Table:
    rows = []
    for state in entry["states"]:
        for body, found in state["bodies"].items():
            hertz, instant = state.get("frequency_hz"), state.get("time_s")
            rows.append(
                [
                    state["state"],
                    state["source"].replace("_", "-"),
                    f"{state['speed_rpm']:.1f}",
                    None if hertz is None else f"{hertz:.5g}",
                    None if instant is None else f"{instant:.4g}",
                    body,
                    1e6 * found["largest_displacement_m"],
                    found["strain_energy_j"],
                    found["strain_energy_error"],
                ]
            )
    return Table(
        title=f"States ({name})",
        head=[
            "state",
            "from",
            "reference shaft [rpm]",
            "frequency [Hz]",
            "time [s]",
            "body",
            "largest displacement [µm]",
            "strain energy [J]",
            "error of the field's energy [1]",
        ],
        rows=rows,
        caption="The energy of the recovered field is compared with that of the reduced body.",
    )
