"""Section of the page on the engine with blades as bladed sectors, against blades as rings.

`python tools/paper/blades.py` computes the engine four times: with rings as in uhbr_engine, with a
ring on every stage, with rigid blades and with elastic ones. It writes the numbers and the picture
that the page shows; the page alone computes nothing of it.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from paper.rows import markdown  # noqa: E402
from paper.runs import SOURCE, STORE, drawn  # noqa: E402

from solidwhirl import geometry as geo  # noqa: E402
from solidwhirl.core.stages import silent  # noqa: E402
from solidwhirl.geometry import mass_properties  # noqa: E402
from solidwhirl.geometry.mass_properties import feature_mass_properties  # noqa: E402
from solidwhirl.model.bodies import build_bodies  # noqa: E402
from solidwhirl.pipeline.run import Results, run_scene  # noqa: E402
from solidwhirl.rotordyn import Modes, modes_at_speed  # noqa: E402
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S  # noqa: E402
from solidwhirl.rotordyn.modes.participation import participation  # noqa: E402
from solidwhirl.rotordyn.plots import chart as charts  # noqa: E402
from solidwhirl.scene_reading.reader import load_toml, parse_scene  # noqa: E402

DATA = ROOT / "docs" / "data" / "paper_blades.json"
SCENES = ROOT / "scenes"
#: What each engine is called on the page
NAMES = {
    "rings": "rings, one a group",
    "stage_rings": "rings, one a stage",
    "rigid": "rigid blades",
    "blades": "elastic blades",
}
# Rigid blades are so many times as stiff.
_RIGID = 1e3
# A ring of a stage sits on the outer surface from this part of its radius on.
_RIM = 0.99
# At rest both whirls are one: their shapes are told apart at this part of the top speed.
_CREEP = 1e-6
# Modes of two engines with less in common are no pair; those with frequencies further apart
# neither.
_ALIKE, _OCTAVES = 0.5, 1.0
# Modes of one engine nearer than this (relative) are the same.
_SAME = 1e-6
_WHIRL = {1: "forward", -1: "backward", 0: "axial, torsion"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Shapes:
    """Modes at one speed, and how the places move that all engines have.

    `hertz`, `family`, `error`, `unit`: by mode: frequency, whirl as in `Modes.family`, estimated
    relative error, and the unit with the most kinetic energy. `motion`: (places, modes).
    """

    hertz: np.ndarray
    family: np.ndarray
    error: np.ndarray
    unit: list[str]
    motion: np.ndarray


# -- the engines -----------------------------------------------------------------------------------


def _scene(name: str) -> dict[str, Any]:
    """A scene without its analyses and references."""
    data = load_toml(SCENES / f"{name}.toml")
    return {k: v for k, v in data.items() if k not in ("analyses", "references")}


def _rigid(data: dict[str, Any]) -> dict[str, Any]:
    """The engine with blades, these much stiffer; errors are those of the same mesh."""
    known = {**geo.MATERIALS}
    materials = dict(data.get("materials", {}))
    bodies = {}
    for name, body in data["bodies"].items():
        rows = []
        for row in body["blades"]:
            given, stiff = known[row["material"]], f"{row['material']}_stiff"
            materials[stiff] = {
                "density_kg_per_m3": given.density_kg_per_m3,
                "youngs_modulus_pa": _RIGID * given.youngs_modulus_pa,
                "poissons_ratio": given.poissons_ratio,
            }
            rows.append({**row, "material": stiff})
        bodies[name] = {**body, "blades": rows}
    model = {**data["model"], "estimates": "off"}
    return {**data, "bodies": bodies, "materials": materials, "model": model}


def _stage_rings(data: dict[str, Any]) -> dict[str, Any]:
    """The engine with blades, these as rigid rings of their mass and inertia."""
    bodies, built = {}, build_bodies(parse_scene(data))
    for name, body in data["bodies"].items():
        sections = {s.name: s for s in built[name].sections}
        seats, rings = [], []
        for blade in built[name].features:
            section = sections[blade.section]
            found = feature_mass_properties(blade, section)
            radius = max(section.outer_radius_m)
            seats.append(
                {
                    "name": f"{blade.name}_ring",
                    "kind": "outer",
                    "start_m": section.start_m,
                    "end_m": section.end_m,
                    "radius_m": [_RIM * radius, radius / _RIM],
                }
            )
            middle = 0.5 * (section.start_m + section.end_m)
            rings.append(
                {
                    "name": blade.name,
                    "interface": f"{blade.name}_ring",
                    "mass_kg": found.mass_kg,
                    "polar_inertia_kg_m2": found.polar_inertia_kg_m2,
                    "diametral_inertia_kg_m2": found.diametral_inertia_kg_m2,
                    "offset_m": float(found.center_of_gravity_m[2]) - middle,
                }
            )
        kept = {k: v for k, v in body.items() if k != "blades"}
        interfaces = [*body["interfaces"], *seats]
        bodies[name] = {**kept, "interfaces": interfaces, "rigid_disks": rings}
    return {**data, "bodies": bodies, "model": _scene("uhbr_engine")["model"]}


#: Scene of each engine, from the first to the last step
ENGINES: Mapping[str, Callable[[], dict[str, Any]]] = {
    "rings": lambda: _scene("uhbr_engine"),
    "stage_rings": lambda: _stage_rings(_scene("uhbr_engine_bladed")),
    "rigid": lambda: _rigid(_scene("uhbr_engine_bladed")),
    "blades": lambda: _scene("uhbr_engine_bladed"),
}


# -- modes of them, in pairs -----------------------------------------------------------------------


def _shapes(results: Results, speed_rpm: float, places: Sequence[str], limit_hz: float) -> Shapes:
    """Modes at a speed below a limit."""
    top = float(results.campbell.speeds_rad_s.max())
    speed = max(speed_rpm * RAD_S_PER_RPM, _CREEP * top)
    modes = modes_at_speed(results.system, speed)
    assert modes.family is not None  # the engine is the same in all directions
    low = np.flatnonzero(modes.frequency_hz < limit_hz)
    share = participation(results.system, modes)
    unit = [share.bodies[k] for k in share.kinetic_bodies.argmax(axis=0)]
    return Shapes(
        hertz=modes.frequency_hz[low],
        family=modes.family[low],
        error=np.array([_error(results, speed_rpm, modes.frequency_hz[k]) for k in low]),
        unit=[unit[k] for k in low],
        motion=_motion(results, modes, places)[:, low],
    )


def _motion(results: Results, modes: Modes, places: Sequence[str]) -> np.ndarray:
    """Displacements of places, and turns about the axis where bodies have them."""
    whole = results.system.transformation @ modes.shapes
    out = []
    for place in places:
        body, _, rest = place.partition(".")
        element = results.elements[body]
        labels = [c.label for c in element.coordinates]
        rows = whole[results.system.body_slices[body]]
        out.append(rows[labels.index(rest)])
    return np.asarray(out)


def _places(results: Mapping[str, Results]) -> list[str]:
    """Coordinates of interfaces that all engines have, as fan.n4.ux."""
    own = [
        {
            f"{body}.{c.label}"
            for body, element in found.elements.items()
            for c in element.coordinates
            if c.kind == "interface" and c.component in ("ux", "uy", "rz")
        }
        for found in results.values()
    ]
    return sorted(set.intersection(*own))


def _error(results: Results, speed_rpm: float, hertz: float) -> float:
    """Estimated error of the branch with a frequency at a speed of the diagram; nan: unknown."""
    if results.estimates is None:
        return float("nan")
    at = int(np.abs(results.campbell.speeds_rad_s * RPM_PER_RAD_S - speed_rpm).argmin())
    away = np.abs(results.campbell.frequency_hz[:, at] / hertz - 1.0)
    nearest = int(np.nanargmin(away))
    if away[nearest] > 1e3 * _SAME:
        return float("nan")
    return float(results.estimates.campbell.total[nearest, at])


def _partners(first: Shapes, second: Shapes) -> dict[int, tuple[int, float]]:
    """Mode of the second engine for each of the first, and the MAC of both."""
    a, b = (s.motion / np.linalg.norm(s.motion, axis=0) for s in (first, second))
    mac = np.abs(a.conj().T @ b) ** 2
    other = first.family[:, None] != second.family[None]
    far = np.abs(np.log2(first.hertz[:, None] / second.hertz[None])) > _OCTAVES
    mac[other | far] = 0.0
    away = np.abs(np.log2(first.hertz[:, None] / second.hertz[None]))
    rows, columns = linear_sum_assignment(np.where(mac >= _ALIKE, np.sqrt(away) - 1.0 - mac, 0.0))
    return {
        int(i): (int(j), float(mac[i, j]))
        for i, j in zip(rows, columns, strict=True)
        if mac[i, j] >= _ALIKE
    }


def _chain(shapes: Mapping[str, Shapes]) -> list[dict[str, Any]]:
    """Every mode of the engine with rings through all engines, then modes that only blades have."""
    names = list(ENGINES)
    steps = [_partners(shapes[a], shapes[b]) for a, b in pairwise(names)]
    rows, met = [], set()
    for start in range(shapes[names[0]].hertz.size):
        at: int | None = start
        hertz, alike = {names[0]: start}, []
        for name, step in zip(names[1:], steps, strict=True):
            found = step.get(at) if at is not None else None
            at = None if found is None else found[0]
            if found is not None:
                hertz[name] = found[0]
                alike.append(found[1])
        met.add(hertz.get(names[-1]))
        rows.append(_row(shapes, hertz, alike))
    last = shapes[names[-1]]
    own = [k for k in range(last.hertz.size) if k not in met]
    return [*rows, *(_row(shapes, {names[-1]: k}, []) for k in own)]


def _row(
    shapes: Mapping[str, Shapes], index: Mapping[str, int], alike: Sequence[float]
) -> dict[str, Any]:
    first = next(iter(index))
    k = index[first]
    return {
        "unit": shapes[first].unit[k],
        "whirl": _WHIRL[int(shapes[first].family[k])],
        "frequency_hz": {name: float(shapes[name].hertz[i]) for name, i in index.items()},
        "error": {
            name: float(shapes[name].error[i])
            for name, i in index.items()
            if np.isfinite(shapes[name].error[i])
        },
        "mac": [round(v, 3) for v in alike],
    }


# -- critical speeds -------------------------------------------------------------------------------


def _critical(results: Mapping[str, Results], places: Sequence[str]) -> list[dict[str, Any]]:
    """Critical speeds of all engines, those of one shaft and whirl in pairs like the modes."""
    found = {name: _critical_shapes(r, places) for name, r in results.items()}
    shafts = dict.fromkeys(s for own in found.values() for s in own)
    rows = []
    for shaft in shafts:
        chained = _chain({name: own.get(shaft, _none(places)) for name, own in found.items()})
        for row in chained:
            # a critical speed is kept where a mode has its frequency
            speeds = row.pop("frequency_hz")
            rows.append({**row, "excited_by": shaft, "speed_rpm": speeds})
    return rows


def _none(places: Sequence[str]) -> Shapes:
    none = np.zeros(0)
    return Shapes(hertz=none, family=none, error=none, unit=[], motion=np.zeros((len(places), 0)))


def _critical_shapes(results: Results, places: Sequence[str]) -> dict[str, Shapes]:
    """Critical speeds by the shaft whose unbalance excites them, as frequencies, in rpm."""
    errors = None if results.estimates is None else results.estimates.critical_speeds.total
    by_shaft: dict[str, list[tuple[Any, ...]]] = {}
    ratios = results.scene.speed_ratios()
    for k, entry in enumerate(results.critical_speeds):
        critical = entry.critical
        modes = modes_at_speed(results.system, critical.speed_rad_s)
        assert modes.family is not None
        at = int(np.abs(modes.frequency_hz - critical.frequency_hz).argmin())
        if not any(ratios[shaft] * modes.family[at] > 0.0 for shaft in entry.excited_by):
            continue
        share = participation(results.system, modes)
        unit = share.bodies[int(share.kinetic_bodies[:, at].argmax())]
        error = float("nan") if errors is None else float(errors[k])
        rpm = critical.speed_rad_s * RPM_PER_RAD_S
        motion = _motion(results, modes, places)[:, at]
        told = (rpm, int(modes.family[at]), error, unit, motion)
        by_shaft.setdefault(", ".join(entry.excited_by), []).append(told)
    return {
        shaft: Shapes(
            hertz=np.array([o[0] for o in own]),
            family=np.array([o[1] for o in own]),
            error=np.array([o[2] for o in own]),
            unit=[o[3] for o in own],
            motion=np.column_stack([o[4] for o in own]),
        )
        for shaft, own in by_shaft.items()
    }


# -- numbers and picture that are kept -------------------------------------------------------------


def compute() -> None:
    """Run the engines; write numbers and picture."""
    results, engines = dict[str, Results](), dict[str, Any]()
    for name, scene in ENGINES.items():
        found = run_scene(parse_scene(scene()), progress=silent, store=STORE)
        assert found is not None
        results[name] = found
        engines[name] = {
            "coordinates": found.system.size,
            "levels": {body: e.level for body, e in found.elements.items()},
        }
        print(f"{name}: {engines[name]}", file=sys.stderr)
    scene = results["blades"].scene
    places, top = _places(results), float(scene.speeds.to_rpm)
    limit = float(scene.campbell.frequency_max_hz or np.inf)
    document = {
        "engines": engines,
        "masses": _masses(),
        "rows": _blade_rows(),
        "modes": {
            f"{rpm:g}": _chain({n: _shapes(r, rpm, places, limit) for n, r in results.items()})
            for rpm in (0.0, top)
        },
        "critical_speeds": _critical(results, places),
    }
    DATA.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    drawn(
        [_both(results, limit)], "blades.png", "Engine with blades and with rings", "Both diagrams"
    )


def _masses() -> dict[str, Any]:
    """Mass, centre, polar and diametral inertia of every unit with rings and with blades."""
    out: dict[str, Any] = {}
    for engine in ("rings", "blades"):
        for body, built in build_bodies(parse_scene(ENGINES[engine]())).items():
            found = mass_properties(built)
            out.setdefault(body, {})[engine] = [
                found.mass_kg,
                float(found.center_of_gravity_m[2]),
                found.polar_inertia_kg_m2,
                found.diametral_inertia_kg_m2,
            ]
    return out


def _blade_rows() -> list[dict[str, Any]]:
    """Rows of blades, with what is asked of them: mass and inertias of the rings of uhbr_*."""
    rings = {
        (unit, disk.name): disk
        for unit in ("fan", "lp", "hp")
        for disk in build_bodies(parse_scene(_scene(f"uhbr_{unit}")))[unit].rigid_disks
    }
    rows = []
    for body, built in build_bodies(parse_scene(ENGINES["blades"]())).items():
        sections = {s.name: s for s in built.sections}
        for blade in built.features:
            assert isinstance(blade, geo.Blade)
            found = feature_mass_properties(blade, sections[blade.on])
            ring = rings[body, blade.name]
            rows.append(
                {
                    "unit": body,
                    "name": blade.name,
                    "count": blade.count,
                    "length_m": blade.length_m,
                    "chord_m": list(blade.chord_m),
                    "thickness_m": list(blade.thickness_m),
                    "blades": [
                        found.mass_kg, found.polar_inertia_kg_m2, found.diametral_inertia_kg_m2
                    ],
                    "ring": [
                        ring.mass_kg, ring.polar_inertia_kg_m2, ring.diametral_inertia_kg_m2
                    ],
                }
            )  # fmt: skip
    return rows


def _both(results: Mapping[str, Results], limit_hz: float) -> charts.Chart:
    """Both Campbell diagrams in one frame: rings below, blades above."""
    parts: list[charts.Part] = []
    for engine, width in (("rings", 4.0), ("blades", 1.4)):
        diagram = results[engine].campbell
        rpm = diagram.speeds_rad_s * RPM_PER_RAD_S
        for curve in charts.branch_curves(rpm, diagram.frequency_hz, diagram.whirl):
            color = "@ink/0.25" if engine == "rings" else curve.look.color
            look = charts.Look(
                color, "solid" if engine == "rings" else curve.look.dash, "", 4, width
            )
            name = NAMES["rings"] if engine == "rings" else f"{NAMES['blades']}, {curve.name}"
            parts.append(charts.Curve(x=curve.x, y=curve.y, name=name, look=look))
    rpm = results["blades"].campbell.speeds_rad_s * RPM_PER_RAD_S
    for shaft, ratio in results["blades"].scene.speed_ratios().items():
        if not ratio:
            continue
        line = charts.Look("@muted", "dot", width=1.0)
        parts.append(
            charts.Curve(x=rpm, y=abs(ratio) * rpm / 60.0, name=f"1/rev of {shaft}", look=line)
        )
    return charts.Chart(
        name="blades",
        title="Engine with rings (grey) and with elastic blades (in colour)",
        x=charts.speed_axis(float(rpm.min()), float(rpm.max())),
        y=charts.Axis(label="natural frequency", unit="Hz", low=0.0, high=limit_hz),
        parts=parts,
        height_px=560,
    )


# -- the page --------------------------------------------------------------------------------------


def blade_sections(_runs: dict[str, Any], _told: dict[str, Any]) -> list[str]:
    """Sections of the page on the engine with blades, from the numbers that are kept."""
    known = json.loads(DATA.read_text(encoding="utf-8"))
    masses = _mass_table(known)
    at_rest, at_speed = known["modes"].items()
    return [
        "### The engine with blades",
        "**The paper** names no blades. **Ours** above are rigid rings. Scene `uhbr_engine_bladed` "
        "has solid blades in their place, of the fan and all stages of Table 7, each row reduced "
        "by a sector of its own ([blades](blades.md#when-counts-have-no-common-divisor)). What "
        "they look like is inferred, by a rule that the scene states: a row has the mass and the "
        "polar inertia of the ring that it stands for, and its middle is where that ring is. "
        "Computed by `make paper_blades`, which takes longer than the rest of this page: it keeps "
        "[numbers](data/paper_blades.json) and picture.",
        _row_table(known),
        masses,
        "Table 4 holds with blades as with rings; their diametral inertia is not fitted.",
        "![Campbell diagrams with rings and with blades](paper/blades.png)",
        "Three steps lead from rings to elastic blades, while mass, centre and inertias of a unit "
        "stay (above). *Mass moved*: every stage has a ring of its own, with the mass, centre and "
        "inertias of its blades, where one stage of a group had a ring for all. *Attachment*: "
        "blades that do not bend, as their modulus is a thousand times as large; they stiffen the "
        "rims under their roots, and the elements are others. *Flexibility*: the blades' own "
        "modulus on the same mesh. Modes are paired by their motion at the nodes (MAC) and by "
        "nearness, within one whirl; axial motion shows at no node and is paired by nearness "
        "alone. At rest both whirls are one. ± is the estimated error. The basis of elastic blades "
        "is not refined after its first estimate, so that some modes which only the LP unit's "
        "blades have, stiffened by the spin, have large ones.",
        f"At rest{_sums(at_rest[1])}",
        _mode_table(at_rest[1]),
        f"At {float(at_speed[0]):.0f} rpm{_sums(at_speed[1])}",
        _mode_table(at_speed[1]),
        _critical_text(known["critical_speeds"]),
        _mode_table(known["critical_speeds"]),
    ]


def _row_table(known: dict[str, Any]) -> str:
    head = (
        "row", "blades", "length [mm]", "chord [mm]", "thickness, root to tip [mm]",
        "mass [kg]", "ring", "polar inertia [kg m²]", "ring", "diametral", "ring",
    )  # fmt: skip
    rows = []
    for row in known["rows"]:
        pairs = zip(row["blades"], row["ring"], strict=True)
        rows.append(
            (
                f"{row['unit']}: {row['name']}",
                str(row["count"]),
                f"{1e3 * row['length_m']:.0f}",
                _ends(row["chord_m"], ".0f"),
                _ends(row["thickness_m"], ".1f"),
                *(f"{value:.4g}" for pair in pairs for value in pair),
            )
        )
    return markdown(head, rows)


def _ends(values: Sequence[float], digits: str) -> str:
    return " to ".join(dict.fromkeys(f"{1e3 * value:{digits}}" for value in values))


def _mass_table(known: dict[str, Any]) -> str:
    head = ("unit", "", "mass [kg]", "centre [m]", "polar [kg m²]", "diametral [kg m²]")
    rows = []
    for unit, own in known["masses"].items():
        told = {"paper": SOURCE["table_4"][unit], **own}
        for name, values in told.items():
            rows.append((unit, NAMES.get(name, name), *(f"{v:.5g}" for v in values)))
    return markdown(head, rows)


def _value(row: Mapping[str, Any]) -> Mapping[str, float]:
    """Frequencies, or critical speeds, by engine."""
    found: Mapping[str, float] = row.get("frequency_hz") or row["speed_rpm"]
    return found


def _change(row: Mapping[str, Any], first: str, second: str) -> float | None:
    own = _value(row)
    return own[second] / own[first] - 1.0 if first in own and second in own else None


_STEPS = {
    "mass moved": ("rings", "stage_rings"),
    "attachment": ("stage_rings", "rigid"),
    "flexibility": ("rigid", "blades"),
}


def _mode_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """A line for each mode that has a pair from the rings on, then a line on those of blades."""
    unit = "rpm" if "speed_rpm" in rows[0] else "Hz"
    head = ("unit", "whirl", *(f"{name} [{unit}]" for name in NAMES.values()), *_STEPS, "MAC")
    out = []
    for row in (r for r in rows if "rings" in _value(r)):
        own = _value(row)
        shift = [_change(row, *pair) for pair in _STEPS.values()]
        who = (
            f"{row['unit']}, excited by {row['excited_by']}" if "excited_by" in row else row["unit"]
        )
        out.append(
            (
                who,
                row["whirl"],
                *(_with_error(own.get(name), row["error"].get(name)) for name in NAMES),
                *("no pair" if s is None else f"{s:+.2%}" for s in shift),
                f"{min(row['mac']):.2f}" if row["mac"] else "",
            )
        )
    return markdown(head, out)


def _with_error(value: float | None, error: float | None) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" + (f" ± {value * error:.1g}" if error else "")


def _sums(rows: Sequence[Mapping[str, Any]]) -> str:
    """Which modes blades change by bending, and how many only they have."""
    moved = [
        (abs(shift), row) for row in rows if (shift := _change(row, "rigid", "blades")) is not None
    ]
    most = sorted(moved, key=lambda pair: -pair[0])[:_NAMED]
    told = ", ".join(
        f"{row['unit']} {row['whirl']} at {_value(row)['rigid']:.1f} Hz by "
        f"{_change(row, 'rigid', 'blades'):+.1%}"
        for _, row in most
    )
    own = [r for r in rows if list(_value(r)) == ["blades"]]
    return (
        f", flexibility moves most: {told}. {len(own)} modes have no pair without elastic blades: "
        f"{_of_blades(own)}."
    )


# Modes that the text names.
_NAMED = 4


def _of_blades(rows: Sequence[Mapping[str, Any]]) -> str:
    by: dict[str, list[float]] = {}
    for row in rows:
        by.setdefault(f"{row['unit']} {row['whirl']}", []).append(_value(row)["blades"])
    told = (f"{name} {', '.join(f'{v:.1f}' for v in sorted(own))} Hz" for name, own in by.items())
    return "; ".join(told) or "none"


def _critical_text(rows: Sequence[Mapping[str, Any]]) -> str:
    own = [r for r in rows if list(_value(r)) == ["blades"]]
    lost = [r for r in rows if "rings" in _value(r) and "blades" not in _value(r)]
    return (
        "Critical speeds in revolutions of the low pressure shaft, those of whirl that the "
        "unbalance of a shaft excites, paired in the same way. "
        f"{len(own)} are of elastic blades alone; {len(lost)} of the engine with rings have no "
        "pair there."
    )


if __name__ == "__main__":
    compute()
