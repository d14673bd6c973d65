"""An engine of rigid bodies in the place of one whose bodies are not reduced yet.

It has the joints of the scene, so that it tells what the run will find of its own engine: which
parts nothing couples (`rotordyn.modes.uncoupled`), whether motions are free, and which parts of
run-ups are the same (`rotordyn.run_up.integration.parts_to_run`). Bodies are counted by the
coordinates that they are expected to have.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from solidwhirl.core.errors import USER_ERRORS
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem, Superelement
    from solidwhirl.rotordyn.core.arrays import IntArray
    from solidwhirl.rotordyn.run_up.integration import RunSettings

# Mass and inertia of a body that is not yet known.
_MASS_KG, _INERTIA_KG_M2 = 1.0, (1.0, 1.0, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class StandIn:
    """An engine of rigid bodies, and these by name; `scene`: whose run-ups it is asked about."""

    scene: Scene
    system: AssembledSystem
    rigid: Mapping[str, Superelement]

    def parts(self, sizes: Mapping[str, int]) -> tuple[float, ...]:
        """Return what of all coordinates the parts have that nothing couples.

        `sizes`: coordinates of each body after its reduction.
        """
        from solidwhirl.rotordyn.modes.uncoupled import uncoupled_groups

        groups = uncoupled_groups(self.system)
        found = [self.coordinates(self.system, at, sizes) for at in groups]
        return tuple(count / sum(found) for count in found) if sum(found) else (1.0,)

    @property
    def is_free(self) -> bool:
        """Whether it has motions without stiffness, such as shafts that turn freely."""
        from solidwhirl.rotordyn import modes_at_speed

        return modes_at_speed(self.system, 0.0).zero_count > 0

    @cached_property
    def stepped(self) -> Mapping[str, list[tuple[AssembledSystem, IntArray]]]:
        """Models and parts that each run-up steps and none before it has, by name of the analysis.

        Without run-ups that can't be had; what is wrong the run itself will say.
        """
        known: dict[Hashable, RunSettings] = {}
        out = {}
        for spec in self.scene.analyses:
            if spec.kind == "run_up":
                with suppress(*USER_ERRORS):
                    out[spec.label] = list(spec.parts_of(self.system, known))
        return out

    def coordinates(self, model: AssembledSystem, at: IntArray, sizes: Mapping[str, int]) -> float:
        """Count the coordinates of a part of a model, bodies in it by those expected of them."""
        total = 0.0
        for name, rows in model.body_slices.items():
            moved = model.transformation[rows].any(axis=0)
            own, every = int(moved[at].sum()), int(moved.sum())
            # of a model in which it stays rigid it has few
            is_own = model.system.rotors[name].element is self.rigid.get(name)
            expected = sizes[name] if is_own else every
            total += expected * own / every if every else 0.0
        return total


def stand_in(scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody]) -> StandIn | None:
    """Return the engine with rigid bodies; None where it tells nothing that costs.

    Lateral motion of one shaft has one part, and without damping it takes no time; in the frame of
    asymmetric bodies all is solved at once. Where bearings follow from the weight that they carry,
    bodies of another weight have none; and rigid bodies can't be held as often as others.
    """
    from solidwhirl.model.static_loads import load_case

    count = len(plan.bodies) + len(scene.rigid_bodies) + len(scene.beams) + len(scene.imported)
    damped = plan.on("bearing_damping") or plan.on("internal_damping")
    has_parts = damped and (count > 1 or plan.on("axial") or plan.on("torsion"))
    runs = any(spec.kind == "run_up" for spec in scene.analyses)
    if plan.on("asymmetry") or not (has_parts or runs) or load_case(scene) is not None:
        return None
    from solidwhirl.model.system_parts import engine_of, simple_elements

    rigid = {name: _rigid(name, body, plan) for name, body in bodies.items()}
    try:
        system = engine_of(scene, plan, {**simple_elements(scene, plan), **rigid})
    except USER_ERRORS:
        return None
    return StandIn(scene=scene, system=system, rigid=rigid)


class SteppedPart(NamedTuple):
    """A part of a model that is stepped by itself: its coordinates after reduction, its steps."""

    coordinates: float
    steps: float


def stepped_parts(
    scene: Scene, plan: Plan, engine: StandIn | None, sizes: Mapping[str, int]
) -> dict[str, list[SteppedPart]]:
    """Return what each run-up steps that none before it has stepped, by the name of the analysis.

    Nothing in the frame of asymmetric bodies, where no part is stepped apart. `engine`: None: all
    steps of all models are of the whole; `sizes`: coordinates of each body, after its reduction.
    """
    if plan.on("asymmetry"):
        return {}
    out: dict[str, list[SteppedPart]] = {}
    for spec in scene.analyses:
        if spec.kind != "run_up":
            continue
        if engine is None or spec.label not in engine.stepped:
            models = 1 + len(spec.compare_flexible)
            out[spec.label] = [SteppedPart(float(sum(sizes.values())), models * spec.steps)]
        else:
            out[spec.label] = [
                SteppedPart(engine.coordinates(model, at, sizes), spec.steps)
                for model, at in engine.stepped[spec.label]
            ]
    return out


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
