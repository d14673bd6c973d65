"""Matrices from other programs as a superelement: order, units, axes, and what must hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES, ForeignBody
from solidwhirl.rotordyn.importing import checks, rigid_motions, rows
from solidwhirl.rotordyn.superelement.families import free_frequencies_by_family
from solidwhirl.rotordyn.superelement.free_body import free_body_problems
from solidwhirl.rotordyn.superelement.record import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS

_SAME = 1e-9
_MOST_FREQUENCIES = 40


def imported_superelement(
    name: str,
    body: ForeignBody,
    options: rows.ImportOptions,
    provenance: Mapping[str, Any] | None = None,
) -> Superelement:
    """Make a superelement of matrices from elsewhere.

    `provenance`: goes into the element's, beside what was noted ("import", "notes"). The level is
    "imported", SI units. Coordinates of nodes that are no interfaces, and amplitudes of modes, are
    its modal coordinates. Raises SuperelementError: units, nodes or matrices that are missing or
    contradict each other; matrices that are not symmetric or skew to 1e-6, a mass that is not
    positive definite, a stiffness that is negative, rigid motions whose mass is not that of one
    body; a turning body without a gyroscopic matrix, or one that is not the same in all directions
    about z.
    """
    report = rows.Report(f"imported body {name!r} ({body.files[0].name})", [])
    length, mass_unit = rows.import_units(report, body, options)
    chosen = rows.import_matrices(report, body, options.names)
    placed = rows.placed_rows(report, body, options, length)
    scaled = rows.scaled_matrices(chosen, placed, length, mass_unit)
    tie = scaled.get("constraint")
    checks.check_mass(report, placed.labels, scaled["mass"], tie)
    inertia = np.diag(scaled["mass"]).copy()
    for role, matrix in scaled.items():
        if ROLES[role].symmetry != "general":
            sign = -1.0 if ROLES[role].symmetry == "skew-symmetric" else 1.0
            scaled[role] = checks.symmetric_or_skew(report, role, matrix, sign, inertia)
    motions = rigid_motions.imported_motions(report, placed.places, placed.components, scaled)
    scaled["stiffness"] = rigid_motions.cleaned_stiffness(report, scaled, motions)
    rates = checks.check_stiffness(report, scaled["mass"], scaled["stiffness"], tie)
    rigid_motions.check_free_motions(report, scaled, motions, rates)
    given = rows.stated_properties(body, options, length, mass_unit)
    properties = checks.rigid_mass(report, scaled, motions, placed.positions, given)
    element = _element(name, placed, scaled, motions, properties, body)
    problems = free_body_problems(element)
    if problems:
        raise report.error("; ".join(problems))
    if options.turns:
        checks.check_turning(report, element)
    if not checks.turn_fits(report, element):
        element = dataclasses.replace(element, spin_generator=None)
    own = {**(provenance or {}), "notes": report.notes}
    return dataclasses.replace(
        element,
        free_frequencies_hz=free_frequencies_by_family(element)["lateral"][:_MOST_FREQUENCIES],
        provenance={"model": "imported matrices", "import": own},
    )


def _element(
    name: str,
    placed: rows.Placed,
    scaled: Mapping[str, FloatArray],
    motions: rigid_motions.ImportedMotions,
    properties: tuple[float, FloatArray, FloatArray],
    body: ForeignBody,
) -> Superelement:
    n = len(placed.components)
    zero = np.zeros((n, n))
    mass_kg, center, inertia = properties
    points, modes = rigid_motions.shown_points(
        placed.places, placed.components, motions, _stated_points(body, placed)
    )
    inside = np.array([not owner for owner in placed.owners])
    block = np.ix_(inside, inside)
    held = (
        la.eigvalsh(scaled["stiffness"][block], scaled["mass"][block])
        if inside.any() and "constraint" not in scaled
        else np.empty(0)
    )
    return Superelement(
        name=name,
        level="imported",
        harmonics=(),
        coordinates=_coordinates(placed, _frequencies(placed, scaled)),
        interfaces=tuple(
            InterfaceNode(name=key, position_m=place, coupling="none")
            for key, place in placed.positions.items()
        ),
        mass=scaled["mass"],
        stiffness=scaled["stiffness"],
        gyroscopic=scaled.get("gyroscopic", zero),
        stress_stiffening=scaled.get("stress_stiffening", zero),
        spin_softening=-scaled.get("spin_softening", zero),
        rigid_body_modes=np.where(motions.present, motions.modes, 0.0),
        rigid_body_present=motions.present,
        mass_kg=mass_kg,
        center_of_gravity_m=center,
        inertia_kg_m2=inertia,
        full_dofs=n,
        maximum_speed_rad_s=body.maximum_speed_rad_s,
        recovery_points_m=points,
        recovery_modes=modes,
        free_frequencies_hz=np.empty(0),
        fixed_interface_frequencies_hz=np.sqrt(held.clip(0.0)) / (2.0 * np.pi),
        frequency_error_estimate=np.empty(0),
        spin_generator=scaled.get("spin_generator"),
        constraint=scaled.get("constraint"),
    )


def _coordinates(placed: rows.Placed, frequencies_hz: FloatArray) -> tuple[Coordinate, ...]:
    """Interfaces keep their components, all others are modal."""
    return tuple(
        Coordinate(
            kind="interface" if owner else "modal",
            interface=owner,
            component=MOTIONS[component - 1] if owner else "q",
            frequency_hz=0.0 if owner else float(frequency),
        )
        for owner, component, frequency in zip(
            placed.owners, placed.components, frequencies_hz, strict=True
        )
    )


def _frequencies(placed: rows.Placed, scaled: Mapping[str, FloatArray]) -> FloatArray:
    """Frequencies of the modal coordinates [Hz], if they are amplitudes of modes; else zeros."""
    inside = np.array([not owner for owner in placed.owners])
    none = np.zeros(len(inside))
    if not inside.any() or placed.components[inside].any():
        return none
    stiffness = scaled["stiffness"][np.ix_(inside, inside)]
    mass = scaled["mass"][np.ix_(inside, inside)]
    root = np.sqrt(np.diag(mass).clip(1e-300))
    for matrix in (stiffness, mass):
        scale = matrix / np.outer(root, root)
        if np.abs(scale - np.diag(np.diag(scale))).max() > _SAME * np.abs(scale).max():
            return none
    none[inside] = np.sqrt((np.diag(stiffness) / np.diag(mass)).clip(0.0)) / (2.0 * np.pi)
    return none


def _stated_points(body: ForeignBody, placed: rows.Placed) -> tuple[FloatArray, FloatArray] | None:
    """Points for pictures that the file has; those of this program's own files are in SI units."""
    if body.point_modes is None or not len(body.points) or body.length_unit != "m":
        return None
    modes = np.einsum("ab,pbn->pan", placed.turn, body.point_modes)[:, :, placed.order]
    return body.points @ placed.turn.T + placed.shift_m, modes
