"""Whatever a scene file holds, it works or is refused with a message; nothing else happens."""

from __future__ import annotations

import copy
import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from solidwhirl.bodies import build_bodies
from solidwhirl.errors import SceneError
from solidwhirl.geometry import GeometryError
from solidwhirl.plan import make_plan
from solidwhirl.scene_file import parse_scene

SCENES = {
    path.stem: tomllib.loads(path.read_text(encoding="utf-8"))
    for path in sorted((Path(__file__).resolve().parents[2] / "scenes").glob("*.toml"))
}

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
        scene = parse_scene(data)
        make_plan(scene, build_bodies(scene))
    except (SceneError, GeometryError) as error:
        return str(error)
    return "planned"


@given(mutated())
@settings(
    max_examples=200, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
def test_mutated_scene_is_planned_or_refused(data):
    assert refused_or_planned(data).strip()


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_single_key_dropped(name):
    """Exhaustive where the random test samples: each key of each scene is left out once."""
    for path in places(SCENES[name]):
        data = copy.deepcopy(SCENES[name])
        del at(data, path)[path[-1]]
        assert refused_or_planned(data).strip()


@pytest.mark.parametrize("value", [None, True, "", "x", [], {}, [[]], -1, 1e308, 10**400, math.nan])
@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_single_value_replaced(name, value):
    for path in places(SCENES[name]):
        data = copy.deepcopy(SCENES[name])
        at(data, path)[path[-1]] = value
        assert refused_or_planned(data).strip()
