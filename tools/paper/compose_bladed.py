# ruff: noqa: E501
"""Compose scenes/uhbr_engine_bladed.toml: the engine with blades as solids in place of rings.

`python tools/paper/compose_bladed.py` takes scenes/uhbr_engine.toml, and gives every stage of
uhbr_lp and uhbr_hp blades of the mass and polar inertia of its ring there; those of the fan are of
the scene fan_blades. Run it again after an identification.
"""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import fsolve

from solidwhirl.geometry import Blade, Section
from solidwhirl.geometry.mass_properties import feature_mass_properties
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene_reading.reader import read_scene

SCENES = Path(__file__).resolve().parents[2] / "scenes"
# Assumed of the stages. Blades are staggered by this, and their chord is as wide as the ring; where
# spacers are as high as the rings, all of a root keeps within this part of the width.
_STAGGER_DEG = 30.0
_WITHIN = {"lpt": 0.9}
# Chord over pitch in the middle of the span; less where blades would be thinner than this part of
# their chord.
_SOLIDITY = 1.0
_THINNEST = 0.08


def stage_blades(unit: str) -> list[Blade]:
    """Blades of every stage of a unit, as heavy as its rings and of their polar inertia."""
    scene = read_scene(SCENES / f"uhbr_{unit}.toml")
    body = build_bodies(scene)[unit]
    rows = []
    for ring in body.rigid_disks:
        group, _, stage = ring.name.rpartition("_blades_")
        section = next(s for s in body.sections if s.name == f"{group}_stage_{stage}")
        rows.append(_as_heavy(ring, section))
    return rows


def _as_heavy(ring: Any, section: Section) -> Blade:
    """Blades whose middle is at the ring's radius, with its mass and polar inertia."""
    rim = max(section.outer_radius_m)
    middle = math.sqrt(ring.polar_inertia_kg_m2 / ring.mass_kg)
    length = 2.0 * (middle - rim)
    volume = ring.mass_kg / section.material.density_kg_per_m3
    around = 2.0 * math.pi * middle
    sine, cosine = math.sin(math.radians(_STAGGER_DEG)), math.cos(math.radians(_STAGGER_DEG))
    width = section.end_m - section.start_m
    within = _WITHIN.get(section.name.partition("_")[0])
    # of all blades together, chord · count is the circumference times the solidity
    mean = volume / (_SOLIDITY * around * length)
    chord = (width if within is None else within * width - mean * sine) / cosine
    solidity = min(_SOLIDITY, volume / (around * length * _THINNEST * chord))
    count = round(solidity * around / chord)
    mean = volume / (count * chord * length)

    def blade(thickness: Any) -> Blade:
        return Blade(
            name=ring.name, on=section.name, count=count, length_m=length,
            chord_m=(chord, chord), thickness_m=(thickness[0], thickness[1]),
            stagger_deg=(_STAGGER_DEG, _STAGGER_DEG), material=section.material,
        )  # fmt: skip

    def missed(thickness: Any) -> list[float]:
        found = feature_mass_properties(blade(np.abs(thickness)), section)
        return [
            found.mass_kg / ring.mass_kg - 1.0,
            found.polar_inertia_kg_m2 / ring.polar_inertia_kg_m2 - 1.0,
        ]

    return blade(fsolve(missed, [mean, mean], xtol=1e-12))


# What takes the place of the head of the scene of the engine, up to its laws of bearings.
HEAD = """# The geared engine of Müller and Hennings with the blades of all stages as solids.
# Composed by tools/paper/compose_bladed.py from uhbr_engine and fan_blades; edit those.
name = "uhbr_engine_bladed"
title = "Geared turbofan with blades: fan, low and high pressure unit on the casing"
notes = [
    "Engine as in the scene uhbr_engine, whose rings of blades are solid blades here: fan, LP and HP stages of Table 7 of the source (Müller and Hennings), reduced by sectors of their own.",
    "INFERRED, as the source gives neither counts nor dimensions of blades: a row has the mass and the polar inertia of the ring on its stage in the scenes uhbr_lp and uhbr_hp, and its middle is where that ring is; thickness at root and tip follow from that. Axial centre and diametral inertia follow and are not fitted.",
    "ASSUMED of them: stagger 30 deg; as wide as the ring in Table 7 (those of the LP turbine, whose spacers are as high as its rings, keep within 0.9 of it); as many as leave gaps of one chord in the middle of the span (solidity 1), or fewer where they would be thinner than 8 % of their chord, in the LP compressor.",
    "Blades of the fan: those of the scene fan_blades.",
]
REFERENCES

[model]
accuracy = 0.02
size_m = 0.1
corner_size_m = 0.004
growth = 0.8
rounds = 1  # a second costs more than the first, for modes that blades have above the others

[speeds]
from_rpm = 0
to_rpm = 13690
count = 21

[campbell]
frequency_max_hz = 250

"""
TAIL = """
[[analyses]]
kind = "rotating_campbell"
bodies = ["lp", "hp", "fan"]
branches = [5, 2, 2]
"""


def main() -> None:
    """Write the scene."""
    text = (SCENES / "uhbr_engine.toml").read_text(encoding="utf-8")
    references = text[text.index("references = [") : text.index("[model]")].rstrip()
    first, end = text.index("[speed_laws."), text.index("[[analyses]]")
    fan = tomllib.loads((SCENES / "fan_blades.toml").read_text(encoding="utf-8"))
    rows = {"fan": [_listed(fan["bodies"]["fan"]["blades"][0])]}
    rows |= {unit: [_row(blade) for blade in stage_blades(unit)] for unit in ("lp", "hp")}
    parts = re.split(r"(?m)^(?=\[(?:bodies|rigid_bodies)\.\w+\]$)", text[first:end])
    out = "".join(_bladed(part, rows) for part in parts).rstrip()
    out = HEAD.replace("REFERENCES", references) + out + "\n" + TAIL
    tomllib.loads(out)
    (SCENES / "uhbr_engine_bladed.toml").write_text(out, encoding="utf-8")


def _bladed(part: str, rows: dict[str, list[str]]) -> str:
    """Put blades in the place of rings into the table of a body; others are returned as they are."""
    found = re.match(r"\[bodies\.(\w+)\]", part)
    if found is None:
        return part
    # free motion needs more than the shafts': blades have modes of their own
    part = re.sub(r"(?m)^modes = .*\n", "", part)
    part = re.sub(r'(?m)^(    #.*\n)*    \{ name = "(\w+_)?blades(_\d)?", kind = .*\n', "", part)
    blades = "\n".join(["blades = [", *rows[found.group(1)], "]"])
    return re.sub(r"(?ms)^rigid_disks = \[\n.*?^\]", lambda _: blades, part, count=1)


def _row(blade: Blade) -> str:
    return _listed(
        {
            "name": blade.name,
            "on": blade.on,
            "count": blade.count,
            "length_m": blade.length_m,
            "chord_m": list(blade.chord_m),
            "thickness_m": list(blade.thickness_m),
            "stagger_deg": _STAGGER_DEG,
            "material": blade.material.name,
        }
    )


def _listed(values: dict[str, Any]) -> str:
    """One line of the list of blades."""

    def told(value: Any) -> str:
        if isinstance(value, list):
            return "[" + ", ".join(told(v) for v in value) + "]"
        return f'"{value}"' if isinstance(value, str) else f"{value:.8g}"

    return "    { " + ", ".join(f"{key} = {told(value)}" for key, value in values.items()) + " },"


if __name__ == "__main__":
    main()
