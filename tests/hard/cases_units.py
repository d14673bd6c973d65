"""Hard cases of units: a thousand times off is questioned before anything is computed."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path

from solidwhirl.geometry import MATERIALS, GeometryError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.plausibility.units import implausible
from solidwhirl.scene_reading.reader import parse_scene

FOLDER = Path(__file__).resolve().parents[2] / "scenes"
SCENES = {
    path.stem: tomllib.loads(path.read_text(encoding="utf-8"))
    for path in sorted(FOLDER.glob("*.toml"))
}
INERTIAS = ("polar_inertia_kg_m2", "diametral_inertia_kg_m2")


def _scaled(node, chosen, factor):
    """A copy with all numbers below the chosen keys multiplied."""
    if isinstance(node, dict):
        return {
            key: _times(value, factor) if chosen(key) else _scaled(value, chosen, factor)
            for key, value in node.items()
        }
    return [_scaled(value, chosen, factor) for value in node] if isinstance(node, list) else node


def _times(value, factor):
    return [_times(v, factor) for v in value] if isinstance(value, list) else value * factor


def _with_materials(data):
    own = {
        name: {
            "density_kg_per_m3": m.density_kg_per_m3,
            "youngs_modulus_pa": m.youngs_modulus_pa,
            "poissons_ratio": m.poissons_ratio,
        }
        for name, m in MATERIALS.items()
    }
    return {**copy.deepcopy(data), "materials": own | data.get("materials", {})}


def _is_noticed(data) -> bool:
    scene = parse_scene(data, folder=FOLDER)
    try:
        return bool(implausible(scene, build_bodies(scene)))
    except GeometryError:  # refused
        return True


def _unnoticed(mistakes) -> float:
    """Mistakes that nothing is said about: name of a scene, keys, factor."""
    return float(
        sum(
            not _is_noticed(_scaled(_with_materials(SCENES[name]), chosen, factor))
            for name, chosen, factor in mistakes
        )
    )


def _lengths() -> float:
    bodies = {
        name: SCENES[name] for name in ("ferraris", "laval", "uhbr_fan", "uhbr_hp", "uhbr_lp")
    }
    silent = 0
    for data in bodies.values():
        for factor in (1e3, 1e-3):
            changed = _scaled(data["bodies"], lambda key: key.endswith("_m"), factor)
            silent += not _is_noticed({**data, "bodies": changed})
    return float(silent)


def _materials() -> float:
    density, modulus = "density_kg_per_m3", "youngs_modulus_pa"
    factors = ((density, 1e-3), (density, 1e-12), (density, 1e3))
    factors += ((modulus, 1e-6), (modulus, 1e-9), (modulus, 1e3))
    return _unnoticed(
        [
            (name, lambda key, wanted=wanted: key == wanted, factor)
            for name in ("ferraris", "uhbr_fan", "uhbr_hp", "uhbr_lp")
            for wanted, factor in factors
        ]
    )


def _disks() -> float:
    groups = (("mass_kg",), INERTIAS)
    return _unnoticed(
        [
            (name, lambda key, group=group: key in group, factor)
            for name in ("laval", "uhbr_fan", "uhbr_hp", "uhbr_lp")
            for group in groups
            for factor in (1e3, 1e-3, 1e6, 1e-6)
        ]
    )


def _false_alarms() -> float:
    return float(sum(_is_noticed(data) for data in SCENES.values()))
