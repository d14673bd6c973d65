"""Results as xarray datasets: named dimensions, coordinates with units, errors as variables.

`datasets` opens a whole run, in memory or from its folder; the other functions take one record of
`solidwhirl.rotordyn`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl.datasets_files import read_netcdf, write_netcdf
from solidwhirl.datasets_parts import RPM, Labelled, error_parts, labelled
from solidwhirl.datasets_runs import datasets
from solidwhirl.engine_stages import ExcitedCriticalSpeed
from solidwhirl.rotordyn import (
    Campbell,
    CampbellErrors,
    CriticalSpeed,
    CriticalSpeedErrors,
    FrequencyErrors,
    Modes,
)
from solidwhirl.rotordyn.critical_speed_map import CriticalSpeedMap
from solidwhirl.rotordyn.response_maps import GroundMotionMap
from solidwhirl.rotordyn.run_up_record import RunUp
from solidwhirl.rotordyn.unbalance import UnbalanceResponse

__all__ = [
    "campbell_dataset",
    "critical_speed_dataset",
    "critical_speed_map_dataset",
    "datasets",
    "ground_motion_dataset",
    "modes_dataset",
    "read_netcdf",
    "run_up_dataset",
    "unbalance_dataset",
    "write_netcdf",
]

_AXES = ["x", "y", "z"]


def campbell_dataset(campbell: Campbell, errors: CampbellErrors | None = None) -> xr.Dataset:
    """Return a Campbell diagram as a dataset.

    Parameters
    ----------
    campbell
        The diagram, b branches at s speeds.
    errors
        Their estimates; None leaves them out.

    Returns
    -------
    Dataset
        frequency_hz, log_decrement, eigenvalue_per_s, whirl ("" where a branch has ended) over
        (branch, speed_rpm), with errors frequency_error_estimate and error_parts.
    """
    over = ("branch", "speed_rpm")
    variables: dict[str, Labelled] = {
        "frequency_hz": (over, campbell.frequency_hz),
        "log_decrement": (over, campbell.log_decrement),
        "whirl": (over, campbell.whirl),
        "eigenvalue_per_s": (over, campbell.eigenvalues),
    }
    coordinates = _numbered("branch", len(campbell.frequency_hz))
    coordinates["speed_rpm"] = ("speed_rpm", campbell.speeds_rad_s / RPM)
    _add_errors(variables, coordinates, errors, over)
    notes = [note.text for note in campbell.notes]
    return labelled(variables, coordinates, frame="inertial", notes=notes)


def modes_dataset(modes: Modes, errors: FrequencyErrors | None = None) -> xr.Dataset:
    """Return the modes of a system at one speed as a dataset.

    Parameters
    ----------
    modes
        m of them.
    errors
        Their estimates; None leaves them out.

    Returns
    -------
    Dataset
        frequency_hz, log_decrement, damping_ratio, eigenvalue_per_s over mode, and shape over
        (coordinate, mode); speed_rpm is a coordinate without dimension.
    """
    variables: dict[str, Labelled] = {
        "frequency_hz": ("mode", modes.frequency_hz),
        "log_decrement": ("mode", modes.log_decrement),
        "damping_ratio": ("mode", modes.damping_ratio),
        "eigenvalue_per_s": ("mode", modes.eigenvalues),
        "shape": (("coordinate", "mode"), modes.shapes),
    }
    coordinates = _numbered("mode", modes.eigenvalues.size)
    coordinates["speed_rpm"] = ((), modes.speed_rad_s / RPM)
    _add_errors(variables, coordinates, errors, ("mode",))
    return labelled(variables, coordinates)


def critical_speed_dataset(
    found: Sequence[CriticalSpeed | ExcitedCriticalSpeed],
    errors: CriticalSpeedErrors | None = None,
) -> xr.Dataset:
    """Return critical speeds as a dataset.

    Parameters
    ----------
    found
        As `critical_speeds` or a run returns them.
    errors
        Their estimates, in that order; None leaves them out.

    Returns
    -------
    Dataset
        speed_rpm, frequency_hz, whirl, log_decrement over critical_speed, which counts from 1; of
        a run also excited_by.
    """
    bare = [c.critical if isinstance(c, ExcitedCriticalSpeed) else c for c in found]
    over = "critical_speed"
    variables: dict[str, Labelled] = {
        "speed_rpm": (over, np.array([c.speed_rad_s / RPM for c in bare], dtype=float)),
        "frequency_hz": (over, np.array([c.frequency_hz for c in bare], dtype=float)),
        "whirl": (over, np.array([c.whirl for c in bare], dtype=str)),
        "log_decrement": (over, np.array([c.log_decrement for c in bare], dtype=float)),
    }
    excited = [", ".join(c.excited_by) for c in found if isinstance(c, ExcitedCriticalSpeed)]
    if excited and len(excited) == len(found):
        variables["excited_by"] = (over, excited)
    coordinates = _numbered(over, len(bare))
    _add_errors(variables, coordinates, errors, (over,))
    return labelled(variables, coordinates)


def critical_speed_map_dataset(found: CriticalSpeedMap) -> xr.Dataset:
    """Return a critical speed map as a dataset.

    Parameters
    ----------
    found
        The map, b branches at s stiffnesses.

    Returns
    -------
    Dataset
        critical_speed_rpm and whirl over (branch, stiffness_n_per_m).
    """
    over = ("branch", "stiffness_n_per_m")
    return labelled(
        {
            "critical_speed_rpm": (over, found.speed_rad_s / RPM),
            "whirl": (over, found.whirl),
            "likeness": (over, found.likeness),
        },
        {
            **_numbered("branch", len(found.speed_rad_s)),
            "stiffness_n_per_m": ("stiffness_n_per_m", found.stiffness_n_per_m),
        },
        bearings=list(found.bearings),
        excitation_ratio=found.excitation_ratio,
    )


def unbalance_dataset(response: UnbalanceResponse) -> xr.Dataset:
    """Return a response to unbalance as a dataset.

    Parameters
    ----------
    response
        e exciters of different frequency, s speeds.

    Returns
    -------
    Dataset
        translation_m and tilt_rad over (exciter, speed_rpm, node, direction), major_m and minor_m
        over (exciter, speed_rpm, node), force_n and moment_n_m over (exciter, speed_rpm, bearing,
        axis), frequency_hz over (exciter, speed_rpm). Amplitudes are complex, time factor e^{iωt};
        those of different exciters have no common phase. tilt is about x and y.
    """
    exciters = response.exciters
    orbits = [exciter.orbits() for exciter in exciters]
    forces = np.stack(
        [np.stack(list(e.bearing_forces.values()), axis=1) for e in exciters]
        if exciters[0].bearing_forces
        else [np.empty((len(response.speeds_rad_s), 0, 6), dtype=complex) for _ in exciters]
    )
    at_node = ("exciter", "speed_rpm", "node")
    through = ("exciter", "speed_rpm", "bearing", "axis")
    hertz = np.stack([e.frequencies_rad_s for e in exciters]) / (2.0 * np.pi)
    return labelled(
        {
            "translation_m": (
                (*at_node, "direction"),
                np.stack([e.translation_m for e in exciters]),
            ),
            "tilt_rad": ((*at_node, "direction"), np.stack([e.tilt_rad for e in exciters])),
            "major_m": (at_node, np.stack([o.major_m for o in orbits])),
            "minor_m": (at_node, np.stack([o.minor_m for o in orbits])),
            "force_n": (through, forces[..., :3]),
            "moment_n_m": (through, forces[..., 3:]),
        },
        {
            "exciter": ("exciter", [", ".join(e.bodies) for e in exciters]),
            "speed_rpm": ("speed_rpm", response.speeds_rad_s / RPM),
            "node": ("node", [node.label for node in exciters[0].nodes]),
            "direction": ("direction", _AXES[:2]),
            "bearing": ("bearing", np.array(list(exciters[0].bearing_forces), dtype=str)),
            "axis": ("axis", _AXES),
            "frequency_hz": (("exciter", "speed_rpm"), hertz),
            "frequency_ratio": ("exciter", [e.frequency_ratio for e in exciters]),
        },
    )


def ground_motion_dataset(found: GroundMotionMap) -> xr.Dataset:
    """Return a response to ground motion (a waterfall) as a dataset.

    Parameters
    ----------
    found
        The map, s speeds and f frequencies.

    Returns
    -------
    Dataset
        translation_m, complex, over (speed_rpm, frequency_hz, direction), and amplitude_m, the
        major semi-axis of the orbit, over (speed_rpm, frequency_hz).
    """
    over = ("speed_rpm", "frequency_hz")
    return labelled(
        {
            "translation_m": ((*over, "direction"), found.translation_m),
            "amplitude_m": (over, found.major_m()),
        },
        {
            "speed_rpm": ("speed_rpm", found.speeds_rad_s / RPM),
            "frequency_hz": ("frequency_hz", found.frequencies_rad_s / (2.0 * np.pi)),
            "direction": ("direction", _AXES[:2]),
        },
        node=found.node.label,
        ground_amplitude_m=found.amplitude_m,
        ground_direction=found.direction,
    )


def run_up_dataset(run: RunUp) -> xr.Dataset:
    """Return the record of a run-up as a dataset.

    Parameters
    ----------
    run
        s times, o interfaces, b bearings.

    Returns
    -------
    Dataset
        translation_m, rotation_rad and their rates over (node, axis, time_s), force_n and
        moment_n_m over (bearing, axis, time_s), energies over time_s. speed_rpm and angle_rad are
        coordinates along time_s.
    """
    moved, held = ("node", "axis", "time_s"), ("bearing", "axis", "time_s")
    energy = run.energy
    return labelled(
        {
            "translation_m": (moved, run.translation_m),
            "rotation_rad": (moved, run.rotation_rad),
            "velocity_m_per_s": (moved, run.velocity_m_per_s),
            "angular_velocity_rad_per_s": (moved, run.angular_velocity_rad_per_s),
            "force_n": (held, run.force_n),
            "moment_n_m": (held, run.moment_n_m),
            "stored_energy_j": ("time_s", energy.stored_j),
            "load_work_j": ("time_s", energy.load_work_j),
            "drive_work_j": ("time_s", energy.drive_work_j),
            "dissipated_j": ("time_s", energy.dissipated_j),
        },
        {
            "time_s": ("time_s", run.time_s),
            "speed_rpm": ("time_s", run.speed_rad_s / RPM),
            "angle_rad": ("time_s", run.angle_rad),
            "node": ("node", np.array([end.label for end in run.outputs], dtype=str)),
            "bearing": ("bearing", np.array(run.bearings, dtype=str)),
            "axis": ("axis", _AXES),
        },
        step_s=run.step_s,
        notes=list(run.notes),
    )


def _numbered(dim: str, count: int) -> dict[str, Labelled]:
    """A coordinate that counts from 1, as pictures and reports do."""
    return {dim: (dim, np.arange(1, count + 1))}


def _add_errors(
    variables: dict[str, Labelled],
    coordinates: dict[str, Labelled],
    errors: CampbellErrors | CriticalSpeedErrors | FrequencyErrors | None,
    over: tuple[str, ...],
) -> None:
    if errors is None:
        return
    variables["frequency_error_estimate"] = (over, errors.total)
    parts: Mapping[str, Any] = errors.parts
    if parts:
        variables["error_parts"], coordinates["error_part"] = error_parts(parts, over)
