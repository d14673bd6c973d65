"""Shapes of the lowest modes, and which bodies and joints take part in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from solidwhirl.analyses import base
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock
from solidwhirl.core.fields import MOST, Count, Name, NotNegative
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labelled, Labels
from solidwhirl.rotordyn import Modes, modes_at_speed
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modes.kinds import kinds, shares_document
from solidwhirl.rotordyn.modes.mode_shapes import ModeShapes, mode_shapes
from solidwhirl.rotordyn.modes.participation import Participation, participation
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.modes import body_chart, deflection_chart, mode_names, share_chart

# Modes that have room in one picture.
_MOST_MODES = 12


class ModeShapesSpec(base.Analysis):
    """Shapes of the lowest modes and which bodies and joints take part in them."""

    section = base.MODE_SHAPES

    kind: Literal["mode_shapes"]
    speeds_rpm: Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=base.MOST_SPEEDS)]
    modes: Annotated[Count, Field(le=60)] = 8
    bodies: Annotated[tuple[Name, ...], Field(max_length=MOST)] = ()

    def possible_files(self, bearings: Mapping[str, bool]) -> tuple[str, ...]:
        """Return three pictures and more for each speed."""
        ends = ("", "_participation", *(f"_{body}" for body in self.bodies))
        return tuple(
            f"{self.label}_{base.number_text(rpm)}rpm{end}.png"
            for rpm in self.speeds_rpm
            for end in ends
        )

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        speeds = len(self.speeds_rpm)
        return Work(eigenproblems=4.0 * speeds, results=20.0 * speeds)

    def run(self, engine: base.Engine) -> Outcome:
        """Shapes of the lowest modes at some speeds, numbered as in the diagram."""
        documents = []
        for rpm in self.speeds_rpm:
            modes, shapes, shares = _modes(engine, rpm, self.modes)
            documents.append(
                {
                    "speed_rpm": rpm,
                    "branch": [k or None for k in shapes.numbers or ()],
                    "frequency_hz": modes.frequency_hz.tolist(),
                    "log_decrement": base.decrements(modes.log_decrement),
                    "whirl": shapes.whirl.tolist(),
                    "kind": kinds(shapes.shares).tolist(),
                    "shares": shares_document(shapes.shares),
                    "bodies": {
                        b.body: {
                            "interfaces": list(b.interfaces),
                            "interface_axial_m": b.interface_axial_m.tolist(),
                            "interface_deflection": b.interface_deflection.tolist(),
                        }
                        for b in shapes.bodies
                    },
                    "kinetic_energy": _by_name(shares.bodies, shares.kinetic_bodies),
                    "strain_energy_of_bodies": _by_name(shares.bodies, shares.strain_bodies),
                    "strain_energy_of_joints": _by_name(shares.joints, shares.strain_joints),
                }
            )
        lowest = ", ".join(f"{f:.2f}" for f in documents[0]["frequency_hz"])
        return Outcome(
            kind=self.kind,
            document={"speeds": documents},
            headline=f"{self.speeds_rpm[0]:.0f} rpm: {lowest} Hz",
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The lowest modes at each speed: all bodies, single ones, and their shares of energy."""
        pictures: dict[str, base.Charts] = {}
        for speed in found.document["speeds"]:
            if speed["frequency_hz"]:
                at = f"_{base.number_text(speed['speed_rpm'])}rpm"
                for suffix in ("", "_participation", *(f"_{body}" for body in self.bodies)):
                    charts = partial(self._charts, found.engine, speed["speed_rpm"], suffix)
                    pictures[at + suffix] = charts
        return pictures

    def _charts(self, engine: base.Engine, rpm: float, suffix: str) -> list[Chart]:
        _, shapes, shares = _modes(engine, rpm, min(self.modes, _MOST_MODES))
        at = f"{base.number_text(rpm)} rpm"
        if self.modes > _MOST_MODES:
            at += f", the lowest {shapes.frequency_hz.size} modes"
        if suffix == "":
            return [deflection_chart([(at, mode_names(shapes), shapes)])]
        if suffix != "_participation":
            return [body_chart(shapes, suffix[1:], at)]
        found = [(at, mode_names(shapes), shares)]
        return [share_chart(found, kind) for kind in ("kinetic", "strain")]

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Nothing: a page shows modes at these speeds beside those at the critical ones."""
        return ()

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Modes over the speed, filled up to the speed that has most of them."""
        speeds = document["speeds"]
        most = max(len(s["frequency_hz"]) for s in speeds)
        bodies = speeds[0]["bodies"]

        def deflections(speed: Mapping[str, Any]) -> list[Any]:
            return [row for b in speed["bodies"].values() for row in b["interface_deflection"]]

        variables: dict[str, Labelled] = {
            key: (("speed_rpm", "mode"), [_padded(s[key], most) for s in speeds])
            for key in ("frequency_hz", "log_decrement", "whirl", "kind")
        }
        branches = [_padded([k or 0 for k in s.get("branch", ())], most) for s in speeds]
        variables["branch"] = (("speed_rpm", "mode"), branches)
        rows = [[_padded(row, most) for row in deflections(s)] for s in speeds]
        variables["deflection"] = (("speed_rpm", "place", "mode"), rows)
        places = [f"{body}.{i}" for body, shape in bodies.items() for i in shape["interfaces"]]
        axial = [z for shape in bodies.values() for z in shape["interface_axial_m"]]
        coordinates: dict[str, Labelled] = {
            "speed_rpm": ("speed_rpm", [s["speed_rpm"] for s in speeds]),
            "place": ("place", np.array(places, dtype=str)),
            "axial_m": ("place", np.array(axial, dtype=float)),
        }
        for key, dim in (
            ("kinetic_energy", "body"),
            ("strain_energy_of_bodies", "body"),
            ("strain_energy_of_joints", "joint"),
        ):
            names = list(speeds[0][key])
            shares = [[_padded(s[key][name], most) for name in names] for s in speeds]
            if names:
                variables[f"share_of_{key}"] = (("speed_rpm", dim, "mode"), shares)
                coordinates[dim] = (dim, names)
        return Labels(variables, coordinates)


def _modes(engine: base.Engine, rpm: float, count: int) -> tuple[Modes, ModeShapes, Participation]:
    modes = modes_at_speed(engine.system, rpm * RAD_S_PER_RPM, count)
    numbers = branch_numbers(engine.system, engine.diagram, modes).tolist()
    shapes = mode_shapes(engine.system, modes, numbers)
    return modes, shapes, participation(engine.system, modes)


def _by_name(names: Sequence[str], rows: Any) -> dict[str, Any]:
    return dict(zip(names, rows.tolist(), strict=True))


def _padded(values: list[Any], count: int) -> list[Any]:
    return [*values, *[None] * (count - len(values))]
