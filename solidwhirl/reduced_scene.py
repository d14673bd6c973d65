"""The reduced bodies of a scene on other supports: for loops and optimisers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.analyses.base import Stability, reference_ranges_rad_s
from solidwhirl.build import with_changes
from solidwhirl.cache.files import MemoryStore, StageStore
from solidwhirl.core.displays import indented
from solidwhirl.core.errors import SceneError
from solidwhirl.core.stages import Progress, silent
from solidwhirl.estimates.results import Estimates
from solidwhirl.geometry import Body
from solidwhirl.model.effects import make_plan
from solidwhirl.model.plan_records import Plan
from solidwhirl.pipeline import engine_stages as stages
from solidwhirl.pipeline.body_stages import Job
from solidwhirl.pipeline.engine_stages import Engine, ExcitedCriticalSpeed
from solidwhirl.pipeline.run import ReducedBodies, reduced
from solidwhirl.rotordyn import (
    AssembledSystem,
    Campbell,
    Modes,
    Superelement,
    draw_campbell,
    modes_at_speed,
)
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds

# Part by which a top speed may exceed that of the reduction: rounding of the input.
_SAME_SPEED = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedScene:
    """A scene with its reduced bodies, as `reduce_scene` makes it.

    Nothing is computed before it is asked for, and nothing of it is kept but the assembled system:
    an optimiser asks for what it needs. Numbers are those of `run_scene`.
    """

    reduced: ReducedBodies

    def __repr__(self) -> str:
        levels = ", ".join(f"{name} ({e.level})" for name, e in self.reduced.elements.items())
        return "\n".join(
            [f"ReducedScene {self.scene.name!r}: {levels}", *indented([repr(self.system)])]
        )

    @property
    def scene(self) -> Scene:
        """The scene, with the supports that were put in."""
        return self.reduced.job.scene

    @property
    def system(self) -> AssembledSystem:
        """The assembled engine; asymmetric bodies as they are at rest."""
        return self._engine.system

    @cached_property
    def _engine(self) -> Engine:
        found = self.reduced
        return stages.assembled_engine(found.job, found.bodies, found.elements, found.beams)

    def with_(self, **bearings: float | npt.ArrayLike | Mapping[str, Any]) -> ReducedScene:
        """Return the same bodies on other supports.

        Parameters
        ----------
        bearings
            By name: new values of keys of the scene file, such as `D={"stiffness_n_per_m": 2e8,
            "damping_n_s_per_m": 1e3}`; a number or an array is a stiffness, N/m.

        Raises
        ------
        ValueError
            There is no such bearing; the message names what is there.
        SceneError
            What comes out is no scene, or needs motions that the bodies were not reduced for.
        """
        return self.changed(
            {
                f"bearings[{name}].{key}": value
                for name, given in bearings.items()
                for key, value in _keys(given).items()
            }
        )

    def changed(self, changes: Mapping[str, Any]) -> ReducedScene:
        """Return the same bodies in a scene with other values at some places.

        `changes`: as of `solidwhirl.build.with_changes`. Raises ValueError, SceneError as `with_`,
        SceneError also if a body changes.
        """
        return self.in_scene(with_changes(self.scene, changes))

    def in_scene(self, scene: Scene) -> ReducedScene:
        """Return the same bodies in another scene that has them.

        Raises SceneError: the bodies of the scene differ, or it needs more of them.
        """
        job = self.reduced.job
        _refuse_other_bodies(self.scene, scene)
        plan = plan_of(scene, self.reduced.geometry, self.reduced.elements)
        _refuse_more(scene, job.plan, plan)
        return self.with_job(replace(job, scene=scene, plan=plan))

    def with_job(self, job: Job) -> ReducedScene:
        """Return the same bodies with another scene, plan or cache, which have to fit them."""
        return ReducedScene(reduced=replace(self.reduced, job=job))

    def modes(self, speed_rpm: float = 0.0) -> Modes:
        """Return the modes at a speed of the reference shaft, rpm."""
        return modes_at_speed(self.system, speed_rpm * RAD_S_PER_RPM)

    def campbell(self) -> Campbell:
        """Return the Campbell diagram at the speeds of the scene."""
        return stages.campbell_of(self._engine)

    def critical_speeds(self) -> tuple[ExcitedCriticalSpeed, ...]:
        """Return the critical speeds within the speeds of the scene, and who excites each."""
        return stages.critical_speeds_of(self._engine)

    def stability(self) -> Stability:
        """Return unstable intervals of the whole range, and damping at the operating speeds."""
        turns = self._engine.rotating is not None
        asymmetry = stages.diagram_of(self._engine).asymmetry if turns else None
        return stages.stability_of_engine(self._engine, asymmetry)

    def estimates(self) -> Estimates | None:
        """Estimate the errors of the diagram and the critical speeds; None where they are off."""
        return stages.estimates_of(self._engine, stages.diagram_of(self._engine))

    def draw_campbell(self, path: str | Path) -> None:
        """Draw the Campbell diagram with what unbalance excites to a PNG, SVG or PDF file."""
        draw_campbell(
            self.campbell(),
            [c.critical for c in self.critical_speeds() if c.excitation.excited],
            path,
            self.scene.title or self.scene.name,
            self.scene.speed_ratios(),
            reference_ranges_rad_s(operating_speeds(self.scene)),
        )


def reduce_scene(
    scene: Scene, *, progress: Progress = silent, store: StageStore | None = None
) -> ReducedScene:
    """Reduce the bodies of a scene, for loops over its supports.

    `progress`, `store`: as of `solidwhirl.pipeline.run.run_scene`; without a store stages are kept
    in memory. Raises what `run_scene` raises before its analyses.
    """
    found = reduced(scene, progress=progress, store=MemoryStore() if store is None else store)
    assert found is not None  # on one rank
    return ReducedScene(reduced=found)


def plan_of(
    scene: Scene, geometry: Mapping[str, Body], elements: Mapping[str, Superelement]
) -> Plan:
    """Return the plan of a scene whose bodies are there, with their levels."""
    levels = [elements[name].level for name, body in geometry.items() if not body.features]
    return make_plan(scene, geometry, levels[0] if levels else None)


def _keys(given: float | npt.ArrayLike | Mapping[str, Any]) -> Mapping[str, Any]:
    if isinstance(given, Mapping):
        return given
    return {"stiffness_n_per_m": np.asarray(given, dtype=float).tolist()}


# Tables of a scene that a reduction depends on, whatever holds its bodies.
_OF_BODIES = (
    *("bodies", "mesh_bodies", "beams", "rigid_bodies", "imported", "materials"),
    *("model", "effects"),
)
# Effects whose matrices a body has or has not.
_IN_BODIES = frozenset({"gyroscopic", "stress_stiffening", "spin_softening"})
_ANEW = "reduce the scene anew (reduce_scene)"


def _refuse_other_bodies(before: Scene, scene: Scene) -> None:
    """Raise SceneError if the bodies of a scene are not those that were reduced."""
    changed = [t for t in _OF_BODIES if getattr(before, t) != getattr(scene, t)]
    if changed:
        raise SceneError(
            scene.name, [f"{t}: differs from the reduced one; {_ANEW}" for t in changed]
        )


def _refuse_more(scene: Scene, before: Plan, plan: Plan) -> None:
    """Raise SceneError if a scene needs more of its bodies than they were reduced for."""
    problems = []
    for name, own in plan.bodies.items():
        known = before.bodies[name]
        if own.maximum_speed_rad_s > known.maximum_speed_rad_s * (1.0 + _SAME_SPEED):
            top, asked = (v.maximum_speed_rad_s * RPM_PER_RAD_S for v in (known, own))
            problems.append(
                f"speeds: body {name!r} was reduced for {top:.6g} rpm, found {asked:.6g}; {_ANEW}"
            )
        if own.interface_components != known.interface_components:
            problems.append(
                f"bearings: they act on motions of body {name!r} that it was reduced without, or "
                f"leave others free; {_ANEW}"
            )
    changed = [name for name in sorted(_IN_BODIES) if before.on(name) != plan.on(name)]
    problems += [f"effects.{name}: it is in the bodies; {_ANEW}" for name in changed]
    if problems:
        raise SceneError(scene.name, problems)
