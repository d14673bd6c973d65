"""Whether something carries the weight and the loads of a scene, before anything is computed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from solidwhirl.geometry import GeometryError, mass_properties
from solidwhirl.model.bodies import build_bodies, known_material, scene_materials
from solidwhirl.rotordyn.core.arrays import FloatArray, motion_at
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import BeamSpec, BearingSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import EFFECT_OF, carried_motions, is_off_axis

if TYPE_CHECKING:
    from solidwhirl.analyses.responses.static import StaticForceSpec
    from solidwhirl.rotordyn import AssembledSystem

# What is smaller than this is rounding.
_ZERO = 1e-9
# ux, uy, rx, ry among the motions of a body.
_LATERAL = [0, 1, 3, 4]
# Stiffness of a bearing across the axis, rows of two.
Lateral = Callable[[Scene, BearingSpec], FloatArray]


def load_problems(scene: Scene) -> list[str]:
    """What carries no weight or no given load: one line each, which begins with the key.

    `scene`: without other problems. Bodies are taken as rigid here: nothing else can be free of
    strain. Imported bodies may be held inside: `refuse_unsupported` looks at them and at bodies of
    meshes.
    """
    problems = []
    for k, spec in enumerate(scene.analyses):
        if spec.kind == "run_up" and spec.gravity_m_per_s2 is not None:
            free = _free_motions(scene, _at_rest)
        elif spec.kind == "static":
            free = _free_motions(scene, _at_any_speed)
            pushed = free.pushed_by(scene, spec.forces)
            problems += [f"analyses[{k}].forces: nothing holds {pushed}"] if pushed else []
        else:
            continue
        where = f"analyses[{k}].gravity_m_per_s2"
        fallen = _weight_problems(scene, spec.gravity_m_per_s2 or (0.0, 0.0, 0.0), free)
        problems += [f"{where}: {text}" for text in fallen]
    return problems


def free_lateral_groups(scene: Scene) -> list[tuple[tuple[str, ...], tuple[str, ...], int]]:
    """Bodies that move together laterally at rest with no joint resisting, before any is computed.

    Each with the bearings that hold it against what does not move, and the number of motions.
    Bodies are taken as rigid, and imported ones as held; of meshes no height is known.
    """
    free = _free_motions(scene, _at_rest)
    lateral = {name: free.of(name)[_LATERAL] for name in free.names}
    moving = [name for name, own in lateral.items() if np.abs(own).max(initial=0.0) > _ZERO]
    joints = [
        (b.name, {end.partition(".")[0] for end in (b.first, b.second)})
        for b in scene.bearings
        if {"ux", "uy", "rx", "ry"} & set(b.rigid)
        or _at_rest(scene, b).any()
        or np.any(b.tilt_stiffness_n_m_per_rad)
    ]
    meshes = [g for g in scene.gears if g.line_of_action_deg is not None]
    joints += [(g.name, {end.partition(".")[0] for end in (g.first, g.second)}) for g in meshes]
    groups: list[set[str]] = []
    for name in moving:
        joined = {name}.union(*(ends for _, ends in joints if name in ends)) & set(moving)
        apart = [group for group in groups if not group & joined]
        groups = [*apart, joined.union(*(group for group in groups if group & joined))]
    return [
        (
            tuple(name for name in moving if name in group),
            tuple(n for n, ends in joints if ends & group and ends - set(moving)),
            _rank(np.vstack([lateral[name] for name in moving if name in group])),
        )
        for group in groups
    ]


def _rank(parts: FloatArray) -> int:
    sizes = np.linalg.svd(parts, compute_uv=False)
    return int((sizes > _ZERO * sizes.max(initial=0.0)).sum())


def refuse_unsupported(scene: Scene, system: AssembledSystem) -> None:
    """Refuse an analysis under a weight that the assembled system does not carry.

    Raises AnalysisError: something falls.
    """
    from solidwhirl.rotordyn.modes.free_motions import unsupported_bodies

    for at, spec in enumerate(scene.analyses):
        if spec.kind != "run_up" and spec.kind != "static":
            continue
        gravity = spec.gravity_m_per_s2
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


class _Free(NamedTuple):
    """Rigid motions that no joint resists: ux to rz of each body about the origin, (6 b, k)."""

    names: Sequence[str]
    motions: FloatArray

    def of(self, name: str) -> FloatArray:
        """Part of one body, (6, k)."""
        at = 6 * self.names.index(name)
        return self.motions[at : at + 6]

    def pushed_by(self, scene: Scene, forces: Sequence[StaticForceSpec]) -> str:
        """What bodies given forces move and how; empty if they are held."""
        heights, load = _heights(scene), np.zeros(len(self.motions))
        for force in forces:
            at = 6 * self.names.index(force.at.partition(".")[0])
            wrench = np.array([*force.force_n, *force.moment_n_m])
            load[at : at + 6] += motion_at(np.array([0.0, 0.0, heights[force.at]])).T @ wrench
        work = load @ self.motions
        if np.abs(work).max(initial=0.0) <= _ZERO * np.abs(load).max(initial=0.0):
            return ""
        falling = (self.motions @ work).reshape(-1, 6)
        falling[np.abs(falling) <= _ZERO * np.abs(falling).max()] = 0.0
        return ", ".join(
            f"{name!r} in {', '.join(m for m, v in zip(MOTIONS, own, strict=True) if v)}"
            for name, own in zip(self.names, falling, strict=True)
            if own.any()
        )


def _weight_problems(
    scene: Scene, gravity_m_per_s2: tuple[float, float, float], free: _Free
) -> Iterator[str]:
    centres = _centres(scene)
    for k, (axis, pull) in enumerate(zip("xyz", gravity_m_per_s2, strict=True)):
        if not pull:
            continue
        works = {
            name: motion_at(np.array([0.0, 0.0, centres[name]]))[k] @ free.of(name)
            for name in free.names
        }
        fallen = tuple(n for n, own in works.items() if np.abs(own).max(initial=0.0) > _ZERO)
        if fallen:
            yield _problem(fallen, axis)


def _free_motions(scene: Scene, lateral: Lateral) -> _Free:
    """Rigid motions without strain in joints; imported bodies stand still, unturned ones too."""
    names = list(scene.interface_names())
    turning = _turning(scene)
    held = [
        6 * k + at
        for k, name in enumerate(names)
        for at in range(6)
        if name in scene.imported or (at == MOTIONS.index("rz") and name not in turning)
    ]
    rows = [np.eye(6 * len(names))[held]]
    rows += [_held_by(scene, names, bearing, lateral) for bearing in scene.bearings]
    rows += [_meshing(scene, names)] if scene.gears else []
    matrix = np.vstack(rows)
    _, sizes, turned = np.linalg.svd(matrix, full_matrices=True)
    rank = int((sizes > _ZERO * sizes.max(initial=1.0)).sum())
    return _Free(names, turned[rank:].T)


def _turning(scene: Scene) -> set[str]:
    """Bodies with torsion."""
    on = {effect for effect in set(EFFECT_OF.values()) if getattr(scene.effects, effect) != "off"}
    carried = carried_motions(scene, on).items()
    found = {place.partition(".")[0] for place, motions in carried if "rz" in motions}
    return found | {name for name, body in scene.rigid_bodies.items() if is_off_axis(body)}


def _held_by(
    scene: Scene, names: Sequence[str], bearing: BearingSpec, lateral: Lateral
) -> FloatArray:
    """What a bearing resists, in rows of unit size."""
    motion = _seat(scene, names, bearing.first) - _seat(scene, names, bearing.second)
    tilt = np.array(bearing.tilt_stiffness_n_m_per_rad)
    rows = [
        motion[[MOTIONS.index(m) for m in bearing.rigid]],
        lateral(scene, bearing) @ motion[:2],
        tilt @ motion[3:5],
        bearing.axial_stiffness_n_per_m * motion[2:3],
        bearing.torsion_stiffness_n_m_per_rad * motion[5:6],
    ]
    every = np.vstack(rows)
    sizes = np.linalg.norm(every, axis=1, keepdims=True)
    return np.divide(every, sizes, out=np.zeros_like(every), where=sizes > 0.0)


def _seat(scene: Scene, names: Sequence[str], end: str) -> FloatArray:
    """Motion of an interface over that of all bodies, (6, 6 b); the ground has none."""
    row, body = np.zeros((6, 6 * len(names))), end.partition(".")[0]
    if body in names:
        at = 6 * names.index(body)
        row[:, at : at + 6] = motion_at(np.array([0.0, 0.0, _heights(scene)[end]]))
    return row


def _meshing(scene: Scene, names: Sequence[str]) -> FloatArray:
    """Motion of teeth, a row for each gear."""
    rows = []
    for gear in scene.gears:
        first, second = (_seat(scene, names, end) for end in (gear.first, gear.second))
        radius = gear.base_radius_first_m or 1.0
        row = radius * (first[5] - second[5] / gear.ratio)
        if gear.line_of_action_deg is not None:
            angle = np.radians(gear.line_of_action_deg)
            row = row + np.array([np.cos(angle), np.sin(angle)]) @ (first - second)[:2]
        rows.append(row)
    return np.array(rows)


def _at_rest(scene: Scene, bearing: BearingSpec) -> FloatArray:
    """Stiffness where a run begins."""
    return _tabled(scene, bearing)[:2]


def _at_any_speed(scene: Scene, bearing: BearingSpec) -> FloatArray:
    """Stiffness at all speeds of a table, one below the other."""
    return _tabled(scene, bearing)


def _tabled(scene: Scene, bearing: BearingSpec) -> FloatArray:
    law = scene.law_of(bearing)
    if isinstance(law, AbsoluteLaw):
        return law.table().stiffness_n_per_m.reshape(-1, 2)
    return np.array(bearing.stiffness_n_per_m)


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
    with suppress(GeometryError, ZeroDivisionError):  # told where bodies are built
        found |= {n: _beam_centre(scene, n, beam) for n, beam in scene.beams.items()}
        bodies = build_bodies(scene)
        found |= {n: mass_properties(b).center_of_gravity_m[2] for n, b in bodies.items()}
    return found


def _beam_centre(scene: Scene, name: str, beam: BeamSpec) -> float:
    """Centre of gravity of a beam with its disks along the axis, m."""
    material = known_material(scene_materials(scene), beam.material, f"beams.{name}")
    ends, (outer, inner) = np.array(beam.stations_m), np.array(beam.section_radii_m)
    areas = np.pi * (outer**2 - inner**2)
    masses = [*(material.density_kg_per_m3 * areas * np.diff(ends))]
    masses += [d.mass_kg for d in beam.disks]
    places = [*(0.5 * (ends[1:] + ends[:-1])), *(d.at_m for d in beam.disks)]
    return float(np.average(places, weights=masses))
