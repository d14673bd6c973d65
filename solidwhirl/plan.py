"""The effects plan: what a scene calls for, what is left out, why, and what it costs.

Nothing that the plan has off is assembled or solved; the ledger of a run can be held against it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solidwhirl.fineness import Fineness, choose_fineness
from solidwhirl.geometry import Body
from solidwhirl.scene import BearingSpec, Scene


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One effect.

    Attributes
    ----------
    name
        As in the scene's [effects] table, or of what the scene can not ask for.
    on
        Whether it is computed.
    why
        The reason.
    cost
        What it adds, in matrices assembled, factorisations and eigenproblems per body.
    """

    name: str
    on: bool
    why: str
    cost: str = ""


@dataclass(frozen=True, kw_only=True)
class BodyPlan:
    """What is computed for one body.

    Attributes
    ----------
    level
        "harmonic" or "solid".
    orders
        Circumferential orders that are solved (harmonic) or kept (solid).
    components
        Interface coordinates.
    fineness
        Mesh and element order.
    maximum_speed_rad_s
        Largest speed of the body.
    matrices, factorisations, eigenproblems
        How many, at most, the reduction will need.
    """

    level: str
    orders: tuple[int, ...]
    components: tuple[str, ...]
    fineness: Fineness
    maximum_speed_rad_s: float
    matrices: int
    factorisations: int
    eigenproblems: int


@dataclass(frozen=True, kw_only=True)
class Plan:
    """The plan of a run.

    Attributes
    ----------
    effects
        All of them, on or off.
    bodies
        By name.
    speeds_rad_s
        (s,) speeds of the reference shaft.
    """

    effects: tuple[Effect, ...]
    bodies: Mapping[str, BodyPlan]
    speeds_rad_s: NDArray[np.float64]

    def on(self, name: str) -> bool:
        """Whether an effect is computed."""
        return next(e.on for e in self.effects if e.name == name)


def scene_speeds(scene: Scene) -> NDArray[np.float64]:
    """Speeds of the reference shaft [rad/s]."""
    s = scene.speeds
    rpm = s.list_rpm if s.list_rpm is not None else np.linspace(s.from_rpm, s.to_rpm, s.count)
    return np.asarray(rpm, dtype=float) * np.pi / 30.0


def make_plan(scene: Scene, bodies: Mapping[str, Body]) -> Plan:
    """Decide what a scene needs.

    Parameters
    ----------
    scene
        The scene.
    bodies
        Its geometry (see `solidwhirl.bodies.build_bodies`).
    """
    speeds = scene_speeds(scene)
    top = {name: abs(spec.speed_ratio) * speeds.max() for name, spec in scene.bodies.items()}
    effects = (
        *_rotation_effects(scene, turning=any(v > 0.0 for v in top.values())),
        _damping(scene),
        _tilt(scene),
        _axial(scene),
        _torsion(scene),
        *_never(scene),
    )
    on = {e.name for e in effects if e.on}
    plans = {name: _body_plan(scene, body, top[name], on) for name, body in bodies.items()}
    return Plan(effects=effects, bodies=plans, speeds_rad_s=speeds)


def _rotation_effects(scene: Scene, *, turning: bool) -> tuple[Effect, ...]:
    """Gyroscopic matrix, stress stiffening, spin softening."""
    costs = {
        "gyroscopic": "1 matrix",
        "stress_stiffening": "2 matrices, 1 static solution, modes at top speed if they matter",
        "spin_softening": "1 matrix",
    }
    # the two centrifugal effects belong together: asking for one asks for both
    pair = (scene.effects.stress_stiffening, scene.effects.spin_softening)
    together = "on" if "on" in pair else pair[0]
    out = []
    for name, cost in costs.items():
        asked = scene.effects.gyroscopic if name == "gyroscopic" else together
        if asked == "auto":
            why = "bodies turn" if turning else "nothing turns: all speeds are zero"
        else:
            why = f"the scene says {asked}"
            if asked == "off" and turning:
                why += "; the results at speed leave it out"
        chosen = asked == "on" or (asked == "auto" and turning)
        out.append(Effect(name=name, on=chosen, why=why, cost=cost))
    return tuple(out)


