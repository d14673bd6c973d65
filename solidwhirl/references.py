"""What the bearings of a scene refer to, checked before anything is meshed."""

from __future__ import annotations

import difflib
from collections.abc import Iterator

import numpy as np

from solidwhirl.scene import BearingSpec, Scene

# Keys that act on a motion, and its row in them.
_MOTIONS = {
    "ux": ("stiffness_n_per_m", "damping_n_s_per_m", 0),
    "uy": ("stiffness_n_per_m", "damping_n_s_per_m", 1),
    "uz": ("axial_stiffness_n_per_m", "axial_damping_n_s_per_m", 0),
    "rx": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 0),
    "ry": ("tilt_stiffness_n_m_per_rad", "tilt_damping_n_m_s_per_rad", 1),
    "rz": ("torsion_stiffness_n_m_per_rad", "torsion_damping_n_m_s_per_rad", 0),
}


def bearing_problems(scene: Scene) -> list[str]:
    """Bearings of a scene that can not be: one line each, which begins with the key.

    Parameters
    ----------
    scene
        Its bearings may join interfaces of its bodies, or one of them and the ground.
    """
    known = [f"{name}.{i.name}" for name, body in scene.bodies.items() for i in body.interfaces]
    names: dict[str, int] = {}
    problems = []
    for k, bearing in enumerate(scene.bearings):
        where = f"bearings[{k}]"
        first = names.setdefault(bearing.name, k)
        if first != k:
            problems.append(f"{where}.name: {bearing.name!r} is the name of bearings[{first}] too")
        problems += [f"{where}.{text}" for text in _end_problems(bearing, known)]
        problems += [f"{where}.rigid: {text}" for text in _rigid_problems(bearing)]
    return problems


def _end_problems(bearing: BearingSpec, known: list[str]) -> Iterator[str]:
    for key, end, more in (("first", bearing.first, []), ("second", bearing.second, ["ground"])):
        allowed = [*known, *more]
        if end not in allowed:
            near = difflib.get_close_matches(end, allowed, n=1, cutoff=0.6)
            hint = f"did you mean {near[0]!r}? " if near else ""
            listed = ", ".join(allowed) or "none, since no body has an interface"
            yield f"{key}: no interface {end!r}; {hint}allowed are {listed}"
    if bearing.first == bearing.second:
        yield f"second: {bearing.second!r} is the first end too; the ends must differ"


def _rigid_problems(bearing: BearingSpec) -> Iterator[str]:
    for component in dict.fromkeys(bearing.rigid):
        *keys, at = _MOTIONS[component]
        for key in keys:
            matrix = np.atleast_2d(np.asarray(getattr(bearing, key), dtype=float))
            if matrix[at].any() or matrix[:, at].any():
                yield f"{component} is rigid and {key} acts on it; give one of the two"
