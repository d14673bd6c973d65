"""Section 5 of Müller and Hennings: what the paper asks of each unit on its own bearings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from paper.mode_counts import SEARCHES as MODE_SEARCHES
from paper.mode_counts import mode_count_sections
from paper.rows import Row, listed, markdown, per_cent, with_error, words
from paper.runs import SOURCE, STORE, drawn
from paper.variants import TRIES, Turning, equally_good, rotating
from paper.variants import UNITS as SOUGHT

from solidwhirl.analyses.kinds.bearing_laws import Law, law_chart
from solidwhirl.analyses.kinds.critical_speed_map import map_curves
from solidwhirl.analyses.responses.unbalance_response import exciters_of
from solidwhirl.core.blocks import numbers
from solidwhirl.core.key_units import unit_of
from solidwhirl.rotordyn import LEE_ANISOTROPIC, End, modes_at_speed
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.maps import MapCurves, map_chart
from solidwhirl.rotordyn.plots.response import amplitude_chart
from solidwhirl.rotordyn.plots.response_maps import ground_chart, place_chart, stiffness_chart
from solidwhirl.rotordyn.response.maps import ground_motion_map

UNITS = {"lp": "uhbr_lp", "hp": "uhbr_hp", "fan": "uhbr_fan"}
DESIGN = SOURCE["section_5_1"]["design_rpm"]
SIX = SOURCE["table_6"]
# The four printed polynomials, of rad/s.
KXX, KYY, DXX, DYY = (
    Polynomial(getattr(LEE_ANISOTROPIC, key))
    for key in ("stiffness_x", "stiffness_y", "damping_x", "damping_y")
)
# A critical speed depends on the stiffness where its slope in logarithms is this part of that of a
# rigid body on springs, 1/2, or more.
_DEPENDS = 0.1
# Frequencies of two models nearer than this (relative) are told as one.
_NEAR = 0.02
_FRAMES = ("rotating", "inertial")
# Points of a curve.
_POINTS = 800


_EQUALLY_GOOD = partial(equally_good, "lp", float(SIX["rpm"]), STORE)
#: What is computed beside the scenes, and kept in files
SEARCHES = (*MODE_SEARCHES, _EQUALLY_GOOD)


def unit_sections(runs: dict[str, Any], told: dict[str, list[Row]]) -> list[str]:
    """Sections of the page on the units alone; adds the rows of their tables to `told`."""
    lp = runs["uhbr_lp"]
    told["Table 4"] = _table_4(runs)
    told["Table 5"] = [*_table_5_at_design(), *_table_5_over_speed()]
    told["Table 6"] = _table_6(lp)
    told["Figure 15"] = _figure_15(lp)
    return [
        "## Section 5: the units of the geared engine",
        "**The paper** models fan, low and high pressure unit of a geared turbofan by stage tables "
        "(Table 7), and withholds shafts, connections, blades and materials. **We** identify what "
        "it withholds from its masses and frequencies at rest ([identify.md](identify.md)): scenes "
        "`uhbr_fan`, `uhbr_lp`, `uhbr_hp`, each unit on its bearings to the ground.",
        "### Table 4: masses, centres of gravity, inertias",
        listed(told["Table 4"]),
        "The casing is what the three units leave of the whole engine, so the totals close by "
        "construction: they say that the remainder is a body (its inertias are positive), no more.",
        "### Section 5.1: modes of the units",
        *mode_count_sections(),
        "### Table 5 and Figure 8: bearings that depend on the speed",
        *_bearing_sections(told["Table 5"]),
        "### Figure 9: critical speed maps of three units",
        *_map_sections(runs),
        "### Figure 10: design of experiments, and the choice of stiffness",
        *_study_sections(lp),
        "### Table 6: frequencies of the low pressure unit",
        *_frequency_sections(lp, told["Table 6"]),
        "### Figures 12 and 13: mode shapes of the low pressure unit",
        lp.picture("mode_shapes_0rpm_lp.png", "Shapes at rest"),
        lp.picture(f"mode_shapes_{SIX['rpm']}rpm_lp.png", "Shapes at speed"),
        _shape_text(lp),
        "### Figures 14 and 15: unbalance response over place and frequency",
        *_response_sections(lp, told["Figure 15"]),
        "### Figure 16: waterfall of ground vibration, in both frames",
        *_waterfall_sections(lp),
    ]


def _references(run: Any, begin: str, family: str, errors: Sequence[float] = ()) -> list[Row]:
    """Rows of the references that the scene itself has, of quantities that begin so."""
    found = [e for e in run.document["references"] if e["quantity"].startswith(begin)]
    rows = []
    for entry in found:
        number = entry["quantity"].partition("[")[2].rstrip("]")
        error = errors[int(number)] if errors else 0.0
        told = (entry["value"], entry["result"], unit_of(entry["quantity"]), "identified")
        rows.append(per_cent(family, entry["title"], *told, error))
    return rows


# -- Table 4 ---------------------------------------------------------------------------------------


def _table_4(runs: dict[str, Any]) -> list[Row]:
    rows = [
        row
        for unit, name in UNITS.items()
        for row in _references(runs[name], "bodies.", f"{unit}: mass properties")
    ]
    parts = list(runs["uhbr_engine"].document["bodies"].values())
    masses = np.array([p["mass_kg"] for p in parts])
    places = np.array([p["center_of_gravity_m"][2] for p in parts])
    mass, center = masses.sum(), float(masses @ places / masses.sum())
    polar = sum(p["polar_inertia_kg_m2"] for p in parts)
    diametral = sum(p["diametral_inertia_kg_m2"] for p in parts)
    ours = (mass, center, polar, diametral + masses @ (places - center) ** 2)
    what = ("mass", "centre of gravity", "polar inertia", "diametral inertia")
    for name, unit, printed, value in zip(
        what, ("kg", "m", "kg·m²", "kg·m²"), SOURCE["table_4"]["engine"], ours, strict=True
    ):
        told = (f"engine: {name}", printed, float(value), unit, "casing is the rest")
        rows.append(per_cent("engine: mass properties", *told))
    return rows


# -- Table 5 and Figure 8 --------------------------------------------------------------------------


def _table_5_at_design() -> list[Row]:
    """Printed stiffness at the design point over that at rest against kxx there."""
    family = "kxx at the design speed of the unit"
    return [
        per_cent(
            family,
            f"{unit}: stiffness at design point over that at rest",
            SOURCE["table_5"][unit][1] / SOURCE["table_5"][unit][0],
            float(KXX(rpm * RAD_S_PER_RPM)),
            "",
            "paper; rad/s assumed",
        )
        for unit, rpm in DESIGN.items()
    ]


def _table_5_over_speed() -> list[Row]:
    """Design speed against the one at which kxx has the printed ratio, the highest if several."""
    rows = []
    for unit, rpm in DESIGN.items():
        at_rest, at_design, _ = SOURCE["table_5"][unit]
        speed = speed_of_ratio(at_design / at_rest)
        what = f"{unit}: speed at which kxx has the printed ratio"
        told = (rpm * RAD_S_PER_RPM, speed, "rad/s", "paper; rad/s assumed")
        rows.append(per_cent("speed at which kxx has the printed ratio", what, *told))
    return rows


def speed_of_ratio(ratio: float) -> float:
    """Return the speed at which kxx over that at rest has a value, the highest if several."""
    return max(_real_roots(KXX - ratio))


def _real_roots(polynomial: Polynomial) -> list[float]:
    return [float(r.real) for r in polynomial.roots() if abs(r.imag) < 1e-9 * abs(r)]


def _bearing_sections(rows: Sequence[Row]) -> list[str]:
    top = max(DESIGN.values()) * RAD_S_PER_RPM
    speeds = np.linspace(0.0, 1.1 * top, _POINTS)
    both = {
        "stiffness": (KXX(speeds), KYY(speeds)),
        "damping": (DXX(speeds), DYY(speeds)),
    }
    matrices = {
        key: np.array([np.diag(pair) for pair in zip(*values, strict=True)])
        for key, values in both.items()
    }
    law = Law(
        bearing="over that at rest:",
        law="Appendix A to the highest design speed",
        speed_rpm=speeds * RPM_PER_RAD_S,
        range_rpm=(0.0, top * RPM_PER_RAD_S),
        **matrices,
    )
    shown = [
        replace(law_chart([(law, matrices[key])], key.capitalize(), "1"), title=key) for key in both
    ]
    negative = {
        name: min(root for root in _real_roots(p) if root > 0)
        for name, p in (("x", DXX), ("y", DYY))
    }
    ends = words((KXX(0.0), KYY(0.0), DXX(0.0), DYY(0.0)), ".3g")
    listed_ends = " and ".join(
        f"{speed:.0f} rad/s ({speed * RPM_PER_RAD_S:.0f} rpm) in {axis}"
        for axis, speed in negative.items()
    )
    lowest = float(speeds[np.argmin(KXX(speeds))])
    return [
        drawn(shown, "figure_8.png", "Figure 8", "The four printed polynomials"),
        listed(rows),
        "**The paper** draws stiffness and damping over those at rest, after Lee (1993), and "
        "prints four polynomials (Appendix A). **Ours** are these. They begin at "
        f"{ends} for kxx, kyy, dxx, dyy: those of y are not normalised to their own value at rest. "
        f"Stiffness kxx falls to {KXX(lowest):.2g} at {lowest:.0f} rad/s before it rises. Damping "
        f"breaks: it turns negative from {listed_ends}, below the design point of the low pressure "
        f"unit ({DESIGN['lp']:.0f} rpm). Table 5 can be read in two ways, of which the paper does "
        "not say which it means: the stiffness at the design speed of each unit, or the speed at "
        "which kxx has the printed ratio. The table above has both; at a steep place of a "
        "polynomial a small error of the speed is a large one of the stiffness. The scenes take "
        "the printed stiffness kxx in both directions and keep the damping of Table 5.",
    ]


# -- Figure 9 --------------------------------------------------------------------------------------


def _map_sections(runs: dict[str, Any]) -> list[str]:
    shown, rows = [], []
    for unit, name in UNITS.items():
        at_rest, at_design, _ = SOURCE["table_5"][unit]
        spins = np.linspace(0.0, 1.1 * DESIGN[unit], _POINTS)
        laws = [
            (f"{text} of Appendix A", at_rest * law(spins * RAD_S_PER_RPM), spins)
            for text, law in (("kxx", KXX), ("kyy", KYY))
        ]
        # a unit alone is its own reference
        curves = map_curves(
            runs[name].analysis("critical_speed_map"),
            1.0,
            chosen={at_rest: "Table 5, at rest", at_design: "design point"},
            supports=laws,
        )
        # one axis below three maps
        curves = replace(curves, bearings=["both bearings"])
        shown.append(replace(map_chart(curves, {unit: DESIGN[unit]}, unit), title=unit))
        rows += _dependence(unit, curves)
    head = ("unit", "critical speed", "whirl", "depends on the stiffness [N/m]")
    said = SOURCE["section_5_3"]
    return [
        drawn(shown, "figure_9.png", "Figure 9", "Critical speed maps of three units"),
        markdown(head, rows),
        "**The paper** says that the first critical speed depends on the stiffness up to "
        f"{said['first_up_to']:.0e} N/m, the second up to {said['second_up_to']:.0e}, that the "
        f"third becomes rigid above {said['rigid_from']:.0e}, that the first of the low pressure "
        f"unit depends less above {said['first_of_lp_less_from']:.0e}, and the third from "
        + " and from ".join(f"{low:.0e} to {high:.0e}" for low, high in said["third"])
        + ". It gives no measure of dependence. **Ours**, from the maps above, is by a threshold "
        f"of our own: a branch depends where its slope in logarithms is {0.5 * _DEPENDS:g} or "
        f"more, {_DEPENDS:.0%} of the 1/2 of a rigid body on springs; another threshold gives "
        f"other ranges. Their ends are known to a step of the maps, a factor of "
        f"{curves.stiffness_n_per_m[1] / curves.stiffness_n_per_m[0]:.2g}; "
        f"{curves.stiffness_n_per_m[0]:.0e} N/m is the end of the maps. The curve "
        "k(Ω), which the caption of the paper's figure names, is drawn over the map: where it "
        "meets a branch is a "
        "critical speed.",
    ]


def _dependence(unit: str, curves: MapCurves) -> Iterator[tuple[str, ...]]:
    """Ranges of stiffness on which the first three branches depend."""
    stiffness = curves.stiffness_n_per_m
    for number, (branch, sense) in enumerate(zip(curves.speed_rpm[:3], curves.whirl, strict=False)):
        known = np.isfinite(branch)
        if np.count_nonzero(known) < 3:
            continue
        slope = np.gradient(np.log(branch[known]), np.log(stiffness[known]))
        on = stiffness[known][slope >= 0.5 * _DEPENDS]
        kinds = dict.fromkeys(w for w in sense if w)
        ranged = f"{on.min():.1e} to {on.max():.1e}" if on.size else "nowhere"
        yield unit, str(number + 1), ", then ".join(kinds), ranged


# -- Figure 10 -------------------------------------------------------------------------------------


def _study_sections(lp: Any) -> list[str]:
    studies = {
        "compressor stage 3": lp.analysis("stiffness_study"),
        "last turbine stage": lp.analysis("stiffness_study_turbine"),
    }
    chosen = dict(zip(("at rest", "at the design point"), SOURCE["table_5"]["lp"], strict=False))
    curves, said = list[charts.Mark](), []
    for number, (place, found) in enumerate(studies.items()):
        stiffness, largest = _in_band(found)
        look = charts.series_look(number)
        curves.append(charts.Curve(x=stiffness, y=largest, name=place, look=look))
        best = found["chosen_stiffness_n_per_m"]
        at = np.interp(np.log(list(chosen.values())), np.log(stiffness), np.log(largest))
        end = ", an end of the range," if found["choice_is_at_the_end_of_the_range"] else ""
        said.append(
            f"at the {place} the smallest is {largest.min() * 1e9:.2g} nm at {best:.2g} N/m{end} "
            f"and at the paper's stiffnesses at rest and at the design point it is "
            f"{words(np.exp(at) / largest.min(), '.3g')} times that"
        )
    curves += [
        charts.Rule(at=value, name=f"paper, {text}: {value:.3g} N/m")
        for text, value in chosen.items()
    ]
    chart = charts.Chart(
        name="figure-10",
        title="largest response around the operating speed",
        x=charts.Axis(label="stiffness of C, D", unit="N/m", is_log=True),
        y=charts.Axis(label="largest displacement in the band", unit="m", is_log=True),
        parts=curves,
    )
    first = studies["compressor stage 3"]
    margin = first["margin"]
    step = float(np.diff(np.log(numbers(first["stiffness_n_per_m"]))).max())
    return [
        _study_map(first, chosen),
        drawn([chart], "figure_10.png", "Figure 10", "Response over the stiffness, by place"),
        "**The paper** excites compressor stage 3 by a force that grows with the square of its "
        "frequency, varies both stiffnesses and takes what moves least; then it excites the "
        "turbine for the values of Table 5. **Ours** does the same at the rings of blades, the "
        "shaft at rest: "
        + "; ".join(said)
        + f". The band is ±{margin:.0%} of the operating speed; stiffnesses are a factor of "
        f"{np.exp(step):.2g} apart. Very stiff bearings hardly move, "
        "and neither do their dampers: heights are then those of the damping that is left.",
    ]


def _study_map(found: dict[str, Any], chosen: dict[str, float]) -> str:
    """The response over frequency and stiffness, with the stiffnesses of the paper."""
    hertz, stiffness = numbers(found["frequency_hz"]), numbers(found["stiffness_n_per_m"])
    chart = stiffness_chart(hertz, stiffness, numbers(found["highest_m"]).reshape(-1, hertz.size))
    lines = [
        charts.Curve(
            x=hertz[[0, -1]],
            y=np.array([value, value]),
            name=f"paper, {text}: {value:.3g} N/m",
            look=replace(charts.WHITE, dash=dash),
        )
        for (text, value), dash in zip(chosen.items(), ("dash", "dot"), strict=True)
    ]
    chart = replace(chart, parts=[*chart.parts, *lines])
    text = "Response at stage 3 over frequency and stiffness"
    return drawn([chart], "figure_10_map.png", "Figure 10", text)


def _in_band(found: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Stiffnesses and the highest response of each in the band around the operating speed."""
    stiffness, hertz = numbers(found["stiffness_n_per_m"]), numbers(found["frequency_hz"])
    highest = numbers(found["highest_m"]).reshape(stiffness.size, hertz.size)
    middle = found["operating_speed_rpm"] / 60.0
    inside = np.abs(hertz / middle - 1.0) <= found["margin"]
    return stiffness, highest[:, inside].max(axis=1)


