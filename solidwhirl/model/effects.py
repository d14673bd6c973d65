"""The effects plan: what a scene calls for, what is left out, why, and what it costs.

Nothing that the plan has off is assembled or solved; the ledger of a run can be held against it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.analyses.registry import KINDS
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody, is_asymmetric
from solidwhirl.model.mesh_bodies import base_plan, build_mesh_bodies, mesh_plan
from solidwhirl.model.plan_records import BodyPlan, Effect, Plan
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.model.static_loads import load_case, loaded_bearings
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import (
    acting_on,
    carried_motions,
    is_off_axis,
    places_of_joints,
)
from solidwhirl.scene_checks.recovery_references import recovered_bodies
from solidwhirl.scene_checks.speeds_asked import scene_speeds, speeds_beyond, top_speed

if TYPE_CHECKING:
    from solidwhirl.analyses.responses.static import StaticSpec


def make_plan(scene: Scene, bodies: Mapping[str, Body], level: str | None = None) -> Plan:
    """Decide what a scene needs.

    `bodies`: its geometry (see `solidwhirl.model.bodies.build_bodies`). `level`: in the place of
    the scene's "auto" (see `solidwhirl.bodies.fidelity`), of bodies without features. Raises
    AnalysisError: an analysis is for other bodies.
    """
    _refuse_kinds(scene, list(_asymmetric(bodies, build_mesh_bodies(scene))))
    return plan_of(scene, bodies, level)


def plan_of(scene: Scene, bodies: Mapping[str, Body], level: str | None = None) -> Plan:
    """Decide the same where nobody runs the analyses, which may be for other bodies than these."""
    mesh_bodies = build_mesh_bodies(scene)
    asymmetric = _asymmetric(bodies, mesh_bodies)
    speeds = scene_speeds(scene)
    fastest = top_speed(scene)
    top = {name: abs(ratio) * fastest for name, ratio in scene.speed_ratios().items()}
    effects = (
        *_rotation_effects(
            scene,
            turning=any(v > 0.0 for v in top.values()),
            # imported bodies that turn may bring their own centrifugal matrices
            solid=bool(bodies or scene.mesh_bodies)
            or any(spec.speed_ratio for spec in scene.imported.values()),
        ),
        *_called_for(scene),
        *_static_loads(scene),
        *_joints({**bodies, **mesh_bodies}, level or scene.model.level),
        _asymmetry(list(asymmetric)),
        *_estimates(scene, list(asymmetric), meshed=bool(scene.finite_element_bodies())),
        _recovery(scene),
        *_never(scene),
    )
    on = {e.name for e in effects if e.on}
    carried = carried_motions(scene, on) | {
        f"{name}.{interface.name}": MOTIONS
        for name, body in asymmetric.items()
        for interface in body.interfaces
    }
    if level is None:
        level = "harmonic" if scene.model.level == "auto" else scene.model.level
    plans = {
        name: _body_plan(scene, body, "solid" if body.features else level, top[name], on, carried)
        for name, body in bodies.items()
    }
    for name, mesh_body in mesh_bodies.items():
        own = mesh_plan(mesh_body, top[name], on, carried)
        whole = None in own.solved_orders
        plans[name] = replace(own, solver=scene.model.solver) if whole else own
    return Plan(
        effects=effects,
        bodies=plans,
        carried=carried,
        speeds_rad_s=speeds,
        analyses=tuple((a.label, a.kind) for a in scene.analyses),
        speeds_beyond=speeds_beyond(scene),
    )


def _asymmetric(*bodies: Mapping[str, AnyBody]) -> dict[str, AnyBody]:
    """Asymmetric bodies."""
    return {name: body for own in bodies for name, body in own.items() if is_asymmetric(body)}


def _are(names: Collection[str]) -> str:
    """Return the verb of a list of names."""
    return "is" if len(names) == 1 else "are"


def _rotation_effects(scene: Scene, *, turning: bool, solid: bool) -> tuple[Effect, ...]:
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
        if chosen and not solid and name != "gyroscopic":
            chosen, why = (False, f"{why}, but there is no solid body, and others have none")
        out.append(Effect(name=name, on=chosen, why=why, cost=cost))
    return tuple(out)


def _needs(scene: Scene) -> tuple[tuple[str, list[str], str, str, str], ...]:
    """Name of an effect, the entries that call for it, why they do, why none does, and its cost."""
    general = "general instead of Hermitian eigenproblems of the assembled system"
    order_0 = "circumferential order 0 of the bodies acted on: all matrices and modes once more"
    internal = scene.internal_damping().items()
    return (
        (
            "bearing_damping",
            _damped_joints(scene),
            "bearings or gears have damping",
            "no bearing or gear has damping",
            general,
        ),
        (
            "internal_damping",
            [name for name, d in internal if d.stiffness_coefficient_s or d.modal_ratio],
            "bodies have internal damping",
            "no body has internal damping",
            general,
        ),
        (
            "speed_dependent_bearings",
            [b.name for b in scene.bearings if b.speed_law is not None],
            "bearings have a speed law",
            "no bearing has a speed law",
            "critical speeds by root search instead of one linear eigenproblem",
        ),
        (
            "tilt",
            acting_on(scene, "tilt"),
            "something acts on the tilt of an interface",
            "nothing acts on the tilt of an interface",
            "2 constraint modes per interface that is acted on",
        ),
        (
            "axial",
            *_of_order_0(scene, "axial", "torsion", "joints act along the axis"),
            "nothing acts along the axis, and lateral motion does not couple to it" + _kept(scene),
            order_0,
        ),
        (
            "torsion",
            *_of_order_0(scene, "torsion", "axial", "bearings or gears act on torsion"),
            "nothing acts on torsion, and lateral motion does not couple to it" + _kept(scene),
            order_0,
        ),
    )


def _of_order_0(scene: Scene, own: str, other: str, reason: str) -> tuple[list[str], str]:
    """What calls for one of the two motions of order 0, and why: what acts on it, else the other.

    A body that moves along its axis turns about it too, freely if nothing acts on that.
    """
    acting = acting_on(scene, own)
    asked = getattr(scene.effects, other)
    beside = [] if asked == "off" else acting_on(scene, other)
    beside += [f"the scene says {other} on"] if asked == "on" and not beside else []
    if acting or not beside:
        return acting, reason
    return beside, f"free beside {other}: nothing acts on it, but order 0 is carried whole"


def _called_for(scene: Scene) -> tuple[Effect, ...]:
    """Effects that some entries of the scene call for."""
    out = []
    for name, needed, reason, absent, cost in _needs(scene):
        asked, listed = getattr(scene.effects, name), ", ".join(needed)
        if asked == "off":
            why = "the scene says off" + (f", though {reason} ({listed})" if needed else "")
        elif asked == "on" and not needed:
            why = "the scene says on"
        else:
            why = f"{reason}: {listed}" if needed else absent
        on = asked != "off" and (bool(needed) or asked == "on")
        out.append(Effect(name=name, on=on, why=why, cost=cost))
    return tuple(out)


def _static_loads(scene: Scene) -> tuple[Effect, ...]:
    """Tables over the load, where the scene has any."""
    case, bearings = load_case(scene), ", ".join(loaded_bearings(scene))
    if case is None:
        return ()
    why = (
        f"tables over the load are read at the static loads of {case.label!r}, at each of their "
        f"speeds: {bearings}"
    )
    cost = "static solutions at the speeds of the tables until loads and coefficients agree"
    return (Effect(name="static_loads", on=True, why=why, cost=cost),)


def _joints(bodies: Mapping[str, Body | MeshedBody], level: str) -> tuple[Effect, ...]:
    """Sections that are parted, where the scene has any."""
    named = ", ".join(name for name, body in bodies.items() if body.joints)
    if not named:
        return ()
    why = f"sections are parted, with layers of springs between them: {named}"
    if level == "beam":
        why = (
            f"beams are bonded where sections are joined, and their stiffness spreads behind a "
            f"step at 45 degrees; neither pressure nor lift of the faces is known: {named}"
        )
    cost = "per order, with pressed faces: 2 factorisations, a solution per point of the faces"
    return (Effect(name="joints", on=level != "beam", why=why, cost=cost),)


def _damped_joints(scene: Scene) -> list[str]:
    """Names of bearings and gears that have damping."""
    keys = [k for k in BearingSpec.model_fields if "damping" in k]
    tables = {
        name
        for name, law in scene.speed_laws.items()
        if isinstance(law, AbsoluteLaw) and law.table().damping_n_s_per_m.any()
    }
    found = [
        b.name
        for b in scene.bearings
        if b.speed_law in tables or any(np.any(np.asarray(getattr(b, key))) for key in keys)
    ]
    if scene.effects.torsion != "off":  # which leaves out the gears
        found += [g.name for g in scene.gears if g.mesh_damping_n_s_per_m]
    return found


def _estimates(scene: Scene, asymmetric: list[str], *, meshed: bool) -> tuple[Effect, ...]:
    """Error estimates, the comparison of couplings shown beside them, and the checks."""
    asked = scene.model.estimates == "on"
    why = "frequencies, critical speeds and peaks get one" if asked else "the scene says off"
    if not meshed:
        why = "there is no meshed body"
    estimate = Effect(
        name="error_estimate",
        on=asked and meshed,
        why=why,
        cost="per order and round: matrices and 1 factorisation with elements one order higher, "
        "3 solutions per column of the basis",
    )
    checks = Effect(
        name="checks",
        on=meshed,
        why="every run checks its bodies" if meshed else "there is no meshed body",
        cost="per order: 1 factorisation more",
    )
    wanted = asked and bool(scene.bodies) and scene.model.compare_coupling == "on"
    joined = bool(places_of_joints(scene))
    if wanted and asymmetric:
        named = ", ".join(asymmetric)
        why = f"compared where all bodies are symmetric, which {named} {_are(asymmetric)} not"
    elif wanted:
        why = "joints act on interfaces" if joined else "no joint acts on an interface"
    elif scene.model.compare_coupling == "off":
        why = "the scene says off"
    elif asked and meshed:
        why = "no meshed body has a profile"
    coupling = Effect(
        name="coupling_comparison",
        on=wanted and joined and not asymmetric,
        why=why,
        cost="2 coarse reductions per body, rigid and distributing interfaces exchanged",
    )
    return estimate, coupling, checks


def _recovery(scene: Scene) -> Effect:
    """Fields of the bodies whose displacement and stress are wanted."""
    asked = recovered_bodies(scene)
    why = "no analysis of kind recovery"
    if asked:
        why = f"displacement and stress in the solid are wanted: {', '.join(asked)}"
    return Effect(
        name="recovery",
        on=bool(asked),
        why=why,
        cost="per body asked for: its last reduction once more, without error estimate and checks",
    )


def _kept(scene: Scene) -> str:
    """Which rigid and imported bodies keep uz and rz all the same."""
    names = [name for name, body in scene.rigid_bodies.items() if is_off_axis(body)]
    said = f", but in {', '.join(names)}: the centre of gravity is off the axis" if names else ""
    standing = ", ".join(name for name, b in scene.mesh_bodies.items() if b.may_have_any_shape)
    said += f"; {standing}: a mesh that stands still moves in all directions" if standing else ""
    given = ", ".join(scene.imported)
    return said + (f"; {given}: an imported body keeps all motions of its file" if given else "")


def _refuse_kinds(scene: Scene, asymmetric: list[str]) -> None:
    """Refuse analyses that are for other bodies than those of the scene.

    Raises AnalysisError.
    """
    wanted = "asymmetric" if asymmetric else "even"
    for k, analysis in enumerate(scene.analyses):
        if asymmetric and analysis.kind == "run_up" and analysis.compare_flexible:
            raise AnalysisError(
                f"analyses[{k}].compare_flexible: holds bodies rigid in turn, which needs "
                f"symmetric bodies, and {', '.join(asymmetric)} {_are(asymmetric)} asymmetric; "
                "leave it out"
            )
        if analysis.kind == "static":
            _refuse_static(scene, f"analyses[{k}]", analysis, asymmetric)
        if analysis.of_bodies in ("any", wanted):
            continue
        where = f"analyses[{k}].kind: {analysis.kind!r} is"
        if not asymmetric:
            raise AnalysisError(
                f'{where} for asymmetric bodies; here all are symmetric: take "unbalance_response"'
            )
        known = sorted(kind for kind, spec in KINDS.items() if spec.of_bodies != "even")
        raise AnalysisError(
            f"{where} for symmetric bodies, and {', '.join(asymmetric)} {_are(asymmetric)} "
            "asymmetric: in fixed axes the matrices change with the angle; "
            f"allowed are {', '.join(known)} (every run has critical speeds, unstable ranges "
            "and diagrams in both frames)"
        )


def _refuse_static(scene: Scene, where: str, analysis: StaticSpec, asymmetric: list[str]) -> None:
    """Refuse what static loads of asymmetric bodies can't be, or of others."""
    if not asymmetric:
        if analysis.angles_deg != (0.0,):
            raise AnalysisError(
                f"{where}.angles_deg: is of asymmetric bodies; here all are symmetric: leave it out"
            )
        return
    named = f"{', '.join(asymmetric)} {_are(asymmetric)} asymmetric"
    if any(analysis.speeds_rpm):
        raise AnalysisError(
            f"{where}.speeds_rpm: {named}, so that weight shakes them twice per turn: static is at "
            'rest, at angles_deg; at speed "asymmetric_response" with gravity_m_per_s2 has mean '
            "deflection and shaking"
        )
    if load_case(scene) is not None:
        raise AnalysisError(
            f"{where}: {named}, so that their bearings have no one load; give load_n in place of "
            "load_from"
        )


