# ruff: noqa: E501
"""Compose scenes/uhbr_engine.toml from the scenes of the three units.

`python tools/paper/compose.py` copies the bodies of uhbr_fan, uhbr_lp and uhbr_hp, puts them on the
casing and gears the fan to the low pressure unit. Run it again after an identification.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np

from solidwhirl.geometry import mass_properties
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene.records import BodySpec
from solidwhirl.scene_reading.reader import read_scene

SCENES = Path(__file__).resolve().parents[2] / "scenes"
UNITS = {"fan": "uhbr_fan", "lp": "uhbr_lp", "hp": "uhbr_hp"}
SOURCE = tomllib.loads(Path(__file__).with_name("source.toml").read_text(encoding="utf-8"))
# Of the whole engine: mass [kg], centre of gravity [m], polar and diametral inertia [kg m²].
TOTAL = SOURCE["table_4"]["engine"]
BEARINGS = {"A": "fan", "B": "fan", "C": "lp", "D": "lp", "E": "hp", "F": "hp"}
# Nodes that joints, unbalances and results need; each costs two coordinates.
KEPT = {"fan": ("n4", "n8"), "lp": ("n9", "n13", "n16"), "hp": ("n5",)}
MODES = {"fan": 4, "lp": 3, "hp": 3}
# First stages of a group whose blades are one ring, on the stage nearest to its centre. All others
# have their own: thin disks tilt by themselves, and a ring taken from one moves modes by a third.
JOINED = {"lpt_blades": 4, "hpc_blades": 6}

HEAD = """# The geared engine of Müller and Hennings, section 5: three units on the casing.
# Composed by tools/paper/compose.py from uhbr_fan, uhbr_lp and uhbr_hp; edit those.
name = "uhbr_engine"
title = "Geared turbofan: fan, low and high pressure unit on the casing"
notes = [
    "Units as in the scenes uhbr_fan, uhbr_lp and uhbr_hp: stages from Table 7 of the source, the rest IDENTIFIED from its Tables 4 and 6.",
    "Gear ratio 0.315 and speed ratio -1.32 from the source. The design point of 13 690 rpm then gives the fan 4312 rpm; the source prints 4346 rpm, a ratio of 0.3175.",
    "Blades are rigid rings with the mass and inertia that they have: one for the four stages of the LP turbine, one for the first six of the HP compressor, one for each other stage. One ring for every group of stages would move forward modes of the HP unit by up to 30 %: thin disks tilt by themselves, and the gyroscopic moment of their blades has to act on them.",
    "The casing is rigid. Its mass, centre of gravity and inertia are what Table 4 leaves when the three units are taken from the whole engine. It is held at P, whose place is ASSUMED to be the engine's centre of gravity.",
    "Stiffness of the bearings at rest from Table 5, over the speed by the printed polynomial for x in both directions (the source calls its bearings isotropic), Ω in rad/s. Damping is that of Table 5 and constant: the printed damping polynomials turn negative from 1106 rad/s, so that the engine would be unstable at its design point.",
]
REFERENCES

[model]
accuracy = 1e-2
modes = 5

[speeds]
from_rpm = 0
to_rpm = 13690
count = 21

[campbell]
frequency_max_hz = 250

[speed_laws.lee]
kind = "polynomial"
argument_unit = "rad/s"
argument_range = [0.0, 2000.0]
stiffness_x = [1.0, -3.52e-3, 7.06e-6, -6.77e-9, 2.46e-12]
stiffness_y = [1.0, -3.52e-3, 7.06e-6, -6.77e-9, 2.46e-12]

"""

TAIL = """
[[gears]]
name = "gear"
first = "lp.n16"
second = "fan.n8"
ratio = 0.315

[[bearings]]
name = "mount"
first = "casing.P"
rigid = ["ux", "uy", "uz", "rx", "ry", "rz"]

[[analyses]]
kind = "rotating_campbell"
bodies = ["lp", "hp", "fan"]
branches = [5, 2, 2]  # as in figure 11

[[analyses]]
kind = "bearing_laws"
to_rpm = 13690

[[analyses]]
kind = "unbalance_response"
unbalances = [
    { at = "lp.n9", moment_kg_m = 1e-6 },
    { at = "hp.n5", moment_kg_m = 1e-6 },
    { at = "fan.n4", moment_kg_m = 1e-4 },
]
observe = ["lp.n9", "hp.n5", "fan.n4"]
to_rpm = 13690
count = 801
orbits_at_rpm = [4000, 9000, 13690]