# -- Table 6 ---------------------------------------------------------------------------------------


def _table_6(lp: Any) -> list[Row]:
    """Modes at rest, and those at speed that come nearest to the printed ones in either frame."""
    _, found = lp.analysis("mode_shapes")["speeds"]
    rows = _references(lp, "modes_at_rest.", "modes at rest", lp.errors_at_rest)
    own, spin = found["frequency_hz"], SIX["rpm"] / 60.0
    frames = {"rotating": rotating(own, found["whirl"], spin), "inertial": np.array(own)}
    error = _error_at(lp, SIX["rpm"]) * np.array(own)
    for frame, hertz in frames.items():
        for number, printed in enumerate(SIX["undamped"]):
            at = int(np.abs(hertz - printed).argmin())
            ours = float(hertz[at])
            what = f"mode {number + 1} at {SIX['rpm']} rpm, nearest in the {frame} frame"
            family = f"nearest modes at {SIX['rpm']} rpm, {frame} frame"
            told = (printed, ours, "Hz", "prediction", float(error[at]) / ours)
            rows.append(per_cent(family, what, *told))
    return rows


def _error_at(run: Any, rpm: float) -> float:
    """Largest estimated error of the branches of a diagram at its speed nearest to this one."""
    speeds, errors = run.branches("frequency_error_estimate")
    return float(np.nanmax(errors[:, int(np.abs(speeds - rpm).argmin())]))


