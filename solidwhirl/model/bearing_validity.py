"""Where bearings of a scene are used beyond the theory that their law is computed by."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solidwhirl.rotordyn import BearingNote
from solidwhirl.rotordyn.assembly.bearing_notes import Beyond
from solidwhirl.rotordyn.bearings.validity import Exceeded
from solidwhirl.scene.bearing_physics import ComputedLaw, SqueezeFilmLawSpec
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene

# Speeds of a table that are looked at.
_SPEEDS = 9


def validity_notes(scene: Scene, top_rad_s: float) -> tuple[BearingNote, ...]:
    """Return what is beyond its limit, for each bearing and quantity at its worst speed.

    `top_rad_s`: highest speed of the reference shaft that the scene asks for. Looked at are nine
    speeds of the table within it; quantities that hardly change, such as a length, once.
    """
    return tuple(note for bearing in scene.bearings for note in _notes(scene, bearing, top_rad_s))


def _notes(scene: Scene, bearing: BearingSpec, top_rad_s: float) -> Iterator[BearingNote]:
    law = scene.law_of(bearing)
    if not isinstance(law, ComputedLaw):
        return
    ratio = abs(scene.speed_ratio_at(bearing.first))
    if ratio == 0.0 and isinstance(law, SqueezeFilmLawSpec):
        ratio = 1.0  # a ring that stands still whirls with the shaft
    low, *_, high = law.table().speeds_rad_s.tolist()
    speeds = np.linspace(low, max(low, min(high, ratio * top_rad_s)), _SPEEDS)
    found: dict[str, list[tuple[float, Exceeded]]] = {}
    for speed in speeds.tolist():
        for one in law.exceeded(speed):
            found.setdefault(one.quantity, []).append((speed / ratio, one))
    for quantity, every in found.items():
        _, worst = max(every, key=lambda item: abs(item[1].value - item[1].limit))
        yield BearingNote(
            bearing=bearing.name,
            kind="beyond theory",
            speed_low_rad_s=every[0][0],
            speed_high_rad_s=every[-1][0],
            finding=f"law {bearing.speed_law!r}: {worst.text}",
            beyond=Beyond(quantity, worst.value, worst.limit),
        )