def _asymmetry(names: list[str]) -> Effect:
    """Asymmetric bodies."""
    why = "all rotors are axisymmetric"
    if names:
        why = f"{', '.join(names)} asymmetric: computed in the rotating frame"
    return Effect(
        name="asymmetry",
        on=bool(names),
        why=why,
        cost="the whole is meshed and solved, all six motions of every interface; harmonics of the "
        "turn where supports are anisotropic; a search for unstable ranges",
    )


def _never(scene: Scene) -> tuple[Effect, ...]:
    """What no scene of this version can ask for, said rather than kept silent."""
    reasons = {
        "nodal_diameter_modes": "order 2 and more of a body of revolution load no bearing",
        "change_of_shape": "prestress is computed on the undeformed body (hoop strain is checked)",
    }
    return tuple(Effect(name=name, on=False, why=why) for name, why in reasons.items())


def _body_plan(
    scene: Scene,
    body: Body,
    level: str,
    top_speed: float,
    on: set[str],
    carried: Mapping[str, tuple[str, ...]],
) -> BodyPlan:
    plan = base_plan(body, level, top_speed, carried)
    if level == "beam":
        return plan
    if is_asymmetric(body):
        plan = replace(plan, orders=(), shape="asymmetric")
    # of a sector the mass and the terms of the spin follow from the mass of one component
    assembled, problems = level == "harmonic", len(plan.solved_orders)
    matrices = 3 + ("gyroscopic" in on) if assembled else 2
    factorisations = eigenproblems = 1
    turning = top_speed > 0.0
    if "stress_stiffening" in on:
        # on a meridian the static solution needs the stiffness of order 0
        matrices += 3 if assembled else 1
        factorisations += 1 + turning
        eigenproblems += turning
    return replace(
        plan,
        resolution=choose_resolution(body, level, scene.model),
        matrices=matrices * problems,
        factorisations=factorisations * problems,
        eigenproblems=eigenproblems * problems,
    )
