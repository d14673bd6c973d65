"""Section 5 of Müller and Hennings: the units of the engine and the geared engine."""

from __future__ import annotations

from typing import Any

import numpy as np
from paper.rows import Row, markdown, per_cent, table

from solidwhirl.core.key_units import unit_of
from solidwhirl.rotordyn import LEE_ANISOTROPIC, LEE_ISOTROPIC

RPM = np.pi / 30.0
# Table 4, whole engine: mass [kg], centre of gravity [m].
TOTAL = (2021.42, 1.174)
# Table 6 [Hz] at 9000 rpm in the rotating frame, undamped and damped; at rest: see the scene.
AT_9000 = (63.1204, 63.4306, 69.4532, 70.7624, 71.9361, 78.3674)
AT_9000_DAMPED = (71.0640, 70.4299, 70.9838, 70.7640, 73.6017, 78.3833)
# Table 5 [N/m]: at rest and at the design point, and the speed of the rotor there [rpm].
TABLE_5 = {
    "LP": (4.53e7, 3.0e7, 13690.0),
    "HP": (5.54e7, 3.5e8, 18049.0),
    "fan": (8.54e7, 7.0e8, 4346.0),
}


def engine_sections(runs: dict[str, Any], told: dict[str, list[Row]]) -> list[str]:
    """Sections of the page on the engine; adds the rows of their tables to `told`."""
    lp, engine = runs["uhbr_lp"], runs["uhbr_engine"]
    told["Table 4"], told["Table 5"] = _table_4(runs), _table_5()
    told["Table 6"], told["Figure 15"] = _table_6(lp), _peaks_at_rest(lp)
    return [
        "## Section 5: the geared engine",
        "Scenes `uhbr_fan`, `uhbr_lp`, `uhbr_hp` (each unit on its bearings to the ground) and "
        "`uhbr_engine` (all three on the casing, fan and low pressure unit geared). Radii, widths "
        "and factors of the stages are those of Table 7; what the paper withholds is identified.",
        "### Table 4: masses, centres of gravity, inertias",
        table(told["Table 4"]),
        "### Table 5 and Figure 8: bearings that depend on the speed",
        table(told["Table 5"]),
        _law_text(),
        engine.picture("bearing_laws_C.png", "Stiffness and damping of bearing C over the speed"),
        "### Figure 9: critical speed map",
        lp.picture("critical_speed_map.png", "Critical speed map of the low pressure unit"),
        _map_text(lp),
        "### Figure 10: design of experiments, and the choice of stiffness",
        lp.picture("stiffness_study.png", "Response over frequency and stiffness"),
        _study_text(lp),
        "### Table 6: frequencies of the low pressure unit",
        table(told["Table 6"]),
        _speed_text(lp),
        "### Figure 11: Campbell diagram in the frames of the units",
        engine.picture("rotating_campbell.png", "Campbell diagram in the frames of the units"),
        engine.picture("campbell.png", "The same in the inertial frame"),
        "### Figures 12 and 13: mode shapes of the low pressure unit",
        lp.picture("mode_shapes_0rpm_lp.png", "Shapes at rest"),
        lp.picture("mode_shapes_9000rpm_lp.png", "Shapes at 9000 rpm"),
        _shape_text(lp),
        "### Figures 14 and 15: unbalance response over place and frequency",
        lp.picture("place_map.png", "Response over place and frequency of the unbalance"),
        lp.picture("unbalance_response.png", "Response to an unbalance at node 9"),
        table(told["Figure 15"]),
        _unbalance_text(lp),
        "### Figure 16: waterfall of ground vibration",
        lp.picture("waterfall.png", "Response at node 9 to ground vibration"),
        _waterfall_text(lp),
        "### Figures 17 and 18: run-up of the engine",
        engine.picture("run_up.png", "Speeds and mount force over time"),
        engine.picture("run_up_spectrogram.png", "Spectrogram of the mount force"),
        _run_up_text(engine),
        "### Section 5.8: required complexity",
        engine.picture("complexity_complexity.png", "Response of models of less complexity"),
        _complexity_table(engine),
        "### Appendices B and C",
        "Frames: `solidwhirl.rotordyn.campbell.body_frames`, tested against equations 15 to 17 and "
        "equations of motion in the rotating frame. Stage factors: `solidwhirl.geometry.TABLE_7` "
        "and `stage_group_sections`.",
    ]


def _references(run: Any, begin: str, family: str = "") -> list[Row]:
    """Rows of the references that the scene itself has, of quantities that begin so."""
    return [
        per_cent(
            family or f"{entry['title'].split(':')[0]}: mass properties",
            entry["title"],
            entry["value"],
            entry["result"],
            unit_of(entry["quantity"]),
            "identified",
        )
        for entry in run.document["references"]
        if entry["quantity"].startswith(begin)
    ]


