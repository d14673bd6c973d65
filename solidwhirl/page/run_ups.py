"""Run-ups of a page: force through the mount, its spectra, the motion of places, complexity."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.outcome import Outcome
from solidwhirl.page.complexity import complexity_chart, complexity_table
from solidwhirl.page.maps import heat
from solidwhirl.page.records import Chart, Run, Section, Table, Text, Toggle
from solidwhirl.page.run_up_peaks import response_peaks
from solidwhirl.page.traces import (
    SPEED_AXIS,
    FloatArray,
    Trace,
    axis,
    line,
    log_axis,
    marks,
    metric,
    numbers,
    series_style,
    slug,
)
from solidwhirl.rotordyn.force_spectrum import amplitude_spectrum, spectrogram

_RPM = 30.0 / np.pi
# Columns of an envelope, and lines of a spectrum that is drawn.
_COLUMNS, _LINES = 900, 3000
# Length of the pieces of a spectrogram, s, and how many pieces and lines of it are drawn.
_PIECE_S = 0.25
_PIECES, _ROWS = 240, 260
_FEWEST = 8


def section(run: Run) -> Section | None:
    """Return the run-ups; None where the scene has none."""
    blocks: list[Any] = []
    ratios = run.results.scene.speed_ratios()
    for name, outcome in run.results.analyses.items():
        if outcome.kind == "run_up":
            entry = run.document["analyses"][name]
            blocks += run_up_blocks(name, entry, recorded(name, outcome), ratios)
    if not blocks:
        return None
    return Section(
        name="run-up",
        title="Run-up",
        blocks=blocks,
        note="Motion in time while the speed rises from rest and then holds.",
    )


def recorded(name: str, outcome: Outcome) -> dict[str, Any] | None:
    """Return the record in time of a run-up, or None where it wrote none.

    Parameters
    ----------
    name
        Of the analysis.
    outcome
        Its results; the record is one of its files.
    """
    file = f"{name}.npz"
    if file not in outcome.files:
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        outcome.files[file](path)
        with np.load(path, allow_pickle=False) as found:
            return {key: found[key] for key in found.files}


def run_up_blocks(
    name: str,
    entry: Mapping[str, Any],
    record: Mapping[str, Any] | None,
    ratios: Mapping[str, float],
) -> list[Any]:
    """Return everything about one run-up.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    record
        From `recorded`.
    ratios
        Speed ratio of every body.
    """
    blocks: list[Any] = [_facts(name, entry)]
    if record is not None and record["time_s"].size > _FEWEST:
        blocks.append(force_chart(name, entry, record))
        if len(record["translation_m"]):
            blocks.append(motion_chart(name, record))
        if np.abs(record["mount_force_n"][0]).max() > 0.0:
            blocks.append(spectrum_chart(name, entry, record))
            pieces = spectrogram_chart(name, entry, record, ratios)
            blocks += [] if pieces is None else [pieces]
    if "normalised_response" in entry:
        blocks.append(response_peaks(name, entry["normalised_response"]))
    if "complexity" in entry:
        blocks += [
            complexity_chart(name, entry["complexity"]),
            complexity_table(entry["complexity"]),
        ]
    blocks += [Text(text=note, kind="note") for note in entry["notes"]]
    return blocks


def _facts(name: str, entry: Mapping[str, Any]) -> Table:
    energy = entry["energy"]
    return Table(
        title=f"In short ({name})",
        head=["quantity", "value"],
        rows=[
            [
                "speed",
                f"0 to {entry['to_rpm']:g} rpm in {entry['ramp_s']:g} s, "
                f"then held for {entry['hold_s']:g} s",
            ],
            [
                f"largest lateral force through {entry['mount']}",
                f"{entry['largest_mount_force_n']:.5g} N",
            ],
            ["fastest excitation", f"{entry['fastest_excitation_hz']:.5g} Hz"],
            ["steps", f"{entry['steps']} of {entry['step_s']:.4g} s"],
            [
                "energy: work of the loads, of the drives, dissipated",
                f"{energy['load_work_j']:.4g} J, {energy['drive_work_j']:.4g} J, "
                f"{energy['dissipated_j']:.4g} J",
            ],
            [
                "largest error of the energy balance",
                f"{energy['largest_error_j']:.2g} J of {energy['largest_j']:.4g} J",
            ],
            ["time of computation", f"{entry['wall_time_s']:.3g} s"],
        ],
    )


def envelope(
    time_s: FloatArray, values: FloatArray, columns: int = _COLUMNS
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times, lowest and highest values of pieces of a signal that reach each other.

    Parameters
    ----------
    time_s, values
        Shape (t,).
    columns
        Number of pieces at most.

    Returns
    -------
    times, low, high : ndarray
        The middle of each piece, and the least and the largest value from its first point to the
        first of the next piece.
    """
    edges = np.unique(
        np.linspace(0, time_s.size - 1, min(columns, time_s.size - 1) + 1).astype(int)
    )
    low = np.minimum(np.minimum.reduceat(values, edges[:-1]), values[edges[1:]])
    high = np.maximum(np.maximum.reduceat(values, edges[:-1]), values[edges[1:]])
    return 0.5 * (time_s[edges[:-1]] + time_s[edges[1:]]), low, high


