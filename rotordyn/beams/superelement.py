"""Shafts as Timoshenko beams, delivered as superelements like every other body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.beams import elements as beam
from solidwhirl.rotordyn.beams import moments
from solidwhirl.rotordyn.beams.families import (
    Attached,
    BeamNodes,
    ReducedFamily,
    add_attached,
    family_maps,
    family_matrices,
    node_rows,
    reduced_family,
    spatial_fields,
)
from solidwhirl.rotordyn.beams.shafts import Disk, Shaft, ShaftMaterial, checked_shaft
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.record import InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement.residual_energy import BLOCKS, ErrorForm
from solidwhirl.rotordyn.superelement.rigid_body import MassProperties, joined_mass_properties
from solidwhirl.rotordyn.superelement.validation import MOTIONS, Component

__all__ = ["Disk", "beam_superelement"]

_LATERAL: tuple[Component, ...] = ("ux", "uy", "rx", "ry")
# Pieces that every element is cut into for its error, and what they leave out in turn: errors of
# frequencies fall with the square of the length (rods) or faster.
_PIECES = 4
_SAFETY = 1.0 / (1.0 - _PIECES**-2)


def beam_superelement(
    name: str,
    stations_m: npt.ArrayLike,
    outer_radius_m: npt.ArrayLike,
    inner_radius_m: npt.ArrayLike,
    material: ShaftMaterial | tuple[float, float, float],
    interface_stations: Mapping[str, float],
    disks: Sequence[Disk] = (),
    components: Sequence[Component] = _LATERAL,
) -> Superelement:
    """Build the superelement of a stepped shaft with rigid disks.

    Parameters
    ----------
    stations_m
        Section ends along the axis, increasing, shape (N,), m. Each pair bounds one element;
        interfaces and disks between stations split theirs.
    outer_radius_m, inner_radius_m
        Radii of the sections, shape (N − 1,), or one number for all; inner 0 is solid, m.
    material
        Young's modulus (Pa), Poisson's ratio, density (kg/m³).
    interface_stations
        Axial position of each interface by name, m; at least one.
    components
        Motions of the interfaces: ux, uy, rx, ry always, "uz" (axial) and "rz" (torsion) if named.

    Returns
    -------
    Superelement
        Level "beam": ux, uy, rx, ry at each interface, then all fixed-interface modes as modal
        coordinates in pairs (plane of x, plane of y); likewise axial motion and torsion. Nothing
        is truncated, so the element is equivalent to the beam model itself. Its error form "mesh"
        tells what shorter elements change.

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
    if isinstance(material, float | int):
        raise SuperelementError(
            f"beam {name!r}: material is one argument, (modulus Pa, Poisson's ratio, kg/m³)"
        )
    wanted = _wanted(name, components)
    shaft = checked_shaft(
        name,
        np.asarray(stations_m, dtype=float),
        np.asarray(outer_radius_m, dtype=float),
        np.asarray(inner_radius_m, dtype=float),
        ShaftMaterial(*material),
        dict(interface_stations),
        tuple(disks),
    )
    return _of_shaft(name, shaft, wanted)


def _wanted(name: str, components: Sequence[Component]) -> list[beam.Family]:
    """Return the families of motions that the components belong to."""
    if not set(_LATERAL) <= set(components) <= set(MOTIONS):
        raise SuperelementError(
            f"beam {name!r}: components {tuple(components)}; allowed are {_LATERAL} and, beside "
            "them, 'uz' and 'rz'"
        )
    named: dict[Component, beam.Family] = {"uz": "axial", "rz": "torsion"}
    return ["lateral", *(named[c] for c in named if c in components)]


def _of_shaft(name: str, shaft: Shaft, wanted: Sequence[beam.Family]) -> Superelement:
    families, rings = _families(shaft, wanted)
    names = tuple(shaft.interfaces)
    return Superelement(
        name=name,
        **spatial_fields(names, families, shaft.nodes_m.size),
        **_mass_properties(shaft)._asdict(),
        interfaces=tuple(
            InterfaceNode(name=key, position_m=np.array([0.0, 0.0, z]), coupling="none")
            for key, z in shaft.interfaces.items()
        ),
        recovery_points_m=np.outer(shaft.nodes_m, [0.0, 0.0, 1.0]),
        provenance=shaft.provenance(),
        moments=moments.beam_moments(names, families, rings),
        error_forms=(_mesh_form(shaft, names, families),),
    )


def _mesh_form(shaft: Shaft, names: Sequence[str], families: Sequence[ReducedFamily]) -> ErrorForm:
    """Return what shorter elements of the same shaft would take up.

    Between its nodes an element follows the static answer to loads at them, so that what finer ones
    add vanishes at the nodes, strains nothing together with it, and is found element by element:
    the answers, nodes held, to the inertia forces along it.
    """
    maps = family_maps(names, families)
    size = maps[0][0].shape[0]
    gram, slowest = np.zeros((BLOCKS * size, BLOCKS * size)), np.inf
    # residuals of M and G of both planes over the root of the stiffness, elements in rows
    found: list[FloatArray] = []
    for own, planes in zip(families, maps, strict=True):
        for nodes, piece in _elements(shaft):
            inside, (mass, weight) = _between_nodes(piece, own.family)
            root = la.cholesky(inside.stiffness, lower=True)
            slowest = min(slowest, float(la.eigvalsh(inside.stiffness, inside.mass)[0]))
            ends = own.shapes[node_rows(nodes, own.family)]
            m, w = (la.solve_triangular(root, part @ ends, lower=True) for part in (mass, weight))
            if len(planes) == 1:
                found.append(np.hstack([m @ planes[0].T, np.zeros((len(m), size))]))
                continue
            in_x, in_y = planes
            found.append(np.hstack([m @ in_x.T, w @ in_y.T]))
            found.append(np.hstack([m @ in_y.T, -w @ in_x.T]))
    residuals = np.vstack(found)
    gram[size : 3 * size, size : 3 * size] = residuals.T @ residuals
    return ErrorForm(
        part="mesh",
        gram=gram,
        stiffness_change=None,
        safety=_SAFETY,
        cutoff_rad_s=float(np.sqrt(slowest)),
    )


