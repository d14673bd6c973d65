"""An engine of rigid bodies in the place of one whose bodies are not reduced yet.

It has the joints of the scene, so that it tells what the run will find of its own engine: which
parts nothing couples (`rotordyn.modes.uncoupled`), whether motions are free, and which parts of
run-ups are the same (`rotordyn.run_up.integration.parts_to_run`). Bodies are counted by the
coordinates that they are expected to have.
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


class StandIn(NamedTuple):
    """An engine of rigid bodies; `sizes`: coordinates that the bodies will have."""

    system: AssembledSystem
    sizes: Mapping[Superelement, int]

    @property
    def parts(self) -> tuple[float, ...]:
        """Parts that nothing couples, by how much of all coordinates they have."""
        from solidwhirl.rotordyn.modes.uncoupled import uncoupled_groups

        found = [self.coordinates(self.system, at) for at in uncoupled_groups(self.system)]
        return tuple(count / sum(found) for count in found)

    @property
    def is_free(self) -> bool:
        """Whether it has motions without stiffness, such as shafts that turn freely."""
        from solidwhirl.rotordyn import modes_at_speed

        return modes_at_speed(self.system, 0.0).zero_count > 0

    def coordinates(self, model: AssembledSystem, at: IntArray) -> float:
        """Count the coordinates of a part of a model, bodies in it by those expected of them."""
        total = 0.0
        for name, rows in model.body_slices.items():
            moved = model.transformation[rows].any(axis=0)
            own, every = int(moved[at].sum()), int(moved.sum())
            expected = self.sizes.get(model.system.rotors[name].element, every)
            total += expected * own / every if every else 0.0
        return total


def stand_in(
    scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody], sizes: Mapping[str, int]
) -> StandIn | None:
    """Return the engine with rigid bodies; None where bearings follow from the weight they carry.

    `sizes`: coordinates of each body after its reduction.
    """
    from solidwhirl.model.static_loads import load_case
    from solidwhirl.model.system_parts import engine_of, simple_elements

    if load_case(scene) is not None:
        return None
    rigid = {name: _rigid(name, body, plan) for name, body in bodies.items()}
    system = engine_of(scene, plan, {**simple_elements(scene, plan), **rigid})
    return StandIn(system, {rigid[name]: sizes[name] for name in bodies})


class SteppedPart(NamedTuple):
    """A part of a model that is stepped by itself: its coordinates after reduction, its steps."""

    coordinates: float
    steps: float


def stepped_parts(
    scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody], sizes: Mapping[str, int]
) -> dict[str, list[SteppedPart]]:
    """Return what each run-up steps that none before it has stepped, by the name of the analysis.

    `sizes`: coordinates of each body, after its reduction.
    """
    asked: list[RunUpSpec] = [spec for spec in scene.analyses if spec.kind == "run_up"]
    if not asked or plan.on("asymmetry"):
        return {}
    engine = stand_in(scene, plan, bodies, sizes)
    if engine is None:  # all steps of all models, of the whole
        whole = float(sum(sizes.values()))
        steps = {spec.label: spec.steps * (1 + len(spec.compare_flexible)) for spec in asked}
        return {name: [SteppedPart(whole, count)] for name, count in steps.items()}
    known: dict[Hashable, RunSettings] = {}
    return {
        spec.label: [
            SteppedPart(engine.coordinates(model, at), spec.steps)
            for model, at in spec.parts_of(engine.system, known)
        ]
        for spec in asked
    }


def _rigid(name: str, body: AnyBody, plan: Plan) -> Superelement:
    """A rigid body with the motions of its joints."""
    from solidwhirl.rotordyn import rigid_superelement
    from solidwhirl.rotordyn.superelement.validation import MOTIONS

    used = {m for own in plan.bodies[name].interface_components.values() for m in own}
    moves = tuple(m for m in MOTIONS if m in used or m not in ("uz", "rz"))
    places = {interface.name: interface.position_m for interface in body.interfaces}
    if len({*places.values()}) == 1:  # not known before the mesh is made: one after the other
        places = {name: (0.0, 0.0, float(k)) for k, name in enumerate(places)}
    return rigid_superelement(name, _MASS_KG, (0.0, 0.0, 0.0), _INERTIA_KG_M2, places, moves)
