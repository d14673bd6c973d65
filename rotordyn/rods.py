"""Axial motion and torsion of a shaft as rods, added to the lateral motion of its beam model."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.beam_elements import rod_coupling
from solidwhirl.rotordyn.mass_moments import MassMoments
from solidwhirl.rotordyn.shafts import Shaft
from solidwhirl.rotordyn.spectrum import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.superelement import Coordinate, Superelement
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component

_CONSISTENT = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
_SPRING = np.array([[1.0, -1.0], [-1.0, 1.0]])


class _Rod(NamedTuple):
    """One motion in Craig-Bampton form with every fixed-interface mode: interfaces first."""

    component: Component
    mass: FloatArray
    stiffness: FloatArray
    basis: FloatArray
    frequencies_hz: FloatArray


def with_rods(
    element: Superelement,
    shaft: Shaft,
    components: Sequence[Component],
    planes: tuple[FloatArray, FloatArray],
) -> Superelement:
    """Return a lateral beam element with axial motion or torsion added, or both.

    Parameters
    ----------
    element
        The lateral part.
    shaft
        What it was made of.
    components
        "uz", "rz" or both; linear two-node elements with consistent mass, disks at nodes.
    planes
        Deflection and slope w1, θ1, w2, ... of all nodes in the planes of x and of y, per
        coordinate of the element, each of shape (2N, n).

    Returns
    -------
    Superelement
        Interface coordinates in the order ux to rz, then lateral modes, then those of the rods.
        Without error forms, as the coordinates are others.
    """
    held = [shaft.node_at(z) for z in shaft.interfaces.values()]
    rods = [_reduced(c, *_matrices(shaft, c), held) for c in components]
    added = [_coordinates(rod, tuple(shaft.interfaces)) for rod in rods]
    coordinates = (*element.coordinates, *(c for group in added for c in group))
    order = _order(coordinates, tuple(shaft.interfaces))
    size = len(coordinates) - element.size
    zero = np.zeros((size, size))

    def grown(matrix: FloatArray, *blocks: FloatArray) -> FloatArray:
        return np.asarray(la.block_diag(matrix, *blocks)[np.ix_(order, order)])

    generator = element.spin_generator
    return dataclasses.replace(
        element,
        coordinates=tuple(coordinates[k] for k in order),
        mass=grown(element.mass, *[rod.mass for rod in rods]),
        stiffness=grown(element.stiffness, *[rod.stiffness for rod in rods]),
        gyroscopic=grown(element.gyroscopic, zero),
        stress_stiffening=grown(element.stress_stiffening, zero),
        spin_softening=grown(element.spin_softening, zero),
        rigid_body_modes=_rigid_modes(element, rods, len(held))[order],
        rigid_body_present=element.rigid_body_present | np.isin(MOTIONS, components),
        recovery_modes=_recovery(element, rods)[:, :, order],
        fixed_interface_frequencies_hz=np.sort(
            np.concatenate(
                [element.fixed_interface_frequencies_hz, *[rod.frequencies_hz for rod in rods]]
            )
        ),
        spin_generator=None if generator is None else grown(generator, zero),
        error_forms=(),
        moments=_moments(element.moments, shaft, rods, planes, order),
    )


def _moments(
    lateral: MassMoments | None,
    shaft: Shaft,
    rods: Sequence[_Rod],
    planes: tuple[FloatArray, FloatArray],
    order: Sequence[int],
) -> MassMoments | None:
    """Add uz, and rz (−y, x, 0), to the moments of sections that stay plane."""
    if lateral is None:
        return None
    known = lateral.size
    n = known + sum(rod.basis.shape[1] for rod in rods)
    simple, first, second = np.zeros((3, n)), np.zeros((3, 3, n)), np.zeros((3, 3, n, n))
    simple[:, :known], first[:, :, :known] = lateral.displacement_kg, lateral.first_kg_m
    second[:, :, :known, :known] = lateral.second_kg
    moving, tilting = _couplings(shaft)
    start, old = known, slice(0, known)
    for rod in rods:
        own = slice(start, start + rod.basis.shape[1])
        start = own.stop
        inertia, _ = _matrices(shaft, rod.component)
        if rod.component == "uz":
            simple[2, own] = rod.basis.T @ inertia.sum(axis=1)
            first[2, 2, own] = rod.basis.T @ inertia @ shaft.nodes_m
            second[2, 2, own, own] = rod.mass
            cross = {(2, a): rod.basis.T @ moving @ planes[a] for a in (0, 1)}
        else:
            first[0, 1, own] = 0.5 * rod.basis.T @ inertia.sum(axis=1)
            first[1, 0, own] = -first[0, 1, own]
            second[0, 0, own, own] = second[1, 1, own, own] = 0.5 * rod.mass
            cross = {
                (0, 2): rod.basis.T @ tilting @ planes[1],
                (1, 2): -rod.basis.T @ tilting @ planes[0],
            }
        for (a, b), block in cross.items():
            second[a, b, own, old], second[b, a, old, own] = block, block.T
    return MassMoments(
        displacement_kg=simple[:, order],
        first_kg_m=first[:, :, order],
        second_kg=second[:, :, order][:, :, :, order],
    )


def _couplings(shaft: Shaft) -> tuple[FloatArray, FloatArray]:
    """Return ∫ ρA N w and ∫ ρI N θ of rods and beams with disks, each (N, 2N)."""
    n = shaft.nodes_m.size
    moving, tilting = np.zeros((n, 2 * n)), np.zeros((n, 2 * n))
    elements = zip(pairwise(shaft.nodes_m), shaft.outer_radius_m, shaft.inner_radius_m, strict=True)
    for k, ((start, stop), outer, inner) in enumerate(elements):
        parts = rod_coupling(stop - start, outer, inner, shaft.poissons_ratio, shaft.density_kg_m3)
        at = np.s_[k : k + 2, 2 * k : 2 * k + 4]
        moving[at] += parts[0]
        tilting[at] += parts[1]
    for disk in shaft.disks:
        node = shaft.node_at(disk.position_m)
        moving[node, 2 * node] += disk.mass_kg
        tilting[node, 2 * node + 1] += 0.5 * disk.polar_kg_m2
    return moving, tilting


def _matrices(shaft: Shaft, component: Component) -> tuple[FloatArray, FloatArray]:
    """Return mass and stiffness of all nodes for uz (E A, ρ A) or rz (G J, ρ J)."""
    n = shaft.nodes_m.size
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    axial = component == "uz"
    modulus = shaft.youngs_modulus_pa
    if not axial:
        modulus = modulus / (2.0 * (1.0 + shaft.poissons_ratio))
    elements = zip(pairwise(shaft.nodes_m), shaft.outer_radius_m, shaft.inner_radius_m, strict=True)
    for k, ((start, stop), outer, inner) in enumerate(elements):
        section = np.pi * (outer**2 - inner**2)
        if not axial:
            section *= 0.5 * (outer**2 + inner**2)
        at = np.ix_([k, k + 1], [k, k + 1])
        length = stop - start
        mass[at] += shaft.density_kg_m3 * section * length * _CONSISTENT
        stiffness[at] += modulus * section / length * _SPRING
    for disk in shaft.disks:
        node = shaft.node_at(disk.position_m)
        mass[node, node] += disk.mass_kg if axial else disk.polar_kg_m2
    return mass, stiffness


def _reduced(
    component: Component, mass: FloatArray, stiffness: FloatArray, held: list[int]
) -> _Rod:
    n, count = mass.shape[0], len(held)
    ends = np.array(held)
    inner = np.setdiff1d(np.arange(n), ends)
    basis = np.zeros((n, n))
    basis[ends, np.arange(count)] = 1.0
    frequencies = np.empty(0)
    condensed = stiffness[np.ix_(ends, ends)]
    if inner.size:
        inside = stiffness[np.ix_(inner, inner)]
        coupling = stiffness[np.ix_(inner, ends)]
        static = -la.solve(inside, coupling, assume_a="pos")
        frequencies, shapes = solve_standing(scale_by_stiffness(inside, mass[np.ix_(inner, inner)]))
        basis[inner, :count], basis[inner, count:] = static, shapes
        condensed = condensed + coupling.T @ static
    # rounding in the rigid motion, which costs no force
    level = np.full((count, count), 1.0 / count)
    project = np.eye(count) - level
    reduced = np.diag(np.concatenate((np.zeros(count), frequencies**2)))
    reduced[:count, :count] = project @ condensed @ project
    return _Rod(component, basis.T @ mass @ basis, reduced, basis, frequencies / (2.0 * np.pi))


def _coordinates(rod: _Rod, interfaces: tuple[str, ...]) -> tuple[Coordinate, ...]:
    held = [
        Coordinate(kind="interface", interface=name, component=rod.component, frequency_hz=0.0)
        for name in interfaces
    ]
    free = [
        Coordinate(kind="modal", interface="", component="q", frequency_hz=float(f))
        for f in rod.frequencies_hz
    ]
    return (*held, *free)


def _order(coordinates: Sequence[Coordinate], interfaces: tuple[str, ...]) -> list[int]:
    def key(k: int) -> tuple[int, int, int]:
        c = coordinates[k]
        if c.kind == "modal":
            return (1, k, 0)
        return (0, interfaces.index(c.interface), MOTIONS.index(c.component))

    return sorted(range(len(coordinates)), key=key)


def _rigid_modes(element: Superelement, rods: Sequence[_Rod], interfaces: int) -> FloatArray:
    parts = [element.rigid_body_modes]
    for rod in rods:
        part = np.zeros((rod.basis.shape[1], 6))
        part[:interfaces, MOTIONS.index(rod.component)] = 1.0
        parts.append(part)
    return np.vstack(parts)


def _recovery(element: Superelement, rods: Sequence[_Rod]) -> FloatArray:
    """Return the displacement of the nodes; torsion moves no point on the axis."""
    parts = [element.recovery_modes]
    for rod in rods:
        part = np.zeros((rod.basis.shape[0], 3, rod.basis.shape[1]))
        if rod.component == "uz":
            part[:, 2] = rod.basis
        parts.append(part)
    return np.concatenate(parts, axis=2)