def _frequency_sections(lp: Any, rows: Sequence[Row]) -> list[str]:
    _, found = lp.analysis("mode_shapes")["speeds"]
    units = _EQUALLY_GOOD()
    decay = [f * d for f, d in zip(found["frequency_hz"], found["log_decrement"], strict=True) if d]
    undamped, damped = (np.array(SIX[key]) for key in ("undamped", "damped"))
    ratio = np.sqrt(1.0 - (undamped / damped) ** 2)
    implied = 2.0 * np.pi * damped * ratio
    at_speed = {f: [r for r in rows if r.family.endswith(f"{f} frame")] for f in _FRAMES}
    told = "; ".join(
        f"in the {frame} frame {min(r.difference for r in own):+.1f} to "
        f"{max(r.difference for r in own):+.1f} %, {len({r.ours for r in own})} of our modes for "
        f"all {len(own)}, {sum(abs(r.difference) <= 100 * _NEAR for r in own)} within {_NEAR:.0%}"
        for frame, own in at_speed.items()
    )
    return [
        listed(rows),
        "**The paper** gives eight frequencies at rest, and six at "
        f"{SIX['rpm']} rpm, undamped f and damped f0, in the rotating frame. **Ours** at rest are "
        f"identified; those at {SIX['rpm']} rpm were not used: they are a prediction. Each row "
        f"takes our nearest mode, chosen afterwards: {told}.",
        _spread_table(units),
        _spread_text(units),
        f"Are the last two columns swapped? In {np.count_nonzero(damped > undamped)} of "
        f"{damped.size} rows the value printed as damped is the larger one, "
        "as f = f0 √(1 − D²) demands if f0 were the undamped one. The implied D are then "
        f"{words(ratio, '.3f')}, and the implied |Re λ| {words(implied, '.0f')} 1/s; ours at that "
        f"speed lie from {min(decay):.2g} to {max(decay):.2g} 1/s. This is an inference; ours has "
        "no such damping, and the paper's frames leave it open.",
    ]