def _between_nodes(
    piece: beam.Segment, family: beam.Family
) -> tuple[beam.ElementMatrices, tuple[FloatArray, FloatArray]]:
    """Matrices of an element cut into pieces with its nodes held, and rows of M and G beside them.

    The rows are forces on the nodes between, by the motion of both ends.
    """
    z = piece.start_m + np.linspace(0.0, piece.length_m, _PIECES + 1)
    stiffness = beam.SectionStiffness(
        *(getattr(piece, k)[0] for k in beam.SectionStiffness._fields)
    )
    inertia = beam.SectionInertia(*(getattr(piece, k)[0] for k in beam.SectionInertia._fields))
    cut = [((k, k + 1), beam.segment((z[k], z[k + 1]), stiffness, inertia)) for k in range(_PIECES)]
    whole = family_matrices(z, cut, family)
    moved, tilted = beam.section_motion(piece, np.linspace(0.0, 1.0, _PIECES + 1), family)
    ends = moved if family != "lateral" else np.stack([moved, tilted], axis=1).reshape(-1, 4)
    inner = node_rows(range(1, _PIECES), family)
    mass, k, weight = (m[np.ix_(inner, inner)] for m in whole[:3])
    forces = whole.mass[inner] @ ends, whole.gyroscopic[inner] @ ends
    return beam.ElementMatrices(mass, k, weight), forces


def _families(
    shaft: Shaft, wanted: Sequence[beam.Family]
) -> tuple[list[ReducedFamily], list[moments.Rings]]:
    """Return the reduced families of motions, and the rings of mass that each moves."""
    z_m, held = shaft.nodes_m, tuple(shaft.node_at(z) for z in shaft.interfaces.values())
    elements = _elements(shaft)
    attached = [
        Attached(
            shaft.node_at(d.position_m), d.position_m, d.mass_kg, d.polar_kg_m2, d.diametral_kg_m2
        )
        for d in shaft.disks
    ]
    families, rings = [], []
    for family in wanted:
        matrices = family_matrices(z_m, elements, family)
        for disk in attached:
            add_attached(matrices, z_m, disk, family)
        own = reduced_family(BeamNodes(z_m, held), matrices, family)
        families.append(own)
        parts = [moments.segment_rings(piece, nodes, own) for nodes, piece in elements]
        rings.append(
            moments.joined_rings([*parts, *(moments.attached_rings(d, z_m, own) for d in attached)])
        )
    return families, rings


def _elements(shaft: Shaft) -> list[tuple[tuple[int, int], beam.Segment]]:
    """Return the two nodes of each element, and its cross-section all along."""
    modulus, nu, density = shaft.material
    shear_modulus = modulus / (2.0 * (1.0 + nu))
    ends = pairwise(shaft.nodes_m.tolist())
    found = []
    radii = zip(shaft.outer_radius_m, shaft.inner_radius_m, strict=True)
    for k, ((start, stop), (outer, inner)) in enumerate(zip(ends, radii, strict=True)):
        area = np.pi * (outer**2 - inner**2)
        second = 0.25 * np.pi * (outer**4 - inner**4)
        kappa = beam.shear_coefficient(nu, inner / outer)
        stiffness = beam.SectionStiffness(
            bending=modulus * second,
            shear=kappa * shear_modulus * area,
            taper=0.0,
            axial=modulus * area,
            torsion=2.0 * shear_modulus * second,
        )
        inertia = beam.SectionInertia(density * area, density * second)
        found.append(((k, k + 1), beam.segment((start, stop), stiffness, inertia)))
    return found


def _mass_properties(shaft: Shaft) -> MassProperties:
    """Return the closed-form mass properties of the cylinders and disks."""
    parts = []
    edges = zip(shaft.nodes_m[:-1], shaft.nodes_m[1:], strict=True)
    radii = zip(shaft.outer_radius_m, shaft.inner_radius_m, strict=True)
    for (start, stop), (outer, inner) in zip(edges, radii, strict=True):
        mass = shaft.material.density_kg_m3 * np.pi * (outer**2 - inner**2) * (stop - start)
        polar = 0.5 * mass * (outer**2 + inner**2)
        diametral = 0.5 * polar + mass * (stop - start) ** 2 / 12.0
        center = np.array([0.0, 0.0, 0.5 * (start + stop)])
        parts.append(MassProperties(mass, center, np.diag([diametral, diametral, polar])))
    for disk in shaft.disks:
        inertia = np.diag([disk.diametral_kg_m2, disk.diametral_kg_m2, disk.polar_kg_m2])
        center = np.array([0.0, 0.0, disk.position_m])
        parts.append(MassProperties(disk.mass_kg, center, inertia))
    return joined_mass_properties(parts)
