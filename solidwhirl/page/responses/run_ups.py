"""Run-ups of a page: force through the mount, its spectra, the motion of places, complexity."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.core.outcome import Outcome
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table, Text
from solidwhirl.page.frame.traces import numbers
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Look, series_look
from solidwhirl.rotordyn.plots.run_up import (
    force_chart,
    motion_chart,
    spectrogram_chart,
    spectrum_chart,
)
from solidwhirl.rotordyn.run_up.force_spectrum import (
    Spectrogram,
    amplitude_spectrum,
    spectrogram,
)

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
        charts = run_up_charts(entry, record, ratios)
        blocks += [page_chart(chart, name) for chart in charts]
    if "normalised_response" in entry:
        blocks.append(response_peaks(name, entry["normalised_response"]))
    if "complexity" in entry:
        blocks += [
            page_chart(complexity_chart(entry["complexity"]), name),
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


def run_up_charts(
    entry: Mapping[str, Any], record: Mapping[str, Any], ratios: Mapping[str, float]
) -> list[Chart]:
    """Return force, motion, spectrum and spectrogram; arguments as `run_up_blocks`."""
    time_s, speed, force = (record[key] for key in ("time_s", "speed_rad_s", "mount_force_n"))
    charts = [force_chart(time_s, force, entry["mount"], speed)]
    if len(record["translation_m"]):
        places = [str(place) for place in record["outputs"]]
        charts.append(motion_chart(time_s, record["translation_m"][:, 0], places, speed))
    if not np.abs(force[0]).max() > 0.0:
        return charts
    found = amplitude_spectrum(time_s, force[0])
    wanted = 2.0 * entry["fastest_excitation_hz"]
    top = min(wanted, float(found.frequency_hz[-1]))
    inside = (found.frequency_hz > 0.0) & (found.frequency_hz <= max(top, found.frequency_hz[1]))
    peaks = [(p["frequency_hz"], p["amplitude_n"]) for p in entry["force_spectrum_peaks"]]
    shown = [peak for peak in peaks if peak[0] <= top]
    charts.append(spectrum_chart(found.frequency_hz[inside], found.amplitude[inside], shown))
    step = float(time_s[1] - time_s[0])
    if time_s[-1] > 4.0 * _PIECE_S and _PIECE_S / step >= _FEWEST:
        pieces = _fewer(spectrogram(time_s, force[0], _PIECE_S, overlap=0.9), wanted)
        top = min(wanted, float(pieces.frequency_hz[-1]))
        charts.append(spectrogram_chart(pieces, time_s, speed, ratios, top))
    return charts


def _fewer(found: Spectrogram, top_hz: float) -> Spectrogram:
    """Some of the spectra and lines up to a frequency."""
    rows = np.flatnonzero(found.frequency_hz <= top_hz)
    rows = rows[:: max(1, -(-rows.size // _ROWS))]
    columns = np.arange(0, found.time_s.size, max(1, -(-found.time_s.size // _PIECES)))
    return replace(
        found,
        time_s=found.time_s[columns],
        frequency_hz=found.frequency_hz[rows],
        amplitude=found.amplitude[np.ix_(rows, columns)],
    )


def complexity_chart(entry: Mapping[str, Any]) -> Chart:
    """Return errors of simpler models by band of frequency.

    Parameters
    ----------
    entry
        `complexity` of a run-up in `results.json`.
    """
    bands = [f"{low:g} to {high:g} Hz" for low, high in entry["bands_hz"]]
    bars = [
        Bars(
            values=100.0 * numbers([model["peak_force_error"], *model["response_error_by_band"]]),
            name=model["name"],
            look=Look(series_look(k).color),
        )
        for k, model in enumerate(entry["models"][1:])
    ]
    return Chart(
        name="complexity",
        title="What simpler models miss",
        caption="Difference from the model with all modes: of the largest force, and of the "
        "normalised response by band of frequency." + beyond(entry) + _stopped(entry),
        alt="Bars of the errors of simpler models; the table has the numbers.",
        x=Axis(label="quantity", places=["largest force", *bands]),
        y=Axis(label="difference from all modes", unit="%", digits=".4g"),
        parts=bars,
        height_px=360,
    )


def beyond(found: Mapping[str, Any]) -> str:
    """Return a sentence on the bands that reach beyond what is excited; empty without any.

    Parameters
    ----------
    found
        As `entry` in `complexity_chart`.
    """
    top = found["excited_to_hz"]
    cut = [f"{low:g} to {high:g} Hz" for low, high in found["bands_hz"] if high > top]
    if not cut:
        return ""
    return (
        f" Nothing is excited above {top:.5g} Hz: the {'bands' if len(cut) > 1 else 'band'} "
        f"{', '.join(cut)} {'are' if len(cut) > 1 else 'is'} compared up to there only."
    )


def _stopped(found: Mapping[str, Any]) -> str:
    """A sentence on the models that diverged; empty without any."""
    said = ", ".join(
        f"{m['name']} at {m['speed_rpm']:.6g} rpm, {m['amplitude_m']:.3g} m"
        for m in found.get("diverged", ())
    )
    return f" Diverged, stopped and not compared: {said}." if said else ""


def complexity_table(found: Mapping[str, Any]) -> Table:
    """Return forces and errors of the models in numbers.

    Parameters
    ----------
    found
        As `entry` in `complexity_chart`.
    """
    return Table(
        head=[
            "model",
            "coordinates",
            "largest force [N]",
            "its difference [%]",
            *[f"{low:g} to {high:g} Hz [%]" for low, high in found["bands_hz"]],
            "time [s]",
        ],
        rows=[
            [
                m["name"],
                m["coordinates"],
                m["peak_force_n"],
                _hundredfold(m["peak_force_error"]),
                *[_hundredfold(e) for e in m["response_error_by_band"]],
                f"{m['wall_time_s']:.3g}",
            ]
            for m in found["models"]
        ],
    )


def _hundredfold(value: float | None) -> str | None:
    return None if value is None else f"{100.0 * value:.3g}"


def response_peaks(name: str, found: Mapping[str, Any]) -> Block:
    """Return the peaks of the force per excitation force, within what is excited.

    Parameters
    ----------
    name
        Of the analysis.
    found
        `normalised_response` of its part of `results.json`.
    """
    low, high = found["excited_hz"]
    within = f"from {low:.4g} to {high:.5g} Hz, the frequencies that the unbalance passes through"
    if not found["peaks"]:
        return Text(text=f"Normalised response ({name}): no peak {within}.")
    return Table(
        head=["frequency [Hz]", "force per excitation force [N/N]"],
        rows=[[f"{p['frequency_hz']:.5g}", p["force_per_force"]] for p in found["peaks"]],
        folded=f"Peaks of the normalised response ({name})",
        caption=f"Shown {within}: beyond them both spectra are side lobes, and their quotient says "
        "nothing.",
    )
