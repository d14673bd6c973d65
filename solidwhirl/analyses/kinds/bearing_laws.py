"""Coefficients of the bearings that depend on the speed."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
)
from solidwhirl.core.fields import (
    Positive,
)
from solidwhirl.core.outcome import Outcome, Write
from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes, note_lines
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.maps import draw_bearing_law
from solidwhirl.rotordyn.response.resonance_samples import with_knots


class BearingLawsSpec(Analysis):
    """Stiffness and damping of the bearings that depend on the speed."""

    kind: Literal["bearing_laws"]
    to_rpm: Positive

    def run(self, engine: Engine) -> Outcome:
        """Coefficients of the bearings that depend on the speed."""
        speeds = with_knots(
            np.linspace(0.0, self.to_rpm * RAD_S_PER_RPM, 401), engine.system.knots_rad_s
        )
        documents: dict[str, Any] = {}
        files: dict[str, Write] = {}
        named = {b.name: b for b in engine.system.system.bearings}
        for joint in engine.system.law_joints:
            values = [joint.coefficients(float(speed)) for speed in speeds]
            documents[joint.bearing] = {
                "law": joint.law.name,
                "speed_of_its_rotor_rpm": (
                    np.abs(joint.speed_ratio) * speeds * RPM_PER_RAD_S
                ).tolist(),
                "stiffness_n_per_m": [np.diag(k).tolist() for k, _ in values],
                "damping_n_s_per_m": [np.diag(c).tolist() for _, c in values],
            }
            bearing = named[joint.bearing]
            own = np.abs(joint.speed_ratio) * speeds

            def draw(path: Any, bearing: Any = bearing, own: Any = own) -> None:
                draw_bearing_law(bearing, own, path, f"{engine.title}: bearing {bearing.name}", {})

            files[f"{self.label}_{joint.bearing}.png"] = draw
        notes = list(note_lines(bearing_notes(engine.system, speeds[[0, -1]])))
        return Outcome(
            kind=self.kind,
            document={"bearings": documents, "notes": notes},
            files=files,
            headline=f"{len(documents)} bearings, {len(notes)} notes",
        )
