"""Unbalances that are given by a balance quality grade, as moments of bodies of known mass."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from solidwhirl.analyses.unbalances import UnbalanceSpec
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.standards.iso_balance import permissible_unbalance_kg_m
from solidwhirl.scene.records import Scene


def with_moments(scene: Scene, masses_kg: Mapping[str, float]) -> Scene:
    """Return the scene with moments in place of grades; itself where it has no grades.

    Raises AnalysisError: a body with a grade has no mass.
    """
    changed = {
        k: spec.model_copy(
            update={"unbalances": tuple(_plain(u, masses_kg) for u in spec.unbalances)}
        )
        for k, spec in enumerate(scene.analyses)
        if (spec.kind == "unbalance_response" or spec.kind == "run_up")
        and any(u.grade is not None for u in spec.unbalances)
    }
    if not changed:
        return scene
    analyses = tuple(changed.get(k, spec) for k, spec in enumerate(scene.analyses))
    return scene.model_copy(update={"analyses": analyses})


def _plain(spec: UnbalanceSpec, masses_kg: Mapping[str, float]) -> UnbalanceSpec:
    if spec.grade is None or spec.at_rpm is None:
        return spec
    mass = masses_kg[spec.at.partition(".")[0]]
    if not (np.isfinite(mass) and mass > 0.0):
        raise AnalysisError(f"the unbalance at {spec.at!r} has a grade, but the body has no mass")
    moment = spec.share * permissible_unbalance_kg_m(mass, spec.grade, spec.at_rpm)
    return UnbalanceSpec(at=spec.at, moment_kg_m=moment, phase_deg=spec.phase_deg)
