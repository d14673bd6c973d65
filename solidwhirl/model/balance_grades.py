"""Unbalances that are given by a balance quality grade, as moments of bodies of known mass."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from solidwhirl.analyses.kinds.run_up import RunUpSpec
from solidwhirl.analyses.kinds.unbalance_response import UnbalanceResponseSpec
from solidwhirl.analyses.unbalances import UnbalanceSpec
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.scene.records import Scene

_M_PER_MM = 1e-3


def permissible_unbalance_kg_m(mass_kg: float, grade_mm_per_s: float, speed_rpm: float) -> float:
    """Return the unbalance that a balance quality grade permits a rotor.

    Notes
    -----
    U = m G / Ω, ISO 21940-11 (formerly ISO 1940-1): the whole of the rotor, all planes together.
    """
    return mass_kg * grade_mm_per_s * _M_PER_MM / (speed_rpm * RAD_S_PER_RPM)


def with_moments(scene: Scene, masses_kg: Mapping[str, float]) -> Scene:
    """Return the scene with moments in place of grades; itself where it has no grades.

    Raises AnalysisError: a body with a grade has no mass.
    """
    kinds = UnbalanceResponseSpec | RunUpSpec
    changed = {
        k: spec.model_copy(
            update={"unbalances": tuple(_plain(u, masses_kg) for u in spec.unbalances)}
        )
        for k, spec in enumerate(scene.analyses)
        if isinstance(spec, kinds) and any(u.grade is not None for u in spec.unbalances)
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
