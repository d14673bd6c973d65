"""The beam level: a Timoshenko model of a body, made from the same profile as its meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.beam_level_error import VARIANTS
from solidwhirl.beam_level_fillets import Lump, fillet_lumps
from solidwhirl.beam_level_moments import Rings, beam_moments, family_rings
from solidwhirl.beam_level_nodes import Layout, layout_of
from solidwhirl.beam_level_planes import (
    DiskRule,
    Family,
    Pieces,
    PlateBlock,
    RootRule,
    family_matrices,
    pieces_of,
    plate_blocks,
)
from solidwhirl.beam_level_profile import BeamLevelError
from solidwhirl.beam_level_reduce import (
    ReducedFamily,
    coordinates_of,
    family_maps,
    reduced_family,
    spatial_matrices,
)
from solidwhirl.beam_level_seats import with_shared_seats
from solidwhirl.beam_level_sections import SPREADS, ShearRule, StiffnessRule
from solidwhirl.geometry import Body, MassProperties, mass_properties
from solidwhirl.rotordyn import InterfaceNode, Superelement, attach_rigid_disk
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component

__all__ = ["BeamLevelError", "beam_element_of", "beam_variants"]

_LATERAL: tuple[Component, ...] = ("ux", "uy", "rx", "ry")
_FREE_MODES_LISTED = 10
#: Fixed-interface modes kept in each plane unless the caller says so.
MODES = 24


def beam_element_of(
    body: Body,
    *,
    components: Sequence[Component] = _LATERAL,
    disks: DiskRule = "plate",
    element_length_m: float | None = None,
    stiffness_rule: StiffnessRule = "spread",
    shear_rule: ShearRule = "weighted",
    root_rule: RootRule = "elastic",
    modes: int | None = MODES,
) -> Superelement:
    """Build the superelement of a body from its profile by beam theory.

    Parameters
    ----------
    body
        Body of revolution with at least one interface.
    components
        Motions of the interfaces: ux, uy, rx, ry always, "uz" and "rz" if named.
    disks
        "plate": disks with a free rim bend with one nodal diameter and move in their plane;
        "rigid": they do not, and sit on the shaft at their middle plane. Webs between a shaft
        and a drum are plates in both.
    element_length_m
        Longest element, m; None is a sixtieth of the axial length. The error of frequencies falls
        with its square.
    stiffness_rule
        How a step or a disk stiffens the shaft: "spread" is the usual rule, "soft" and "stiff"
        bracket it, "none" and "full" are its bounds (see `beam_level_sections.SPREADS`).
    shear_rule
        Shear coefficient: that of Cowper (1966) or Hutchinson (2001), or "weighted", from
        Hutchinson for solid sections to Cowper for thin tubes; "shifted" and "doubled" are
        bounds of that.
    root_rule
        Whether the surface of a shaft gives way where a disk or web is built in.
    modes
        Fixed-interface modes kept in each plane, and of axial motion and torsion; None keeps all.

    Returns
    -------
    Superelement
        Level "beam". Mass properties are those of the body, in closed form, rigid disks included.

    Raises
    ------
    BeamLevelError
        If the body is none of beams and plates, or an interface has no single place on them.
    GeometryError
        If the sections do not fit together.

    Notes
    -----
    Columns are Timoshenko beams on the axis, several at one place where a drum surrounds a shaft.
    Disks and webs are Mindlin plates in circumferential order 1 (0 for axial motion and torsion)
    with a rigid circle where they meet a beam. Rigid interfaces hold the whole cross-section
    between their planes. Centrifugal stiffness: that of plates, under their own load and that of
    the rings that hold them; drums and cones have none.
    """
    rules = _Rules(stiffness_rule, shear_rule, root_rule, disks)
    layout = _layout(body, components, element_length_m)
    model = _model(body, layout, components, rules, modes)
    return _element(body, model, _rings(model))


def beam_variants(
    body: Body,
    *,
    components: Sequence[Component] = _LATERAL,
    disks: DiskRule = "plate",
    element_length_m: float | None = None,
    modes: int | None = MODES,
) -> tuple[Superelement, ...]:
    """Build the models of a body whose spread tells how far beam theory can be trusted.

    Parameters
    ----------
    body, components, disks, element_length_m, modes
        As in `beam_element_of`.

    Returns
    -------
    tuple of Superelement
        In the order of `beam_level_error.VARIANTS`, the first one that of `beam_element_of`; all
        have the same coordinates but for the frequencies of their modes. The others do not know
        their mass moments.

    Raises
    ------
    BeamLevelError, GeometryError
        As `beam_element_of`.
    """
    layout = _layout(body, components, element_length_m)
    found: list[Superelement] = []
    for v in VARIANTS:
        if v.centrifugal_rule == "none":
            zero = np.zeros_like(found[0].mass)
            found.append(replace(found[0], stress_stiffening=zero, spin_softening=zero))
            continue
        rules = _Rules(v.stiffness_rule, v.shear_rule, v.root_rule, disks)
        model = _model(body, layout, components, rules, modes)
        found.append(_element(body, model, () if found else _rings(model)))
    return tuple(found)


class _Rules(NamedTuple):
    stiffness: StiffnessRule
    shear: ShearRule
    roots: RootRule
    disks: DiskRule


def _layout(body: Body, components: Sequence[Component], element_length_m: float | None) -> Layout:
    unknown = set(components) - set(MOTIONS)
    if unknown or not set(_LATERAL) <= set(components):
        raise BeamLevelError(
            f"body '{body.name}': components {tuple(components)}; allowed are {_LATERAL} and, "
            "beside them, 'uz' and 'rz'"
        )
    return layout_of(body, element_length_m)


class _Model(NamedTuple):
    """Nodes, cross-sections and fillets; each family with its plates; how it was made."""

    layout: Layout
    pieces: Pieces
    lumps: tuple[Lump, ...]
    blocks: tuple[tuple[PlateBlock, ...], ...]
    families: tuple[ReducedFamily, ...]
    provenance: dict[str, Any]


def _model(
    body: Body, layout: Layout, components: Sequence[Component], rules: _Rules, modes: int | None
) -> _Model:
    pieces = pieces_of(layout, SPREADS[rules.stiffness], rules.shear)
    lumps = fillet_lumps(body, layout.skeleton)
    wanted: list[Family] = ["lateral"]
    wanted += ["axial"] if "uz" in components else []
    wanted += ["torsion"] if "rz" in components else []
    blocks = tuple(plate_blocks(layout, family, rules.disks, rules.roots) for family in wanted)
    families = tuple(
        reduced_family(layout, family_matrices(layout, pieces, family, own, lumps), family, modes)
        for family, own in zip(wanted, blocks, strict=True)
    )
    provenance = {
        "model": "Timoshenko beams and annular Mindlin plates from the profile",
        "disks": rules.disks,
        "stiffness_rule": rules.stiffness,
        "shear_rule": rules.shear,
        "root_rule": rules.roots,
        "elements": len(layout.elements),
        "longest_element_m": max(e.ends_m[1] - e.ends_m[0] for e in layout.elements),
        "plates": len(layout.plate_nodes),
        "modes": modes,
    }
    return _Model(layout, pieces, lumps, blocks, families, provenance)


def _rings(model: _Model) -> tuple[Rings, ...]:
    """How each family moves the mass of a model."""
    return tuple(
        family_rings(model.layout, model.pieces, family, blocks, model.lumps)
        for family, blocks in zip(model.families, model.blocks, strict=True)
    )


def _element(body: Body, model: _Model, rings: tuple[Rings, ...]) -> Superelement:
    """The superelement with its rigid disks; without rings it does not know its mass moments."""
    element = _superelement(body, model, rings)
    for disk in body.rigid_disks:
        element = attach_rigid_disk(
            element,
            disk.interface,
            disk.name,
            disk.mass_kg,
            disk.polar_inertia_kg_m2,
            disk.diametral_inertia_kg_m2,
            disk.offset_m,
        )
    return element


def _superelement(body: Body, model: _Model, rings: tuple[Rings, ...]) -> Superelement:
    layout, families = model.layout, model.families
    first = [body.interfaces[layout.interfaces.index(node)] for node in layout.seats]
    names = tuple(interface.name for interface in first)
    coordinates = coordinates_of(names, families)
    maps = family_maps(names, coordinates, families)
    space = spatial_matrices(families, maps)
    properties: MassProperties = mass_properties(replace(body, rigid_disks=()))
    polar, diametral = properties.polar_inertia_kg_m2, properties.diametral_inertia_kg_m2
    has = {c.component for c in coordinates}
    axis = _axis_nodes(layout)
    free = np.sort(np.concatenate([np.repeat(f.free_hz, _pairs(f)) for f in families]))
    held = [np.repeat(f.frequencies_hz, _pairs(f)) for f in families]
    element = Superelement(
        name=body.name,
        level="beam",
        harmonics=(),
        coordinates=coordinates,
        interfaces=tuple(
            InterfaceNode(name=i.name, position_m=np.array(i.position_m), coupling="none")
            for i in first
        ),
        mass=space.mass,
        stiffness=space.stiffness,
        gyroscopic=space.gyroscopic,
        stress_stiffening=space.stiffening,
        spin_softening=space.softening,
        rigid_body_modes=space.rigid,
        rigid_body_present=np.array([motion in has for motion in MOTIONS]),
        mass_kg=properties.mass_kg,
        center_of_gravity_m=properties.center_of_gravity_m,
        inertia_kg_m2=np.diag([diametral, diametral, polar]),
        full_dofs=sum(_pairs(f) * f.basis.shape[0] for f in families),
        maximum_speed_rad_s=np.inf,
        recovery_points_m=np.outer(layout.nodes_m[axis], [0.0, 0.0, 1.0]),
        recovery_modes=space.nodes[axis],
        free_frequencies_hz=free[:_FREE_MODES_LISTED],
        fixed_interface_frequencies_hz=np.concatenate(held),
        frequency_error_estimate=np.empty(0),
        provenance=model.provenance,
        spin_generator=space.generator,
        moments=beam_moments(families, maps, rings) if rings else None,
    )
    if len(first) == len(body.interfaces):
        return element
    owner = {
        interface.name: first[layout.seats.index(node)].name
        for interface, node in zip(body.interfaces, layout.interfaces, strict=True)
    }
    return with_shared_seats(element, body, owner)


def _pairs(family: ReducedFamily) -> int:
    return 2 if family.family == "lateral" else 1


def _axis_nodes(layout: Layout) -> list[int]:
    """Return the nodes of the columns nearest to the axis, one at each place, in their order."""
    columns = layout.skeleton.columns
    nearest = {
        start: min(
            (k for k, c in enumerate(columns) if c.start_m == start),
            key=lambda k: columns[k].inner_m(columns[k].start_m),
        )
        for start in {c.start_m for c in columns}
    }
    found: dict[float, int] = {}
    for element in layout.elements:
        if element.column in nearest.values():
            for z, node in zip(element.ends_m, element.nodes, strict=True):
                found.setdefault(z, node)
    ordered: list[tuple[float, int]] = sorted(found.items())
    smallest = 1e-9 * (ordered[-1][0] - ordered[0][0])
    kept = [ordered[0][1]]
    kept += [node for (low, _), (z, node) in pairwise(ordered) if z - low > smallest]
    return kept
