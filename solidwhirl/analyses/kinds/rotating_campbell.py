"""The Campbell diagram in the frames of bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses.base import Analysis, Charts, Engine, Found, Names
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import MOST, Count
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn.campbell.body_frames import RotatingCampbell, campbell_seen_by_body
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.modes import FrameCurves, frame_chart, is_drawn

_ENERGY = "share_of_kinetic_energy"
# Share of a component that is drawn of the branches that are drawn at first.
_MAIN = 0.25


class RotatingCampbellSpec(Analysis):
    """The Campbell diagram in the frames of bodies."""

    section = PageSection(
        "rotating-frames",
        "Frequencies that the bodies see",
        "What a strain gauge on a turning body would measure.",
        40,
    )
    turning: ClassVar = {"bodies": "its frame is the inertial one"}

    kind: Literal["rotating_campbell"]
    bodies: Names
    branches: Annotated[tuple[Count, ...], Field(max_length=MOST)] = ()

    @model_validator(mode="after")
    def _each(self) -> RotatingCampbellSpec:
        if self.branches and len(self.branches) != len(self.bodies):
            raise ValueError(
                f"branches has {len(self.branches)} numbers for {len(self.bodies)} bodies"
            )
        return self

    def work(self, size: EngineSize) -> Work:
        """Modes of the diagram again, for their motion in each body's frame."""
        return Work(eigenproblems=25.0 * len(self.bodies))

    def run(self, engine: Engine) -> Outcome:
        """The Campbell diagram as bodies see it (Appendix B of Müller and Hennings)."""
        frames = [
            campbell_seen_by_body(engine.system, engine.diagram, body) for body in self.bodies
        ]
        return Outcome(
            kind=self.kind,
            document={
                "branches": list(self.branches),
                "speed_rpm": (engine.diagram.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "bodies": {frame.body: _frame_document(frame) for frame in frames},
            },
            headline=f"frames of {', '.join(self.bodies)}",
        )

    def pictures(self, found: Found) -> Mapping[str, Charts]:
        """A frame for each body."""
        return {"": lambda: [frame_chart(frames_of(found.document))]}

    def blocks(self, found: Found) -> Sequence[AnalysisBlock]:
        """The diagram, a body at a time."""
        return [frame_chart(frames_of(found.document))]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Components of the branches, and how much of the kinetic energy the body has."""
        bodies = document["bodies"]
        over = ("body", "order", "branch", "speed_rpm")
        keys = ("frequency_hz", "share", "mirrored")
        energy = [body["share_of_kinetic_energy"] for body in bodies.values()]
        return Labels(
            {
                **{key: (over, [body[key] for body in bodies.values()]) for key in keys},
                "share_of_kinetic_energy": (("body", "branch", "speed_rpm"), energy),
            },
            {
                "body": ("body", list(bodies)),
                "order": ("order", next(iter(bodies.values()))["orders"]),
                "speed_rpm": ("speed_rpm", document["speed_rpm"]),
                "speed_ratio": ("body", [body["speed_ratio"] for body in bodies.values()]),
            },
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


def frames_of(document: Mapping[str, Any]) -> list[FrameCurves]:
    """Return what bodies see, from the document of the analysis."""
    rpm, found = numbers(document["speed_rpm"]), []
    first = _first_branches(document)
    for body, frame in document["bodies"].items():
        hertz, orders = numbers(frame["frequency_hz"]), np.array(frame["orders"])
        # a positive order turns with +z, and so does a body with a positive ratio, until mirrored
        against = np.array(frame["mirrored"], dtype=bool) ^ (
            orders[:, None, None] * np.sign(frame["speed_ratio"]) < 0
        )
        drawn = is_drawn(numbers(frame["share"]), numbers(frame["share_of_kinetic_energy"]))
        found.append(
            FrameCurves(
                name=f"{body} (speed ratio {frame['speed_ratio']:.5g})",
                rpm=np.abs(frame["speed_ratio"]) * rpm,
                signed_hz=np.where(drawn, np.where(against, -hertz, hertz), np.nan),
                orders=orders.tolist(),
                first=first.get(body),
            )
        )
    return found


def own_branches(bodies: Mapping[str, Any]) -> dict[str, tuple[IntArray, IntArray]]:
    """Return the branches of each body: those that bend, and those of torsion and axial motion.

    `bodies`: of the document of the analysis. A branch is that of the body with the most of its
    kinetic energy over the speeds. It is torsion or axial motion, which turning leaves as it is, if
    most of the motion there has the order 0. Empty without a branch.
    """
    if not any(len(body[_ENERGY]) for body in bodies.values()):
        return {}  # nothing vibrates
    moved = np.array([np.nan_to_num(numbers(b[_ENERGY])).mean(axis=1) for b in bodies.values()])
    found = {}
    for k, (body, frame) in enumerate(bodies.items()):
        order = np.array(frame["orders"])[_mean_share(frame).argmax(axis=0)]
        is_own = moved.argmax(axis=0) == k
        found[body] = np.flatnonzero(is_own & (order != 0)), np.flatnonzero(is_own & (order == 0))
    return found


def _mean_share(frame: Mapping[str, Any]) -> FloatArray:
    """Shares of components (c, b) over the speeds."""
    return np.asarray(np.nan_to_num(numbers(frame["share"])).mean(axis=2))


def _first_branches(document: Mapping[str, Any]) -> dict[str, BoolArray]:
    """Which components (c, b) of the lowest branches of each body are drawn at first.

    Of the branches that bend, the larger components are.
    """
    wanted, bodies = document.get("branches", ()), document["bodies"]
    found = {}
    for (body, (bent, _)), count in zip(own_branches(bodies).items(), wanted, strict=False):
        share = _mean_share(bodies[body])
        found[body] = (share >= _MAIN) & np.isin(np.arange(share.shape[1]), bent[:count])
    return found
