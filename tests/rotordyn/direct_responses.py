"""Frequency responses of state-space models, and their error against the whole system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.state_space.channels import ForceInput, Output, channels_at_speed
from solidwhirl.rotordyn.state_space.model import StateSpace


class ResponseError(NamedTuple):
    """Largest error of each channel over its largest response (p, m), and where the worst is."""

    relative: FloatArray
    speed_rad_s: float
    frequency_hz: float

    @property
    def worst(self) -> float:
        """Largest of all channels."""
        return float(self.relative.max())


def frequency_response(
    model: StateSpace, speed_rad_s: float, frequencies_hz: npt.ArrayLike
) -> ComplexArray:
    """Return the frequency responses of a model at one speed.

    `frequencies_hz`: of the inputs e^{iωt}, shape (f,). Returns C (iω − A)⁻¹ B + D, shape (f, p,
    m).
    """
    a, b, c, d = model.at_speed(speed_rad_s)
    omega = 2.0 * np.pi * np.asarray(frequencies_hz, dtype=float)
    unit = np.eye(len(a))
    return np.array([c @ la.solve(1j * w * unit - a, b) + d for w in omega])


def response_error(
    model: StateSpace,
    assembled: AssembledSystem,
    inputs: Sequence[ForceInput],
    outputs: Sequence[Output],
    speeds_rad_s: npt.ArrayLike,
    frequencies_hz: npt.ArrayLike,
) -> ResponseError:
    """Measure the frequency responses of a model against the system it stands for.

    `model`: such as that of a truncated system. `speeds_rad_s`, `frequencies_hz`: where to compare,
    shapes (s,) and (f,); between them nothing is known. Returns max |H − H_ref| / max |H_ref| of
    each channel over all speeds and frequencies. Raises AnalysisError if the model has other inputs
    or outputs.
    """
    ends = tuple(tuple(item.name_and_unit[0] for item in end) for end in (inputs, outputs))
    if ends != (model.input_names, model.output_names):
        raise AnalysisError(f"the model has {model.input_names} and {model.output_names}")
    speeds = np.asarray(speeds_rad_s, dtype=float)
    frequencies = np.asarray(frequencies_hz, dtype=float)
    reference = np.array([_direct(assembled, inputs, outputs, v, frequencies) for v in speeds])
    found = np.array([frequency_response(model, float(v), frequencies) for v in speeds])
    largest = np.abs(reference).max(axis=(0, 1))
    # A channel without any response is compared with the largest of its output.
    largest = np.where(largest > 0, largest, largest.max(axis=1, keepdims=True))
    error = np.abs(found - reference) / np.where(largest > 0, largest, 1.0)
    place = np.unravel_index(int(error.argmax()), error.shape)
    return ResponseError(
        error.max(axis=(0, 1)), float(speeds[place[0]]), float(frequencies[place[1]])
    )


def _direct(
    assembled: AssembledSystem,
    inputs: Sequence[ForceInput],
    outputs: Sequence[Output],
    speed: float,
    frequencies: FloatArray,
) -> ComplexArray:
    """Return the responses from the dynamic stiffness, shape (f, p, m)."""
    matrices = matrices_at_speed(assembled, float(speed))
    channels = channels_at_speed(assembled, inputs, outputs, float(speed))
    velocity = matrices.damping + matrices.gyroscopic
    scale = 1.0 / np.sqrt(np.diag(matrices.mass))
    result = []
    for w in 2.0 * np.pi * frequencies:
        dynamic = matrices.stiffness + 1j * w * velocity - w**2 * matrices.mass
        scaled = scale[:, None] * dynamic * scale
        q = scale[:, None] * la.solve(scaled, scale[:, None] * channels.load)
        rows = channels.displacement + 1j * w * channels.velocity - w**2 * channels.acceleration
        result.append(rows @ q)
    return np.array(result)
