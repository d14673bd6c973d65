"""The meridian of a body as a conforming planar subdivision: what a mesher needs to know.

Sections become faces that share whole curves, interfaces become lists of curves, re-entrant
corners are found and filleted. Whatever does not fit together is refused with its place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

from solidwhirl.geometry.materials import Material
from solidwhirl.geometry.meridian import contact
from solidwhirl.geometry.meridian import fillets as rounding
from solidwhirl.geometry.meridian.arrangement import arrange, materials_of
from solidwhirl.geometry.meridian.attachments import interface_curves, split_at_interfaces
from solidwhirl.geometry.meridian.feature_fit import refuse_misfits
from solidwhirl.geometry.meridian.joint_faces import (
    JointFace,
    joint_faces,
    refuse_filleted_ends,
    split_at_seats,
)
from solidwhirl.geometry.meridian.outline import Corner, outline_of, reentrant_corners
from solidwhirl.geometry.meridian.plane_graph import Curve, Face, PlaneGraph, outline_curves
from solidwhirl.geometry.meridian.snapping import Scale, scale_of, snap_body
from solidwhirl.geometry.profile import Body
from solidwhirl.rotordyn.core.arrays import FloatArray

__all__ = ["Corner", "Curve", "Face", "Subdivision", "planned_fillets", "subdivide"]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Subdivision:
    """Hold the conforming planar subdivision of a body's meridian half-plane (z, r)."""

    points: FloatArray  #: (p, 2) Coordinates (z, r) [m], read-only. Centres of arcs are among them.
    curves: tuple[Curve, ...]
    faces: tuple[Face, ...]  #: Pieces of the sections, followed by one face per fillet
    #: What `Face.material` refers to; each material once, in the order of first use
    materials: tuple[Material, ...]
    #: What `Face.section` refers to; the body's sections in their order
    section_names: tuple[str, ...]
    #: Curves with one adjacent face, those on the axis left out; ascending
    boundary: tuple[int, ...]
    axis: tuple[int, ...]  #: Curves with one adjacent face and r = 0 at both ends; ascending
    corners: tuple[Corner, ...]  #: Re-entrant corners of the outline as drawn, by point index
    fillet_arcs: tuple[int, ...]  #: Curve indices of the fillets' arcs, all of them in `boundary`
    #: Curve indices of every interface, ascending; read-only
    interfaces: Mapping[str, tuple[int, ...]]
    joints: tuple[JointFace, ...] = ()  #: Of the body's joints, in their order

    def __post_init__(self) -> None:
        self.points.setflags(write=False)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class _Plan:
    """Hold the checked subdivision without fillets, and the fillets to be added."""

    body: Body
    scale: Scale
    graph: PlaneGraph
    interfaces: Mapping[str, tuple[int, ...]]
    corners: tuple[Corner, ...]
    fillets: tuple[rounding.Fillet, ...]
    joints: tuple[JointFace, ...]


@lru_cache(maxsize=32)
def subdivide(body: Body) -> Subdivision:
    """Return the conforming planar subdivision of a body's meridian.

    Coordinates that differ by less than 1e-9 of the body's size (the larger of its length and its
    outer radius) are made equal, and sections that close to each other are bonded. Sections that
    touch along edges of positive length are bonded; every edge is split at all vertices lying on
    it, at the planes of "section" interfaces and at the bounds of all interfaces.

    With `Body.fillet_radius_m` > 0 every re-entrant corner of the outline gets a face between the
    two straight edges and the arc tangent to both; consecutive curves on one line count as one
    edge. Corners so flat that the tangent length is below 1e-6 of the body's size stay as they
    are (and unfilleted in `Subdivision.corners`).

    Raises GeometryError if sections overlap, touch only in a point, are in pieces or leave a gap or
    edge below 1e-6 of the size; if an interface lies outside or partially outside; if a fillet does
    not fit or covers an interface; if the sections of a joint do not touch; if features do not fit
    (`feature_fit`), which leave no trace in the meridian.
    """
    plan = _plan(body)
    materials = materials_of(plan.body)
    graph, arcs = rounding.add_fillet_faces(
        plan.graph,
        plan.fillets,
        [materials.index(section.material) for section in plan.body.sections],
        plan.scale.tolerance_m,
    )
    contact.refuse_tiny_details(plan.body, graph, plan.scale.detail_m)
    outline = sorted(curve for curve, _ in outline_curves(graph))
    filleted = {fillet.corner for fillet in plan.fillets}
    return Subdivision(
        points=graph.points,
        curves=graph.curves,
        faces=graph.faces,
        materials=materials,
        section_names=tuple(section.name for section in plan.body.sections),
        boundary=tuple(curve for curve in outline if not graph.on_axis(curve)),
        axis=tuple(curve for curve in outline if graph.on_axis(curve)),
        corners=tuple(replace(c, filleted=c.point in filleted) for c in plan.corners),
        fillet_arcs=arcs,
        interfaces=MappingProxyType(dict(plan.interfaces)),
        joints=plan.joints,
    )


def planned_fillets(body: Body) -> tuple[rounding.Fillet, ...]:
    """Return the fillets that `subdivide` adds to a body; raises what it raises."""
    return _plan(body).fillets


def _plan(body: Body) -> _Plan:
    """Build and check everything up to the fillets."""
    scale = scale_of(body)
    tolerance = scale.tolerance_m
    body = snap_body(body, tolerance)
    contact.refuse_overlaps(body, tolerance)
    graph = arrange(body, tolerance)
    contact.refuse_pinches(body, graph)
    contact.refuse_pieces(body, graph)
    graph = split_at_seats(split_at_interfaces(graph, body, tolerance), body, tolerance)
    joints = joint_faces(graph, body, tolerance)
    interfaces = interface_curves(graph, body, tolerance)
    contact.refuse_tiny_details(body, graph, scale.detail_m)
    outline = outline_of(graph)
    corners = reentrant_corners(graph, outline, tolerance)
    fillets = rounding.plan_fillets(graph, outline, corners, body, scale)
    rounding.refuse_swallowed_interfaces(graph, fillets, body.interfaces, interfaces, tolerance)
    refuse_filleted_ends(body, graph, joints, fillets)
    refuse_misfits(body, fillets, scale)
    return _Plan(
        body=body, scale=scale, graph=graph, interfaces=interfaces, corners=corners,
        fillets=fillets, joints=joints,
    )  # fmt: skip
