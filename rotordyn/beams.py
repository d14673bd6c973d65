"""Shafts as Timoshenko beams, delivered as superelements like every other body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.beam_elements import PlaneMatrices, shaft_matrices
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.mass_moments import MassMoments
from solidwhirl.rotordyn.rigid_body import MassProperties, joined_mass_properties
from solidwhirl.rotordyn.rods import with_rods
from solidwhirl.rotordyn.shafts import Disk, Shaft, checked_shaft
from solidwhirl.rotordyn.spectrum import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.superelement import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component

__all__ = ["Disk", "beam_superelement"]

_FREE_MODES_LISTED = 10
_LATERAL: tuple[Component, ...] = ("ux", "uy", "rx", "ry")


def beam_superelement(
    name: str,
    stations_m: npt.ArrayLike,
    outer_radius_m: npt.ArrayLike,
    inner_radius_m: npt.ArrayLike,
    youngs_modulus_pa: float,
    poissons_ratio: float,
    density_kg_m3: float,
    interface_stations: Mapping[str, float],
    disks: Sequence[Disk] = (),
    components: Sequence[Component] = _LATERAL,
) -> Superelement:
    """Build the superelement of a stepped shaft with rigid disks.

    Parameters
    ----------
    name
        Name of the body.
    stations_m
        Section ends along the axis, increasing, shape (N,), m. Each pair bounds one element;
        interfaces and disks between stations split theirs.
    outer_radius_m, inner_radius_m
        Radii of the sections, shape (N − 1,), or one number for all; inner 0 is solid, m.
    youngs_modulus_pa, poissons_ratio, density_kg_m3
        Material.
    interface_stations
        Axial position of each interface by name, m; at least one.
    disks
        Rigid disks.
    components
        Motions of the interfaces: ux, uy, rx, ry always, "uz" (axial) and "rz" (torsion) if named.

    Returns
    -------
    Superelement
        Level "beam": ux, uy, rx, ry at each interface, then all fixed-interface modes as modal
        coordinates in pairs (plane of x, plane of y); likewise axial motion and torsion. Nothing
        is truncated, so the element is equivalent to the beam model itself.

    Raises
    ------
    SuperelementError
        If the geometry or material is out of range; the message names the place.

    Notes
    -----
    In the inertial frame a Timoshenko beam has no centrifugal stiffness: the stress stiffening
    and the spin softening of a tilting cross-section cancel. A shear modulus G and Young's
    modulus E stand for Poisson's ratio E/2G − 1.
    """
    unknown = set(components) - set(MOTIONS)
    if unknown or not set(_LATERAL) <= set(components):
        raise SuperelementError(
            f"beam {name!r}: components {tuple(components)}; allowed are {_LATERAL} and, beside "
            "them, 'uz' and 'rz'"
        )
    shaft = checked_shaft(
        name,
        np.asarray(stations_m, dtype=float),
        np.asarray(outer_radius_m, dtype=float),
        np.asarray(inner_radius_m, dtype=float),
        (youngs_modulus_pa, poissons_ratio, density_kg_m3),
        dict(interface_stations),
        tuple(disks),
    )
    matrices = _plane_matrices(shaft)
    held = [shaft.node_at(z) for z in shaft.interfaces.values()]
    plane = _fixed_interface_form(shaft.nodes_m, matrices, held)
    properties = _mass_properties(shaft)
    lateral = Superelement(
        name=name,
        level="beam",
        harmonics=(),
        coordinates=_coordinates(tuple(shaft.interfaces), plane.frequencies_hz),
        interfaces=tuple(
            InterfaceNode(name=key, position_m=np.array([0.0, 0.0, z]), coupling="none")
            for key, z in shaft.interfaces.items()
        ),
        **_spatial_matrices(plane, len(held)),
        rigid_body_modes=_rigid_body_modes(shaft.nodes_m[held], plane.frequencies_hz.size),
        rigid_body_present=np.array([True, True, False, True, True, False]),
        mass_kg=properties.mass_kg,
        center_of_gravity_m=properties.center_of_gravity_m,
        inertia_kg_m2=properties.inertia_kg_m2,
        full_dofs=4 * shaft.nodes_m.size,
        maximum_speed_rad_s=np.inf,
        recovery_points_m=np.outer(shaft.nodes_m, [0.0, 0.0, 1.0]),
        recovery_modes=_recovery_modes(plane.basis, len(held)),
        free_frequencies_hz=_free_frequencies_hz(matrices),
        fixed_interface_frequencies_hz=np.repeat(plane.frequencies_hz, 2),
        frequency_error_estimate=np.empty(0),
        provenance=shaft.provenance(),
        spin_generator=_spin_generator(len(held), plane.frequencies_hz.size),
        moments=_moments(plane, shaft.nodes_m[held]),
    )
    rods = [c for c in MOTIONS if c in components and c not in _LATERAL]
    if not rods:
        return lateral
    in_x, in_y = _planes(len(held), plane.frequencies_hz.size)
    return with_rods(lateral, shaft, rods, (plane.basis @ in_x.T, plane.basis @ in_y.T))


class _ReducedPlane(NamedTuple):
    """One plane in (w, θ) of the interfaces and all fixed-interface modes."""

    basis: FloatArray
    matrices: PlaneMatrices
    frequencies_hz: FloatArray


def _plane_matrices(shaft: Shaft) -> PlaneMatrices:
    """Return the matrices of the shaft with its disks in one plane."""
    matrices = shaft_matrices(
        shaft.nodes_m,
        shaft.outer_radius_m,
        shaft.inner_radius_m,
        shaft.youngs_modulus_pa,
        shaft.poissons_ratio,
        shaft.density_kg_m3,
    )
    for disk in shaft.disks:
        at = 2 * shaft.node_at(disk.position_m)
        matrices.mass[at, at] += disk.mass_kg
        matrices.mass[at + 1, at + 1] += disk.diametral_kg_m2
        matrices.gyroscopic[at + 1, at + 1] += disk.polar_kg_m2
    return matrices


def _fixed_interface_form(
    nodes_m: FloatArray, matrices: PlaneMatrices, held: list[int]
) -> _ReducedPlane:
    """Return the Craig-Bampton form of one plane with every fixed-interface mode kept."""
    mass, stiffness, gyroscopic = matrices
    boundary = np.array([2 * node + k for node in held for k in (0, 1)])
    inner = np.setdiff1d(np.arange(mass.shape[0]), boundary)
    basis = np.zeros_like(mass)
    basis[boundary, np.arange(boundary.size)] = 1.0
    frequencies = np.empty(0)
    condensed = stiffness[np.ix_(boundary, boundary)]
    if inner.size:
        inside = np.ix_(inner, inner)
        coupling = stiffness[np.ix_(inner, boundary)]
        static = -la.solve(stiffness[inside], coupling, assume_a="pos")
        scaled = scale_by_stiffness(stiffness[inside], mass[inside])
        frequencies, shapes = solve_standing(scaled)
        basis[inner, : boundary.size] = static
        basis[inner, boundary.size :] = shapes
        condensed = condensed + coupling.T @ static
    reduced = np.diag(np.concatenate((np.zeros(boundary.size), frequencies**2)))
    reduced[: boundary.size, : boundary.size] = _without_rigid_part(condensed, nodes_m[held])
    return _ReducedPlane(
        basis,
        PlaneMatrices(basis.T @ mass @ basis, reduced, basis.T @ gyroscopic @ basis),
        frequencies / (2.0 * np.pi),
    )


def _without_rigid_part(condensed: FloatArray, positions_m: FloatArray) -> FloatArray:
    """Return the interface stiffness with the rounding in its two rigid motions removed."""
    if positions_m.size == 1:
        return np.zeros_like(condensed)
    length = float(np.ptp(positions_m))
    metric = np.tile([1.0, 1.0 / length], positions_m.size)
    rigid = metric[:, None] ** -1.0 * _plane_rigid_modes(positions_m)
    rigid = la.orth(rigid)
    projector = np.eye(metric.size) - rigid @ rigid.T
    scaled = projector @ (metric[:, None] * condensed * metric) @ projector
    return np.asarray(scaled / np.outer(metric, metric))


def _plane_rigid_modes(positions_m: FloatArray) -> FloatArray:
    """Return translation and tilt about the origin in (w1, θ1, w2, θ2, ...)."""
    modes = np.zeros((2 * positions_m.size, 2))
    modes[0::2, 0] = 1.0
    modes[0::2, 1] = positions_m
    modes[1::2, 1] = 1.0
    return modes


def _free_frequencies_hz(matrices: PlaneMatrices) -> FloatArray:
    """Return the lowest elastic frequencies of the free shaft at rest, both planes."""
    omega, _ = solve_standing(scale_by_stiffness(matrices.stiffness, matrices.mass))
    return np.repeat(omega[: _FREE_MODES_LISTED // 2] / (2.0 * np.pi), 2)


def _planes(interface_count: int, mode_count: int) -> tuple[FloatArray, FloatArray]:
    """Return the maps from the plane of x and of y to ux, uy, rx, ry, ..., q, q.

    In the plane of x (w, θ) = (ux, ry); in the plane of y (w, θ) = (uy, −rx).
    """
    size = 2 * interface_count + mode_count
    in_x, in_y = np.zeros((2 * size, size)), np.zeros((2 * size, size))
    for j in range(interface_count):
        in_x[4 * j, 2 * j] = in_x[4 * j + 3, 2 * j + 1] = 1.0
        in_y[4 * j + 1, 2 * j], in_y[4 * j + 2, 2 * j + 1] = 1.0, -1.0
    for k in range(mode_count):
        column = 2 * interface_count + k
        in_x[2 * column, column] = in_y[2 * column + 1, column] = 1.0
    return in_x, in_y


def _spatial_matrices(plane: _ReducedPlane, interface_count: int) -> dict[str, Any]:
    """Return the matrices of both planes; G couples them through Ip (rx ry' − ry rx')."""
    mass, stiffness, gyroscopic = plane.matrices
    in_x, in_y = _planes(interface_count, plane.frequencies_hz.size)
    zero = np.zeros((in_x.shape[0], in_x.shape[0]))
    return {
        "mass": in_x @ mass @ in_x.T + in_y @ mass @ in_y.T,
        "stiffness": in_x @ stiffness @ in_x.T + in_y @ stiffness @ in_y.T,
        "gyroscopic": in_x @ gyroscopic @ in_y.T - in_y @ gyroscopic @ in_x.T,
        "stress_stiffening": zero,
        "spin_softening": zero,
    }


def _moments(plane: _ReducedPlane, positions_m: FloatArray) -> MassMoments:
    """Return the moments of sections that stay plane: (w_x, w_y, −θ_x x − θ_y y) at (x, y).

    ∫ x² = ∫ y² is half the weight of G; what else M holds belongs to the motion across the axis,
    with the tilt of disks of some length in it.
    """
    tilting = 0.5 * plane.matrices.gyroscopic
    moving = plane.matrices.mass - tilting
    in_x, in_y = _planes(positions_m.size, plane.frequencies_hz.size)
    rigid = np.zeros((moving.shape[0], 2))
    rigid[: 2 * positions_m.size] = _plane_rigid_modes(positions_m)
    simple = np.zeros((3, in_x.shape[0]))
    first = np.zeros((3, 3, in_x.shape[0]))
    second = np.zeros((3, 3, in_x.shape[0], in_x.shape[0]))
    for a, own in enumerate((in_x, in_y)):
        simple[a] = own @ moving @ rigid[:, 0]
        first[2, a] = own @ moving @ rigid[:, 1]
        first[a, 2] = -own @ tilting @ rigid[:, 1]
        second[2, 2] += own @ tilting @ own.T
        for b, other in enumerate((in_x, in_y)):
            second[a, b] = own @ moving @ other.T
    return MassMoments(displacement_kg=simple, first_kg_m=first, second_kg=second)


def _spin_generator(interface_count: int, mode_count: int) -> FloatArray:
    """Return L: a small turn moves the plane of x into that of y."""
    in_x, in_y = _planes(interface_count, mode_count)
    return np.asarray(in_y @ in_x.T - in_x @ in_y.T)


def _rigid_body_modes(positions_m: FloatArray, mode_count: int) -> FloatArray:
    """Return the motions ux, uy, uz, rx, ry, rz about the origin, shape (n, 6)."""
    in_x, in_y = _planes(positions_m.size, mode_count)
    plane = np.zeros((in_x.shape[1], 2))
    plane[: 2 * positions_m.size] = _plane_rigid_modes(positions_m)
    modes = np.zeros((in_x.shape[0], 6))
    modes[:, 0], modes[:, 4] = (in_x @ plane).T
    modes[:, 1], modes[:, 3] = in_y @ plane[:, 0], -(in_y @ plane[:, 1])
    return modes


def _recovery_modes(basis: FloatArray, interface_count: int) -> FloatArray:
    """Return the displacement of the nodes per coordinate, shape (N, 3, n)."""
    in_x, in_y = _planes(interface_count, basis.shape[1] - 2 * interface_count)
    modes = np.zeros((basis.shape[0] // 2, 3, in_x.shape[0]))
    modes[:, 0], modes[:, 1] = basis[0::2] @ in_x.T, basis[0::2] @ in_y.T
    return modes


def _coordinates(interfaces: tuple[str, ...], frequencies_hz: FloatArray) -> tuple[Coordinate, ...]:
    motions: tuple[Component, ...] = ("ux", "uy", "rx", "ry")
    held = [
        Coordinate(kind="interface", interface=name, component=c, frequency_hz=0.0)
        for name in interfaces
        for c in motions
    ]
    free = [
        Coordinate(kind="modal", interface="", component="q", frequency_hz=float(f))
        for f in np.repeat(frequencies_hz, 2)
    ]
    return (*held, *free)


def _mass_properties(shaft: Shaft) -> MassProperties:
    """Return the closed-form mass properties of the cylinders and disks."""
    parts = []
    edges = zip(shaft.nodes_m[:-1], shaft.nodes_m[1:], strict=True)
    radii = zip(shaft.outer_radius_m, shaft.inner_radius_m, strict=True)
    for (start, stop), (outer, inner) in zip(edges, radii, strict=True):
        mass = shaft.density_kg_m3 * np.pi * (outer**2 - inner**2) * (stop - start)
        polar = 0.5 * mass * (outer**2 + inner**2)
        diametral = 0.5 * polar + mass * (stop - start) ** 2 / 12.0
        center = np.array([0.0, 0.0, 0.5 * (start + stop)])
        parts.append(MassProperties(mass, center, np.diag([diametral, diametral, polar])))
    for disk in shaft.disks:
        inertia = np.diag([disk.diametral_kg_m2, disk.diametral_kg_m2, disk.polar_kg_m2])
        center = np.array([0.0, 0.0, disk.position_m])
        parts.append(MassProperties(disk.mass_kg, center, inertia))
    return joined_mass_properties(parts)
