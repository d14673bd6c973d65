"""What the joints and analyses of a scene refer to, checked before anything is meshed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import AnalysisSpec, UnbalanceSpec
from solidwhirl.scene_joints import BearingSpec, GearSpec

# Keys that act on a motion, and its row in them.
_MOTIONS = {
    "ux": ("stiffness_n_per_m", "damping_n_s_per_m", 0),
    "uy": ("stiffness_n_per_m", "damping_n_s_per_m", 1),
    "uz": ("axial_stiffness_n_per_m", "axial_damping_n_s_per_m", 0),
    "rx": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 0),
    "ry": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 1),
    "rz": ("torsion_stiffness_n_m_per_rad", "torsion_damping_n_m_s_per_rad", 0),
}
# Keys of analyses by what they name.
_PLACES = ("at", "observe", "excite", "places", "inputs", "outputs", "drives")
_BODIES = ("bodies", "excited_by", "shaft", "compare_flexible")
_BEARINGS = ("bearings", "mount")
# A gear's ratio and the speeds of its bodies must agree to this.
_SAME_RATIO = 1e-9


def reference_problems(scene: Scene) -> list[str]:
    """What a scene names and does not have: one line each, which begins with the key.

    Parameters
    ----------
    scene
        Its bearings and gears may join interfaces of its bodies, or one of them and the ground.
    """
    places = [f"{body}.{i}" for body, names in scene.interface_names().items() for i in names]
    problems = list(_repeated("bearings", [b.name for b in scene.bearings]))
    problems += _repeated("gears", [g.name for g in scene.gears])
    problems += _repeated("analyses", [a.label for a in scene.analyses])
    for k, bearing in enumerate(scene.bearings):
        where = f"bearings[{k}]"
        problems += [f"{where}.{text}" for text in _end_problems(bearing, places)]
        problems += [f"{where}.rigid: {text}" for text in _rigid_problems(bearing)]
        problems += [f"{where}.{text}" for text in _law_problems(scene, bearing)]
    for k, gear in enumerate(scene.gears):
        problems += [f"gears[{k}].{text}" for text in _gear_problems(scene, gear, places)]
    for k, analysis in enumerate(scene.analyses):
        found = _analysis_problems(scene, analysis, places)
        problems += [f"analyses[{k}].{text}" for text in found]
    return problems


def _repeated(key: str, names: Sequence[str]) -> Iterator[str]:
    first: dict[str, int] = {}
    for k, name in enumerate(names):
        if first.setdefault(name, k) != k:
            yield f"{key}[{k}].name: {name!r} is the name of {key}[{first[name]}] too"


def _unknown(kind: str, name: str, allowed: Sequence[str], none: str) -> str:
    near = difflib.get_close_matches(name, allowed, n=1, cutoff=0.6)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"no {kind} {name!r}; {hint}allowed are {', '.join(allowed) or none}"


def _end_problems(joint: BearingSpec | GearSpec, places: list[str]) -> Iterator[str]:
    ground = ["ground"] if isinstance(joint, BearingSpec) else []
    for key, end, more in (("first", joint.first, []), ("second", joint.second, ground)):
        if end not in [*places, *more]:
            none = "none, since no body has an interface"
            yield f"{key}: {_unknown('interface', end, [*places, *more], none)}"
    if joint.first == joint.second:
        yield f"second: {joint.second!r} is the first end too; the ends must differ"


def _rigid_problems(bearing: BearingSpec) -> Iterator[str]:
    for component in dict.fromkeys(bearing.rigid):
        *keys, at = _MOTIONS[component]
        for key in keys:
            matrix = np.atleast_2d(np.asarray(getattr(bearing, key), dtype=float))
            if matrix[at].any() or matrix[:, at].any():
                yield f"{component} is rigid and {key} acts on it; give one of the two"


def _law_problems(scene: Scene, bearing: BearingSpec) -> Iterator[str]:
    if bearing.speed_law is None:
        return
    if bearing.speed_law not in scene.speed_laws:
        none = "none, since the scene has no [speed_laws]"
        known = list(scene.speed_laws)
        yield f"speed_law: {_unknown('speed law', bearing.speed_law, known, none)}"
        return
    own = [np.array(m) for m in (bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)]
    if scene.speed_laws[bearing.speed_law].kind == "table":
        if any(m.any() for m in own):
            yield (
                f"speed_law: {bearing.speed_law!r} is a table of absolute values; leave out "
                "stiffness_n_per_m and damping_n_s_per_m"
            )
    elif any(m[0, 1] or m[1, 0] for m in own):
        yield f"speed_law: {bearing.speed_law!r} scales x and y only; cross terms must be 0"
    if {"ux", "uy"} & set(bearing.rigid):
        yield "speed_law: ux or uy is rigid; give one of the two"


def _gear_problems(scene: Scene, gear: GearSpec, places: list[str]) -> Iterator[str]:
    found = list(_end_problems(gear, places))
    yield from found
    if found:
        return
    bodies = [end.partition(".")[0] for end in (gear.first, gear.second)]
    if bodies[0] == bodies[1]:
        yield f"second: both seats are on body {bodies[0]!r}; a gear joins two"
        return
    first, second = (scene.speed_ratio(body) for body in bodies)
    if abs(second - gear.ratio * first) > _SAME_RATIO * abs(second):
        yield (
            f"ratio: {gear.ratio:g}, but {bodies[0]!r} has speed_ratio {first:g} and "
            f"{bodies[1]!r} {second:g}, which is {second / first if first else float('inf'):g}"
        )


def _analysis_problems(scene: Scene, spec: AnalysisSpec, places: list[str]) -> Iterator[str]:
    bodies = list(scene.interface_names())
    bearings = [b.name for b in scene.bearings]
    for key, value in _named(spec):
        kind = key.rpartition(".")[2].partition("[")[0]
        if kind in _PLACES and value not in places:
            yield f"{key}: {_unknown('interface', value, places, 'none')}"
        elif kind in _BODIES and value not in bodies:
            yield f"{key}: {_unknown('body', value, bodies, 'none')}"
        elif kind in _BEARINGS and value not in bearings:
            yield f"{key}: {_unknown('bearing', value, bearings, 'none')}"
    unbalances: tuple[UnbalanceSpec, ...] = getattr(spec, "unbalances", ())
    for k, unbalance in enumerate(unbalances):
        body = unbalance.at.partition(".")[0]
        if body in bodies and scene.speed_ratio(body) == 0.0:
            yield f"unbalances[{k}].at: {body!r} does not turn; an unbalance needs a turning body"
    excited = getattr(spec, "excited_by", None)
    if excited in bodies and scene.speed_ratio(excited) == 0.0:
        yield f"excited_by: {excited!r} does not turn"


def _named(record: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Keys of a record that name something, with the name."""
    for key in type(record).model_fields:
        if key in ("name", "kind", "direction"):
            continue
        yield from _texts(getattr(record, key), f"{prefix}{key}")


def _texts(value: Any, key: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, tuple):
        for k, item in enumerate(value):
            yield from _texts(item, f"{key}[{k}]")
    elif hasattr(type(value), "model_fields"):
        yield from _named(value, f"{key}.")


def places_used(specs: Iterable[AnalysisSpec]) -> tuple[str, ...]:
    """Interfaces that analyses name, each once."""
    found: dict[str, None] = {}
    for spec in specs:
        for key, value in _named(spec):
            if key.rpartition(".")[2].partition("[")[0] in _PLACES:
                found[value] = None
    return tuple(found)