[[analyses]]
kind = "separation_margins"
operating = [
    { shaft = "fan", from_rpm = 4312.35, to_rpm = 4312.35 },
    { shaft = "lp", from_rpm = 13690, to_rpm = 13690 },
    { shaft = "hp", from_rpm = 18070.8, to_rpm = 18070.8 },
]
search_factor = 1.2

[[analyses]]
kind = "stability"
to_rpm = 13690

# Figures 17 and 18 and section 5.8: 20 s linear, 10 s constant.
[[analyses]]
kind = "run_up"
ramp_s = 20
hold_s = 10
to_rpm = 13690
sampling_hz = 20000
unbalances = [
    { at = "lp.n9", moment_kg_m = 1e-6 },
    { at = "hp.n5", moment_kg_m = 1e-6 },
    { at = "fan.n4", moment_kg_m = 1e-4 },
]
drives = ["lp.n13"]
observe = ["lp.n9"]
mount = "mount"

# Figure 17 b: nothing but the torque that speeds the engine up.
[[analyses]]
kind = "run_up"
name = "start_up"
ramp_s = 20
hold_s = 10
to_rpm = 13690
sampling_hz = 2000
record_hz = 2000
drives = ["lp.n13"]
mount = "mount"

# Section 5.8: which units have to be flexible.
[[analyses]]
kind = "run_up"
name = "complexity"
ramp_s = 20
hold_s = 10
to_rpm = 13690
sampling_hz = 20000
unbalances = [
    { at = "lp.n9", moment_kg_m = 1e-6 },
    { at = "hp.n5", moment_kg_m = 1e-6 },
    { at = "fan.n4", moment_kg_m = 1e-4 },
]
mount = "mount"
compare_flexible = [[], ["lp"], ["hp"], ["fan"], ["fan", "lp"]]
bands_hz = [[5, 80], [80, 140], [140, 300]]