def _by_rank(hertz: Sequence[Sequence[float] | np.ndarray]) -> np.ndarray:
    """Frequencies of units as far as all of them have one, (units, modes)."""
    count = min(map(len, hertz))
    return np.array([own[:count] for own in hertz])


def _spread_table(units: Sequence[Turning]) -> str:
    """Frequencies at speed of the identified unit and of all, by rank."""
    fixed = _by_rank([u.frequency_hz for u in units])
    seen = _by_rank([u.seen_by(SIX["rpm"]) for u in units])
    rows = [
        (
            str(k + 1),
            " or ".join(dict.fromkeys(u.whirl[k] for u in units)),
            f"{fixed[0, k]:.1f}",
            f"{fixed[:, k].min():.1f} to {fixed[:, k].max():.1f}",
            f"{seen[0, k]:.1f}",
            f"{seen[:, k].min():.1f} to {seen[:, k].max():.1f}",
        )
        for k in range(fixed.shape[1])
    ]
    head = ("mode", "whirl", "identified [Hz]", "all", "rotating frame [Hz]", "all in that frame")
    return markdown(head, rows)


def _spread_text(units: Sequence[Turning]) -> str:
    """How many equally good units there are, how far apart, and what none of them has."""
    away = [u.away for u in units[1:]]
    text = (
        f"Is that a matter of the unit chosen? {SOUGHT} other units were sought in {TRIES} tries "
        "along the directions that the eight printed numbers leave free, and "
    )
    if not away:
        return text + "none was found that meets all of them to their tolerances."
    spread = np.ptp(_by_rank([u.frequency_hz for u in units]), axis=0)
    every = [f for u in units for f in (*u.frequency_hz, *u.seen_by(SIX["rpm"]))]
    lost = [f for f in SIX["undamped"] if np.abs(np.array(every) / f - 1.0).min() > _NEAR]
    return (
        f"{text}{len(away)} were found that meet all of them to their tolerances; their parameter "
        f"that moved most did so by {min(away):.2f} to {max(away):.2f} of its range. The table has "
        f"the spread of the modes at speed of all {len(units)} units: {spread.min():.1f} to "
        f"{spread.max():.1f} Hz of a mode. No more than that is known of other units of the same "
        "arrangement. "
        + (
            f"None of these has, in either frame, a mode within {_NEAR:.0%} of the paper's "
            f"{words(lost, '.1f')} Hz."
            if lost
            else f"Each printed value has, in one of the frames, a mode of one of these within "
            f"{_NEAR:.0%}: chosen afterwards among {len(every)} frequencies, which proves nothing."
        )
    )


