"""Bodies of a scene on the beam level: elements, their variants, and when beams are enough."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np

from solidwhirl.beams.body import MODES, beam_element_of, beam_variants
from solidwhirl.beams.nodes import DEFAULT_ELEMENTS
from solidwhirl.geometry import Body
from solidwhirl.geometry.meridian.snapping import axial_range
from solidwhirl.model.plan_records import Plan
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS, Component
from solidwhirl.scene.records import Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class BeamBodies:
    """Beam models of the bodies of a scene."""

    elements: Mapping[str, Superelement]  #: By name, those of the run
    #: Models with other choices, each all bodies by name (see `error.VARIANTS`)
    variants: tuple[Mapping[str, Superelement], ...]
    finer: Mapping[str, Superelement]  #: With beams half as long; empty without estimates


def beam_models(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body]
) -> Iterator[Mapping[str, Superelement]]:
    """Make the beam models of all bodies, then their variants, each when it is asked for.

    In the order of `error.VARIANTS`. Raises BeamLevelError: a body is none of beams and plates.
    """
    asked = {name: _asked(scene, plan, name) for name in bodies}
    made = [beam_variants(body, **asked[name]) for name, body in bodies.items()]
    for models in zip(*made, strict=True):
        yield {n: _with_effects(m, plan) for n, m in zip(bodies, models, strict=True)}


def with_finer(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body],
    models: Sequence[Mapping[str, Superelement]],
) -> BeamBodies:
    """Return all of `beam_models` with models of beams half as long."""
    finer: dict[str, Superelement] = {}
    for name, body in bodies.items():
        start, end = axial_range(body)
        half = 0.5 * (end - start) / DEFAULT_ELEMENTS
        made = beam_element_of(body, element_length_m=half, **_asked(scene, plan, name))
        finer[name] = _with_effects(made, plan)
    return BeamBodies(elements=models[0], variants=tuple(models[1:]), finer=finer)


def beam_bodies(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body], *, estimated: bool
) -> BeamBodies:
    """Make the beam models of all bodies, of one or more.

    `estimated`: whether variants and finer models are wanted as well. Raises BeamLevelError: a body
    is none of beams and plates.
    """
    models = beam_models(scene, plan, bodies)
    if estimated:
        return with_finer(scene, plan, bodies, [*models])
    return BeamBodies(elements=next(models), variants=(), finer={})


class _Asked(TypedDict):
    """What is asked of the models of a body."""

    components: Sequence[Component]
    modes: int


def _asked(scene: Scene, plan: Plan, name: str) -> _Asked:
    modes = max(MODES, scene.bodies[name].modes or scene.model.modes or 0)
    used = {m for own in plan.bodies[name].interface_components.values() for m in own}
    components = tuple(m for m in MOTIONS if m in used or m in ("ux", "uy", "rx", "ry"))
    return _Asked(components=components, modes=modes)


def _with_effects(element: Superelement, plan: Plan) -> Superelement:
    """The element without the matrices of effects that are off."""
    zero = np.zeros((element.size, element.size))
    if not plan.on("gyroscopic"):
        element = replace(element, gyroscopic=zero)
    if not plan.on("stress_stiffening"):
        element = replace(element, stress_stiffening=zero, spin_softening=zero)
    return element