def _table_4(runs: dict[str, Any]) -> list[Row]:
    rows = [
        row
        for unit in ("uhbr_fan", "uhbr_lp", "uhbr_hp")
        for row in _references(runs[unit], "bodies.")
    ]
    parts = runs["uhbr_engine"].document["bodies"].values()
    mass = sum(b["mass_kg"] for b in parts)
    center = sum(b["mass_kg"] * b["center_of_gravity_m"][2] for b in parts) / mass
    told = ("engine: mass properties", "casing is the rest")
    rows.append(per_cent(told[0], "engine: mass", TOTAL[0], mass, "kg", told[1]))
    rows.append(per_cent(told[0], "engine: centre of gravity", TOTAL[1], center, "m", told[1]))
    return rows


def _table_5() -> list[Row]:
    rows = []
    for unit, (at_rest, at_design, rpm) in TABLE_5.items():
        speed = rpm * RPM
        factor = LEE_ISOTROPIC.coefficients(speed, np.eye(2), np.eye(2)).stiffness_n_per_m[0, 0]
        rows.append(
            per_cent(
                f"{unit}: stiffness at design point over that at rest",
                unit,
                at_design / at_rest,
                float(factor),
                "",
                "paper; rad/s assumed",
            )
        )
    return rows


def _law_text() -> str:
    def lowest(law: Any, axis: int) -> float:
        speeds = np.linspace(0.0, 2000.0, 20001)
        values = np.array(
            [
                law.coefficients(float(s), np.eye(2), np.eye(2)).damping_n_s_per_m[axis, axis]
                for s in speeds
            ]
        )
        return float(speeds[np.argmax(values < 0.0)])

    x, y = lowest(LEE_ANISOTROPIC, 0), lowest(LEE_ANISOTROPIC, 1)
    return (
        "The printed polynomials do not give the stiffness of Table 5 for any unit of Ω. Their "
        f"damping turns negative from {x:.0f} rad/s ({x / RPM:.0f} rpm) in x and {y:.0f} rad/s "
        f"({y / RPM:.0f} rpm) in y, below the design point (13 690 rpm). The scenes take the "
        "printed stiffness in both directions and keep the damping of Table 5."
    )


def _map_text(lp: Any) -> str:
    found = lp.document["analyses"]["critical_speed_map"]
    stiffness = np.array(found["stiffness_n_per_m"])
    speeds = np.array(found["critical_speed_rpm"], dtype=float)
    chosen = int(np.argmin(np.abs(np.log(stiffness / 4.53e7))))
    near = sorted(float(v) for v in speeds[:, chosen] if np.isfinite(v))
    listed = ", ".join(f"{v:.0f}" for v in near[:8])
    return f"At {stiffness[chosen]:.3g} N/m, nearest to Table 5, critical speeds are {listed} rpm."


def _study_text(lp: Any) -> str:
    found = lp.document["analyses"]["stiffness_study"]
    end = ", at the end of the range tried" if found["choice_is_at_the_end_of_the_range"] else ""
    return (
        f"Smallest response within ±{100 * found['margin']:.0f} % of "
        f"{found['operating_speed_rpm']:.0f} rpm at {found['chosen_stiffness_n_per_m']:.3g} N/m"
        f"{end}; the paper chose 3.0e7 N/m at the design point from the response of the turbine."
    )


def _rotating(at_speed: dict[str, Any]) -> Any:
    """Frequencies that the unit sees: |f - spin| of forward whirl, f + spin of backward whirl."""
    spin = at_speed["speed_rpm"] / 60.0
    seen = [
        abs(f - spin) if whirl == "forward" else f + spin
        for f, whirl in zip(at_speed["frequency_hz"], at_speed["whirl"], strict=True)
    ]
    return np.sort(seen)


def _table_6(lp: Any) -> list[Row]:
    _, at_speed = lp.document["analyses"]["mode_shapes"]["speeds"]
    rows = _references(lp, "modes_at_rest.", "modes at rest")
    rotating = _rotating(at_speed)
    misses = [np.abs(rotating[k : k + 6] - AT_9000).sum() for k in range(len(rotating) - 5)]
    start = int(np.argmin(misses))
    family = "modes at 9000 rpm, rotating frame"
    for k, printed in enumerate(AT_9000):
        ours = float(rotating[start + k])
        rows.append(per_cent(family, f"mode {k + 1}", printed, ours, "Hz", "prediction"))
    return rows


def _speed_text(lp: Any) -> str:
    _, at_speed = lp.document["analyses"]["mode_shapes"]["speeds"]
    rotating = _rotating(at_speed)
    return (
        "The values at 9000 rpm were not used in the identification. Ours are the six neighbours "
        f"that come nearest among {len(rotating)} from {rotating[0]:.2f} to {rotating[-1]:.2f} Hz. "
        "They do not agree: the paper's six lie within 15 Hz of each other. Masses and frequencies "
        "at rest do not determine the gyroscopic behaviour of a unit whose inner layout is "
        "withheld. " + _inertial_text(at_speed) + "The paper's damped values differ from its "
        f"undamped ones by up to {_largest_change():.0f} %, which damping of 1000 N s/m can't do "
        "to modes whose decrement is small."
    )


def _largest_change() -> float:
    """Largest change of the paper's frequencies by its damping, per cent."""
    return float(100.0 * np.abs(np.array(AT_9000_DAMPED) / AT_9000 - 1.0).max())