def envelope_trace(
    time_s: FloatArray, values: FloatArray, name: str, number: int, unit: str
) -> Trace:
    """Return the envelope of a signal as a filled outline; arguments as `envelope`."""
    times, low, high = envelope(time_s, values)
    style = series_style(number)
    return {
        "type": "scatter",
        "mode": "lines",
        "x": np.concatenate([times, times[::-1], times[:1]]),
        "y": np.concatenate([high, low[::-1], high[:1]]),
        "fill": "toself",
        "fillcolor": f"{style.color}/0.55",
        "line": {"color": style.color, "width": 0.7},
        "name": name,
        "hoveron": "points",
        "hovertemplate": f"<b>{name}</b><br>%{{x:.4g}} s<br>%{{y:.4g}} {unit}<extra></extra>",
    }


def _speed_trace(record: Mapping[str, Any]) -> Trace:
    times, _, rpm = envelope(record["time_s"], record["speed_rad_s"] * _RPM, 200)
    style = series_style(6)._replace(dash="dash")
    return line(
        times,
        rpm,
        "speed (right axis)",
        style,
        yaxis="y2",
        hovertemplate="%{x:.4g} s<br>%{y:,.0f} rpm<extra></extra>",
    )


def _in_time(unit_text: str, record: Mapping[str, Any]) -> dict[str, Any]:
    top_s = float(record["time_s"][-1])
    top_rpm = 1.05 * _RPM * float(record["speed_rad_s"].max())
    return {
        "xaxis": axis("time [s]", range=[0.0, top_s]),
        "yaxis": axis(unit_text),
        "yaxis2": axis(
            SPEED_AXIS,
            overlaying="y",
            side="right",
            showgrid=False,
            range=[0.0, max(top_rpm, 1.0)],
            tickmode="auto",
        ),
        "margin": {"r": 64},
    }


def force_chart(name: str, entry: Mapping[str, Any], record: Mapping[str, Any]) -> Chart:
    """Return the force through the mount over the time; arguments as `run_up_blocks`."""
    force = record["mount_force_n"]
    unit, factor = metric(float(np.abs(force[:2]).max()), "N")
    traces = [
        envelope_trace(record["time_s"], factor * force[k], f"force along {axis_name}", k, unit)
        for k, axis_name in enumerate("xy")
    ]
    traces.append(_speed_trace(record))
    return Chart(
        name=f"mount-{slug(name)}",
        title=f"Force through {entry['mount']} ({name})",
        caption="Envelope of the force in time: every column reaches from the least to the largest "
        "value in it. It swells where the speed passes a resonance. Broken line: speed.",
        alt=f"Force through the mount over the time, up to {entry['largest_mount_force_n']:.4g} N.",
        traces=traces,
        layout=_in_time(f"force [{unit}]", record),
        height_px=400,
        controls=[
            Toggle(label="along x", traces=[0]),
            Toggle(label="along y", traces=[1], shown=False),
            Toggle(label="speed", traces=[2]),
        ],
    )


def motion_chart(name: str, record: Mapping[str, Any]) -> Chart:
    """Return the motion of the observed places over the time; arguments as `run_up_blocks`."""
    moved = record["translation_m"][:, :2]
    unit, factor = metric(float(np.abs(moved).max(initial=0.0)), "m")
    places = [str(place) for place in record["outputs"]]
    traces = [
        envelope_trace(record["time_s"], factor * moved[k, 0], f"{place}, along x", k, unit)
        for k, place in enumerate(places)
    ]
    traces.append(_speed_trace(record))
    return Chart(
        name=f"motion-{slug(name)}",
        title=f"Displacement during the run-up ({name})",
        caption="Envelope of the displacement along x of the observed places. Broken line: speed.",
        alt=f"Displacement of {', '.join(places)} over the time.",
        traces=traces,
        layout=_in_time(f"displacement along x [{unit}]", record),
        height_px=380,
    )


