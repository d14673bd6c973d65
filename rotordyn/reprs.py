"""How records show themselves: a few lines with units instead of all their arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from solidwhirl.rotordyn.campbell import Campbell
    from solidwhirl.rotordyn.critical_speed_map import CriticalSpeedMap
    from solidwhirl.rotordyn.critical_speeds import CriticalSpeed
    from solidwhirl.rotordyn.eigen import Modes
    from solidwhirl.rotordyn.parts import Bearing, Rotor, System
    from solidwhirl.rotordyn.run_up_record import RunUp
    from solidwhirl.rotordyn.superelement import Superelement
    from solidwhirl.rotordyn.system import AssembledSystem
    from solidwhirl.rotordyn.unbalance import ExciterResponse, UnbalanceResponse

_RPM = 30.0 / np.pi
# Lines of a list, and entries of a row, before the rest is counted.
_MOST_LINES, _MOST_WORDS = 8, 6


def row(words: Iterable[str]) -> str:
    """Return words with commas, the last ones counted where there are many.

    Parameters
    ----------
    words
        Names or numbers.
    """
    every = list(words)
    more = len(every) - _MOST_WORDS
    return ", ".join([*every[:_MOST_WORDS], *([f"and {more} more"] if more > 0 else [])])


def hertz(values: npt.ArrayLike) -> str:
    """Return frequencies in a row with their unit.

    Parameters
    ----------
    values
        In Hz.
    """
    known = np.ravel(values)
    return row(f"{v:.2f}" for v in known) + " Hz" if known.size else "none"


def _lines(head: str, rest: Sequence[str]) -> str:
    more = len(rest) - _MOST_LINES
    shown = [*rest[:_MOST_LINES], *([f"and {more} more"] if more > 0 else [])]
    return "\n".join([head, *(f"  {line}" for line in shown)])


def _speeds(speeds_rad_s: npt.NDArray[np.float64]) -> str:
    rpm = speeds_rad_s * _RPM
    if rpm.size < 2:
        return f"{rpm.size} speed" + "".join(f", {v:.6g} rpm" for v in rpm)
    return f"{rpm.size} speeds from {rpm[0]:.6g} to {rpm[-1]:.6g} rpm"


def superelement_text(element: Superelement) -> str:
    """Name, mass, size, interfaces, modes, and the speed it is good for."""
    top = element.maximum_speed_rad_s * _RPM
    seats = row(f"{n.name} {n.position_m[2]:.4g}" for n in element.interfaces)
    return _lines(
        f"Superelement {element.name!r}: {element.level}, {element.mass_kg:.5g} kg, "
        f"{len(element.coordinates)} coordinates of {element.full_dofs}",
        [
            f"interfaces at z: {seats} m",
            f"free modes: {hertz(element.free_frequencies_hz)}",
            f"good up to {top:.6g} rpm" if np.isfinite(top) else "good at all speeds",
        ],
    )


def rotor_text(rotor: Rotor) -> str:
    """The body and its speed ratio."""
    damped = ", internal damping" if rotor.internal_damping is not None else ""
    element = rotor.element
    return (
        f"Rotor {element.name!r}: {element.level}, {element.mass_kg:.5g} kg, "
        f"speed ratio {rotor.speed_ratio:g}{damped}"
    )


def bearing_text(bearing: Bearing) -> str:
    """Both ends and what is not zero."""
    second = "ground" if bearing.second is None else bearing.second.label
    found = [
        _matrix_text("k", bearing.stiffness_n_per_m, "N/m"),
        _matrix_text("c", bearing.damping_n_s_per_m, "N s/m"),
        _matrix_text("tilt k", bearing.tilt_stiffness_n_m_per_rad, "N m/rad"),
        _matrix_text("tilt c", bearing.tilt_damping_n_m_s_per_rad, "N m s/rad"),
    ]
    numbers = (
        ("axial k", bearing.axial_stiffness_n_per_m, "N/m"),
        ("axial c", bearing.axial_damping_n_s_per_m, "N s/m"),
        ("torsion k", bearing.torsion_stiffness_n_m_per_rad, "N m/rad"),
        ("torsion c", bearing.torsion_damping_n_m_s_per_rad, "N m s/rad"),
    )
    found += [f"{name} {value:.4g} {unit}" for name, value, unit in numbers if value]
    found += [f"rigid {' '.join(bearing.rigid)}"] if bearing.rigid else []
    found += [f"law {bearing.speed_law.name!r}"] if bearing.speed_law is not None else []
    told = "; ".join(text for text in found if text) or "nothing"
    return f"Bearing {bearing.name!r}, {bearing.first.label} to {second}: {told}"


def _matrix_text(name: str, matrix: npt.NDArray[np.float64], unit: str) -> str:
    if not matrix.any():
        return ""
    if matrix[0, 1] or matrix[1, 0]:
        inside = "; ".join(" ".join(f"{v:.4g}" for v in line) for line in matrix)
        return f"{name} [{inside}] {unit}"
    if matrix[0, 0] == matrix[1, 1]:
        return f"{name} {matrix[0, 0]:.4g} {unit}"
    return f"{name} {matrix[0, 0]:.4g} in x, {matrix[1, 1]:.4g} in y {unit}"


def _parts(system: System) -> list[str]:
    joints = [_named("bearing", [b.name for b in system.bearings])]
    joints += [_named("gear", [g.name for g in system.gears])] if system.gears else []
    rotors = [
        f"{name}: {r.element.level}, {r.element.mass_kg:.5g} kg, speed ratio {r.speed_ratio:g}"
        for name, r in system.rotors.items()
    ]
    more = len(rotors) - _MOST_LINES + len(joints)
    if more > 0:
        rotors = [*rotors[: -more - 1], f"and {more + 1} more bodies"]
    return rotors + joints


def _named(what: str, names: Sequence[str]) -> str:
    return f"{_count(len(names), what)}: {row(names)}" if names else f"no {what}s"


def _bodies(system: System) -> str:
    number = len(system.rotors)
    return f"{number} {'body' if number == 1 else 'bodies'}"


def _count(number: int, what: str) -> str:
    return f"{number} {what if number == 1 else what + 's'}"


def system_text(system: System) -> str:
    """Bodies, bearings and gears."""
    return _lines("System of " + _bodies(system), _parts(system))


def assembled_text(assembled: AssembledSystem) -> str:
    """Bodies, bearings, gears and the number of coordinates."""
    kind = "undamped" if assembled.is_conservative else "damped"
    return _lines(
        f"AssembledSystem of {_bodies(assembled.system)}: {assembled.size} coordinates, {kind}",
        _parts(assembled.system),
    )


def modes_text(modes: Modes) -> str:
    """Speed, number and the lowest frequencies."""
    unstable = int((modes.log_decrement < 0).sum())
    warned = f", {unstable} of them grow" if unstable else ""
    return (
        f"Modes at {modes.speed_rad_s * _RPM:.6g} rpm: {modes.eigenvalues.size}{warned}\n"
        f"  {hertz(modes.frequency_hz)}"
    )


def campbell_text(campbell: Campbell) -> str:
    """Speeds, and both ends of every branch."""
    branches = []
    pairs = zip(campbell.frequency_hz, campbell.whirl, strict=True)
    for number, (frequency, whirl) in enumerate(pairs, start=1):
        alive = np.flatnonzero(np.isfinite(frequency))
        ends = [f"{frequency[k]:.2f} Hz {whirl[k]}" for k in alive[[0, -1]]] if alive.size else []
        branches.append(f"{number}: {' to '.join(ends) or 'absent'}")
    notes = f", {len(campbell.notes)} notes" if campbell.notes else ""
    head = f"Campbell: {len(branches)} branches, {_speeds(campbell.speeds_rad_s)}{notes}"
    return _lines(head, branches)


def critical_speed_text(found: CriticalSpeed) -> str:
    """Speed, frequency, whirl and damping."""
    return (
        f"CriticalSpeed: {found.speed_rad_s * _RPM:.2f} rpm, {found.frequency_hz:.2f} Hz, "
        f"{found.whirl}, log decrement {found.log_decrement:.3g}"
    )


def critical_speed_map_text(found: CriticalSpeedMap) -> str:
    """Bearings, stiffnesses and the number of branches."""
    k = found.stiffness_n_per_m
    return (
        f"CriticalSpeedMap of {row(found.bearings)}: {len(found.speed_rad_s)} branches, "
        f"{k.size} stiffnesses from {k[0]:.4g} to {k[-1]:.4g} N/m"
    )


def exciter_text(found: ExciterResponse) -> str:
    """Who excites at which frequency, and the places that move."""
    return (
        f"ExciterResponse to {row(found.bodies)} at {found.frequency_ratio:g} times the speed: "
        f"{len(found.nodes)} nodes, {len(found.bearing_forces)} bearings, "
        f"{_speeds(found.speeds_rad_s)}"
    )


def unbalance_text(found: UnbalanceResponse) -> str:
    """What was placed where, and the largest orbit of each exciter."""
    placed = row(f"{u.moment_kg_m:.4g} kg m at {u.end.label}" for u in found.unbalances)
    largest = []
    for exciter in found.exciters:
        major = np.nan_to_num(exciter.orbits().major_m)
        if major.size:
            at, node = np.unravel_index(int(major.argmax()), major.shape)
            largest.append(
                f"{row(exciter.bodies)}: largest orbit {major[at, node]:.4g} m at "
                f"{exciter.nodes[int(node)].label}, {found.speeds_rad_s[at] * _RPM:.6g} rpm"
            )
    head = f"UnbalanceResponse to {placed}: {_speeds(found.speeds_rad_s)}"
    return _lines(head, largest)


def run_up_text(run: RunUp) -> str:
    """Duration, speeds, and the largest force through each bearing."""
    pull = np.linalg.norm(run.force_n[:, :2], axis=1)
    forces = [
        f"{name}: largest force {force.max():.4g} N at {run.time_s[force.argmax()]:.4g} s"
        for name, force in zip(run.bearings, pull, strict=True)
        if force.size
    ]
    rpm = run.speed_rad_s * _RPM
    places = row(end.label for end in run.outputs) or "none"
    head = (
        f"RunUp: {run.time_s[-1] - run.time_s[0]:.4g} s, {rpm[0]:.6g} to {rpm[-1]:.6g} rpm, "
        f"{run.time_s.size} records of {places}"
    )
    return _lines(head, forces)