# -- Figures 12 to 15 ------------------------------------------------------------------------------


def _shape_text(lp: Any) -> str:
    found = lp.analysis("mode_shapes")["speeds"][0]["bodies"]["lp"]
    names = found["interfaces"]
    deflection = np.abs(np.array(found["interface_deflection"], dtype=float))
    nodes = [k for k, name in enumerate(names) if name.startswith("n")]
    largest = [names[nodes[int(deflection[nodes, m].argmax())]] for m in (0, 2, 4, 6)]
    which = " and ".join(str(k) for k in SOURCE["figure_15"]["largest"])
    return (
        f"**The paper** finds the largest deflection of modes {which} at node "
        f"{SOURCE['figure_15']['node']}. **Ours**, of modes 1 to 4 at rest: {', '.join(largest)}. "
        "Where the nodes lie along the shaft is assumed."
    )


def _figure_15(lp: Any) -> list[Row]:
    """Peaks of the force at node 9 with the shaft at rest."""
    (found,) = lp.analysis("unbalance_response_at_rest")["exciters"]
    peaks = found["peaks"][f"lp.{SOURCE['figure_15']['node']}"]
    rows = []
    for number, printed in enumerate(SOURCE["figure_15"]["peaks_hz"]):
        own = min(peaks, key=lambda p: abs(p["frequency_hz"] - printed))
        told = (printed, own["frequency_hz"], "Hz", "identified", own["frequency_error_estimate"])
        rows.append(per_cent("peaks, shaft at rest", f"peak {number + 1}", *told))
    return rows


