"""What the joints and analyses of a scene refer to, checked before anything is meshed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from solidwhirl.core.errors import repeated, unknown
from solidwhirl.core.fields import alike_in_files
from solidwhirl.scene.bearing_physics import (
    AbsoluteLaw,
    RollingLawSpec,
    ShortBearingLawSpec,
    SqueezeFilmLawSpec,
)
from solidwhirl.scene.joints import BearingSpec, GearSpec, LoadTableLawSpec
from solidwhirl.scene.magnetic_bearings import MagneticLawSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.recovery_references import recovery_problems
from solidwhirl.scene_reading.analysis_checks import analysis_problems
from solidwhirl.scene_reading.weight import load_problems

# Keys that act on a motion, and its row in them.
_MOTIONS = {
    "ux": ("stiffness_n_per_m", "damping_n_s_per_m", 0),
    "uy": ("stiffness_n_per_m", "damping_n_s_per_m", 1),
    "uz": ("axial_stiffness_n_per_m", "axial_damping_n_s_per_m", 0),
    "rx": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 0),
    "ry": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 1),
    "rz": ("torsion_stiffness_n_m_per_rad", "torsion_damping_n_m_s_per_rad", 0),
}
# A gear's ratio and the speeds of its bodies must agree to this.
_SAME_RATIO = 1e-9


def reference_problems(scene: Scene) -> list[str]:
    """What a scene names and does not have: one line each, which begins with the key."""
    places = scene.places()
    problems = list(_repeated_bearings(scene))
    problems += repeated("gears", [g.name for g in scene.gears])
    problems += repeated("analyses", [a.label for a in scene.analyses])
    problems += _alike_analyses([a.label for a in scene.analyses])
    for bearing in scene.bearings:
        where = bearing.key
        problems += [f"{where}.{text}" for text in _end_problems(bearing, places)]
        problems += [f"{where}.rigid: {text}" for text in _rigid_problems(bearing)]
        problems += [f"{where}.{text}" for text in _law_problems(scene, bearing)]
        problems += [f"{where}.{text}" for text in _wound_problems(scene, bearing)]
    problems += _load_problems(scene)
    for k, gear in enumerate(scene.gears):
        problems += [f"gears[{k}].{text}" for text in _gear_problems(scene, gear, places)]
    problems += [*analysis_problems(scene), *_case_problems(scene), *recovery_problems(scene)]
    return list(dict.fromkeys(problems)) or load_problems(scene)


def _repeated_bearings(scene: Scene) -> Iterator[str]:
    """Entries may stand for several bearings, whose names follow from it."""
    first: dict[str, str] = {}
    for bearing in scene.bearings:
        if bearing.name in first:
            taken = first[bearing.name]
            yield f"{bearing.key}.name: {bearing.name!r} is the name of {taken} too"
        first.setdefault(bearing.name, bearing.key)


def _case_problems(scene: Scene) -> Iterator[str]:
    """Sets of bearing laws of analyses that name what is not there, or can not be."""
    bearings = {b.name: b for b in scene.bearings}
    for a, analysis in enumerate(scene.analyses):
        for k, case in enumerate(analysis.cases if analysis.kind == "api617" else ()):
            where = f"analyses[{a}].cases[{k}].laws"
            for name, law in case.laws.items():
                if name not in bearings:
                    yield f"{where}: {unknown('bearing', name, list(bearings))}"
                elif bearings[name].speed_law is None:
                    yield f"{where}.{name}: the bearing has no speed_law in the scene; give it one"
                else:
                    other = bearings[name].model_copy(update={"speed_law": law})
                    found = _law_problems(scene, other)
                    yield from (f"{where}.{name}: {t.removeprefix('speed_law: ')}" for t in found)


def _alike_analyses(names: Sequence[str]) -> Iterator[str]:
    """Analyses whose files some systems take for the same."""
    alike = alike_in_files(list(dict.fromkeys(names)))
    if alike:
        at = names.index(alike[1])
        yield (
            f"analyses[{at}].name: {alike[1]!r} differs from {alike[0]!r} in upper and lower case "
            "only, and each has files; choose another name for one"
        )


def _end_problems(joint: BearingSpec | GearSpec, places: list[str]) -> Iterator[str]:
    ground = ["ground"] if isinstance(joint, BearingSpec) else []
    ends = [("first", joint.first, []), ("second", joint.second, ground)]
    if isinstance(joint, BearingSpec) and joint.sensor is not None:
        ends.append(("sensor", joint.sensor, []))
    for key, end, more in ends:
        if end not in [*places, *more]:
            none = "none, since no body has an interface"
            yield f"{key}: {unknown('interface', end, [*places, *more], none)}"
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
    if bearing.sensor is not None and not isinstance(scene.law_of(bearing), MagneticLawSpec):
        yield "sensor: a bearing has one if its speed_law is of kind magnetic"
    if bearing.speed_law is None:
        return
    if bearing.speed_law not in scene.speed_laws:
        none = "none, since the scene has no [speed_laws]"
        known = list(scene.speed_laws)
        yield f"speed_law: {unknown('speed law', bearing.speed_law, known, none)}"
        return
    own = [np.array(m) for m in (bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)]
    law = scene.speed_laws[bearing.speed_law]
    if isinstance(law, AbsoluteLaw):
        if any(m.any() for m in own):
            yield (
                f"speed_law: {bearing.speed_law!r} is a table of absolute values; leave out "
                "stiffness_n_per_m and damping_n_s_per_m"
            )
    elif any(m[0, 1] or m[1, 0] for m in own):
        yield f"speed_law: {bearing.speed_law!r} scales x and y only; cross terms must be 0"
    held = law.held if isinstance(law, AbsoluteLaw) else ()
    if {"ux", "uy"} & set(bearing.rigid):
        yield "speed_law: ux or uy is rigid; give one of the two"
    for key, motion in (("axial_stiffness_n_per_m", "uz"), ("tilt_stiffness_n_m_per_rad", "rx")):
        again = np.any(np.asarray(getattr(bearing, key))) and isinstance(law, RollingLawSpec)
        if motion in held and (again or motion in bearing.rigid):
            yield (
                f"{key if again else 'rigid'}: the law {bearing.speed_law!r} holds {motion} too; "
                "leave it out here, or out of the motions of the law"
            )
    ratios = scene.speed_ratios()
    body = bearing.first.partition(".")[0]
    if ratios.get(body) == 0.0 and not isinstance(law, MagneticLawSpec | SqueezeFilmLawSpec):
        yield (
            f"first: {body!r} does not turn, and the law takes the speed of the first end; put "
            "the end on the turning body first"
        )
    backward = ratios.get(body, 0.0) < 0.0 and bearing.cross_coupling == "with_spin"
    if isinstance(law, ShortBearingLawSpec) and backward and all(law.load_n):
        yield (
            f"speed_law: {body!r} turns backward, and the film {bearing.speed_law!r} is mirrored "
            "for that, which is right for a load_n along x or y only"
        )


def _load_problems(scene: Scene) -> Iterator[str]:
    """Tables over the load without a static analysis, or with several."""
    cases = [a.label for a in scene.analyses if a.kind == "static"]
    named = {n: w.load_from for n, w in scene.speed_laws.items() if isinstance(w, LoadTableLawSpec)}
    for law, case in named.items():
        key = f"speed_laws.{law}.load_from"
        if case not in cases:
            none = "none, since the scene has no [[analyses]] of kind 'static'"
            yield f"{key}: {unknown('static analysis', case, cases, none)}"
        elif case != next(iter(named.values())):
            yield (
                f"{key}: {case!r}, but that of {next(iter(named))!r} is "
                f"{next(iter(named.values()))!r}; bearings share their loads, so that all tables "
                "are read at those of one static analysis"
            )


def _wound_problems(scene: Scene, bearing: BearingSpec) -> Iterator[str]:
    """Joints of rz between bodies that turn at different speeds."""
    ratios = scene.speed_ratios()
    bodies = [end.partition(".")[0] for end in (bearing.first, bearing.second)]
    if not set(bodies) <= set(ratios):
        return
    first, second = (ratios[body] for body in bodies)
    if abs(first - second) <= _SAME_RATIO * max(abs(first), abs(second)):
        return
    keys = ["rigid"] if "rz" in bearing.rigid else []
    keys += ["torsion_stiffness_n_m_per_rad"] if bearing.torsion_stiffness_n_m_per_rad else []
    for key in keys:
        yield (
            f"{key}: {bearing.name!r} ties rz of {bodies[0]!r}, speed_ratio {first:.12g}, to "
            f"{bodies[1]!r}, {second:.12g}, and would wind up; allowed is between bodies of one "
            "speed_ratio, and [[gears]] between others"
        )


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
            f"ratio: {gear.ratio:.12g}, but {bodies[0]!r} has speed_ratio {first:.12g} and "
            f"{bodies[1]!r} {second:.12g}, which is "
            f"{second / first if first else float('inf'):.12g}"
        )
