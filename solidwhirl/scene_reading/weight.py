"""Whether something carries the weight of the bodies of a scene, before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np

from solidwhirl.analyses.kinds.run_up import RunUpSpec
from solidwhirl.geometry import GeometryError, mass_properties
from solidwhirl.model.bodies import build_bodies
from solidwhirl.rotordyn import AnalysisError, AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.modes.free_motions import unsupported_bodies
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import EFFECT_OF, carried_motions, is_off_axis

# Row of the matrices of a bearing, translation and tilt in each plane.
_PLANES = {"x": (0, "ux", "ry"), "y": (1, "uy", "rx")}
# What is smaller than this is rounding.
_ZERO = 1e-9


def weight_problems(scene: Scene, gravity_m_per_s2: tuple[float, float, float]) -> Iterator[str]:
    """Yield what carries no weight, one line for each direction x, y, z.

    Bodies are taken as rigid here: nothing else can be free of strain. Imported bodies may be held
    inside: `refuse_unsupported` looks at them and at bodies of meshes.
    """
    for axis, pull in zip("xyz", gravity_m_per_s2, strict=True):
        free = _free_bodies(scene, axis) if pull else ()
        if free:
            yield _problem(free, axis)


def refuse_unsupported(scene: Scene, system: AssembledSystem) -> None:
    """Refuse a run-up under a weight that the assembled system does not carry.

    Raises AnalysisError: something falls.
    """
    for at, spec in enumerate(scene.analyses):
        gravity = spec.gravity_m_per_s2 if isinstance(spec, RunUpSpec) else None
        for axis, pull in zip("xyz", np.diag(gravity or (0.0, 0.0, 0.0)), strict=True):
            free = unsupported_bodies(system, pull) if pull.any() else ()
            if free:
                said = _problem(free, axis) + _turned(system, free)
                raise AnalysisError(f"analyses[{at}].gravity_m_per_s2: {said}")


def _problem(bodies: tuple[str, ...], axis: str) -> str:
    kind = "axial bearing" if axis == "z" else "bearing"
    named = ", ".join(repr(name) for name in bodies)
    return f"no {kind} carries the weight of {named} along {axis}"


def _turned(system: AssembledSystem, bodies: tuple[str, ...]) -> str:
    """What to do where the weight turns a body about the axis."""
    centres = {n: system.system.rotors[n].element.center_of_gravity_m for n in bodies}
    off = [n for n, centre in centres.items() if np.hypot(*centre[:2]) > 0.0]
    return (
        f"; the centre of gravity of {', '.join(repr(n) for n in off)} is off the axis: give the "
        "torsion stiffness of its coupling to a bearing (torsion_stiffness_n_m_per_rad)"
        if off
        else ""
    )


def _free_bodies(scene: Scene, axis: str) -> tuple[str, ...]:
    """Bodies whose weight does work on a rigid motion that no joint resists."""
    names = [n for n in _moving(scene, axis) if n not in scene.imported]
    rows = [_row(scene, names, bearing, kind) for bearing, kind in _holding(scene, axis)]
    matrix = np.array(rows).reshape(len(rows), 2 * len(names))
    if axis == "z":  # a body does not tilt along its axis
        matrix[:, 1::2] = 0.0
    _, sizes, turned = np.linalg.svd(matrix, full_matrices=True)
    free = turned[int((sizes > _ZERO * sizes.max(initial=1.0)).sum()) :]
    arms = _centres(scene) if axis != "z" else {}
    work = [free[:, 2 * k] + arms.get(n, 0.0) * free[:, 2 * k + 1] for k, n in enumerate(names)]
    return tuple(
        n for n, own in zip(names, work, strict=True) if np.abs(own).max(initial=0) > _ZERO
    )


def _moving(scene: Scene, axis: str) -> list[str]:
    """Bodies that can move along an axis at all."""
    if axis != "z":
        return list(scene.interface_names())
    on = {effect for effect in set(EFFECT_OF.values()) if getattr(scene.effects, effect) != "off"}
    found = {
        place.partition(".")[0] for place, m in carried_motions(scene, on).items() if "uz" in m
    }
    found |= {name for name, body in scene.rigid_bodies.items() if is_off_axis(body)}
    found |= {name for name, body in scene.mesh_bodies.items() if body.may_have_any_shape}
    return [name for name in scene.interface_names() if name in found]


def _holding(scene: Scene, axis: str) -> Iterator[tuple[BearingSpec, str]]:
    """Bearings that resist a "motion" along an axis, or a "tilt" in that plane."""
    for bearing in scene.bearings:
        if axis == "z":
            if bearing.axial_stiffness_n_per_m or "uz" in bearing.rigid:
                yield bearing, "motion"
            continue
        place, move, turn = _PLANES[axis]
        if move in bearing.rigid or _stiffness(scene, bearing)[place].any():
            yield bearing, "motion"
        if turn in bearing.rigid or np.array(bearing.tilt_stiffness_n_m_per_rad)[1 - place].any():
            yield bearing, "tilt"


def _stiffness(scene: Scene, bearing: BearingSpec) -> FloatArray:
    """Stiffness where a run begins, at rest."""
    law = scene.speed_laws.get(bearing.speed_law or "")
    if isinstance(law, AbsoluteLaw):
        return np.array(law.table().stiffness_n_per_m[0])
    return np.array(bearing.stiffness_n_per_m)


def _row(scene: Scene, names: list[str], bearing: BearingSpec, kind: str) -> FloatArray:
    """Motion between the ends of a bearing over translation and slope of all bodies."""
    row, heights = np.zeros(2 * len(names)), _heights(scene)
    for end, way in ((bearing.first, 1.0), (bearing.second, -1.0)):
        body = end.partition(".")[0]
        if body in names:
            own = (0.0, 1.0) if kind == "tilt" else (1.0, heights[end])
            row[2 * names.index(body) :][:2] += way * np.array(own)
    return row


def _heights(scene: Scene) -> Mapping[str, float]:
    """Places of the interfaces along the axis, m; those of meshes are all different."""
    found: dict[str, float] = {}
    for name, body in scene.bodies.items():
        for place in body.interfaces:
            ends = [z for z in (place.at_m, place.start_m, place.end_m) if z is not None]
            found[f"{name}.{place.name}"] = sum(ends) / len(ends)
    simple = {name: body.interfaces for name, body in scene.beams.items()}
    simple |= {name: body.interfaces for name, body in scene.rigid_bodies.items()}
    for name, places in simple.items():
        found |= {f"{name}.{own}": z for own, z in places.items()}
    others = (f"{name}.{i}" for name, own in scene.interface_names().items() for i in own)
    for k, other in enumerate(p for p in others if p not in found):
        found[other] = float(np.sqrt(2.0 + k))
    return found


def _centres(scene: Scene) -> Mapping[str, float]:
    """Centres of gravity along the axis, m; where not known they are amid the bearings."""
    heights = _heights(scene)
    found = {}
    for name in scene.interface_names():
        ends = [end for b in scene.bearings for end in (b.first, b.second)]
        own = [heights[end] for end in ends if end.partition(".")[0] == name]
        found[name] = sum(own) / len(own) if own else 0.0
    found |= {n: b.center_of_gravity_m[2] for n, b in scene.rigid_bodies.items()}
    with suppress(GeometryError):  # told where bodies are built
        bodies = build_bodies(scene)
        found |= {n: mass_properties(b).center_of_gravity_m[2] for n, b in bodies.items()}
    return found
