"""Section 4 of Müller and Hennings: the twin rotor, and what each modelling choice costs."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from paper.rows import Row, listed, markdown, per_cent
from paper.runs import SOURCE, drawn

from solidwhirl.core.blocks import numbers
from solidwhirl.rotordyn import (
    AssembledSystem,
    InternalDamping,
    assemble,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modes.modal_truncation import truncated_system
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.orbits import elliptic_orbits

FOUR = SOURCE["section_4"]
TOP = FOUR["to_rpm"] * RAD_S_PER_RPM
# Speeds of Figure 5.
SPEEDS = np.linspace(0.0, TOP, FOUR["speeds"])
ANALYTIC = "one-term Ritz (analytic)"
# Numbers of modes that are tried, and runs of which the fastest counts.
_COUNTS, _REPEATED = (2, 4, 6, 8, 12, 16, 32, 48, 64, 96), 3
_DOTS = charts.series_look(0)


@dataclass(frozen=True, kw_only=True)
class Variant:
    """Frequencies of one model of the twin rotor [Hz]."""

    name: str
    at_rest: tuple[float, ...]
    at_top: tuple[float, ...]
    peaks: tuple[float, ...]
    decrements: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class OneTerm:
    """One-term Ritz model with sin(πz/L): what the source calls analytic.

    m x" + kx x + a Ω y' = 0 and m y" + ky y - a Ω x' = 0; `disk` is the shape at the inner disk.
    """

    mass_kg: float
    coupling_kg: float
    stiffness_n_per_m: tuple[float, float]
    disk: float

    def dynamic(self, speed: float, omega: float) -> np.ndarray:
        """Dynamic stiffness of (x, y) at a frequency, (2, 2)."""
        turn = 1j * omega * self.coupling_kg * speed
        kx, ky = (k - self.mass_kg * omega**2 for k in self.stiffness_n_per_m)
        return np.array([[kx, turn], [-turn, ky]])

    def frequencies(self, speed: float) -> tuple[float, ...]:
        """Both frequencies at a speed [Hz]."""
        kx, ky = self.stiffness_n_per_m
        m, turn = self.mass_kg, self.coupling_kg * speed
        squares = np.roots([m**2, -m * (kx + ky) - turn**2, kx * ky])
        return tuple(float(f) for f in np.sort(np.sqrt(squares.real)) / (2.0 * np.pi))

    def peaks(self) -> tuple[float, ...]:
        """Frequencies [Hz] at which the unbalance resonates: (kx - mΩ²)(ky - mΩ²) = a²Ω⁴."""
        kx, ky = self.stiffness_n_per_m
        m = self.mass_kg
        squares = np.roots([m**2 - self.coupling_kg**2, -m * (kx + ky), kx * ky])
        return tuple(float(f) for f in np.sort(np.sqrt(squares.real)) / (2.0 * np.pi))

    def amplitude(self, speed: float, moment_kg_m: float) -> float:
        """Largest displacement of the inner disk for an unbalance there [m]."""
        force = moment_kg_m * speed**2 * self.disk * np.array([1.0, -1j])
        motion = self.disk * np.linalg.solve(self.dynamic(speed, speed), force)
        return float(elliptic_orbits(*motion).major_m)


def one_term() -> OneTerm:
    """Return the model of Table 1, with the axial positions that the printed results imply."""
    t = SOURCE["table_1"]
    length, density = t["length_m"], t["density_kg_m3"]
    disk1, joint, disk2 = (share * length for share in (1 / 3, 2 / 3, 13 / 15))
    wave = np.pi / length
    shape, slope = (lambda z: np.sin(wave * z)), (lambda z: wave * np.cos(wave * z))

    def ring(outer: float, inner: float, width: float) -> tuple[float, float, float]:
        mass = density * np.pi * (outer**2 - inner**2) * width
        polar = mass * (outer**2 + inner**2) / 2
        return mass, polar, polar / 2 + mass * width**2 / 12

    def section(outer: float, inner: float) -> tuple[float, float]:
        return np.pi * (outer**2 - inner**2), np.pi * (outer**4 - inner**4) / 4

    area, second_moment = section(t["r1_m"], 0.0)
    first = ring(t["r2_m"], t["r1_m"], t["disk_width_m"][0])
    second = ring(t["r5_m"], t["r4_m"], t["disk_width_m"][1])
    mass = density * (area + second_moment * wave**2) * length / 2
    mass += first[0] * shape(disk1) ** 2 + first[2] * slope(disk1) ** 2
    spin1 = density * second_moment * wave**2 * length + first[1] * slope(disk1) ** 2
    # the outer rotor is rigid: held at D, it follows the inner shaft at C
    span = length - joint
    turn = shape(joint) / span
    area, around = (density * part for part in section(t["r4_m"], t["r3_m"]))
    mass += turn**2 * (area * span**3 / 3 + around * span)
    mass += turn**2 * (second[0] * (length - disk2) ** 2 + second[2])
    spin2 = turn**2 * (2 * around * span + second[1])
    bending = t["elastic_modulus_pa"] * second_moment * wave**4 * length / 2
    return OneTerm(
        mass_kg=float(mass),
        coupling_kg=float(spin1 - spin2),
        stiffness_n_per_m=(float(bending + t["kxx_n_per_m"] * shape(joint) ** 2), float(bending)),
        disk=float(shape(disk1)),
    )


def variant_of(model: OneTerm) -> Variant:
    """Frequencies of the one-term model."""
    return Variant(
        name="one-term Ritz, closed form",
        at_rest=model.frequencies(0.0),
        at_top=model.frequencies(TOP),
        peaks=model.peaks(),
        decrements=(0.0, 0.0),
    )


def measured(name: str, system: AssembledSystem) -> Variant:
    """Frequencies at rest and at the top speed, and the peaks that an unbalance excites."""
    count = min(3, system.size)
    followed = campbell(system, SPEEDS, branch_count=count)
    found = critical_speeds(system, speed_max_rad_s=TOP)
    return Variant(
        name=name,
        at_rest=tuple(modes_at_speed(system, 0.0).frequency_hz[:2].tolist()),
        at_top=tuple(followed.frequency_hz[:count, -1].tolist()),
        peaks=tuple(c.frequency_hz for c in found[:3]),
        decrements=tuple(followed.log_decrement[:2, -1].tolist()),
    )


def choices(bonded: AssembledSystem, rigid_disks: AssembledSystem) -> list[Variant]:
    """Models with the choices of the source added one by one."""
    damped = _with_damping(rigid_disks, FOUR["modal_damping"])
    kept = FOUR["modes"]
    return [
        measured("solid disks bonded over their width", bonded),
        measured("+ disks rigid, on a piece of shaft", rigid_disks),
        measured(f"+ {kept} modes of the system", truncated_system(rigid_disks, kept)),
        measured(
            f"+ {FOUR['modal_damping']:.0%} damping of every mode of a shaft",
            truncated_system(damped, kept),
        ),
        measured("+ one bending mode in each plane", truncated_system(damped, 2)),
        variant_of(one_term()),
    ]


def _with_damping(system: AssembledSystem, ratio: float) -> AssembledSystem:
    parts: Any = system.system
    damping = InternalDamping(modal_ratio=ratio)
    rotors = {name: replace(r, internal_damping=damping) for name, r in parts.rotors.items()}
    return assemble(rotors, parts.bearings, gears=parts.gears)


@dataclass(frozen=True, kw_only=True)
class Effort:
    """A model with some modes of the system: its largest error, and time of a diagram."""

    modes: int
    error: float
    seconds: float


def efforts(system: AssembledSystem) -> list[Effort]:
    """Errors of the branches of Figure 5 and times of its speeds over the number of modes."""
    whole = campbell(system, SPEEDS, branch_count=2).frequency_hz
    found = []
    for count in sorted({*_COUNTS, FOUR["modes"], system.size}):
        if count > system.size:
            continue
        small = truncated_system(system, count)
        times = []
        for _ in range(_REPEATED):
            start = time.process_time()
            hertz = campbell(small, SPEEDS, branch_count=2).frequency_hz
            times.append(time.process_time() - start)
        error = float(np.nanmax(np.abs(hertz / whole - 1.0)))
        found.append(Effort(modes=count, error=error, seconds=min(times)))
    return found


def twin_sections(runs: dict[str, Any], told: dict[str, list[Row]]) -> list[str]:
    """Sections of the page on the twin rotor; adds the rows of their tables to `told`."""
    bonded, held = runs["ferraris"], runs["ferraris_paper"]
    model = one_term()
    rows = choices(bonded.saved.system, held.saved.system)
    told["Table 2"] = _rows(rows, "table_2", "at_rest", _errors_at_rest(bonded, held))
    told["Table 3"] = _rows(rows, "table_3", "peaks", _errors_of_peaks(bonded, held))
    grid = SOURCE["table_3"]["ansys_grid_rpm"]
    return [
        "## Section 4: coaxial counter-rotating twin rotor",
        "**The paper** models the twin rotor of Ferraris et al. three times: a closed form, beams "
        "with rigid disks in Ansys, and the same reduced to modes in Simpack. **We** take the "
        "scenes [ferraris](../scenes/ferraris.toml) (solid disks bonded to their shafts) and "
        "[ferraris_paper](../scenes/ferraris_paper.toml) (rigid disks that hold a piece of shaft) "
        "and a one-term Ritz model in closed form. Dimensions and stiffnesses are those of Table "
        "1; axial positions are inferred from the printed results, the held length is identified.",
        "### Table 2: frequencies at standstill",
        listed(told["Table 2"]),
        "### Figure 5: Campbell diagram of the three approaches",
        _campbell_picture(model, bonded, held),
        _campbell_text(rows),
        "### Table 3 and Figure 6: unbalance response of the three approaches",
        listed(told["Table 3"]),
        f"The Ansys peaks lie on a grid of {grid} rpm (± {grid / 120.0:.2f} Hz). Unbalance "
        f"{FOUR['unbalance_kg_m']:g} kg m on the inner disk, speed ratio −1, no damping, so that "
        "peaks have no height.",
        _response_picture(model, bonded, held),
        "### What each choice of the paper costs",
        _choices_table(rows),
        "Each row adds a choice to the row above; the last one is what the paper calls analytic. "
        "The first two rows have the errors of Tables 2 and 3, those below that of the second. "
        f"Log decrements are those of the first two branches at {FOUR['to_rpm']} rpm. Damping "
        "assigned to the modes of a shaft turns with it: above the forward critical speed it "
        "drives it unstable.",
        "### Section 4.2.1: how many modes",
        *_effort_sections(efforts(held.saved.system)),
    ]


def _campbell_text(rows: list[Variant]) -> str:
    solid, held, analytic = rows[0], rows[1], rows[-1]
    apart = max(abs(a / b - 1.0) for a, b in zip(held.at_top[:2], analytic.at_top, strict=True))
    said = FOUR["largest_error_percent"]
    return (
        f"The paper says that its finite element curve differs from the analytic one by "
        f"{said['Ansys']:g} % at most and the multibody one by {said['Simpack']:g} %. A model with "
        "more than one mode does not: the second bending mode pulls the first branch down, to "
        f"{held.at_top[0]:.1f} Hz at {FOUR['to_rpm']} rpm with rigid disks and "
        f"{solid.at_top[0]:.1f} Hz with solid ones, where the one-term model has "
        f"{analytic.at_top[0]:.1f} Hz: {apart:.1%} apart. The axis of its figure ends at "
        f"{FOUR['axis_hz']} Hz; the lower frame shows both branches enlarged."
    )


def _campbell_picture(model: OneTerm, bonded: Any, held: Any) -> str:
    curves = list[charts.Mark]()
    for number, (name, run) in enumerate(_solids(bonded, held)):
        rpm, hertz = run.branches("frequency_hz")
        errors = run.branches("frequency_error_estimate")[1] * hertz
        look = replace(charts.series_look(number), size=4.0)
        curves += [
            charts.Curve(x=rpm / 60.0, y=h, name=name, look=look, errors=e, errors_along="y")
            for h, e in zip(hertz, errors, strict=True)
        ]
    look = replace(charts.series_look(2), mark="")
    curves += [
        charts.Curve(x=SPEEDS / (2.0 * np.pi), y=branch, name=ANALYTIC, look=look)
        for branch in np.array([model.frequencies(spin) for spin in SPEEDS]).T
    ]
    low, high = (round(f, -1) for f in (min(model.frequencies(TOP)), max(model.frequencies(TOP))))
    whole = charts.Chart(
        name="figure-5",
        title="axes as the paper's",
        x=charts.Axis(label="rotor frequency", unit="Hz", low=0.0, high=TOP / (2.0 * np.pi)),
        y=charts.Axis(label="frequency", unit="Hz", low=0.0, high=FOUR["axis_hz"]),
        parts=curves,
    )
    near = replace(
        whole, title="its two branches", y=replace(whole.y, low=low - 30, high=high + 20)
    )
    return drawn([whole, near], "figure_5.png", "Figure 5", "Campbell diagrams of three approaches")


def _response_picture(model: OneTerm, bonded: Any, held: Any) -> str:
    curves = list[charts.Mark]()
    for number, (name, run) in enumerate(_solids(bonded, held)):
        (found,) = run.analysis("unbalance_response")["exciters"]
        size = numbers(found["places"]["inner.disk"]["major_m"])
        hertz = numbers(found["frequency_hz"])
        look = replace(charts.series_look(number), mark="")
        size = np.where(size > 0, size, np.nan)
        curves.append(charts.Curve(x=hertz, y=size, name=name, look=look))
    spins = np.linspace(0.0, TOP, 1000)[1:]
    analytic = np.array([model.amplitude(spin, FOUR["unbalance_kg_m"]) for spin in spins])
    look = replace(charts.series_look(2), mark="")
    curves.append(charts.Curve(x=spins / (2 * np.pi), y=analytic, name=ANALYTIC, look=look))
    peaks = {"the paper's analytic peaks": "analytic", "the paper's Ansys peaks": "Ansys"}
    curves += [
        charts.Rule(at=peak, name=text, look=charts.Look(f"@c{5 + k}", "dot", width=1.0))
        for k, (text, key) in enumerate(peaks.items())
        for peak in SOURCE["table_3"][key]
    ]
    chart = charts.Chart(
        name="figure-6",
        title="inner disk",
        x=charts.Axis(
            label="frequency of the excitation (1/rev)", unit="Hz", low=0.0, high=TOP / (2 * np.pi)
        ),
        y=charts.size_axis("largest displacement", "m", 1e-9, float(np.median(analytic)) * 1e3),
        parts=curves,
    )
    return drawn([chart], "figure_6.png", "Figure 6", "Unbalance responses of three approaches")


def _solids(bonded: Any, held: Any) -> list[tuple[str, Any]]:
    return [("solid disks bonded to the shafts", bonded), ("rigid disks (as Ansys, Simpack)", held)]


def _effort_sections(found: list[Effort]) -> list[str]:
    counts, seconds = (np.array([getattr(e, key) for e in found]) for key in ("modes", "seconds"))
    upper = counts >= FOUR["modes"]
    power = float(np.polyfit(np.log(counts[upper]), np.log(seconds[upper]), 1)[0])
    (own,) = (e for e in found if e.modes == FOUR["modes"])
    errors = np.array([e.error for e in found])
    curves = [
        charts.Curve(x=counts * 1.0, y=np.maximum(errors, 1e-9) * 100.0, name="error", look=_DOTS),
        charts.Curve(
            x=counts * 1.0,
            y=seconds,
            name="time",
            look=replace(charts.series_look(1), dash="dash"),
            on_right=True,
        ),
    ]
    chart = charts.Chart(
        name="modes",
        title="two branches at all speeds",
        x=charts.Axis(label="modes of the system", is_log=True),
        y=charts.Axis(label="largest error", unit="%", is_log=True),
        right=charts.Axis(label="time of the diagram", unit="s", is_log=True),
        parts=curves,
    )
    return [
        drawn([chart], "section_4_modes.png", "Error and time", "Error and time over the modes"),
        f"**The paper** keeps {FOUR['modes']} modes, says that fewer increase the error "
        "significantly, and that the effort grows quadratically with their number. **Ours**, of "
        f"the rigid-disk model, with {FOUR['modes']} modes: {own.error:.1e} of a frequency at "
        "most; fewer: "
        + "; ".join(f"{e.modes} modes {e.error:.1e}" for e in found if e.modes < FOUR["modes"])
        + f". Beyond {FOUR['modes']} modes the time of the diagram grows with the power "
        f"{power:.1f} of their number, of which this model has {int(counts[-1])} in all.",
    ]


def _errors_at_rest(bonded: Any, held: Any) -> dict[int, list[float]]:
    return {0: bonded.errors_at_rest, 1: held.errors_at_rest}


def _errors_of_peaks(bonded: Any, held: Any) -> dict[int, list[float]]:
    return {
        k: [c["frequency_error_estimate"] or 0.0 for c in run.document["critical_speeds"]]
        for k, run in enumerate((bonded, held))
    }


def _rows(rows: list[Variant], where: str, key: str, errors: dict[int, list[float]]) -> list[Row]:
    """Frequencies of the models beside those of the paper that each stands for."""
    printed = SOURCE[where]
    pairs = [
        (len(rows) - 1, "one-term Ritz", "analytic", "inferred"),
        (1, "rigid disks", "Ansys", "inferred; held length identified"),
        (1, "rigid disks", "Simpack", "inferred; held length identified"),
        (0, "solid disks", "Ansys", "inferred"),
    ]
    return [
        per_cent(
            f"{name} / {source}",
            f"{name} / {source}, {k + 1}",
            value,
            getattr(rows[at], key)[k],
            "Hz",
            data,
            errors[at][k] if at in errors else 0.0,
        )
        for at, name, source, data in pairs
        for k, value in enumerate(printed[source])
    ]


def _choices_table(rows: list[Variant]) -> str:
    def listed(values: tuple[float, ...], digits: int) -> str:
        return " / ".join(f"{v:.{digits}f}" for v in values) or "-"

    top = f"at {FOUR['to_rpm']} rpm [Hz]"
    head = ("model", "at rest [Hz]", top, "peaks [Hz]", "log decrements")
    return markdown(
        head,
        (
            (
                v.name,
                listed(v.at_rest, 2),
                listed(v.at_top, 2),
                listed(v.peaks, 2),
                listed(v.decrements, 3),
            )
            for v in rows
        ),
    )