def _inertial_text(at_speed: dict[str, Any]) -> str:
    """Which of our frequencies in the inertial frame lie within 2 % of one of the paper's."""
    near = [
        (f, whirl, min(AT_9000, key=lambda p: abs(p - f)))
        for f, whirl in zip(at_speed["frequency_hz"], at_speed["whirl"], strict=True)
    ]
    near = [entry for entry in near if abs(entry[0] / entry[2] - 1.0) < 0.02]
    if not near:
        return ""
    listed = " and ".join(f"{f:.2f} Hz {whirl} (paper {p:g})" for f, whirl, p in near)
    return (
        f"In the inertial frame, however, {listed} lie within 2 % of values of the paper, which "
        "says that its own are in the rotating frame. "
    )


def _shape_text(lp: Any) -> str:
    found = lp.document["analyses"]["mode_shapes"]["speeds"][0]["bodies"]["lp"]
    names = found["interfaces"]
    deflection = np.abs(np.array(found["interface_deflection"], dtype=float))
    nodes = [k for k, name in enumerate(names) if name.startswith("n")]
    largest = [names[nodes[int(deflection[nodes, m].argmax())]] for m in (0, 2, 4, 6)]
    return (
        "Largest deflection of modes 1 to 4 at rest at nodes " + ", ".join(largest) + ". The paper "
        "finds node 9 for the second and third mode."
    )


def _peaks_at_rest(lp: Any) -> list[Row]:
    at_rest = lp.document["analyses"]["mode_shapes"]["speeds"][0]["frequency_hz"]
    return [
        per_cent(
            "peaks, against ours without spin",
            f"peak {k + 1}",
            printed,
            min(at_rest, key=lambda f: abs(f - printed)),
            "Hz",
            "identified",
        )
        for k, printed in enumerate((18.0, 71.0, 82.0, 153.0))
    ]


def _unbalance_text(lp: Any) -> str:
    found = lp.document["analyses"]["unbalance_response"]["exciters"][0]["peaks"]["lp.n9"]
    listed = ", ".join(f"{p['frequency_hz']:.1f}" for p in found)
    place = lp.document["analyses"]["place_map"]["most_sensitive_place"]
    return (
        "The paper's peaks are its frequencies at rest: its force turns and its rotor does not. "
        f"With the spin, peaks of the identified unit lie at {listed} Hz. The largest response of "
        f"all places is at {place} (paper: node 9)."
    )


def _waterfall_text(lp: Any) -> str:
    peaks = lp.document["analyses"]["waterfall"]["peaks"]
    listed = "; ".join(f"{p['frequency_hz']:.0f} Hz at {p['speed_rpm']:.0f} rpm" for p in peaks[:5])
    return (
        f"Highest points of ours: {listed}. The paper's: 29 Hz at 5250 rpm, 33 Hz at 7950 rpm and "
        "109 Hz at 12 150 rpm."
    )


def _run_up_text(engine: Any) -> str:
    found = engine.document["analyses"]["run_up"]
    peaks = found["normalised_response"]["peaks"]
    highest = sorted(
        sorted(peaks, key=lambda p: -p["force_per_force"])[:8], key=lambda p: p["frequency_hz"]
    )
    listed = ", ".join(f"{p['frequency_hz']:.0f}" for p in highest)
    energy = found["energy"]
    work = max(abs(v) for key, v in energy.items() if key != "largest_error_j")
    return (
        f"{found['ramp_s']:.0f} s linear, {found['hold_s']:.0f} s constant, {found['steps']} steps "
        f"in {found['wall_time_s']:.0f} s of computing "
        f"({1e6 * found['wall_time_per_step_s']:.0f} µs each). Largest mount force "
        f"{found['largest_mount_force_n']:.4g} N; energy balance closes to "
        f"{energy['largest_error_j']:.1e} J beside {work:.1e} J of work. "
        f"Highest peaks of the force over the excitation: {listed} Hz; the paper's: 66, 117, 154, "
        "311, 373 and 529 Hz. Peaks above the highest 1/rev frequency (301 Hz) can't be excited "
        "by these unbalances in a linear model; the paper gives no formula for its response."
    )


def _complexity_table(engine: Any) -> str:
    found = engine.document["analyses"]["complexity"]["complexity"]
    bands = [f"{low:.0f} to {high:.0f} Hz" for low, high in found["bands_hz"]]
    head = ("model", "coordinates", "peak force [N]", "error of the peak", *bands, "time [s]")
    rows = [
        (
            m["name"],
            str(m["coordinates"]),
            f"{m['peak_force_n']:.4g}",
            f"{100 * m['peak_force_error']:+.1f} %",
            *(f"{100 * e:.0f} %" for e in m["response_error_by_band"]),
            f"{m['wall_time_s']:.1f}",
        )
        for m in found["models"]
    ]
    return (
        markdown(head, rows)
        + "\n\nErrors by band are root mean square differences of the response. The paper: 12.5 % "
        "in the force amplitude with no modes or those of one unit alone, best agreement with the "
        "modes of the high pressure unit, moderate to good with those of the low pressure unit."
    )


__all__ = ["Row", "engine_sections"]
