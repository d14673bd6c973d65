"""Scenes written in Python: a few functions that make what a scene file says.

Each returns plain data with the keys of the scene file, and takes every further key of its table by
name; `scene` puts them together and checks all of it at once, as `read_scene` does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.paths import place_steps, resolved_step
from solidwhirl.scene_reading.reader import parse_scene

__all__ = ["beam", "bearing", "body", "cylinder", "disk", "scene", "unbalance", "with_changes"]

Table = dict[str, Any]
Radius = float | tuple[float, float]


def cylinder(
    name: str, start_m: float, end_m: float, outer_radius_m: Radius, inner_radius_m: Radius = 0.0
) -> Table:
    """Return a section of a body of revolution, solid or hollow.

    Its name is unique within the body; a radius is a number, or one at each end.
    """
    return _table(
        name=name,
        start_m=start_m,
        end_m=end_m,
        outer_radius_m=outer_radius_m,
        inner_radius_m=inner_radius_m,
    )


def body(
    *sections: Table,
    interfaces: Mapping[str, float | Table],
    material: str = "steel",
    speed_ratio: float = 1.0,
    **keys: Any,
) -> Table:
    """Return a body of revolution, `[bodies.NAME]` of a scene file.

    Parameters
    ----------
    sections
        From `cylinder`.
    interfaces
        By name: the place of a cross-section along the axis in m, or a table for other kinds.
    speed_ratio
        Its speed over that of the reference shaft; negative turns the other way, 0 stands.
    keys
        Further ones, such as rigid_disks.
    """
    places = [
        _table(name=name, **at)
        if isinstance(at, Mapping)
        else _table(name=name, kind="section", at_m=at)
        for name, at in interfaces.items()
    ]
    return _table(
        speed_ratio=speed_ratio,
        material=material,
        sections=list(sections),
        interfaces=places,
        **keys,
    )


def beam(
    stations_m: npt.ArrayLike,
    outer_radius_m: npt.ArrayLike,
    interfaces: Mapping[str, float],
    *,
    material: str = "steel",
    speed_ratio: float = 1.0,
    disks: Sequence[Table] = (),
    **keys: Any,
) -> Table:
    """Return a shaft of Timoshenko beams, `[beams.NAME]` of a scene file.

    Parameters
    ----------
    stations_m
        Ends of the elements along the axis, rising.
    outer_radius_m
        One for all elements, or one for each.
    interfaces
        Places along the axis by name.
    disks
        From `disk`.
    keys
        Further ones, such as inner_radius_m.
    """
    return _table(
        speed_ratio=speed_ratio,
        material=material,
        stations_m=stations_m,
        outer_radius_m=np.atleast_1d(np.asarray(outer_radius_m, dtype=float)),
        interfaces=dict(interfaces),
        disks=list(disks),
        **keys,
    )


def disk(name: str, *, mass_kg: float, polar: float, diametral: float, **place: Any) -> Table:
    """Return a rigid disk.

    Parameters
    ----------
    polar, diametral
        Moments of inertia about the axis and across it, kg m².
    place
        at_m on a beam, interface="NAME" on a body.
    """
    return _table(
        name=name,
        mass_kg=mass_kg,
        polar_inertia_kg_m2=polar,
        diametral_inertia_kg_m2=diametral,
        **place,
    )


def bearing(
    name: str,
    first: str,
    second: str = "ground",
    stiffness_n_per_m: npt.ArrayLike | None = None,
    damping_n_s_per_m: npt.ArrayLike | None = None,
    **keys: Any,
) -> Table:
    """Return a bearing, an entry of `[[bearings]]`.

    Parameters
    ----------
    first, second
        "body.interface", or "ground".
    stiffness_n_per_m, damping_n_s_per_m
        A number, two along x and y, or 2 × 2.
    keys
        Further ones, such as rigid=("ux", "uy").
    """
    given = {"stiffness_n_per_m": stiffness_n_per_m, "damping_n_s_per_m": damping_n_s_per_m}
    some = {key: value for key, value in given.items() if value is not None}
    return _table(name=name, first=first, second=second, **some, **keys)


def unbalance(
    at: str, moment_kg_m: float | None = None, phase_deg: float = 0.0, **keys: Any
) -> Table:
    """Return an unbalance for an analysis.

    Parameters
    ----------
    at
        "body.interface".
    moment_kg_m
        Mass times its distance from the axis; None: by `grade` and `at_rpm`.
    phase_deg
        Angle from +x towards +y.
    """
    moment = {} if moment_kg_m is None else {"moment_kg_m": moment_kg_m}
    return _table(at=at, **moment, phase_deg=phase_deg, **keys)


def scene(
    name: str,
    *,
    bodies: Mapping[str, Table] | None = None,
    beams: Mapping[str, Table] | None = None,
    bearings: Sequence[Table] = (),
    speeds_rpm: npt.ArrayLike = (0.0,),
    branches: int = 8,
    model: Mapping[str, Any] | None = None,
    analyses: Sequence[Mapping[str, Any]] = (),
    **tables: Any,
) -> Scene:
    """Return a scene, checked as one from a file.

    Parameters
    ----------
    bodies, beams
        By name, from `body` and `beam`.
    bearings
        From `bearing`.
    speeds_rpm
        Speeds of the reference shaft, rising.
    branches
        Of the Campbell diagram.
    model
        `[model]`, such as {"accuracy": 1e-3}.
    analyses
        `[[analyses]]`, each a mapping with its kind.
    tables
        Further tables of the scene file by name: title, materials, gears, effects, ...

    Raises
    ------
    SceneError
        All that a scene may not hold, at once.
    """
    speeds = np.atleast_1d(np.asarray(speeds_rpm, dtype=float))
    data = {
        "bodies": dict(bodies or {}),
        "beams": dict(beams or {}),
        "bearings": list(bearings),
        "speeds": {"list_rpm": speeds},
        "campbell": {"branches": branches},
        "model": dict(model or {}),
        "analyses": list(analyses),
    }
    return parse_scene(_table(name=name, **(data | tables)), name)


def with_changes(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Return a scene with other values at some places, checked again.

    Parameters
    ----------
    changes
        New values by place, spelt as in a sweep: keys joined by dots, [name] or [number] behind a
        list, such as "bearings[kxx].stiffness_n_per_m" or "bodies.inner.speed_ratio". A dot
        instead of the brackets means the same.

    Raises
    ------
    ValueError
        A list has no such entry; the message names what is there.
    SceneError
        What comes out is no scene.
    """
    data: Any = scene.model_dump(mode="json", exclude_unset=True)
    for place, value in changes.items():
        *path, last = place_steps(place) if "[" in place else place.split(".")
        holder = data
        for key in path:
            holder = holder[_step(holder, key, place)]
        holder[_step(holder, last, place)] = _plain(value)
    return parse_scene(data, scene.name)


def _step(holder: Any, key: str, place: str) -> str | int:
    """Return the key of a table, or the index of an entry of a list, whichever way it is spelt."""
    if isinstance(holder, dict) and key[0] != "[":  # a table that is absent has its usual values
        holder.setdefault(key, {})
    if isinstance(holder, list) and key[0] != "[":
        key = f"[{key}]"
    return resolved_step(holder, key, "the place before it", place)


def _table(**keys: Any) -> Table:
    return {key: _plain(value) for key, value in keys.items()}


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as those that a file holds."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value