# What the source wanted for its wing: forces and motions at P over the speed.
[[analyses]]
kind = "state_space"
inputs = ["lp.n9", "hp.n5", "fan.n4"]
outputs = ["lp.n9", "fan.n4"]
to_rpm = 13690
speed_count = 15
"""


# The engine let go at P: what a wing needs that carries it there.
FREE = """[[analyses]]
kind = "state_space"
inputs = ["casing.P"]
outputs = ["casing.P"]
to_rpm = 13690
speed_count = 15
"""


def _freed(text: str) -> str:
    """Return the head and bodies for the engine without its mount, at rest only."""
    text = text.replace('name = "uhbr_engine"', 'name = "uhbr_engine_free"')
    text = text.replace('on the casing"\nnotes', 'on the casing, free at the mount P"\nnotes')
    text = text.replace("It is held at P, whose", "It is free: forces and motions at P, whose")
    text = text.replace(
        "place is ASSUMED to be the engine's centre of gravity.",
        "place is ASSUMED to be the engine's centre of gravity, go to the wing.",
    )
    return text.replace("to_rpm = 13690\ncount = 21", "to_rpm = 0\ncount = 1", 1)


def main() -> None:
    """Write the scene."""
    ratios = {"fan": 0.315, "lp": 1.0, "hp": -1.32}
    bodies, units, places = [], {}, {}
    references: list[str] = []
    materials: dict[str, str] = {}
    for body, name in UNITS.items():
        text = (SCENES / f"{name}.toml").read_text(encoding="utf-8")
        scene = read_scene(SCENES / f"{name}.toml")
        properties = mass_properties(build_bodies(scene)[body])
        units[body] = properties
        references += re.findall(rf'^    \{{ quantity = "bodies\.{body}\..*\}},$', text, flags=re.M)
        for interface in scene.bodies[body].interfaces:
            if interface.name in BEARINGS:
                at = interface.at_m
                places[interface.name] = (
                    at if at is not None else (interface.start_m + interface.end_m) / 2
                )
        start = text.index(f"[bodies.{body}]")
        end = re.search(r"^(#.*\n)*\[\[(bearings|analyses)\]\]", text[start:], flags=re.M)
        block = text[start : start + end.start() if end else None].rstrip()
        block = _without_unused_nodes(block, KEPT[body])
        block = _with_joined_blades(block, scene.bodies[body])
        block = re.sub(r"^speed_ratio = .*\n", "", block, flags=re.M)
        block = re.sub(r"^modes = .*\n", "", block, flags=re.M)
        header = f"[bodies.{body}]\nspeed_ratio = {ratios[body]}\nmodes = {MODES[body]}"
        bodies.append(block.replace(f"[bodies.{body}]", header, 1))
        for found in re.finditer(r"^\[materials\.(\w+)\]\n(?:.+\n)+", text, flags=re.M):
            materials[found.group(1)] = found.group(0).rstrip()
    printed = SOURCE["table_5"]
    joints = [
        f'[[bearings]]\nname = "{name}"\nfirst = "{body}.{name}"\nsecond = "casing.{name}"\n'
        f"stiffness_n_per_m = {printed[body][0]:.3g}\ndamping_n_s_per_m = {printed[body][2]:.4g}\n"
        'speed_law = "lee"'
        for name, body in BEARINGS.items()
    ]
    listed = "\n".join(["references = [", *references, "]"])
    parts = [
        HEAD.rstrip().replace("REFERENCES", listed),
        *materials.values(),
        *bodies,
        _casing(units, places),
        *joints,
    ]
    gear = TAIL.split("[[bearings]]", 1)[0]
    for name, out in (
        ("uhbr_engine", "\n\n".join(parts) + "\n" + TAIL),
        ("uhbr_engine_free", _freed("\n\n".join(parts)) + "\n" + gear + FREE),
    ):
        tomllib.loads(out)
        (SCENES / f"{name}.toml").write_text(out, encoding="utf-8")


def _without_unused_nodes(block: str, kept: tuple[str, ...]) -> str:
    """Leave out the nodes n1, n2, ... that are not kept, with the comments above them."""
    lines: list[str] = []
    for line in block.splitlines():
        node = re.match(r'\s*\{ name = "(n\d+)"', line)
        if node and node.group(1) not in kept:
            while lines and lines[-1].lstrip().startswith("#"):
                lines.pop()
            continue
        lines.append(line)
    return "\n".join(lines)


def _with_joined_blades(block: str, body: BodySpec) -> str:
    """Put the blades of the joined stages on one ring, with the inertia that they have together."""
    place = {i.name: (i.start_m + i.end_m) / 2 for i in body.interfaces if i.kind == "outer"}
    for group, count in JOINED.items():
        names = [f"{group}_{stage}" for stage in range(1, count + 1)]
        rings = [d for d in body.rigid_disks if d.name in names]
        if not rings:
            continue
        mass = sum(d.mass_kg for d in rings)
        center = sum(d.mass_kg * place[d.interface] for d in rings) / mass
        polar = sum(d.polar_inertia_kg_m2 for d in rings)
        diametral = sum(
            d.diametral_inertia_kg_m2 + d.mass_kg * (place[d.interface] - center) ** 2
            for d in rings
        )
        carrier = min(names, key=lambda name: abs(place[name] - center))
        ring = (
            f'    {{ name = "{group}", interface = "{carrier}", mass_kg = {mass:.8g}, '
            f"polar_inertia_kg_m2 = {polar:.8g}, diametral_inertia_kg_m2 = {diametral:.8g}, "
            f"offset_m = {center - place[carrier]:.6g} }},"
        )
        lines: list[str] = []
        for line in block.splitlines():
            found = re.match(rf'\s*\{{ name = "({group}_\d+)"', line)
            if found is None or found.group(1) not in names:
                lines.append(line)
                continue
            while lines and lines[-1].lstrip().startswith("#"):
                lines.pop()
            if "mass_kg" not in line and found.group(1) == carrier:
                lines.append(line)
            elif "mass_kg" in line and found.group(1) == names[0]:
                lines.append(ring)
        block = "\n".join(lines)
    return block


def _casing(units: dict[str, object], places: dict[str, float]) -> str:
    """What the units leave of the whole engine, inertias about the casing's own centre."""
    mass = TOTAL[0] - sum(u.mass_kg for u in units.values())
    moment = TOTAL[0] * TOTAL[1] - sum(u.mass_kg * u.center_of_gravity_m[2] for u in units.values())
    center = moment / mass
    polar = TOTAL[2] - sum(u.polar_inertia_kg_m2 for u in units.values())
    diametral = TOTAL[3] - mass * (center - TOTAL[1]) ** 2
    for unit in units.values():
        arm = unit.center_of_gravity_m[2] - TOTAL[1]
        diametral -= unit.diametral_inertia_kg_m2 + unit.mass_kg * arm**2
    seats = ", ".join(f"{name} = {at:.6g}" for name, at in sorted(places.items()))
    return (
        "[rigid_bodies.casing]\n"
        f"mass_kg = {mass:.6g}\n"
        f"center_of_gravity_m = [0.0, 0.0, {center:.6g}]\n"
        f"inertia_kg_m2 = [{diametral:.6g}, {diametral:.6g}, {polar:.6g}]\n"
        f"interfaces = {{ {seats}, P = {TOTAL[1]:.6g} }}"
    )


if __name__ == "__main__":
    np.seterr(all="raise")
    main()
