"""The beam level: a Timoshenko model of a body, made from the same profile as its meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.beams.assembly import Pieces, PlateBlock, assembled_family, pieces_of, plate_blocks
from solidwhirl.beams.error import VARIANTS, Variant
from solidwhirl.beams.moments import family_rings
from solidwhirl.beams.nodes import Layout, decay_length_m, layout_of
from solidwhirl.beams.profile import BeamLevelError
from solidwhirl.beams.sections import SPREADS
from solidwhirl.geometry import Body, Interface, mass_properties
from solidwhirl.rotordyn import InterfaceNode, Superelement, attach_rigid_disk
from solidwhirl.rotordyn.beams.elements import Family
from solidwhirl.rotordyn.beams.families import ReducedFamily, reduced_family, spatial_fields
from solidwhirl.rotordyn.beams.moments import Rings, beam_moments
from solidwhirl.rotordyn.superelement.mass_moments import projected_moments
from solidwhirl.rotordyn.superelement.validation import MOTIONS, Component

_LATERAL: tuple[Component, ...] = ("ux", "uy", "rx", "ry")
_MATRICES = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
#: Fixed-interface modes kept in each plane unless the caller says so.
MODES = 24
# What is left of a short rigid piece, of its length.
_LEFT = 0.05


def beam_element_of(
    body: Body,
    *,
    components: Sequence[Component] = _LATERAL,
    element_length_m: float | None = None,
    modes: int | None = MODES,
) -> Superelement:
    """Build the superelement of a body from its profile by beam theory.

    Columns are Timoshenko beams on the axis, several at one place where a drum surrounds a shaft.
    Disks and webs are Mindlin plates in circumferential order 1 (0 for axial motion and torsion)
    with a rigid circle where they meet a solid beam; thin walls stretch there. Rigid interfaces
    hold the whole cross-section between their planes, distributing ones follow the beam along
    their surface. Centrifugal stiffness: that of plates, under their own load and that of the
    rings that hold them; drums and cones have none.

    Parameters
    ----------
    body
        Body of revolution with at least one interface.
    components
        Motions of the interfaces: ux, uy, rx, ry always, "uz" and "rz" if named.
    element_length_m
        Longest element, m; None is a sixtieth of the axial length. The error of frequencies falls
        with its square.
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
    """
    layout = _layout(body, components, element_length_m)
    model = _model(body, layout, components, VARIANTS[0], modes)
    return _element(body, model, _rings(model))


def beam_variants(
    body: Body, *, components: Sequence[Component] = _LATERAL, modes: int | None = MODES
) -> Iterator[Superelement]:
    """Build the models of a body whose spread tells how far beam theory can be trusted.

    In the order of `error.VARIANTS`, the first one that of `beam_element_of`, each made when it is
    asked for; all have the same coordinates but for the frequencies of their modes. The others do
    not know their mass moments. Raises BeamLevelError, GeometryError as `beam_element_of`.
    """
    layout = _layout(body, components, None)
    model = _model(body, layout, components, VARIANTS[0], modes)
    nominal = _element(body, model, _rings(model))
    yield nominal
    for variant in VARIANTS[1:]:
        if variant.centrifugal_rule == "none":
            zero = np.zeros_like(nominal.mass)
            yield replace(nominal, stress_stiffening=zero, spin_softening=zero)
        else:
            own = _blurred(body, layout) if variant.seat_rule == "blurred" else layout
            yield _element(body, _model(body, own, components, variant, modes), ())


def _blurred(body: Body, layout: Layout) -> Layout:
    """The layout with the ends of all seats elsewhere, by what a beam knows of their place.

    Distributing ones, and rigid planes, reach further; rigid pieces are shorter.
    """
    seats = []
    for interface, node in zip(body.interfaces, layout.interfaces, strict=True):
        owners = [e.column for e in layout.elements if node in e.nodes]
        if interface.coupling != "rigid" or not owners:
            seats.append(interface)
            continue
        column = layout.skeleton.columns[owners[0]]
        middle, length = interface.position_m[2], interface.end_m - interface.start_m
        left = max(length - 2.0 * decay_length_m(column, middle), _LEFT * length)
        start, end = middle - 0.5 * left, middle + 0.5 * left
        if left > 0.0:
            seats.append(replace(interface, start_m=start, end_m=end))
        else:
            seats.append(replace(interface, coupling="distributing"))
    return layout_of(replace(body, interfaces=tuple(seats)), None, blurred=True)


def _layout(body: Body, components: Sequence[Component], element_length_m: float | None) -> Layout:
    unknown = set(components) - set(MOTIONS)
    if unknown or not set(_LATERAL) <= set(components):
        raise BeamLevelError(
            f"body '{body.name}': components {tuple(components)}; allowed are {_LATERAL} and, "
            "beside them, 'uz' and 'rz'"
        )
    return layout_of(body, element_length_m)


class _Model(NamedTuple):
    """Nodes and cross-sections; each family with its plates; how it was made."""

    layout: Layout
    pieces: Pieces
    blocks: tuple[tuple[PlateBlock, ...], ...]
    families: tuple[ReducedFamily, ...]
    provenance: dict[str, Any]


def _model(
    body: Body, layout: Layout, components: Sequence[Component], rules: Variant, modes: int | None
) -> _Model:
    pieces = pieces_of(body, layout, SPREADS[rules.stiffness_rule], rules.shear_rule)
    wanted: list[Family] = ["lateral"]
    wanted += ["axial"] if "uz" in components else []
    wanted += ["torsion"] if "rz" in components else []
    blocks = tuple(plate_blocks(layout, family, rules.root_rule) for family in wanted)
    families = tuple(
        reduced_family(
            layout.beam_nodes, assembled_family(layout, pieces, family, own), family, modes
        )
        for family, own in zip(wanted, blocks, strict=True)
    )
    provenance = {
        "model": "Timoshenko beams and annular Mindlin plates from the profile",
        "disks": "plate",
        "stiffness_rule": rules.stiffness_rule,
        "shear_rule": rules.shear_rule,
        "root_rule": rules.root_rule,
        "elements": len(layout.elements),
        "longest_element_m": max(e.ends_m[1] - e.ends_m[0] for e in layout.elements),
        "plates": len(layout.plate_nodes),
        "modes": modes,
    }
    return _Model(layout, pieces, blocks, families, provenance)


def _rings(model: _Model) -> tuple[Rings, ...]:
    """How each family moves the mass of a model."""
    return tuple(
        family_rings(model.layout, model.pieces, family, blocks)
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
    seats = layout.beam_nodes.interfaces
    first = [body.interfaces[layout.interfaces.index(node)] for node in seats]
    names = tuple(interface.name for interface in first)
    properties = mass_properties(replace(body, rigid_disks=()))
    polar, diametral = properties.polar_inertia_kg_m2, properties.diametral_inertia_kg_m2
    axis = _axis_nodes(layout)
    fields = spatial_fields(names, families, layout.nodes_m.size)
    element = Superelement(
        name=body.name,
        **fields | {"recovery_modes": fields["recovery_modes"][axis]},
        interfaces=_nodes(first),
        mass_kg=properties.mass_kg,
        center_of_gravity_m=properties.center_of_gravity_m,
        inertia_kg_m2=np.diag([diametral, diametral, polar]),
        recovery_points_m=np.outer(layout.nodes_m[axis], [0.0, 0.0, 1.0]),
        provenance=model.provenance,
        moments=beam_moments(names, families, rings) if rings else None,
    )
    if len(first) == len(body.interfaces):
        return element
    owner = {
        interface.name: first[seats.index(node)].name
        for interface, node in zip(body.interfaces, layout.interfaces, strict=True)
    }
    return _with_shared_seats(element, body, owner)


def _nodes(interfaces: Sequence[Interface]) -> tuple[InterfaceNode, ...]:
    return tuple(
        InterfaceNode(name=i.name, position_m=np.array(i.position_m), coupling="none")
        for i in interfaces
    )


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


def _with_shared_seats(element: Superelement, body: Body, owner: Mapping[str, str]) -> Superelement:
    """Return a superelement with coordinates for all interfaces of a body.

    `owner` has, by the name of each interface of the body, the interface whose node it has;
    interfaces of one node move as one, which is the `constraint`.
    """
    modal = [c for c in element.coordinates if c.kind == "modal"]
    held = [
        (replace(c, interface=i.name), element.interface_index(owner[i.name], c.component))
        for i in body.interfaces
        for c in element.coordinates
        if c.interface == owner[i.name]
    ]
    source = [k for _, k in held] + list(range(element.size - len(modal), element.size))
    tie = np.eye(element.size)[source]
    spread = np.linalg.pinv(tie)
    generator = element.spin_generator
    return replace(
        element,
        coordinates=(*(c for c, _ in held), *modal),
        interfaces=_nodes(body.interfaces),
        **{name: spread.T @ getattr(element, name) @ spread for name in _MATRICES},
        rigid_body_modes=tie @ element.rigid_body_modes,
        recovery_modes=element.recovery_modes @ spread,
        spin_generator=None if generator is None else tie @ generator @ spread,
        constraint=tie,
        moments=projected_moments(element.moments, spread),
    )
