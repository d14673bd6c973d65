"""Bodies of a scene on the beam level: elements, their variants, and when beams are enough."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from solidwhirl.beams.body import MODES, beam_element_of, beam_variants
from solidwhirl.beams.nodes import DEFAULT_ELEMENTS
from solidwhirl.geometry import Body
from solidwhirl.geometry.meridian.snapping import axial_range
from solidwhirl.model.plan_records import Plan
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.records import Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class BeamBodies:
    """Beam models of the bodies of a scene."""

    elements: Mapping[str, Superelement]  #: By name, those of the run
    #: Models with other choices, each all bodies by name (see `error.VARIANTS`)
    variants: tuple[Mapping[str, Superelement], ...]
    finer: Mapping[str, Superelement]  #: With beams half as long; empty without estimates


def beam_bodies(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body], *, estimated: bool
) -> BeamBodies:
    """Make the beam models of all bodies.

    `estimated`: whether variants and finer models are wanted as well. Raises BeamLevelError: a body
    is none of beams and plates.
    """
    elements: dict[str, Superelement] = {}
    others: list[dict[str, Superelement]] = []
    finer: dict[str, Superelement] = {}
    for name, body in bodies.items():
        modes = max(MODES, scene.bodies[name].modes or scene.model.modes or 0)
        used = {m for own in plan.bodies[name].interface_components.values() for m in own}
        components = tuple(m for m in MOTIONS if m in used or m in ("ux", "uy", "rx", "ry"))
        if not estimated:
            made = beam_element_of(body, components=components, modes=modes)
            elements[name] = _with_effects(made, plan)
            continue
        models = beam_variants(body, components=components, modes=modes)
        elements[name], *rest = (_with_effects(m, plan) for m in models)
        others = others or [{} for _ in rest]
        for own, model in zip(others, rest, strict=True):
            own[name] = model
        start, end = axial_range(body)
        half = 0.5 * (end - start) / DEFAULT_ELEMENTS
        made = beam_element_of(body, components=components, element_length_m=half, modes=modes)
        finer[name] = _with_effects(made, plan)
    return BeamBodies(elements=elements, variants=tuple(others), finer=finer)


def _with_effects(element: Superelement, plan: Plan) -> Superelement:
    """The element without the matrices of effects that are off."""
    zero = np.zeros((element.size, element.size))
    if not plan.on("gyroscopic"):
        element = replace(element, gyroscopic=zero)
    if not plan.on("stress_stiffening"):
        element = replace(element, stress_stiffening=zero, spin_softening=zero)
    return element
