"""Section 4 of Müller and Hennings: the twin rotor, and what each modelling choice costs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from paper.rows import Row, markdown, per_cent, table
from scipy.linalg import eigvals

from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn import (
    AssembledSystem,
    InternalDamping,
    assemble,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.modes.modal_truncation import truncated_system

RPM = np.pi / 30.0
TOP = 20000.0 * RPM


@dataclass(frozen=True, kw_only=True)
class Variant:
    """Frequencies of one model of the twin rotor [Hz]."""

    name: str
    at_rest: tuple[float, ...]
    at_top: tuple[float, ...]
    peaks: tuple[float, ...]
    decrements: tuple[float, ...]


def one_mode_model() -> Variant:
    """One-term Ritz model with sin(πz/L), in closed form: what the source calls analytic."""
    length, steel, density = 0.4, 2.0e11, 7800.0
    disk1, joint, disk2, end = length / 3, 2 * length / 3, 13 * length / 15, length
    inner = np.pi * 0.02**2 * density, np.pi * 0.02**4 / 4 * density
    bending = steel * np.pi * 0.02**4 / 4

    def ring(outer: float, inner_radius: float, width: float) -> tuple[float, float, float]:
        mass = density * np.pi * (outer**2 - inner_radius**2) * width
        polar = mass * (outer**2 + inner_radius**2) / 2
        return mass, polar, polar / 2 + mass * width**2 / 12

    wave = np.pi / length
    shape, slope = (lambda z: np.sin(wave * z)), (lambda z: wave * np.cos(wave * z))
    first, second = ring(0.15, 0.02, 0.03), ring(0.1, 0.035, 0.03)
    mass = inner[0] * length / 2 + inner[1] * wave**2 * length / 2
    mass += first[0] * shape(disk1) ** 2 + first[2] * slope(disk1) ** 2
    spin1 = 2 * inner[1] * wave**2 * length / 2 + first[1] * slope(disk1) ** 2
    # the outer rotor is rigid: held at D, it follows the inner shaft at C
    turn = shape(joint) / (end - joint)
    area = np.pi * (0.035**2 - 0.03**2) * density
    second_moment = np.pi * (0.035**4 - 0.03**4) / 4 * density
    span = end - joint
    mass += turn**2 * (area * span**3 / 3 + second_moment * span)
    mass += turn**2 * (second[0] * (end - disk2) ** 2 + second[2])
    spin2 = turn**2 * (2 * second_moment * span + second[1])
    stiffness_y = bending * wave**4 * length / 2
    stiffness_x = stiffness_y + 8e6 * shape(joint) ** 2

    def frequencies(speed: float) -> tuple[float, ...]:
        coupling = (spin1 - spin2) * speed
        matrix = np.array(
            [
                [0, 0, 1, 0],
                [0, 0, 0, 1],
                [-stiffness_x / mass, 0, 0, -coupling / mass],
                [0, -stiffness_y / mass, coupling / mass, 0],
            ]
        )
        omega = np.sort(np.abs(eigvals(matrix).imag))[[0, 2]] / (2 * np.pi)
        return tuple(float(f) for f in omega)

    net = spin1 - spin2
    # (k_x - m Ω²)(k_y - m Ω²) = a² Ω⁴
    roots = np.roots(
        [mass**2 - net**2, -mass * (stiffness_x + stiffness_y), stiffness_x * stiffness_y]
    )
    peaks = tuple(float(f) for f in np.sort(np.sqrt(roots.real)) / (2 * np.pi))
    return Variant(
        name="one-term Ritz, closed form",
        at_rest=frequencies(0.0),
        at_top=frequencies(TOP),
        peaks=peaks,
        decrements=(0.0, 0.0),
    )


def measured(name: str, system: AssembledSystem) -> Variant:
    """Frequencies at rest and at 20 000 rpm, and the peaks that an unbalance excites."""
    count = min(3, system.size)
    followed = campbell(system, np.linspace(0.0, TOP, 21), branch_count=count)
    found = critical_speeds(system, speed_max_rad_s=TOP)
    return Variant(
        name=name,
        at_rest=tuple(modes_at_speed(system, 0.0).frequency_hz[:2].tolist()),
        at_top=tuple(followed.frequency_hz[:count, -1].tolist()),
        peaks=tuple(c.frequency_hz for c in found[:3]),
        decrements=tuple(followed.log_decrement[:2, -1].tolist()),
    )


def choices(bonded: Results, rigid_disks: Results) -> list[Variant]:
    """Models with the choices of the source added one by one."""
    damped = _with_damping(rigid_disks.system, 0.02)
    return [
        measured("solid disks bonded over 30 mm", bonded.system),
        measured("+ disks rigid, on 10.4 mm of shaft", rigid_disks.system),
        measured("+ 22 modes of the system", truncated_system(rigid_disks.system, 22)),
        measured("+ 2 % damping of every mode of a shaft", truncated_system(damped, 22)),
        measured("+ one bending mode in each plane", truncated_system(damped, 2)),
        one_mode_model(),
    ]


def _with_damping(system: AssembledSystem, ratio: float) -> AssembledSystem:
    parts: Any = system.system
    damping = InternalDamping(modal_ratio=ratio)
    rotors = {name: replace(r, internal_damping=damping) for name, r in parts.rotors.items()}
    return assemble(rotors, parts.bearings, gears=parts.gears)


def twin_sections(runs: dict[str, Any], told: dict[str, list[Row]]) -> list[str]:
    """Sections of the page on the twin rotor; adds the rows of their tables to `told`."""
    bonded, held = runs["ferraris"], runs["ferraris_paper"]
    analytic = one_mode_model()
    rows = choices(bonded.results, held.results)
    told["Table 2"] = _table_2(analytic, rows)
    told["Table 3"] = _table_3(analytic, rows)
    return [
        "## Section 4: coaxial counter-rotating twin rotor",
        "Scenes [ferraris](../scenes/ferraris.toml) (solid disks bonded to their shafts) and "
        "`ferraris_paper` (rigid disks that hold 10.4 mm of shaft). Dimensions and stiffnesses are "
        "those of Table 1; the axial positions are inferred from the printed results.",
        "### Table 2: frequencies at standstill",
        table(told["Table 2"]),
        "### Figure 5: Campbell diagram",
        bonded.picture("campbell.png", "Campbell diagram, bonded disks")
        + "\n"
        + held.picture("campbell.png", "Campbell diagram, rigid disks"),
        "The paper says that its finite element curve differs from the one-mode analytic one by "
        "1 % at most. A model with more than one mode can't: the second bending mode pulls the "
        f"first branch down to {rows[1].at_top[0]:.1f} Hz at 20 000 rpm, the one-mode model has "
        f"{analytic.at_top[0]:.1f} Hz.",
        "### Table 3 and Figure 6: peaks of the unbalance response",
        table(told["Table 3"]),
        "The Ansys peaks lie on a grid of 100 rpm (±0.83 Hz). Unbalance 1e-7 kg m on the inner "
        "disk, speed ratio −1, no damping.",
        bonded.picture("unbalance_response.png", "Unbalance response, bonded disks")
        + "\n"
        + held.picture("unbalance_response.png", "Unbalance response, rigid disks"),
        "### What each choice of the paper costs",
        _choices_table(rows),
        "Each row adds a choice to the row above; the last one is what the paper calls analytic. "
        "Log decrements are those of the first two branches at 20 000 rpm. Damping assigned to the "
        "modes of a shaft turns with it: above the forward critical speed it drives it unstable.",
    ]


def _table_2(analytic: Variant, rows: list[Variant]) -> list[Row]:
    printed = {"analytic": (166.59, 190.93), "Simpack": (168.80, 190.55), "Ansys": (168.24, 189.82)}
    models = {
        "one-term Ritz": (analytic, "analytic", "inferred"),
        "rigid disks on 10.4 mm": (rows[1], "Ansys", "inferred; 10.4 mm identified"),
        "rigid disks on 10.4 mm ": (rows[1], "Simpack", "inferred; 10.4 mm identified"),
        "bonded solid disks": (rows[0], "analytic", "inferred"),
    }
    return [
        per_cent(
            f"{name.strip()} / {source}", f"f{k + 1}", printed[source][k], v.at_rest[k], "Hz", data
        )
        for name, (v, source, data) in models.items()
        for k in (0, 1)
    ]


def _table_3(analytic: Variant, rows: list[Variant]) -> list[Row]:
    printed = {
        "analytic": (165.32, 192.83),
        "Simpack": (168.41, 190.35),
        "Ansys": (163.33, 188.33, 328.33),
    }
    pairs = [
        (analytic, "one-term Ritz", "analytic", "inferred"),
        (rows[1], "rigid disks on 10.4 mm", "Ansys", "inferred; 10.4 mm identified"),
        (rows[1], "rigid disks on 10.4 mm", "Simpack", "inferred; 10.4 mm identified"),
        (rows[0], "bonded solid disks", "Ansys", "inferred"),
    ]
    return [
        per_cent(f"{name} / {source}", f"peak {k + 1}", value, v.peaks[k], "Hz", data)
        for v, name, source, data in pairs
        for k, value in enumerate(printed[source])
    ]


def _choices_table(rows: list[Variant]) -> str:
    def listed(values: tuple[float, ...], digits: int) -> str:
        return " / ".join(f"{v:.{digits}f}" for v in values) or "-"

    head = ("model", "at rest [Hz]", "at 20 000 rpm [Hz]", "peaks [Hz]", "log decrements")
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
