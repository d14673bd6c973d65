"""Whatever a scene file holds, it works or is refused with a message; nothing else happens."""

from __future__ import annotations

import copy
import math
import random
import tomllib
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from engine_of_all_kinds import ENGINE
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from solidwhirl.build import disk
from solidwhirl.core.errors import USER_ERRORS, SceneError
from solidwhirl.geometry import GeometryError
from solidwhirl.meshing import MeshingError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.scene_reading.reader import parse_scene

FOLDER = Path(__file__).resolve().parents[3] / "scenes"
SCENES = {
    path.stem: tomllib.loads(path.read_text(encoding="utf-8"))
    for path in sorted(FOLDER.glob("*.toml"))
} | {"engine": ENGINE}

NUMBERS = st.one_of(
    st.sampled_from([0, -1, 1, 2, 10**400, -(10**30), 1e308, -1e308, 5e-324, 1e-300, 1e150, 1e30]),
    st.sampled_from([1e9, 1e-9, 0.0, -0.0, math.inf, -math.inf, math.nan]),
    st.floats(),
    st.integers(),
)
LEAVES = st.one_of(
    NUMBERS,
    st.booleans(),
    st.sampled_from(["", " ", "ground", "inner.A", "steel", "solid", "on", "\x00", "x" * 300]),
    st.text(max_size=8),
)
RUBBISH = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)


