"""State-space models of a page: what they hold, and their frequency responses."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from solidwhirl.core.outcome import Outcome
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Chart, Run, Section, Table
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.state_space.file import read_state_space
from solidwhirl.rotordyn.state_space.model import StateSpace

# Larger models take too long for a page; those above the second limit show one speed.
_MOST_STATES, _FEW_STATES = 400, 150
_FREQUENCIES, _INPUTS, _OUTPUTS = 400, 6, 8


def section(run: Run) -> Section | None:
    """Return the state-space models; None where the scene has none."""
    blocks: list[Any] = []
    top = float(np.nanmax(run.results.campbell.frequency_hz, initial=1.0))
    for name, outcome in run.results.analyses.items():
        if outcome.kind == "state_space":
            blocks.append(model_table(name, run.document["analyses"][name]))
            model = stored_model(name, outcome)
            if model is not None and model.state_count <= _MOST_STATES:
                chart = response_chart(name, model, 1.2 * top)
                blocks += [] if chart is None else [chart]
    if not blocks:
        return None
    return Section(
        name="state-space",
        title="State-space models",
        blocks=blocks,
        note="Matrices A, B, C, D for control and simulation programs, as files of the run.",
    )


def stored_model(name: str, outcome: Outcome) -> StateSpace | None:
    """Return the model that an analysis wrote, or None where it wrote none.

    Parameters
    ----------
    name
        Of the analysis.
    outcome
        Its results.
    """
    file = f"{name}.h5"
    if file not in outcome.files:
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        outcome.files[file](path)
        return read_state_space(path)


def model_table(name: str, entry: Mapping[str, Any]) -> Table:
    """Return what a model holds.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    speeds = entry["speed_rpm"]
    exact = entry["form"] == "polynomial"
    return Table(
        title=f"Model ({name})",
        head=["what", "value"],
        rows=[
            ["states", entry["states"]],
            ["inputs", ", ".join(entry["inputs"])],
            ["outputs", ", ".join(entry["outputs"])],
            ["speeds", f"{speeds[0]:g} to {speeds[-1]:g} rpm"],
            ["form", "exact at every speed" if exact else f"table of {len(speeds)} speeds"],
            ["files", ", ".join(f"`{file}`" for file in entry["files"])],
        ],
    )


def responses(
    model: StateSpace, speed_rad_s: float, hertz: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Return C (iω − A)⁻¹ B + D by the Schur form of A, which free motions leave well conditioned.

    Parameters
    ----------
    model
        The model.
    speed_rad_s
        Ω.
    hertz
        Frequencies, shape (f,).

    Returns
    -------
    ndarray
        Shape (f, p, m).
    """
    a, b, c, d = model.at_speed(speed_rad_s)
    upper, turn = la.schur(a, output="complex")
    left, right, eye = c @ turn, turn.conj().T @ b, np.eye(len(a))
    solved = [la.lapack.ztrtrs(rate * eye - upper, right)[0] for rate in 2j * np.pi * hertz]
    return np.asarray(left @ np.array(solved) + d)


def response_chart(name: str, model: StateSpace, top_hz: float) -> Chart | None:
    """Return the displacement per force over the frequency; None without displacements.

    Parameters
    ----------
    name
        Of the analysis.
    model
        The model.
    top_hz
        Highest frequency.
    """
    outputs = [k for k, n in enumerate(model.output_names) if n.startswith("displacement ")]
    outputs = [k for k in outputs if model.output_names[k].endswith((".ux", ".uy"))][:_OUTPUTS]
    inputs = [k for k, n in enumerate(model.input_names) if n.endswith((".ux", ".uy"))][:_INPUTS]
    if not outputs or not inputs:
        return None
    hertz = np.linspace(top_hz / _FREQUENCIES, top_hz, _FREQUENCIES)
    speeds = [float(model.speeds_rad_s[-1])]
    if model.state_count <= _FEW_STATES:
        speeds.insert(0, float(model.speeds_rad_s[0]))
    found = {speed: np.abs(responses(model, speed, hertz)) for speed in speeds}
    options = []
    for i in inputs:
        for speed in speeds:
            sizes = found[speed][:, :, i]
            curves = [
                charts.Curve(
                    x=hertz,
                    y=np.where(sizes[:, o] > 0.0, sizes[:, o], np.nan),
                    name=model.output_names[o].removeprefix("displacement "),
                    look=replace(charts.series_look(k), mark=""),
                )
                for k, o in enumerate(outputs)
            ]
            label = f"{model.input_names[i]} at {speed * RPM_PER_RAD_S:.0f} rpm"
            options.append(charts.Option(label=label, marks=curves))
    every = np.concatenate([f[:, outputs][:, :, inputs].ravel() for f in found.values()])
    if not float(every.max()) > 0.0:
        return None
    low, high = float(every[every > 0.0].min()), float(every.max())
    chart = charts.Chart(
        name="states",
        title="Frequency responses",
        caption="Displacement per force of the model at its outputs, for a chosen input and speed.",
        alt="Displacement per force over the frequency.",
        x=charts.Axis(label="frequency", unit="Hz", low=0.0, high=top_hz),
        y=charts.size_axis("displacement per force", "m/N", low, high),
        parts=[charts.Choice(label="input", options=options)],
    )
    return page_chart(chart, name)
