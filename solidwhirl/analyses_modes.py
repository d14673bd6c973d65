"""Modes of the engine of a scene: frames of the bodies, shapes, participation, state space."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.analyses_response import RPM, end_of
from solidwhirl.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, Campbell, modes_at_speed
from solidwhirl.rotordyn.body_frames import campbell_seen_by_body
from solidwhirl.rotordyn.branch_numbers import branch_numbers
from solidwhirl.rotordyn.frames import RotatingCampbell
from solidwhirl.rotordyn.mode_shapes import BodyShape, mode_shapes
from solidwhirl.rotordyn.participation import participation
from solidwhirl.rotordyn.pictures_modes import (
    draw_body_modes,
    draw_mode_shapes,
    draw_rotating_campbell,
)
from solidwhirl.rotordyn.pictures_participation import draw_participation
from solidwhirl.rotordyn.resonance_samples import with_knots
from solidwhirl.rotordyn.state_channels import ForceInput, Input, MotionOutput, Output
from solidwhirl.rotordyn.state_space import state_space, tabulated_state_space
from solidwhirl.rotordyn.state_space_file import export_mat, export_npz, write_state_space
from solidwhirl.scene_analyses import (
    ModeShapesSpec,
    RotatingCampbellSpec,
    StateSpaceSpec,
    speed_text,
)
from solidwhirl.stability_documents import decrements

# Modes that have room in one picture.
_MOST_MODES = 12


def run_rotating_campbell(
    spec: RotatingCampbellSpec, system: AssembledSystem, diagram: Campbell, title: str
) -> Outcome:
    """The Campbell diagram as bodies see it (Appendix B of Müller and Hennings)."""
    frames = [campbell_seen_by_body(system, diagram, body) for body in spec.bodies]
    return Outcome(
        kind=spec.kind,
        document={
            "speed_rpm": (diagram.speeds_rad_s / RPM).tolist(),
            "bodies": {frame.body: _frame_document(frame) for frame in frames},
        },
        files={f"{spec.label}.png": lambda path: draw_rotating_campbell(frames, path, title)},
        headline=f"frames of {', '.join(spec.bodies)}",
    )


def _frame_document(frame: RotatingCampbell) -> dict[str, Any]:
    return {
        "speed_ratio": frame.speed_ratio,
        "orders": frame.orders.tolist(),
        "frequency_hz": frame.frequency_hz.tolist(),
        "share": frame.share.tolist(),
        "share_of_kinetic_energy": frame.body_share.tolist(),
        "mirrored": frame.is_mirrored.tolist(),
    }


def run_mode_shapes(
    spec: ModeShapesSpec, system: AssembledSystem, diagram: Campbell, title: str
) -> Outcome:
    """Shapes of the lowest modes at some speeds, numbered as in the diagram, and their parts."""
    documents = []
    files: dict[str, Write] = {}
    for rpm in spec.speeds_rpm:
        modes = modes_at_speed(system, rpm * RPM, spec.modes)
        numbers = branch_numbers(system, diagram, modes).tolist()
        shapes, shares = mode_shapes(system, modes, numbers), participation(system, modes)
        files |= _mode_files(spec, system, diagram, rpm, f"{title}, {speed_text(rpm)} rpm")
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
        kind=spec.kind,
        document={"speeds": documents},
        files=files,
        headline=f"{spec.speeds_rpm[0]:.0f} rpm: {lowest} Hz",
    )


def _mode_files(
    spec: ModeShapesSpec, system: AssembledSystem, diagram: Campbell, rpm: float, title: str
) -> dict[str, Write]:
    """Pictures of the modes that have room in them, the lowest ones."""
    modes = modes_at_speed(system, rpm * RPM, min(spec.modes, _MOST_MODES))
    if modes.frequency_hz.size == 0:
        return {}
    numbers = branch_numbers(system, diagram, modes).tolist()
    shapes, shares = mode_shapes(system, modes, numbers), participation(system, modes)
    if spec.modes > _MOST_MODES:
        title += f", the lowest {modes.frequency_hz.size} modes"
    at = f"{spec.label}_{speed_text(rpm)}rpm"
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


def run_state_space(spec: StateSpaceSpec, system: AssembledSystem) -> Outcome:
    """A, B, C, D between forces and motions at interfaces over the speed."""
    inputs: list[Input] = [
        ForceInput(body=b, interface=i, component=c) for b, i, c in _all(spec.inputs, system)
    ]
    outputs: list[Output] = [
        MotionOutput(body=b, interface=i, component=c, quantity=quantity)
        for b, i, c in _all(spec.outputs, system)
        for quantity in ("displacement", "velocity", "acceleration")
    ]
    speeds = np.linspace(spec.from_rpm, spec.to_rpm, max(2, spec.speed_count)) * RPM
    if system.has_constant_bearings:
        model = state_space(system, inputs, outputs, (float(speeds[0]), float(speeds[-1])))
    else:
        speeds = with_knots(speeds, system.knots_rad_s)
        model = tabulated_state_space(system, inputs, outputs, speeds)
    return Outcome(
        kind=spec.kind,
        document={
            "form": model.form,
            "states": model.state_count,
            "inputs": list(model.input_names),
            "outputs": list(model.output_names),
            "speed_rpm": (model.speeds_rad_s / RPM).tolist(),
            "files": [f"{spec.label}{suffix}" for suffix in (".h5", ".npz", ".mat")],
        },
        files={
            f"{spec.label}.h5": lambda path: write_state_space(model, path),
            f"{spec.label}.npz": lambda path: export_npz(model, path),
            f"{spec.label}.mat": lambda path: export_mat(model, path),
        },
        headline=f"{model.state_count} states, {len(model.input_names)} inputs, "
        f"{len(model.output_names)} outputs",
    )


def _all(places: tuple[str, ...], system: AssembledSystem) -> list[tuple[str, str, str]]:
    """Every motion that interfaces carry."""
    out: list[tuple[str, str, str]] = []
    for place in places:
        end = end_of(place)
        element = system.system.rotors[end.body].element
        out += [(end.body, end.interface, c) for c in element.components_at(end.interface)]
    return out
