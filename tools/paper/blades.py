"""Section of the page on the engine with blades as bladed sectors, against blades as rings.

`python tools/paper/blades.py` computes the engine four times: with rings as in uhbr_engine, with a
ring on every stage, with rigid blades and with elastic ones. It writes the numbers and the picture
that the page shows; the page alone computes nothing of it.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from paper.rows import markdown, with_error  # noqa: E402
from paper.runs import SOURCE, STORE, drawn  # noqa: E402
from paper.variants import stiffer  # noqa: E402

from solidwhirl import geometry as geo  # noqa: E402
from solidwhirl.build import disk  # noqa: E402
from solidwhirl.core.stages import silent  # noqa: E402
from solidwhirl.geometry import mass_properties  # noqa: E402
from solidwhirl.geometry.mass_properties import feature_mass_properties  # noqa: E402
from solidwhirl.model.bodies import build_bodies  # noqa: E402
from solidwhirl.pipeline.run import Results, run_for_page  # noqa: E402
from solidwhirl.rotordyn import Modes, modes_at_speed  # noqa: E402
from solidwhirl.rotordyn.campbell.branch_numbers import modal_assurance  # noqa: E402
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S  # noqa: E402
from solidwhirl.rotordyn.modes.participation import participation  # noqa: E402
from solidwhirl.rotordyn.plots import chart as charts  # noqa: E402
from solidwhirl.rotordyn.plots.campbell import excitation_lines  # noqa: E402
from solidwhirl.scene_reading.reader import load_toml, parse_scene  # noqa: E402

DATA = ROOT / "docs" / "data" / "paper_blades.json"
SCENES = ROOT / "scenes"
#: What each engine is called on the page
NAMES = {
    "rings": "rings as above",
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
# A branch of the diagram nearer than this (relative) is the mode.
_SAME = 1e-3
_WHIRL = {1: "forward", -1: "backward", 0: "axial, torsion"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Mode:
    """A mode or critical speed, and how the places move that all engines have.

    `value`: frequency in Hz or speed in rpm; `family`: whirl as in `Modes.family`; `unit`: the one
    with the most kinetic energy; `motion`: (places,); `error`: relative, estimated.
    """

    value: float
    family: int
    unit: str
    motion: np.ndarray
    error: float = math.nan


# -- the engines -----------------------------------------------------------------------------------


def _scene(name: str) -> dict[str, Any]:
    """A scene without its analyses and references."""
    data = load_toml(SCENES / f"{name}.toml")
    return {k: v for k, v in data.items() if k not in ("analyses", "references")}


def _rigid(data: dict[str, Any]) -> dict[str, Any]:
    """The engine with blades, these much stiffer; errors are those of the same mesh."""
    materials = dict(data.get("materials", {}))
    bodies = {}
    for name, body in data["bodies"].items():
        rows = [{**row, "material": f"{row['material']}_stiff"} for row in body["blades"]]
        for row, own in zip(rows, body["blades"], strict=True):
            materials[row["material"]] = stiffer(geo.MATERIALS[own["material"]], _RIGID)
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
                disk(
                    blade.name,
                    mass_kg=found.mass_kg,
                    polar=found.polar_inertia_kg_m2,
                    diametral=found.diametral_inertia_kg_m2,
                    interface=f"{blade.name}_ring",
                    offset_m=float(found.center_of_gravity_m[2]) - middle,
                )
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


def _modes(results: Results, speed_rad_s: float, places: Sequence[str]) -> list[Mode]:
    """All modes at a speed."""
    modes = modes_at_speed(results.system, speed_rad_s)
    assert modes.family is not None  # the engine is the same in all directions
    share = participation(results.system, modes)
    motion, most = _motion(results, modes, places), share.kinetic_bodies.argmax(axis=0)
    return [
        Mode(
            value=float(hertz),
            family=int(modes.family[k]),
            unit=share.bodies[most[k]],
            motion=motion[:, k],
        )
        for k, hertz in enumerate(modes.frequency_hz)
    ]


def _modes_below(
    results: Results, speed_rpm: float, places: Sequence[str], limit_hz: float
) -> list[Mode]:
    """Modes at a speed of the diagram below a limit, with their errors."""
    top = float(results.campbell.speeds_rad_s.max())
    found = _modes(results, max(speed_rpm * RAD_S_PER_RPM, _CREEP * top), places)
    return [
        replace(mode, error=_error(results, speed_rpm, mode.value))
        for mode in found
        if mode.value < limit_hz
    ]


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
        return math.nan
    at = int(np.abs(results.campbell.speeds_rad_s * RPM_PER_RAD_S - speed_rpm).argmin())
    away = np.abs(results.campbell.frequency_hz[:, at] / hertz - 1.0)
    nearest = int(np.nanargmin(away))
    if away[nearest] > _SAME:
        return math.nan
    return float(results.estimates.campbell.total[nearest, at])


def _partners(first: Sequence[Mode], second: Sequence[Mode]) -> dict[int, tuple[int, float]]:
    """Mode of the second engine for each of the first, and the MAC of both."""
    if not first or not second:
        return {}
    mac = modal_assurance(*(np.array([m.motion for m in own]) for own in (first, second)))
    (family, value), (others, values) = (
        np.array([(m.family, m.value) for m in own]).T for own in (first, second)
    )
    away = np.abs(np.log2(value[:, None] / values))
    mac[(family[:, None] != others) | (away > _OCTAVES)] = 0.0
    rows, columns = linear_sum_assignment(np.where(mac >= _ALIKE, np.sqrt(away) - 1.0 - mac, 0.0))
    return {
        int(i): (int(j), float(mac[i, j]))
        for i, j in zip(rows, columns, strict=True)
        if mac[i, j] >= _ALIKE
    }


def _chain(modes: Mapping[str, Sequence[Mode]], what: str) -> list[dict[str, Any]]:
    """Every mode of the engine with rings through all engines, then modes that only blades have."""
    steps = {(a, b): _partners(modes[a], modes[b]) for a, b in pairwise(ENGINES)}
    begin, *_, last = ENGINES
    rows, met = [], set()
    for start in range(len(modes[begin])):
        at, alike = {begin: start}, []
        for (a, b), step in steps.items():
            if at[a] not in step:
                break
            at[b], mac = step[at[a]]
            alike.append(round(mac, 3))
        met.add(at.get(last))
        rows.append(_row({name: modes[name][k] for name, k in at.items()}, alike, what))
    own = [mode for k, mode in enumerate(modes[last]) if k not in met]
    return [*rows, *(_row({last: mode}, [], what) for mode in own)]


def _row(modes: Mapping[str, Mode], alike: Sequence[float], what: str) -> dict[str, Any]:
    first = next(iter(modes.values()))
    return {
        "unit": first.unit,
        "whirl": _WHIRL[first.family],
        what: {name: mode.value for name, mode in modes.items()},
        "error": {name: mode.error for name, mode in modes.items() if math.isfinite(mode.error)},
        "mac": alike,
    }


# -- critical speeds -------------------------------------------------------------------------------


def _critical(results: Mapping[str, Results], places: Sequence[str]) -> list[dict[str, Any]]:
    """Critical speeds of all engines, those of one shaft and whirl in pairs like the modes."""
    found = {name: _critical_speeds(r, places) for name, r in results.items()}
    shafts = dict.fromkeys(s for own in found.values() for s in own)
    return [
        {**row, "excited_by": shaft}
        for shaft in shafts
        for row in _chain({name: own.get(shaft, []) for name, own in found.items()}, "speed_rpm")
    ]


def _critical_speeds(results: Results, places: Sequence[str]) -> dict[str, list[Mode]]:
    """Critical speeds by the shaft whose unbalance excites them."""
    estimates, ratios = results.estimates, results.scene.speed_ratios()
    by_shaft: dict[str, list[Mode]] = {}
    for k, entry in enumerate(results.critical_speeds):
        critical = entry.critical
        modes = _modes(results, critical.speed_rad_s, places)
        mode = min(modes, key=lambda m: abs(m.value - critical.frequency_hz))
        if any(ratios[shaft] * mode.family > 0.0 for shaft in entry.shafts):
            rpm = critical.speed_rad_s * RPM_PER_RAD_S
            error = math.nan if estimates is None else float(estimates.critical_speeds.total[k])
            own = by_shaft.setdefault(", ".join(entry.shafts), [])
            own.append(replace(mode, value=rpm, error=error))
    return by_shaft


# -- numbers and picture that are kept -------------------------------------------------------------


def compute() -> None:
    """Run the engines; write numbers and picture."""
    results, engines = dict[str, Results](), dict[str, Any]()
    for name, scene in ENGINES.items():
        found = run_for_page(parse_scene(scene()), progress=silent, store=STORE)
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
            f"{rpm:g}": _chain(
                {n: _modes_below(r, rpm, places, limit) for n, r in results.items()}, "frequency_hz"
            )
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
    rings, blades = (
        charts.branch_curves(d.speeds_rad_s * RPM_PER_RAD_S, d.frequency_hz, d.whirl)
        for d in (results["rings"].campbell, results["blades"].campbell)
    )
    grey = charts.Look("@ink/0.25", width=4.0)
    parts: list[charts.Part] = [replace(c, name=NAMES["rings"], look=grey) for c in rings]
    for c in blades:
        look = replace(c.look, mark="", width=1.4)
        parts.append(replace(c, name=f"{NAMES['blades']}, {c.name}", look=look))
    rpm = results["blades"].campbell.speeds_rad_s * RPM_PER_RAD_S
    ratios = {n: abs(r) for n, r in results["blades"].scene.speed_ratios().items() if r}
    parts.append(excitation_lines(ratios, float(rpm.max()), limit_hz))
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
        _mass_table(known),
        "Table 4 holds with blades as with rings; their diametral inertia is not fitted.",
        "![Campbell diagrams with rings and with blades](paper/blades.png)",
        "Three steps lead from rings to elastic blades, while mass, centre and inertias of a unit "
        "stay (above). *Mass moved*: every stage has a ring of its own, with the mass, centre and "
        "inertias of its blades, where above some stages share one. *Attachment*: "
        "blades that do not bend, as their modulus is a thousand times as large; they stiffen the "
        "rims under their roots, and the elements are others. *Flexibility*: the blades' own "
        "modulus on the same mesh. Modes are paired by their motion at the nodes (MAC) and by "
        "nearness, within one whirl; axial motion shows at no node and is paired by nearness "
        "alone. Nothing acts on the units along the axis: they are free there. "
        "At rest both whirls are one. ± is the estimated error. The basis of elastic blades "
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
                *(
                    with_error(own[n], own[n] * row["error"].get(n, 0.0)) if n in own else ""
                    for n in NAMES
                ),
                *("no pair" if s is None else f"{s:+.2%}" for s in shift),
                f"{min(row['mac']):.2f}" if row["mac"] else "",
            )
        )
    return markdown(head, out)


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
