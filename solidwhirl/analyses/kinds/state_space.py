"""State-space matrices between forces and motions of interfaces."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Literal

import numpy as np
from pydantic import (
    Field,
    model_validator,
)

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
    Places,
    refuse_falling,
)
from solidwhirl.analyses.unbalances import (
    end_of,
)
from solidwhirl.core.fields import (
    Count,
    NotNegative,
    Positive,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem, End, Invariant
from solidwhirl.rotordyn.checks.plain_responses import Channel, check_transfer
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.response.resonance_samples import with_knots
from solidwhirl.rotordyn.state_space.channels import ForceInput, MotionOutput, Output
from solidwhirl.rotordyn.state_space.file import export_mat, export_npz, write_state_space
from solidwhirl.rotordyn.state_space.model import StateSpace, state_space, tabulated_state_space


class StateSpaceSpec(Analysis):
    """State-space matrices between forces and motions of interfaces."""

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
