"""Doubts about speeds: a diagram that ends below all operating speeds."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from solidwhirl.operating import Operating, operating_speeds
from solidwhirl.plausibility_records import Doubt
from solidwhirl.scene import Scene
from solidwhirl.speeds_asked import scene_speeds, top_speed

_RPM = 30.0 / math.pi
# Fastest body: a dental drill turns at 5e5 rpm, a spinning sphere in a laboratory at more.
SPEED_RPM = 3e6


def fast_bodies(scene: Scene, judged: Collection[str]) -> Iterator[Doubt]:
    """Yield a doubt where a body would turn faster than any rotor does.

    Parameters
    ----------
    scene
        The scene.
    judged
        Names of bodies whose speed is judged with their size.
    """
    others = {n: abs(r) for n, r in scene.speed_ratios().items() if n not in judged}
    if not others:
        return
    name, ratio = max(others.items(), key=lambda pair: pair[1])
    rpm = ratio * top_speed(scene) * _RPM
    if rpm > SPEED_RPM:
        yield Doubt(
            key="speeds",
            found=f"{name!r} at up to {rpm:g} rpm",
            usual=f"up to {SPEED_RPM:g} rpm",
            mistake="rpm expected; is the speed too high, or a speed_ratio?",
        )


def operating_doubts(scene: Scene) -> Iterator[Doubt]:
    """Yield a doubt where the speeds of the scene end below all operating speeds of its shafts.

    Parameters
    ----------
    scene
        The scene; one whose speeds are all zero is not questioned.
    """
    top_rpm = float(scene_speeds(scene).max()) * _RPM
    ranges = [(o.reference_rpm[0], o) for o in operating_speeds(scene)]
    if top_rpm == 0.0 or not ranges:
        return
    lowest, nearest = min(ranges, key=lambda pair: pair[0])
    if lowest <= top_rpm:
        return
    key = "to_rpm" if scene.speeds.list_rpm is None else "list_rpm"
    geared = abs(scene.speed_ratio(nearest.shaft)) != 1.0
    of_reference = f", from {lowest:.6g} rpm of the reference shaft on" if geared else ""
    in_rad_s = top_rpm * _RPM
    hint = f"is this in rad/s ({in_rad_s:.6g} rpm)?" if in_rad_s >= lowest else "does it end early?"
    yield Doubt(
        key=f"speeds.{key}",
        found=f"{top_rpm:.6g} rpm, and the operating speeds of {nearest.shaft!r} are "
        f"{_range(nearest)}{of_reference}",
        usual="a diagram up to the operating speeds",
        mistake=f"rpm expected; {hint}",
    )


def _range(operating: Operating) -> str:
    if operating.from_rpm == operating.to_rpm:
        return f"{operating.to_rpm:g} rpm"
    return f"{operating.from_rpm:g} to {operating.to_rpm:g} rpm"
