"""State-space matrices between forces and motions of interfaces."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import scipy.linalg as la
from pydantic import Field, model_validator

from solidwhirl.analyses.base import Analysis, Engine, Found, Places, refuse_falling
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table
from solidwhirl.core.fields import Count, NotNegative, Positive
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.rotordyn import AssembledSystem, End, Invariant
from solidwhirl.rotordyn.checks.plain_responses import Channel, check_transfer
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.resonance_samples import with_knots
from solidwhirl.rotordyn.state_space.channels import ForceInput, MotionOutput, Output
from solidwhirl.rotordyn.state_space.file import (
    export_mat,
    export_npz,
    read_state_space,
    write_state_space,
)
from solidwhirl.rotordyn.state_space.model import StateSpace, state_space, tabulated_state_space

# Larger models take too long for a page; those above the second limit show one speed.
_MOST_STATES, _FEW_STATES = 400, 150
_FREQUENCIES, _INPUTS, _OUTPUTS = 400, 6, 8


class StateSpaceSpec(Analysis):
    """State-space matrices between forces and motions of interfaces."""

    section = PageSection(
        "state-space",
        "State-space models",
        "Matrices A, B, C, D for control and simulation programs, as files of the run.",
        120,
    )
    suffixes = (".h5", ".npz", ".mat")

    kind: Literal["state_space"]
    inputs: Places
    outputs: Places
    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    speed_count: Annotated[Count, Field(ge=2, le=501)] = 11

    @model_validator(mode="after")
    def _range(self) -> StateSpaceSpec:
        refuse_falling(self.from_rpm, self.to_rpm)
        return self

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        values = self.speed_count * (2.0 * size.coordinates) ** 2
        return Work(eigenproblems=2.0 * self.speed_count, results=300.0, values=values)

    def run(self, engine: Engine) -> Outcome:
        """A, B, C, D between forces and motions at interfaces over the speed."""
        inputs = [
            ForceInput(body=b, interface=i, component=c)
            for b, i, c in _all(self.inputs, engine.system)
        ]
        outputs: list[Output] = [
            MotionOutput(body=b, interface=i, component=c, quantity=quantity)
            for b, i, c in _all(self.outputs, engine.system)
            for quantity in ("displacement", "velocity", "acceleration")
        ]
        speeds = np.linspace(self.from_rpm, self.to_rpm, max(2, self.speed_count)) * RAD_S_PER_RPM
        if engine.system.has_constant_bearings:
            model = state_space(
                engine.system, inputs, outputs, (float(speeds[0]), float(speeds[-1]))
            )
        else:
            speeds = with_knots(speeds, engine.system.knots_rad_s)
            model = tabulated_state_space(engine.system, inputs, outputs, speeds)
        return Outcome(
            kind=self.kind,
            document={
                "form": model.form,
                "states": model.state_count,
                "inputs": list(model.input_names),
                "outputs": list(model.output_names),
                "speed_rpm": (model.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "files": [f"{self.label}{suffix}" for suffix in (".h5", ".npz", ".mat")],
                "checks": [asdict(_transfer_check(self, engine.system, model))],
            },
            files={
                f"{self.label}.h5": lambda path: write_state_space(model, path),
                f"{self.label}.npz": lambda path: export_npz(model, path),
                f"{self.label}.mat": lambda path: export_mat(model, path),
            },
            headline=f"{model.state_count} states, {len(model.input_names)} inputs, "
            f"{len(model.output_names)} outputs",
        )

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """What the model holds, and its frequency responses where it is small enough."""
        top = 1.2 * float(np.nanmax(found.engine.diagram.frequency_hz, initial=1.0))
        model = stored_model(found.name, found.outcome)
        chart = response_chart(model, top) if model.state_count <= _MOST_STATES else None
        return [_model_table(found.document), *([] if chart is None else [chart])]


def stored_model(name: str, outcome: Outcome) -> StateSpace:
    """Return the model that an analysis of a name wrote."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.h5"
        outcome.files[path.name](path)
        return read_state_space(path)


def _model_table(document: Mapping[str, Any]) -> Table:
    speeds = document["speed_rpm"]
    exact = document["form"] == "polynomial"
    return Table(
        title="Model",
        head=["what", "value"],
        rows=[
            ["states", document["states"]],
            ["inputs", ", ".join(document["inputs"])],
            ["outputs", ", ".join(document["outputs"])],
            ["speeds", f"{speeds[0]:g} to {speeds[-1]:g} rpm"],
            ["form", "exact at every speed" if exact else f"table of {len(speeds)} speeds"],
            ["files", ", ".join(f"`{file}`" for file in document["files"])],
        ],
    )


def responses(model: StateSpace, speed_rad_s: float, hertz: FloatArray) -> ComplexArray:
    """Return C (iω − A)⁻¹ B + D at frequencies (f,), shape (f, p, m).

    By the Schur form of A, which free motions leave well conditioned.
    """
    a, b, c, d = model.at_speed(speed_rad_s)
    upper, turn = la.schur(a, output="complex")
    left, right, eye = c @ turn, turn.conj().T @ b, np.eye(len(a))
    solved = [la.lapack.ztrtrs(rate * eye - upper, right)[0] for rate in 2j * np.pi * hertz]
    return np.asarray(left @ np.array(solved) + d)


def response_chart(model: StateSpace, top_hz: float) -> charts.Chart | None:
    """Return the displacement per force up to a frequency; None without displacements."""
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
    return charts.Chart(
        name="states",
        title="Frequency responses",
        caption="Displacement per force of the model at its outputs, for a chosen input and speed.",
        alt="Displacement per force over the frequency.",
        x=charts.Axis(label="frequency", unit="Hz", low=0.0, high=top_hz),
        y=charts.size_axis("displacement per force", "m/N", low, high),
        parts=[charts.Choice(label="input", options=options)],
    )


def _transfer_check(spec: StateSpaceSpec, system: AssembledSystem, model: StateSpace) -> Invariant:
    """Compare the model with transfer functions of the system straight from its parts."""
    inputs = [Channel(End(body=b, interface=i), c) for b, i, c in _all(spec.inputs, system)]
    outputs = [
        Channel(End(body=b, interface=i), c, order)
        for b, i, c in _all(spec.outputs, system)
        for order in range(3)
    ]
    ends = (0, len(model.speeds_rad_s) // 2, -1)
    speeds = sorted({float(model.speeds_rad_s[at]) for at in ends})
    plain = PlainSystem.of(system)
    return check_transfer(plain, model.at_speed, inputs, outputs, speeds, spec.label)


def _all(places: tuple[str, ...], system: AssembledSystem) -> list[tuple[str, str, str]]:
    """Every motion that interfaces carry."""
    out: list[tuple[str, str, str]] = []
    for place in places:
        end = end_of(place)
        element = system.system.rotors[end.body].element
        out += [(end.body, end.interface, c) for c in element.components_at(end.interface)]
    return out
