"""Shapes of the lowest modes, and which bodies and joints take part in them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
)

from solidwhirl.analyses.base import (
    MOST_SPEEDS,
    Analysis,
    Engine,
    decrements,
    number_text,
)
from solidwhirl.core.fields import (
    MOST,
    Count,
    Name,
    NotNegative,
)
from solidwhirl.core.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, Campbell, modes_at_speed
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modes.mode_shapes import BodyShape, mode_shapes
from solidwhirl.rotordyn.modes.participation import participation
from solidwhirl.rotordyn.plots.modes import (
    draw_body_modes,
    draw_mode_shapes,
)
from solidwhirl.rotordyn.plots.participation import draw_participation

# Modes that have room in one picture.
_MOST_MODES = 12


class ModeShapesSpec(Analysis):
    """Shapes of the lowest modes and which bodies and joints take part in them."""

    kind: Literal["mode_shapes"]
    speeds_rpm: Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=MOST_SPEEDS)]
    modes: Annotated[Count, Field(le=60)] = 8
    bodies: Annotated[tuple[Name, ...], Field(max_length=MOST)] = ()

    def run(self, engine: Engine) -> Outcome:
        """Shapes of the lowest modes at some speeds, numbered as in the diagram."""
        documents = []
        files: dict[str, Write] = {}
        for rpm in self.speeds_rpm:
            modes = modes_at_speed(engine.system, rpm * RAD_S_PER_RPM, self.modes)
            numbers = branch_numbers(engine.system, engine.diagram, modes).tolist()
            shapes, shares = (
                mode_shapes(engine.system, modes, numbers),
                participation(engine.system, modes),
            )
            files |= _mode_files(
                self, engine.system, engine.diagram, rpm, f"{engine.title}, {number_text(rpm)} rpm"
            )
            documents.append(
                {
                    "speed_rpm": rpm,
                    "branch": [k or None for k in numbers],
                    "frequency_hz": modes.frequency_hz.tolist(),
                    "log_decrement": decrements(modes.log_decrement),
                    "whirl": shapes.whirl.tolist(),
                    "bodies": {b.body: _shape_document(b) for b in shapes.bodies},
                    "kinetic_energy": dict(
                        zip(shares.bodies, shares.kinetic_bodies.tolist(), strict=True)
                    ),
                    "strain_energy_of_bodies": dict(
                        zip(shares.bodies, shares.strain_bodies.tolist(), strict=True)
                    ),
                    "strain_energy_of_joints": dict(
                        zip(shares.joints, shares.strain_joints.tolist(), strict=True)
                    ),
                }
            )
        lowest = ", ".join(f"{f:.2f}" for f in documents[0]["frequency_hz"])
        return Outcome(
            kind=self.kind,
            document={"speeds": documents},
            files=files,
            headline=f"{self.speeds_rpm[0]:.0f} rpm: {lowest} Hz",
        )


def _mode_files(
    spec: ModeShapesSpec, system: AssembledSystem, diagram: Campbell, rpm: float, title: str
) -> dict[str, Write]:
    """Pictures of the modes that have room in them, the lowest ones."""
    modes = modes_at_speed(system, rpm * RAD_S_PER_RPM, min(spec.modes, _MOST_MODES))
    if modes.frequency_hz.size == 0:
        return {}
    numbers = branch_numbers(system, diagram, modes).tolist()
    shapes, shares = mode_shapes(system, modes, numbers), participation(system, modes)
    if spec.modes > _MOST_MODES:
        title += f", the lowest {modes.frequency_hz.size} modes"
    at = f"{spec.label}_{number_text(rpm)}rpm"
    draw_shares = partial(draw_participation, numbers=numbers)
    files: dict[str, Write] = {
        f"{at}.png": _later(draw_mode_shapes, shapes, title),
        f"{at}_participation.png": _later(draw_shares, shares, title),
    }
    for body in spec.bodies:
        files[f"{at}_{body}.png"] = _later(draw_body_modes, shapes, body, title)
    return files


def _later(draw: Callable[..., None], *arguments: Any) -> Write:
    """Draw with (arguments without the title, path, title)."""
    *first, title = arguments

    def write(path: Path) -> None:
        draw(*first, path, title)

    return write


def _shape_document(shape: BodyShape) -> dict[str, Any]:
    return {
        "interfaces": list(shape.interfaces),
        "interface_axial_m": shape.interface_axial_m.tolist(),
        "interface_deflection": shape.interface_deflection.tolist(),
    }
