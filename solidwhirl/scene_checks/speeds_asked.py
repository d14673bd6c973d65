"""Speeds that a scene asks for: of the diagram, and those to which its analyses look."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from solidwhirl.analyses.registry import AnalysisSpec
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds, running_speeds


@dataclass(frozen=True, kw_only=True)
class SpeedAsked:
    """The highest speed to which an analysis looks."""

    analysis: str  #: Its name
    speed_rpm: float  #: Of the reference shaft
    source: str  #: The key that it comes from, or how it does


def scene_speeds(scene: Scene) -> FloatArray:
    """Speeds of the reference shaft [rad/s]."""
    s = scene.speeds
    rpm = s.list_rpm if s.list_rpm is not None else np.linspace(s.from_rpm, s.to_rpm, s.count)
    return np.asarray(rpm, dtype=float) * np.pi / 30.0


def top_speed(scene: Scene) -> float:
    """Largest speed of the reference shaft in any analysis [rad/s]; the bases are made for it."""
    rpm = max((asked.speed_rpm for asked in _speeds_asked(scene)), default=0.0)
    return max(float(scene_speeds(scene).max()), rpm * np.pi / 30.0)


def range_top_rpm(scene: Scene) -> float:
    """Highest speed of the reference shaft that results are given for, or a shaft operates at."""
    given = [v for a in scene.analyses for _, speeds in _given(a) for v in speeds]
    operating = [o.reference_rpm[1] for o in operating_speeds(scene)]
    return max([float(scene_speeds(scene).max()) * RPM_PER_RAD_S, *given, *operating])


def speeds_beyond(scene: Scene) -> tuple[SpeedAsked, ...]:
    """Return what asks for speeds above those of the diagram, one entry for an analysis."""
    own = float(scene_speeds(scene).max())
    found: dict[str, SpeedAsked] = {}
    for asked in _speeds_asked(scene):
        most = found.get(asked.analysis)
        if asked.speed_rpm / RPM_PER_RAD_S > own * (1.0 + 1e-9) and (
            most is None or most.speed_rpm < asked.speed_rpm
        ):
            found[asked.analysis] = asked
    return tuple(found.values())


def top_speed_text(scene: Scene, body: str) -> str:
    """Say where the top speed of a body comes from; empty if from the speeds of the diagram."""
    beyond = speeds_beyond(scene)
    if not beyond:
        return ""
    most = max(beyond, key=lambda asked: asked.speed_rpm)
    ratio = abs(scene.speed_ratio(body))
    geared = "" if ratio == 1.0 else f"{ratio:g} times {most.speed_rpm:.6g} rpm, "
    return (
        f"this speed is {geared}{most.source}, although [speeds] ends at "
        f"{float(scene_speeds(scene).max()) * RPM_PER_RAD_S:.6g} rpm"
    )


def _speeds_asked(scene: Scene) -> Iterator[SpeedAsked]:
    for o in scene.operating:
        yield SpeedAsked(
            analysis="operating",
            speed_rpm=o.to_rpm / _ratio(scene, o.shaft),
            source=f"the operating speed of {o.shaft!r}, {o.to_rpm:g} rpm",
        )
    for k, analysis in enumerate(scene.analyses):
        where = f"analyses[{k}] ({analysis.label})"
        for key, speeds in _given(analysis):
            for rpm in speeds:
                yield SpeedAsked(analysis=analysis.label, speed_rpm=rpm, source=f"{key} of {where}")
        ratio = partial(_ratio, scene)
        for rpm, source in analysis.shaft_speeds(running_speeds(scene), ratio, where):
            yield SpeedAsked(analysis=analysis.label, speed_rpm=rpm, source=source)


def _given(analysis: AnalysisSpec) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Keys that give speeds of the reference shaft."""
    spin = getattr(analysis, "speed_rpm", None)
    key = "to_rpm" if spin is None else "speed_rpm"
    yield key, (getattr(analysis, key, None) or 0.0,)
    for key in ("speeds_rpm", "orbits_at_rpm"):
        yield key, tuple(getattr(analysis, key, ()))


def _ratio(scene: Scene, body: str) -> float:
    """|speed ratio| of a body, inf if it stands still: nothing is asked of it then."""
    return abs(scene.speed_ratio(body)) or float("inf")
