"""Random rotors as scenes: stepped shafts with disks, drums, cones, rigid disks and bearings.

Hypothesis strategies; `scenes` draws a fixed list for a seed. Every shaft step carries at
most one disk in its middle and one interface beside it, so that most draws are valid; what the
program refuses before meshing is not drawn.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from hypothesis import HealthCheck, Phase, Verbosity, assume, given, seed, settings
from hypothesis import strategies as st

from solidwhirl.geometry import GeometryError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import parse_scene

# Rim speed and speed of rotation are limited: strains stay small, and rotors real.
RIM_SPEED_M_PER_S = 250.0
TOP_RPM = 30_000.0
MATERIALS = ("steel", "titanium", "aluminium")
KINDS = ("section", "outer", "inner", "slab")
# Within one search later draws are variations of earlier ones, so each rotor has its own.
_DRAWS = 8

Data = dict[str, Any]


def scene(first_seed: int, number: int) -> Scene:
    """One rotor of a seed by its number: always the same one.

    Parameters
    ----------
    first_seed, number
        The number is below 1000.
    """
    data = _drawn(1000 * first_seed + number)
    return parse_scene({**data, "name": f"random_{first_seed}_{number}"})


def scenes(count: int, first_seed: int) -> list[Scene]:
    """Rotors 0 to count - 1 of a seed."""
    return [scene(first_seed, number) for number in range(count)]


def _drawn(number: int) -> Data:
    """One rotor of a seed: the last of a few, as the first ones are the simplest there are."""
    found: list[Data] = []

    @seed(number)
    @settings(
        max_examples=_DRAWS,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        verbosity=Verbosity.quiet,
        suppress_health_check=list(HealthCheck),
    )
    @given(rotors())
    def collect(data: Data) -> None:
        found.append(data)

    collect()
    return found[-1]


@st.composite
def rotors(draw: st.DrawFn) -> Data:
    """One rotor as the content of a scene file."""
    steps = draw(shafts())
    disks = draw(disks_on(steps))
    length = steps[-1]["end_m"]
    interfaces = draw(interfaces_on(steps, length))
    names = [i["name"] for i in interfaces]
    rim = max(max(_pair(s["outer_radius_m"])) for s in [*steps, *disks])
    top = min(RIM_SPEED_M_PER_S / rim * 30.0 / 3.14159, TOP_RPM) * draw(_among(0.3, 1.0))
    count = draw(st.integers(3, 5))
    held = draw(st.sampled_from([0, 2, 2, 2, 3]))
    assume(held <= len(names))
    data: Data = {
        "name": "random",
        "speeds": {"to_rpm": round(top), "count": count},
        "campbell": {"branches": draw(st.sampled_from([6, 8, 10]))},
        "bodies": {
            "rotor": {
                "material": draw(st.sampled_from(MATERIALS)),
                "fillet_radius_m": draw(st.sampled_from([0.0, 0.0, 0.0, 0.002])),
                "sections": [*steps, *disks],
                "interfaces": interfaces,
                "rigid_disks": draw(rigid_disks_on(names)),
            }
        },
        "bearings": [draw(bearing_at(name)) for name in names[:held]],
    }
    _refuse(data)
    return data


@st.composite
def shafts(draw: st.DrawFn) -> list[Data]:
    """Steps of a shaft, one after the other, of one bore."""
    radii = draw(st.lists(_among(0.012, 0.05), min_size=2, max_size=6))
    bore = draw(st.sampled_from([0.0, 0.0, 0.4, 0.7, 0.85])) * min(radii)
    out, at = [], 0.0
    for k, radius in enumerate(radii):
        end = _mm(at + draw(_among(0.06, 0.25)))
        step = {"name": f"step_{k}", "start_m": at, "end_m": end, "outer_radius_m": _mm(radius)}
        if bore:
            step["inner_radius_m"] = _mm(bore)
        out.append(step)
        at = end
    return out


@st.composite
def disks_on(draw: st.DrawFn, steps: list[Data]) -> list[Data]:
    """Webs, thin to thick, perhaps with a rim, a drum between two of them, or a cone."""
    places = draw(st.lists(st.sampled_from(range(len(steps))), max_size=3, unique=True).map(sorted))
    shaft = max(s["outer_radius_m"] for s in steps)
    outer = _mm(shaft + draw(_among(0.04, 0.16)))
    drum = draw(st.sampled_from([None, None, "drum", "cone"]))
    out: list[Data] = []
    for k in places:
        step = steps[k]
        length = step["end_m"] - step["start_m"]
        middle = 0.5 * (step["start_m"] + step["end_m"])
        width = min(draw(st.sampled_from([0.004, 0.008, 0.015, 0.03])), 0.4 * length)
        own = outer if drum == "drum" else _mm(shaft + draw(_among(0.04, 0.16)))
        web = {
            "name": f"web_{k}",
            "start_m": _mm(middle - 0.5 * width),
            "end_m": _mm(middle + 0.5 * width),
            "inner_radius_m": step["outer_radius_m"],
            "outer_radius_m": own,
        }
        out.append(web)
        if drum is None and draw(st.booleans()):
            out.append(_rim(web, draw(_among(0.01, 0.03)), 0.6 * length))
    webs = [d for d in out if d["name"].startswith("web")]
    wall = _mm(draw(_among(0.003, 0.008)))
    if drum == "drum":
        out += [_shell(a, b, wall) for a, b in pairwise(webs)]
    elif drum == "cone" and webs:
        out.append(_cone(webs[-1], wall, _mm(draw(_among(0.03, 0.1)))))
    return out


def _rim(web: Data, height: float, width: float) -> Data:
    """A ring on the web, of that width."""
    middle = 0.5 * (web["start_m"] + web["end_m"])
    half = max(0.5 * min(width, 0.04), 0.5 * (web["end_m"] - web["start_m"]))
    return {
        "name": web["name"].replace("web", "rim"),
        "start_m": _mm(middle - half),
        "end_m": _mm(middle + half),
        "inner_radius_m": web["outer_radius_m"],
        "outer_radius_m": _mm(web["outer_radius_m"] + height),
    }


def _shell(first: Data, second: Data, wall: float) -> Data:
    """A drum between two webs, flush with their rims."""
    return {
        "name": first["name"].replace("web", "drum"),
        "start_m": first["end_m"],
        "end_m": second["start_m"],
        "inner_radius_m": _mm(first["outer_radius_m"] - wall),
        "outer_radius_m": first["outer_radius_m"],
    }


def _cone(web: Data, wall: float, length: float) -> Data:
    """An overhung cone behind a web."""
    radius = web["outer_radius_m"]
    inner = web["inner_radius_m"] + 0.01
    free = _mm(max(0.75 * radius, inner + wall))
    return {
        "name": web["name"].replace("web", "cone"),
        "start_m": web["end_m"],
        "end_m": _mm(web["end_m"] + length),
        "inner_radius_m": [_mm(radius - wall), _mm(free - wall)],
        "outer_radius_m": [radius, free],
    }


@st.composite
def interfaces_on(draw: st.DrawFn, steps: list[Data], length: float) -> list[Data]:
    """Two to four interfaces of all kinds, one per step and on the first end."""
    chosen = draw(st.lists(st.sampled_from(range(len(steps))), min_size=2, max_size=4, unique=True))
    out: list[Data] = []
    for k in chosen:
        step = steps[k]
        span = step["end_m"] - step["start_m"]
        start = _mm(step["start_m"] + 0.08 * span)
        kind = draw(st.sampled_from(KINDS))
        if kind == "inner" and "inner_radius_m" not in step:
            kind = "section"
        place = {"name": f"at_{k}", "kind": kind}
        place["coupling"] = draw(st.sampled_from(["distributing"] * 3 + ["rigid"]))
        if kind == "section":
            place["at_m"] = start
        else:
            place |= {"start_m": start, "end_m": _mm(start + 0.12 * span)}
        out.append(place)
    if draw(st.booleans()):
        out.append({"name": "end", "kind": "face", "at_m": length})
    return out


@st.composite
def rigid_disks_on(draw: st.DrawFn, names: list[str]) -> list[Data]:
    """None to two rigid disks, flat or long."""
    chosen = draw(st.lists(st.sampled_from(names), max_size=2, unique=True))
    out = []
    for name in chosen:
        mass, radius = draw(_among(0.5, 10.0)), draw(_among(0.05, 0.15))
        polar = 0.5 * mass * radius**2
        ratio = draw(st.sampled_from([0.5, 0.6, 1.0]))
        disk = {"name": f"disk_{name}", "interface": name, "mass_kg": mass}
        out.append(disk | {"polar_inertia_kg_m2": polar, "diametral_inertia_kg_m2": ratio * polar})
    return out


@st.composite
def bearing_at(draw: st.DrawFn, name: str) -> Data:
    """A spring to the ground, perhaps unequal in x and y."""
    power = draw(_among(5.0, 9.0))
    other = power + draw(st.sampled_from([0.0, 0.0, 0.3]))
    both = [10.0**power, 10.0**other]
    return {"name": name, "first": f"rotor.{name}", "stiffness_n_per_m": both}


def _refuse(data: Data) -> None:
    """Leave out what the program refuses before meshing."""
    drawn = parse_scene(data)
    try:
        make_plan(drawn, build_bodies(drawn))
    except GeometryError:
        assume(False)


def _among(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of a range in a thousand steps, none of them preferred."""
    return st.integers(0, 1000).map(lambda k: low + (high - low) * k / 1000)


def _mm(value: float) -> float:
    """Whole tenths of a millimetre: nothing is near a tolerance by accident."""
    return round(value, 4)


def _pair(value: float | list[float]) -> list[float]:
    return value if isinstance(value, list) else [value]
