"""Error estimates as plain data for `results.json`; relative errors, dimensionless."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.dial import Round
from solidwhirl.estimates import Estimates
from solidwhirl.scene import Scene

FloatArray = NDArray[np.float64]


def with_estimate(parts: Mapping[str, FloatArray], total: FloatArray) -> dict[str, Any]:
    """Estimates of an array of frequencies.

    Parameters
    ----------
    parts, total
        Relative errors, shape of the frequencies each.
    """
    return {
        "frequency_error_estimate": total.tolist(),
        "error_parts": {part: values.tolist() for part, values in parts.items()},
    }


def critical_speed_entry(estimates: Estimates, index: int) -> dict[str, Any]:
    """Estimate of one critical speed (of its speed and of its frequency alike)."""
    found = estimates.critical_speeds
    return {
        "frequency_error_estimate": float(found.total[index]),
        "error_parts": {part: float(values[index]) for part, values in found.parts.items()},
    }


def accuracy_document(
    scene: Scene, estimates: Estimates | None, rounds: tuple[Round, ...]
) -> dict[str, Any]:
    """What was asked, what was got, and how.

    Parameters
    ----------
    scene
        For the accuracy asked.
    estimates
        None where the scene has them off.
    rounds
        Of the accuracy dial.
    """
    achieved = np.nan if estimates is None else estimates.largest
    given = [] if estimates is None else _given_meshes(scene, estimates)
    return {
        "asked": scene.model.accuracy,
        "largest_error_estimate": achieved,
        "met": _met(achieved, scene.model.accuracy, known=not given),
        "not_summed": "interface_coupling: a choice of the model, not an approximation",
        "bodies_without_estimate": []
        if estimates is None
        else list(estimates.campbell.bodies_without_estimate),
        "meshes_without_estimate": given,
        "rounds": [
            {
                "unknowns": dict(r.unknowns),
                "modes": dict(r.modes),
                "largest_error_estimate": r.estimate,
                "error_parts": dict(r.parts),
                "refined": list(r.refined),
            }
            for r in rounds
        ],
    }


def _given_meshes(scene: Scene, estimates: Estimates) -> list[str]:
    """Bodies whose mesh was given, and could not be compared with another one."""
    compared = {
        name
        for pair in estimates.comparisons
        if pair.part == "mesh"
        for name in pair.second_elements
    }
    return [name for name in scene.mesh_bodies if name not in compared]


def _met(achieved: float, asked: float, *, known: bool) -> bool | None:
    """Whether the accuracy is met; that of what is not known can only be missed."""
    if not np.isfinite(achieved) or (achieved <= asked and not known):
        return None
    return bool(achieved <= asked)
