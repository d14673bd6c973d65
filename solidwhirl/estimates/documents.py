"""Error estimates as plain data for `results.json`; relative errors, dimensionless."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.bodies.refinement import Round
from solidwhirl.estimates.results import Estimates
from solidwhirl.rotordyn import FrequencyErrors, Invariant
from solidwhirl.scene.records import Scene


def with_estimate(errors: FrequencyErrors) -> dict[str, Any]:
    """Estimates of an array of frequencies, in its shape."""
    return {
        "frequency_error_estimate": errors.total.tolist(),
        "error_parts": {part: values.tolist() for part, values in errors.parts.items()},
    }


def critical_speed_entry(estimates: Estimates, index: int) -> dict[str, Any]:
    """Estimate of one critical speed (of its speed and of its frequency alike)."""
    found = estimates.critical_speeds
    return {
        "frequency_error_estimate": float(found.total[index]),
        "error_parts": {part: float(values[index]) for part, values in found.parts.items()},
    }


def accuracy_document(
    scene: Scene,
    largest: float,
    without: Sequence[str],
    rounds: tuple[Round, ...],
    checks: Sequence[Invariant] = (),
) -> dict[str, Any]:
    """What was asked, what was got, and how.

    `largest`: error estimate of what counts, nan where there is none; `without`: bodies whose
    discretisation is not in it;
    `rounds`: of the adaptive refinement; `checks`: of the run: where one fails, an estimate of the
    same numbers says nothing.
    """
    failed = sum(check.passed is False for check in checks)
    return {
        "asked": scene.model.accuracy,
        "largest_error_estimate": largest,
        "met": _met(largest, scene.model.accuracy, known=not without and not failed),
        "failed_checks": failed,
        "not_summed": "interface_coupling: a choice of the model, not an approximation",
        "bodies_without_estimate": list(without),
        "meshes_without_estimate": [name for name in without if name in scene.mesh_bodies],
        "bodies_of_several_materials": several_materials(scene),
        "rounds": [
            {
                "unknowns": dict(r.unknowns),
                "modes": dict(r.modes),
                "largest_error_estimate": r.estimate,
                "error_parts": dict(r.parts),
                "refined": list(r.refined),
                "stopped": r.stopped,
                "kept": r.kept,
                "from_other": r.from_other,
            }
            for r in rounds
        ],
    }


def followed_by(rounds: Sequence[Mapping[str, Any]], index: int) -> str:
    """Return what came after a round of the accuracy document: what was refined, or its end."""
    found = rounds[index]
    if not found.get("stopped"):
        return ", ".join(found["refined"])
    kept = next(k for k, r in enumerate(rounds) if r.get("kept"))
    return f"stopped: {found['stopped']}" + (f"; round {kept + 1} kept" if kept != index else "")


def several_materials(scene: Scene) -> dict[str, list[str]]:
    """Return the bodies that are of several materials, with the names of these."""
    found: dict[str, list[str]] = {}
    for name, body in scene.bodies.items():
        own = [part.material for part in body.sections]
        own += [group.material for group in body.stage_groups]
        own += [blade.material for blade in body.blades]
        own += [g.blades.material or g.material for g in body.stage_groups if g.blades]
        found[name] = [material or body.material or "" for material in own]
    for name, mesh in scene.mesh_bodies.items():
        found[name] = list(mesh.materials.values())
        found[name] += [mesh.material] if mesh.material else []
    once = {name: list(dict.fromkeys(materials)) for name, materials in found.items()}
    return {name: materials for name, materials in once.items() if len(materials) > 1}


def coupling_effect(document: Mapping[str, Any]) -> float | None:
    """Return by how much the other coupling of the interfaces moves what matters at most.

    `document`: the contents of `results.json`. Relative, of the critical speeds that count; where
    there is none, of the modes of the diagram that do; None where it was not computed.
    """
    counted = [c for c in document["critical_speeds"] if not c.get("critically_damped")]
    speeds = [c.get("error_parts", {}).get("interface_coupling") for c in counted]
    known = [value for value in speeds if value is not None]
    if known:
        return float(max(known))
    diagram = document["campbell"]
    damped = diagram.get("critically_damped")
    return max(
        (
            value
            for b, row in enumerate(diagram.get("error_parts", {}).get("interface_coupling", ()))
            for s, value in enumerate(row)
            if value is not None and not (damped and damped[b][s])
        ),
        default=None,
    )


def coupling_text(effect: float) -> str:
    """Return what an effect from `coupling_effect` means and what to do, as one paragraph."""
    return (
        "Choice of the coupling: with rigid interfaces where the scene has distributing ones, and "
        f"the reverse, critical speeds (or else frequencies) move by up to {100.0 * effect:.2g} %. "
        "That is a choice of the model and not in the sum. Take `coupling` rigid where a stiff "
        "ring or bearing holds the cross-section round and plane, distributing where what sits "
        "there is softer than the shaft."
    )


def materials_text(names: Sequence[str]) -> str:
    """Return what the estimate does not cover where the named materials of a body join."""
    return (
        f"is of several materials ({', '.join(names)}): the estimate has not been checked on such "
        "bodies, and where they join stresses can be more singular than it takes them to be; "
        "compare with a finer accuracy"
    )


def _met(achieved: float, asked: float, *, known: bool) -> bool | None:
    """Whether the accuracy is met; that of what is not known can only be missed."""
    if not np.isfinite(achieved) or (achieved <= asked and not known):
        return None
    return bool(achieved <= asked)
