"""Rigid motions of imported matrices: what nodes say, and what the stiffness makes of the rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray, motion_at
from solidwhirl.rotordyn.importing.rows import Report
from solidwhirl.rotordyn.superelement.validation import MOTIONS

# Square of a frequency in rigid motion over that of the fastest mode: below it the motion is free,
# and the rest is rounding of the file. 10 digits leave 1e-10; a mount of 10 Hz on a casing whose
# model reaches 100 kHz has 1e-8.
_FREE = 1e-9
# Elastic force in rigid motion that is rounding of doubles; more is taken out.
_ROUNDING = 1e-11
# A motion that the others make up to this part is none of its own.
_OWN = 1e-6
# Interior motions softer than this part of the stiffest are not determined by the interfaces.
_LOOSE = 1e-10
_SAME_MOTION = 1e-6
# A free motion that rigid ones miss by less is meant to be one.
_LOOSE_PART = 0.3


class ImportedMotions(NamedTuple):
    """Motions ux to rz about the origin.

    `modes`: in the coordinates, shape (n, 6); zero columns where the coordinates can't show one.
    `shown`: which can be shown, shape (6,).
    `present`: which the stiffness leaves free, shape (6,).
    """

    modes: FloatArray
    shown: Any
    present: Any


def imported_motions(
    report: Report, places: FloatArray, components: Any, matrices: Mapping[str, FloatArray]
) -> ImportedMotions:
    """Find the rigid motions of a body.

    `places`, `components`: of the rows: nodes, shape (n, 3), and 1 to 6, or 0 for an amplitude of a
    mode; `matrices`: by role, in SI units.
    Raises SuperelementError: rigid motions that the file states and the nodes contradict.
    """
    modes = np.zeros((len(components), 6))
    real = components > 0
    for row in np.flatnonzero(real):
        modes[row] = motion_at(places[row])[components[row] - 1]
    stated = matrices.get("rigid_modes")
    if stated is not None:
        _check_stated(report, stated, modes, real)
        modes = np.where(real[:, None] & stated.any(axis=0), modes, stated)
    elif not real.all():
        modes[~real] = _condensed(report, matrices, real, modes[real])
    mass, stiffness = matrices["mass"], matrices["stiffness"]
    shown = _independent(mass, modes)
    modes = np.where(shown, modes, 0.0)
    top = _fastest(mass, stiffness, matrices.get("constraint"))
    kinetic = np.einsum("ik,ij,jk->k", modes, mass, modes)
    elastic = np.einsum("ik,ij,jk->k", modes, stiffness, modes)
    ratio = np.where(shown, np.abs(elastic) / np.where(shown, kinetic, 1.0), np.inf)
    present = ratio <= _FREE * top
    if not present.any():
        said = "The stiffness holds all rigid motions: the body is fixed to the ground."
        report.notes.append(said)
    elif (shown & ~present).any():
        held = ", ".join(m for m, s, p in zip(MOTIONS, shown, present, strict=True) if s and not p)
        report.notes.append(f"The stiffness holds the rigid motions {held}.")
    return ImportedMotions(modes=modes, shown=shown, present=present)


def _check_stated(report: Report, stated: FloatArray, modes: FloatArray, real: Any) -> None:
    """Refuse stated motions that are not t + θ × x at the nodes."""
    there = stated.any(axis=0)
    size = max(1.0, float(np.abs(modes).max(initial=0.0)))
    wrong = np.abs(stated - modes)[real][:, there]
    if wrong.size and wrong.max() > _SAME_MOTION * size:
        raise report.error(
            f"rigid_modes differ from the motions of the nodes by {wrong.max():.2e}; they "
            "are columns ux uy uz rx ry rz about the origin"
        )


def _condensed(
    report: Report, matrices: Mapping[str, FloatArray], real: Any, moved: FloatArray
) -> FloatArray:
    """Amplitudes of modes that follow the nodes without elastic force of their own."""
    stiffness, mass, inside = matrices["stiffness"], matrices["mass"], ~real
    root = np.sqrt(np.diag(mass)[inside].clip(1e-300))
    block = stiffness[np.ix_(inside, inside)] / np.outer(root, root)
    values, vectors = la.eigh(block)
    firm = values > _LOOSE * max(float(values[-1]), 0.0)
    if not firm.all():
        report.notes.append(
            f"{np.count_nonzero(~firm)} modes are free while the nodes stand still; rigid motions "
            "that need them are not known (the file could state them as rigid_modes)."
        )
    force = stiffness[np.ix_(inside, real)] @ moved / root[:, None]
    parts = vectors[:, firm].T @ force
    return np.asarray(-(vectors[:, firm] @ (parts / values[firm, None])) / root[:, None])


def _independent(mass: FloatArray, modes: FloatArray) -> Any:
    """Which motions have inertia of their own, translations first."""
    shown = np.zeros(6, dtype=bool)
    momentum = mass @ modes
    for k in range(6):
        own = float(modes[:, k] @ momentum[:, k])
        if own <= 0.0:
            continue
        rest = modes[:, k]
        if shown.any():
            others, push = modes[:, shown], momentum[:, shown]
            rest = rest - others @ la.lstsq(others.T @ push, push.T @ rest)[0]
        shown[k] = float(rest @ mass @ rest) > _OWN**2 * own
    return shown


def _fastest(mass: FloatArray, stiffness: FloatArray, tie: FloatArray | None) -> float:
    """Largest ratio of stiffness to mass of a coordinate, (rad/s)²: a bound of the size of K."""
    if tie is not None:
        mass, stiffness = tie.T @ mass @ tie, tie.T @ stiffness @ tie
    root = np.sqrt(np.diag(mass).clip(1e-300))
    return float(la.norm(stiffness / np.outer(root, root), 2)) or 1.0


def cleaned_stiffness(
    report: Report, matrices: Mapping[str, FloatArray], motions: ImportedMotions
) -> FloatArray:
    """Return K without the rounding that resists free rigid motions."""
    stiffness, mass = matrices["stiffness"], matrices["mass"]
    if not motions.present.any():
        return stiffness
    modes = motions.modes[:, motions.present]
    root = np.sqrt(np.diag(mass).clip(1e-300))
    scaled = stiffness / np.outer(root, root)
    size = float(la.norm(scaled, 2))
    moved = root[:, None] * modes
    force = la.norm(scaled @ moved, axis=0) / la.norm(moved, axis=0)
    if size == 0.0 or force.max() <= _ROUNDING * size:
        return stiffness
    kinetic = np.einsum("ik,ij,jk->k", modes, mass, modes)
    elastic = np.abs(np.einsum("ik,ij,jk->k", modes, stiffness, modes))
    worst = float(np.sqrt((elastic / kinetic).max()) / (2.0 * np.pi))
    report.notes.append(
        f"Rounding of the file holds rigid motions with up to {worst:.2g} Hz (relative force "
        f"{force.max() / size:.1e}); it was taken out of the stiffness."
    )
    momentum = mass @ modes
    away = np.eye(len(mass)) - modes @ la.solve(modes.T @ momentum, momentum.T, assume_a="pos")
    clean = away.T @ stiffness @ away
    return np.asarray(0.5 * (clean + clean.T))


def check_free_motions(
    report: Report, matrices: Mapping[str, FloatArray], motions: ImportedMotions, rates: FloatArray
) -> None:
    """Refuse a stiffness that leaves a motion free which is rigid but for the places of the nodes.

    `rates` are the squares of the frequencies at rest, rising, (rad/s)²; notes say where a part of
    the body is loose.

    Raises SuperelementError: the places or components of the nodes contradict the stiffness.
    """
    mass, stiffness = matrices["mass"], matrices["stiffness"]
    limit = _FREE * max(float(rates[-1]), 0.0)
    loose = int(np.count_nonzero(rates <= limit))
    modes = motions.modes[:, motions.shown]
    momentum = mass @ modes
    kinetic = modes.T @ momentum
    known = int(np.count_nonzero(la.eigvalsh(modes.T @ stiffness @ modes, kinetic) <= limit))
    if loose <= known or limit == 0.0:
        return
    tie = matrices.get("constraint")
    tie = np.eye(len(mass)) if tie is None else tie
    _, free = la.eigh(tie.T @ stiffness @ tie, tie.T @ mass @ tie, subset_by_index=[0, loose - 1])
    free = tie @ free
    # the parts of the free motions that no rigid motion has; the vectors have unit inertia
    parts = free - modes @ la.solve(kinetic, momentum.T @ free, assume_a="pos")
    missed = np.sqrt(np.abs(la.eigvalsh(parts.T @ mass @ parts))[known - loose :])
    if missed.min() < _LOOSE_PART:
        raise report.error(
            f"the stiffness leaves {loose} motions free, of which {known} are rigid "
            f"motions of the nodes, and another is one but for {missed.min():.1e} of it; are "
            "places and components of the nodes those of the matrices, and in the same unit?"
        )
    report.notes.append(
        f"The stiffness leaves {loose - known} more motions free than rigid ones: a part of the "
        "body is loose."
    )


def shown_points(
    places: FloatArray,
    components: Any,
    motions: ImportedMotions,
    stated: tuple[FloatArray, FloatArray] | None,
) -> tuple[FloatArray, FloatArray]:
    """Return points for pictures, (p, 3), and their displacements, (p, 3, n): stated, or nodes."""
    n = len(components)
    if stated is not None:
        return stated
    found: dict[tuple[float, ...], dict[int, int]] = {}
    for row in np.flatnonzero((components >= 1) & (components <= 3)):
        found.setdefault(tuple(places[row]), {})[int(components[row]) - 1] = int(row)
    points, modes = [], []
    for place, rows in found.items():
        mode = np.zeros((3, n))
        for axis, row in rows.items():
            mode[axis, row] = 1.0
        wanted = motion_at(np.array(place))[:3]
        wrong = np.abs(mode @ motions.modes - wanted)[:, motions.present]
        # a node without uz is a point only if no rigid motion moves it along z
        if wrong.max(initial=0.0) <= _SAME_MOTION:
            points.append(place)
            modes.append(mode)
    return np.array(points).reshape(-1, 3), np.array(modes).reshape(-1, 3, n)
