"""Undamped critical speeds over the stiffness of supports."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from solidwhirl.analyses import base
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import Count, Name, Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.assembly.bearing_laws import PolynomialLaw
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map, stiffness_at_rest
from solidwhirl.rotordyn.critical_speeds.map_supports import support_stiffness
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.maps import MapCurves, map_chart

# Speeds at which the stiffness of bearings is drawn, and what of it.
_SUPPORT_SPEEDS, _SPEED = 101, "shaft_speed_rpm"
_SUPPORTS = (
    ("kxx", "kxx_n_per_m"),
    ("kyy", "kyy_n_per_m"),
    ("effective stiffness", "effective_n_per_m"),
)


class CriticalSpeedMapSpec(base.Stiffnesses):
    """Critical speeds over the stiffness of supports."""

    section = base.CRITICAL_SPEEDS
    turning: ClassVar = {"excited_by": base.UNBALANCE_TURNS}
    axes = dict.fromkeys(
        ("critical_speed_rpm", "shaft_speed_rpm", "whirl", "likeness"),
        ("branch", "stiffness_n_per_m"),
    )

    kind: Literal["critical_speed_map"]
    excited_by: Name
    branches: Annotated[Count, Field(le=50)] = 6
    search_to_rpm: Positive
    operating_speed_rpm: Positive | None = None

    def operating_named(self) -> Iterator[base.OperatingSpec]:
        """Yield the operating speed that it is drawn for."""
        rpm = self.operating_speed_rpm
        if rpm is not None:
            yield base.OperatingSpec(shaft=self.excited_by, from_rpm=rpm, to_rpm=rpm)

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield the speed to which critical speeds are sought."""
        yield self.search_to_rpm / ratio(self.excited_by), f"search_to_rpm of {where}"

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve: pencils of the stiffness, with laws one after the other."""
        each = Work(undamped=14.0, factorisations=10.0) if size.laws else Work(undamped=2.1)
        return each.times(self.stiffness_count)

    def run(self, engine: base.Engine) -> Outcome:
        """Undamped critical speeds over the stiffness of supports."""
        ratio = abs(engine.speed_ratios[self.excited_by])
        found = critical_speed_map(
            engine.system,
            self.bearings,
            self.stiffnesses_n_per_m,
            excitation_ratio=ratio,
            branch_count=self.branches,
            speed_max_rad_s=self.search_to_rpm * RAD_S_PER_RPM / ratio,
        )
        return Outcome(
            kind=self.kind,
            document={
                "bearings": list(self.bearings),
                "excited_by": self.excited_by,
                "stiffness_n_per_m": self.stiffnesses_n_per_m.tolist(),
                "critical_speed_rpm": (found.speed_rad_s * RPM_PER_RAD_S).tolist(),
                "shaft_speed_rpm": (ratio * found.speed_rad_s * RPM_PER_RAD_S).tolist(),
                "whirl": [[w or None for w in branch] for branch in found.whirl.tolist()],
                "free_rpm": (found.free_rad_s * RPM_PER_RAD_S).tolist(),
                "rigid_rpm": (found.rigid_rad_s * RPM_PER_RAD_S).tolist(),
                "operating_speed_rpm": self.operating_speed_rpm,
                "supports": self._supports(engine, ratio),
            },
            headline=f"{len(found.speed_rad_s)} branches over {self.stiffness_count} stiffnesses",
        )

    def _supports(self, engine: base.Engine, ratio: float) -> list[dict[str, Any]]:
        """The stiffness over the speed of bearings whose law the map replaces, alike ones once."""
        laws = {joint.bearing: (joint.law, joint.speed_ratio) for joint in engine.system.law_joints}
        rpm = np.linspace(0.0, self.search_to_rpm, _SUPPORT_SPEEDS)
        alike: dict[tuple[int, float], list[str]] = {}
        for name in self.bearings:
            if name in laws and not isinstance(laws[name][0], PolynomialLaw):
                alike.setdefault((id(laws[name][0]), laws[name][1]), []).append(name)
        out = []
        for names in alike.values():
            found = support_stiffness(engine.system, names[0], rpm * RAD_S_PER_RPM / ratio, ratio)
            out.append(
                {
                    "bearings": names,
                    "shaft_speed_rpm": rpm.tolist(),
                    "kxx_n_per_m": found.kxx_n_per_m.tolist(),
                    "kyy_n_per_m": found.kyy_n_per_m.tolist(),
                    "effective_n_per_m": found.effective_n_per_m.tolist(),
                }
            )
        return out

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The map, if it has a branch."""
        speeds = numbers(found.document["critical_speed_rpm"])
        return {"": lambda: [self._chart(found)]} if np.isfinite(speeds).any() else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The map."""
        return [self._chart(found)]

    def _chart(self, found: base.Found) -> Chart:
        """The map over the speed of the shaft that excites."""
        document, rpm = found.document, self.operating_speed_rpm
        ratio = abs(found.engine.speed_ratios[self.excited_by])
        curves = map_curves(
            document,
            ratio,
            chosen=_chosen(found.engine, self.bearings, document["supports"]),
            supports=_support_curves(document["supports"]),
        )
        return map_chart(curves, {} if rpm is None else {self.excited_by: rpm}, self.excited_by)


def map_curves(
    document: Mapping[str, Any],
    ratio: float,
    *,
    chosen: Mapping[float, str],
    supports: Sequence[tuple[str, FloatArray, FloatArray]],
) -> MapCurves:
    """Return what a map draws, from its document; `chosen` and `supports` as in `MapCurves`.

    `ratio`: speed of the shaft that excites over that of the reference shaft.
    """
    stiffness = numbers(document["stiffness_n_per_m"])
    return MapCurves(
        bearings=document["bearings"],
        stiffness_n_per_m=stiffness,
        speed_rpm=numbers(document["shaft_speed_rpm"]).reshape(-1, stiffness.size),
        whirl=document["whirl"],
        free_rpm=numbers(document["free_rpm"]) * ratio,
        rigid_rpm=numbers(document["rigid_rpm"]) * ratio,
        chosen=chosen,
        supports=supports,
    )


def _support_curves(
    supports: Sequence[Mapping[str, Any]],
) -> list[tuple[str, FloatArray, FloatArray]]:
    """Name, stiffness and speed of each curve."""
    return [
        (f"{text} of {', '.join(own['bearings'])}", numbers(own[key]), numbers(own[_SPEED]))
        for own in supports
        for text, key in _SUPPORTS
    ]


def _chosen(
    engine: base.Engine, names: Sequence[str], supports: Sequence[Mapping[str, Any]]
) -> dict[float, str]:
    """The bearings by the stiffness that they have, N/m, but those with curves of their own."""
    places: dict[float, list[str]] = {}
    drawn = {name for own in supports for name in own["bearings"]}
    for name in (name for name in names if name not in drawn):
        pair = stiffness_at_rest(engine.system, name)
        marks = ("", "") if pair[0] == pair[1] else (" (x)", " (y)")
        for value, mark in zip(pair.tolist(), marks, strict=True):
            if name + mark not in places.setdefault(value, []):
                places[value].append(name + mark)
    return {value: ", ".join(own) for value, own in places.items()}