def places(value, path=()):
    """Paths of everything inside a scene."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key)
        if isinstance(inner, dict | list):
            yield from places(inner, (*path, key))


def at(data, path):
    """The container that holds the last key of a path."""
    for part in path[:-1]:
        data = data[part]
    return data


@st.composite
def mutated(draw):
    """A real scene with one to three changes."""
    data = copy.deepcopy(SCENES[draw(st.sampled_from(sorted(SCENES)))])
    for _ in range(draw(st.integers(1, 3))):
        change = draw(st.sampled_from(["drop", "rename", "number", "rubbish", "scale", "copy"]))
        spots = list(places(data))
        if change == "scale":
            spots = [path for path in spots if isinstance(at(data, path)[path[-1]], float)]
        if not spots:
            break
        path = draw(st.sampled_from(spots))
        holder, key = at(data, path), path[-1]
        match change:
            case "drop":
                del holder[key]
            case "rename" if isinstance(holder, dict):
                holder[draw(st.one_of(st.text(max_size=8), st.just(f"{key}m")))] = holder.pop(key)
            case "copy" if isinstance(holder, list):
                holder.append(copy.deepcopy(holder[key]))
            case "number":
                holder[key] = draw(NUMBERS)
            case "scale":
                holder[key] *= draw(st.sampled_from([-1.0, 1e-9, 0.5, 0.99, 1.01, 2.0, 1e3, 1e200]))
            case _:
                holder[key] = draw(RUBBISH)
    return data


def refused_or_planned(data):
    """ "planned", or the message with which a scene was refused; anything else is an error."""
    try:
        scene = parse_scene(data, folder=FOLDER)
        make_plan(scene, build_bodies(scene))
    except (SceneError, GeometryError, MeshingError, AnalysisError) as error:
        return str(error)
    return "planned"


@given(mutated())
@settings(max_examples=50, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_mutated_scene_is_planned_or_refused(data):
    assert refused_or_planned(data).strip()


def kinds():
    """One place of each kind in all scenes, by scene.

    Elements of lists are of one kind, as are bodies and other named entries; each kind of analysis
    is one of its own. All places are left out once by `make verify`.
    """
    found = {}
    for name, data in SCENES.items():
        for path in places(data):
            inner = ["*" if isinstance(k, int) else k for k in path]
            if path[0] == "analyses" and len(path) > 1:
                inner[1] = data["analyses"][path[1]].get("kind")
            elif len(path) > 1 and isinstance(data[path[0]], dict) and path[0] in NAMED:
                inner[1] = "*"
            found.setdefault(tuple(inner), (name, path))
    by_scene = {name: [] for name in SCENES}
    for name, path in found.values():
        by_scene[name].append(path)
    return by_scene


NAMED = ("bodies", "beams", "rigid_bodies", "imported", "mesh_bodies", "materials")
SPOTS = kinds()


DROPPED = "dropped"
VALUES = [DROPPED, None, True, "", "x", [], {}, [[]], -1, 1e308, 10**400, math.nan]


def change_one_by_one(data, paths, value):
    for path in paths:
        changed = copy.deepcopy(data)
        if value is DROPPED:
            del at(changed, path)[path[-1]]
        else:
            at(changed, path)[path[-1]] = value
        assert refused_or_planned(changed).strip()


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize("name", [name for name, own in SPOTS.items() if own])
def test_value_of_every_kind_changed(name, value):
    """Where the random test samples: each kind of key is left out or replaced once."""
    change_one_by_one(SCENES[name], SPOTS[name], value)


# Their places are those of uhbr_engine, and each of them takes up to 0.3 s.
ALIKE = {"uhbr_engine_bladed", "uhbr_engine_free"}


@pytest.mark.verify
@pytest.mark.parametrize("value", [DROPPED, -1])
@pytest.mark.parametrize("name", sorted(SCENES.keys() - ALIKE))
def test_every_single_value_changed(name, value):
    """Not only the first of each kind: left out, and by a number that is of the right type."""
    change_one_by_one(SCENES[name], places(SCENES[name]), value)


# Changes of the small scene that pass the plan more often than not, run to the end.

FACTORS = (-1.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.5, 0.99, 1.01, 2.0, 1e3, 1e6, 1e12)
FIRST_BEARING = {
    "damping_n_s_per_m": [0.0, 1e-30, 1e30, 1e3, 1e9, -1e3, [[0.0, 1e5], [-1e5, 0.0]]],
    "stiffness_n_per_m": [0.0, 1e-30, 1e30, -1e6, 1e16, [[1e7, 1e8], [-1e8, 1e7]], [1e7, -1e7]],
    "tilt_stiffness_n_m_per_rad": [1e-9, 1e30, -1e3, 1e5],
    "axial_stiffness_n_per_m": [1e-9, 1e30, 1e5],
    "torsion_stiffness_n_m_per_rad": [1e-9, 1e30, 1e5],
}
BODY = {
    "speed_ratio": [0.0, -1.0, 1e-30, 1e30, 1e3, -1e-3],
    "fillet_radius_m": [1e-9, 1e-3, 0.01],
    "internal_damping": [
        *({"stiffness_coefficient_s": beta} for beta in (1e-30, 1e-5, 1.0, 1e30)),
        *({"modal_ratio": ratio} for ratio in (1e-30, 0.02, 0.999)),
    ],
    "rigid_disks": [
        [disk("disk", mass_kg=mass, polar=inertia, diametral=inertia, interface="left")]
        for mass in (0.0, 1e-30, 1.0, 1e30)
        for inertia in (0.0, 1e-30, 1.0, 1e30)
    ],
}
TABLES = {
    "materials": [
        {"steel": {"density_kg_per_m3": d, "youngs_modulus_pa": e, "poissons_ratio": n}}
        for d in (1e-30, 7.8, 7.8e3, 1e30)
        for e in (1e-30, 2e5, 2e11, 1e30)
        for n in (-0.999, 0.0, 0.3, 0.4999999999)
    ],
    "speeds": [{"list_rpm": r} for r in ([0.0], [1e-30], [0.0, 1e-30, 1e6], [1e30], [0.0, 2e5])],
    "campbell": [
        *({"branches": n} for n in (1, 3, 40, 200)),
        *({"frequency_max_hz": f} for f in (1e-30, 1.0, 1e30)),
    ],
    "bearings": [[]],
    "effects": [
        {effect: switch}
        for effect in ("tilt", "axial", "torsion", "gyroscopic", "bearing_damping")
        for switch in ("on", "off")
    ],
}


def floats(data, path=()):
    return [p for p in places(data, path) if isinstance(at(data, p)[p[-1]], float)]


def extreme(small_scene, rng):
    """The small scene with one to three numbers far out."""
    data = small_scene(rpm=(0.0, 15000.0))
    data["model"] = {"accuracy": 0.1, "modes": 2, "estimates": "off", "compare_coupling": "off"}
    if rng.random() < 0.2:
        data["model"]["estimates"] = "on"
    for _ in range(rng.choice((1, 1, 2, 3))):
        kind = rng.choice(("number", "number", "bearing", "body", "table", "level"))
        if kind == "number":
            path = rng.choice(floats(data))
            value = at(data, path)[path[-1]]
            far = [value * factor for factor in FACTORS] + [0.0, 1e30, 5e-324, 1e-30, 1e-9, 1e15]
            at(data, path)[path[-1]] = rng.choice(far)
        elif kind == "bearing" and data["bearings"]:
            key = rng.choice(sorted(FIRST_BEARING))
            data["bearings"][0][key] = rng.choice(FIRST_BEARING[key])
        elif kind == "body":
            key = rng.choice(sorted(BODY))
            data["bodies"]["rotor"][key] = copy.deepcopy(rng.choice(BODY[key]))
        elif kind == "table":
            key = rng.choice(sorted(TABLES))
            data[key] = copy.deepcopy(rng.choice(TABLES[key]))
        else:
            data["model"] |= rng.choice(
                [{"level": "beam"}, {"modes": 1}, {"modes": 40}, {"accuracy": 1e-3}]
            )
    return data


def planned(small_scene, number):
    """The first extreme scene of a series that passes the plan, and its seed."""
    for seed in range(1000 * number, 1000 * number + 1000):
        data = extreme(small_scene, random.Random(seed))
        if refused_or_planned(data) == "planned":
            return parse_scene(data, folder=FOLDER), seed
    raise AssertionError("no scene of the series passes the plan")


def run_or_refused(small_scene, number):
    """Run a scene to the end: results, or what the command line turns into a message."""
    scene, seed = planned(small_scene, number)
    try:
        results = run_scene(scene)
    except Exception as error:
        known = (SceneError, np.linalg.LinAlgError, scipy.linalg.LinAlgWarning, *USER_ERRORS)
        assert isinstance(error, known), (seed, error)
        assert 0 < len(str(error)) < 4000
        assert "Traceback" not in str(error)
        return
    assert results is not None
    assert np.isfinite(results.at_rest.frequency_hz).all()


@pytest.mark.solver
@pytest.mark.parametrize("number", range(6))
def test_extreme_scene_runs_or_is_refused(small_scene, number):
    run_or_refused(small_scene, number)


@pytest.mark.solver
@pytest.mark.verify
@pytest.mark.parametrize("part", range(6))
def test_many_more_extreme_scenes(small_scene, part):
    for number in range(25 * part, 25 * part + 25):
        run_or_refused(small_scene, number)


@pytest.mark.solver
@pytest.mark.verify
@pytest.mark.parametrize("number", [1004, 1076, 1319])
def test_extreme_scenes_that_failed_once(small_scene, number):
    """A traceback; a root that rounding moved; hours of bisection between noise and noise."""
    run_or_refused(small_scene, number)
