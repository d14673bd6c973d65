"""The Campbell diagram in the frames of bodies."""

from __future__ import annotations

from typing import Any, Literal

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
    Names,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.campbell.body_frames import RotatingCampbell, campbell_seen_by_body
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.modes import (
    draw_rotating_campbell,
)


class RotatingCampbellSpec(Analysis):
    """The Campbell diagram in the frames of bodies."""

    kind: Literal["rotating_campbell"]
    bodies: Names

    def run(self, engine: Engine) -> Outcome:
        """The Campbell diagram as bodies see it (Appendix B of Müller and Hennings)."""
        frames = [
            campbell_seen_by_body(engine.system, engine.diagram, body) for body in self.bodies
        ]
        return Outcome(
            kind=self.kind,
            document={
                "speed_rpm": (engine.diagram.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "bodies": {frame.body: _frame_document(frame) for frame in frames},
            },
            files={
                f"{self.label}.png": lambda path: draw_rotating_campbell(frames, path, engine.title)
            },
            headline=f"frames of {', '.join(self.bodies)}",
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