def _response_sections(lp: Any, rows: Sequence[Row]) -> list[str]:
    node = f"lp.{SOURCE['figure_15']['node']}"
    at_rest, turning = (
        lp.analysis(f"unbalance_response{end}")["exciters"][0]["peaks"][node]
        for end in ("_at_rest", "")
    )
    placed = lp.analysis("place_map_at_rest")
    largest = []
    for number, printed in enumerate(SOURCE["figure_15"]["peaks_hz"]):
        by_place = {
            place: max(
                (
                    p["amplitude_m"]
                    for p in peaks
                    if abs(p["frequency_hz"] / printed - 1.0) < 2 * _NEAR
                ),
                default=0.0,
            )
            for place, peaks in placed["peaks"].items()
        }
        place = max(by_place, key=lambda name: by_place[name])
        largest.append(f"peak {number + 1} at {place} ({by_place[place] * 1e6:.2g} µm)")
    top = max(at_rest, key=lambda p: p["amplitude_m"])
    return [
        *_response_pictures(placed, lp.analysis("unbalance_response_at_rest"), node),
        listed(rows),
        "**The paper** turns an unbalance force at each node in turn and draws the response there; "
        "its four peaks are its frequencies at rest. So its force turned and its shaft did not, "
        "although it calls the excitation synchronous. **Ours** does the same (`speed_rpm = 0`). "
        f"Largest at node 9: {top['amplitude_m'] * 1e6:.3g} µm at {top['frequency_hz']:.2f} Hz. "
        f"Of all places the largest: {', '.join(largest)}; the paper has its largest at node 9 "
        "for the second and the third.",
        lp.picture("unbalance_response.png", "Response to an unbalance at node 9 that turns"),
        "With the shaft turning as fast as the force, peaks of the same unit lie at "
        f"{words([p['frequency_hz'] for p in turning], '.1f')} Hz; the most sensitive place is "
        f"{lp.analysis('place_map')['most_sensitive_place']}.",
    ]