def _called_for(
    scene: Scene, name: str, needed: list[str], reason: str, absent: str, cost: str
) -> Effect:
    """An effect that some entries of the scene call for."""
    asked = getattr(scene.effects, name)
    if asked == "off":
        why = "the scene says off"
        if needed:
            why += f", though {reason} ({', '.join(needed)})"
        return Effect(name=name, on=False, why=why, cost=cost)
    if asked == "on" and not needed:
        return Effect(name=name, on=True, why="the scene says on", cost=cost)
    why = f"{reason}: {', '.join(needed)}" if needed else absent
    return Effect(name=name, on=bool(needed), why=why, cost=cost)


def _nonzero(bearing: BearingSpec, *keys: str) -> bool:
    return any(np.any(np.asarray(getattr(bearing, key))) for key in keys)


def _damping(scene: Scene) -> Effect:
    keys = [k for k in BearingSpec.model_fields if "damping" in k]
    found = [b.name for b in scene.bearings if _nonzero(b, *keys)]
    return _called_for(
        scene,
        "bearing_damping",
        found,
        "bearings have damping",
        "no bearing has damping",
        "general instead of Hermitian eigenproblems of the assembled system",
    )


def _tilt(scene: Scene) -> Effect:
    found = [
        b.name
        for b in scene.bearings
        if _nonzero(b, "tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad")
        or {"rx", "ry"} & set(b.rigid)
    ]
    found += [d.name for spec in scene.bodies.values() for d in spec.rigid_disks]
    return _called_for(
        scene,
        "tilt",
        found,
        "something acts on the tilt of an interface",
        "nothing acts on the tilt of an interface",
        "2 constraint modes per interface",
    )


def _axial(scene: Scene) -> Effect:
    keys = ("axial_stiffness_n_per_m", "axial_damping_n_s_per_m")
    found = [b.name for b in scene.bearings if _nonzero(b, *keys) or "uz" in b.rigid]
    return _called_for(
        scene,
        "axial",
        found,
        "bearings act along the axis",
        "no bearing acts along the axis, and lateral motion does not couple to it",
        "circumferential order 0: all matrices and modes once more",
    )


def _torsion(scene: Scene) -> Effect:
    keys = ("torsion_stiffness_n_m_per_rad", "torsion_damping_n_m_s_per_rad")
    found = [b.name for b in scene.bearings if _nonzero(b, *keys) or "rz" in b.rigid]
    return _called_for(
        scene,
        "torsion",
        found,
        "bearings or gears act on torsion",
        "nothing acts on torsion, and lateral motion does not couple to it",
        "circumferential order 0: all matrices and modes once more",
    )


def _never(scene: Scene) -> tuple[Effect, ...]:
    """What no scene of this version can ask for, said rather than kept silent."""
    reasons = {
        "nodal_diameter_modes": "order 2 and more of a body of revolution load no bearing",
        "change_of_shape": "prestress is computed on the undeformed body (hoop strain is checked)",
        "internal_damping": "not part of this scene format",
        "speed_dependent_bearings": "not part of this scene format; stiffness is constant",
    }
    return tuple(Effect(name=name, on=False, why=why) for name, why in reasons.items())


def _body_plan(scene: Scene, body: Body, top_speed: float, on: set[str]) -> BodyPlan:
    level = "harmonic" if scene.model.level == "auto" else scene.model.level
    components = ["ux", "uy"]
    components += ["uz"] if "axial" in on else []
    components += ["rx", "ry"] if "tilt" in on else []
    components += ["rz"] if "torsion" in on else []
    orders = (1, 0) if {"axial", "torsion"} & on else (1,)
    problems = len(orders) if level == "harmonic" else 1
    matrices = (2 + ("gyroscopic" in on) + 2 * (level == "solid")) * problems
    factorisations = eigenproblems = 1
    turning = top_speed > 0.0
    if "stress_stiffening" in on:
        # order 1 needs the stiffness of order 0 for the static solution; order 0 has it
        matrices += 2 * problems + (level == "harmonic")
        factorisations += 1 + turning
        eigenproblems += turning
    return BodyPlan(
        level=level,
        orders=orders,
        components=tuple(components),
        fineness=choose_fineness(body, level, scene.model),
        maximum_speed_rad_s=top_speed,
        matrices=matrices,
        factorisations=factorisations * problems,
        eigenproblems=eigenproblems * problems,
    )