def spectrum_chart(name: str, entry: Mapping[str, Any], record: Mapping[str, Any]) -> Chart:
    """Return the spectrum of the force over the whole record; arguments as `run_up_blocks`."""
    found = amplitude_spectrum(record["time_s"], record["mount_force_n"][0])
    top = min(2.0 * entry["fastest_excitation_hz"], float(found.frequency_hz[-1]))
    inside = (found.frequency_hz > 0.0) & (found.frequency_hz <= max(top, found.frequency_hz[1]))
    hertz, height = found.frequency_hz[inside], found.amplitude[inside]
    unit, factor = metric(float(height.max()), "N")
    hertz, height = _thinned(hertz, factor * height)
    low = max(1e-7 * float(height.max()), 0.5 * float(height.min()))
    traces = [
        line(
            hertz,
            np.maximum(height, low),
            "force along x",
            series_style(0),
            hovertemplate=f"%{{x:.5g}} Hz<br>%{{y:.4g}} {unit}<extra></extra>",
        )
    ]
    traces[0]["line"]["width"] = 1.2
    peaks = [p for p in entry["force_spectrum_peaks"] if p["frequency_hz"] <= top]
    if peaks:
        ring = series_style(1)._replace(symbol="circle-open")
        traces.append(
            marks(
                [p["frequency_hz"] for p in peaks],
                factor * numbers([p["amplitude_n"] for p in peaks]),
                "peaks",
                ring,
                10,
                hovertemplate=f"<b>peak %{{x:.5g}} Hz</b><br>%{{y:.4g}} {unit}<extra></extra>",
            )
        )
    return Chart(
        name=f"spectrum-{slug(name)}",
        title=f"Spectrum of the force ({name})",
        caption="Amplitudes of the force along x over the whole record (Hann window). While the "
        "speed changes a line is smeared over the frequencies that it passes.",
        alt="Spectrum of the mount force; peaks at "
        + ", ".join(f"{p['frequency_hz']:.4g}" for p in peaks)
        + " Hz.",
        traces=traces,
        layout={
            "xaxis": axis("frequency [Hz]", range=[0.0, top]),
            "yaxis": log_axis(f"amplitude [{unit}]", low, 2.0 * float(height.max())),
        },
        height_px=380,
    )


def _thinned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most some points, of every piece the highest."""
    if x.size <= _LINES:
        return x, y
    edges = np.unique(np.linspace(0, x.size, _LINES + 1).astype(int))
    kept = np.array([a + int(y[a:b].argmax()) for a, b in pairwise(edges)])
    return x[kept], y[kept]


def spectrogram_chart(
    name: str, entry: Mapping[str, Any], record: Mapping[str, Any], ratios: Mapping[str, float]
) -> Chart | None:
    """Return short-time spectra with the lines of the shafts; None of a record that is too short.

    Arguments as `run_up_blocks`.
    """
    time_s = record["time_s"]
    step = float(time_s[1] - time_s[0])
    if time_s[-1] <= 4.0 * _PIECE_S or _PIECE_S / step < _FEWEST:
        return None
    found = spectrogram(time_s, record["mount_force_n"][0], _PIECE_S, overlap=0.9)
    top = min(2.0 * entry["fastest_excitation_hz"], float(found.frequency_hz[-1]))
    rows = np.flatnonzero(found.frequency_hz <= top)
    rows = rows[:: max(1, -(-rows.size // _ROWS))]
    columns = np.arange(0, found.time_s.size, max(1, -(-found.time_s.size // _PIECES)))
    part = found.amplitude[np.ix_(rows, columns)]
    unit, factor = metric(float(part.max()), "N")
    traces = [
        heat(
            found.time_s[columns],
            found.frequency_hz[rows],
            factor * part,
            f"amplitude [{unit}]",
            f"%{{x:.3g}} s, %{{y:.4g}} Hz<br><b>%{{customdata:.4g}} {unit}</b>",
        )
    ]
    named: dict[float, list[str]] = {}
    for body, ratio in ratios.items():
        if ratio != 0.0:
            named.setdefault(abs(ratio), []).append(body)
    times, _, speed = envelope(time_s, np.abs(record["speed_rad_s"]) / (2.0 * np.pi), 200)
    white = series_style(0)._replace(color="#ffffff", dash="dash")
    for ratio, bodies in named.items():
        text = f"once per turn of {', '.join(bodies)}"
        traces.append(
            line(
                times,
                np.where(ratio * speed <= top, ratio * speed, np.nan),
                text,
                white,
                hovertemplate=f"{text}<br>%{{y:.4g}} Hz<extra></extra>",
            )
        )
        traces[-1]["line"]["width"] = 1.2
    return Chart(
        name=f"spectrogram-{slug(name)}",
        title=f"Spectrogram of the force ({name})",
        caption="Short-time spectra of the force along x. White broken lines: once per turn of "
        "each shaft. Bright bars that stay at one frequency are the engine's own.",
        alt="Spectrogram of the mount force over time and frequency.",
        traces=traces,
        layout={
            "xaxis": axis("time [s]", range=[float(found.time_s[0]), float(found.time_s[-1])]),
            "yaxis": axis("frequency [Hz]", range=[0.0, top]),
            "showlegend": False,
        },
        height_px=440,
        controls=[Toggle(label="lines of the shafts", traces=list(range(1, len(traces))))],
    )