def _response_pictures(
    placed: dict[str, Any], response: dict[str, Any], node: str
) -> Iterator[str]:
    """Figures 14 and 15 over the frequency of the force."""
    axis = {"label": "frequency of the force", "unit": "Hz"}
    places = placed["places"]
    hertz, size = (
        numbers(placed[key]).reshape(len(places), -1) for key in ("frequency_hz", "amplitude_m")
    )
    chart = place_chart(places, hertz[0], hertz, size)
    chart = replace(chart, x=replace(chart.x, **axis))
    yield drawn([chart], "figure_14.png", "Figure 14", "Force at each place in turn, shaft at rest")
    (curve,) = exciters_of(response)
    # no peaks: they are named by their speed
    chart = amplitude_chart([replace(curve, speed_rpm=curve.speed_rpm / 60.0, peaks={})])
    rules = [charts.Rule(at=f, name="the paper's peaks") for f in SOURCE["figure_15"]["peaks_hz"]]
    chart = replace(chart, x=replace(chart.x, **axis), parts=[*chart.parts, *rules])
    text = f"Response to the force at {node} at rest"
    yield drawn([chart], "figure_15.png", "Figure 15", text)


# -- Figure 16 -------------------------------------------------------------------------------------


def _waterfall_sections(lp: Any) -> list[str]:
    asked = lp.analysis("waterfall")
    rpm, hertz = numbers(asked["speed_rpm"]), numbers(asked["frequency_hz"])
    system = lp.saved.system
    place, _, node = asked["observed"].partition(".")
    end, size = End(body=place, interface=node), asked["ground_amplitude_m"]
    seen = _seen_by_rotor(system, end, hertz, size, rpm)
    printed = [(f, speed, 0.0) for speed, f in SOURCE["figure_16"]["peaks"]]
    flat = ground_chart(hertz, rpm, seen, printed)
    chart = replace(
        flat,
        x=replace(flat.x, label="frequency that the rotor sees"),
        title="in the rotating frame; rings: the paper's peaks",
    )
    rows = []
    speeds, branches = lp.branches("frequency_hz")
    _, errors = lp.branches("frequency_error_estimate")
    whirls = list(zip(*lp.document["campbell"]["whirl"], strict=True))
    for speed, f in SOURCE["figure_16"]["peaks"]:
        fixed = np.array([np.interp(speed, speeds, branch) for branch in branches])
        at = int(np.abs(speeds - speed).argmin())
        turned = rotating(fixed, whirls[at], speed / 60.0)
        nearest = [int(np.nanargmin(np.abs(values - f))) for values in (turned, fixed)]
        told = (
            f"{with_error(values[k], errors[k, at] * fixed[k], '.1f')} Hz "
            f"({values[k] / f - 1.0:+.0%}), branch {k + 1}"
            for k, values in zip(nearest, (turned, fixed), strict=True)
        )
        rows.append((f"{f:g} Hz at {speed} rpm", *told))
    head = ("paper", "nearest branch in the rotating frame", "in the inertial frame")
    highest = "; ".join(
        f"{p['frequency_hz']:.0f} Hz at {p['speed_rpm']:.0f} rpm" for p in asked["peaks"][:5]
    )
    return [
        lp.picture("waterfall.png", "Response at node 9 to ground vibration, inertial frame"),
        drawn([chart], "figure_16.png", "Figure 16", "The same as the rotor sees it"),
        markdown(head, rows),
        "**The paper** shakes the bearings at every frequency while the speed rises, and names "
        "three peaks; its results are *calculated in the rotational system*. **Ours** shakes the "
        "ground and observes node 9, once in fixed axes and once as the rotor sees it: a forward "
        "circle at |f − spin|, a backward one at f + spin. In fixed axes the highest points are "
        f"{highest}. The table is suggestive only: each cell is the nearest of "
        f"{len(branches)} branches, chosen afterwards, and a branch may serve several rows; with "
        "so many one is rarely far.",
    ]


