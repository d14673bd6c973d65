"""What the run-ups of a scene cost: parts that nothing couples, each stepped once for all of them.

Which parts there are, and which of them run-ups and models share, is asked of the run-up itself
(`rotordyn.run_up.integration.parts_to_run`), on an engine of the scene's joints whose bodies are
rigid. Bodies are counted by the coordinates that they are expected to have.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.analyses.responses.run_up import RunUpSpec
    from solidwhirl.rotordyn import AssembledSystem, Superelement
    from solidwhirl.rotordyn.core.arrays import IntArray
    from solidwhirl.rotordyn.run_up.integration import RunSettings

# Mass and inertia of a body that is not yet known.
_MASS_KG, _INERTIA_KG_M2 = 1.0, (1.0, 1.0, 1.0)


class SteppedPart(NamedTuple):
    """A part of a model that is stepped by itself: its coordinates after reduction, its steps."""

    coordinates: float
    steps: float


def stepped_parts(
    scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody], coordinates: Mapping[str, int]
) -> dict[str, list[SteppedPart]]:
    """Return what each run-up steps that none before it has stepped, by the name of the analysis.

    `coordinates`: of each body, after its reduction.
    """
    asked: list[RunUpSpec] = [spec for spec in scene.analyses if spec.kind == "run_up"]
    if not asked or plan.on("asymmetry"):
        return {}
    from solidwhirl.model.system_parts import engine_of, simple_elements

    rigid = {name: _rigid(name, body, plan) for name, body in bodies.items()}
    system = engine_of(scene, plan, {**simple_elements(scene, plan), **rigid})
    sizes = {rigid[name]: count for name, count in coordinates.items()}
    known: dict[Hashable, RunSettings] = {}
    return {
        spec.label: [
            SteppedPart(_coordinates(model, at, sizes), spec.steps)
            for model, at in spec.parts_of(system, known)
        ]
        for spec in asked
    }


def _rigid(name: str, body: AnyBody, plan: Plan) -> Superelement:
    """A rigid body in the place of one that is not reduced yet, with the motions of its joints."""
    from solidwhirl.rotordyn import rigid_superelement
    from solidwhirl.rotordyn.superelement.validation import MOTIONS

    used = {m for own in plan.bodies[name].interface_components.values() for m in own}
    moves = tuple(m for m in MOTIONS if m in used or m not in ("uz", "rz"))
    places = {interface.name: interface.position_m for interface in body.interfaces}
    return rigid_superelement(name, _MASS_KG, (0.0, 0.0, 0.0), _INERTIA_KG_M2, places, moves)


def _coordinates(
    model: AssembledSystem, at: IntArray, sizes: Mapping[Superelement, int]
) -> float:
    """Count the coordinates of a part of a model, bodies in it by those expected of them."""
    total = 0.0
    for name, rows in model.body_slices.items():
        moved = model.transformation[rows].any(axis=0)
        own, every = int(moved[at].sum()), int(moved.sum())
        expected = sizes.get(model.system.rotors[name].element, every)
        total += expected * own / every if every else 0.0
    return total