def _seen_by_rotor(
    system: Any, node: End, hertz: np.ndarray, amplitude_m: float, rpm: np.ndarray
) -> np.ndarray:
    """The response to ground vibration in the frame of the rotor, highest in each step, (s, f)."""
    step, rows = hertz[1] - hertz[0], []
    for speed in rpm * RAD_S_PER_RPM:
        spin = speed / (2.0 * np.pi)
        modes = modes_at_speed(system, float(speed)).frequency_hz
        modes = modes[(modes > 0.0) & (modes <= hertz[-1] + spin)]
        fine = np.union1d(np.arange(step, hertz[-1] + spin + step, step), modes)
        solved = ground_motion_map(
            system, amplitude_m, "x", [float(speed)], 2.0 * np.pi * fine, node
        ).translation_m[0]
        circles = np.array([0.5 * np.abs(solved[:, 0] + turn * solved[:, 1]) for turn in (1j, -1j)])
        rows.append(in_steps(hertz, seen_frequencies(fine, spin), circles))
    return np.array(rows)


def seen_frequencies(hertz: np.ndarray, spin_hz: float) -> np.ndarray:
    """Return what a turning body sees of the forward and the backward circle, (2, n) Hz."""
    return np.stack((np.abs(hertz - spin_hz), hertz + spin_hz))


def in_steps(hertz: np.ndarray, seen_hz: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the largest of some sizes in the step around each of equally spaced frequencies."""
    at = np.round(seen_hz / (hertz[1] - hertz[0])).astype(int) - 1
    inside = (at >= 0) & (at < hertz.size)
    row = np.zeros(hertz.size)
    np.maximum.at(row, at[inside], size[inside])
    return row
