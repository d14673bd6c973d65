"""Where the interfaces of a body are, how large, and what was asked for, as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.core.warnings import Doubt
from solidwhirl.geometry import Body, Interface
from solidwhirl.meshing import FloatArray, Mesh
from solidwhirl.meshing.imported.records import MeshedBody, MeshInterface
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.rotordyn import Superelement

# Area that a box cuts off, over all that lies in it, from which on it is told.
_WORTH_SAYING = 1e-3


def interfaces_document(
    element: Superelement, body: Body | MeshedBody | None = None, mesh: Mesh | None = None
) -> list[dict[str, Any]]:
    """The interfaces of a body: node, centre of area, area and what was asked for.

    Bodies without geometry and mesh have no area.
    """
    asked: dict[str, Interface | MeshInterface] = {}
    if body is not None:
        asked = {i.name: i for i in body.interfaces}
    out = []
    for node in element.interfaces:
        found: dict[str, Any] = {"name": node.name, "position_m": node.position_m.tolist()}
        if mesh is not None and node.name in mesh.interfaces:
            area, centre = _area_and_centre(mesh, node.name)
            found |= {"mean_position_m": centre.tolist(), "area_m2": area}
        if own := asked.get(node.name):
            found["asked"] = _asked_text(own)
            if isinstance(own, MeshInterface) and own.cut_facets:
                found |= {"cut_facets": own.cut_facets, "cut_area_m2": own.cut_area_m2}
        out.append(found)
    return out


def mesh_doubts(scene: Scene) -> Iterator[Doubt]:
    """Doubts about what of meshes is left out: parts of files, facets that boxes cut."""
    for name, body in build_mesh_bodies(scene).items():
        for remark in body.remarks:
            yield Doubt(
                key=f"mesh_bodies.{name}.file",
                found=remark,
                usual="what this program knows",
                mistake="Does it hold, join or weigh anything of the body?",
            )
        for k, interface in enumerate(body.interfaces):
            inside = interface.area_m2 + interface.cut_area_m2
            if interface.cut_area_m2 <= _WORTH_SAYING * inside:
                continue
            low, high = (f"{corner[2]:.4g}" for corner in interface.box_m or ())
            yield Doubt(
                key=f"mesh_bodies.{name}.interfaces[{k}].box_m",
                found=f"the box cuts {interface.cut_facets} facets of the mesh; they are left out, "
                f"{100.0 * interface.cut_area_m2 / inside:.0f} % of the surface inside the box",
                usual="a box that ends between facets",
                mistake=f"The surface of {interface.name!r} has its centre at z = "
                f"{interface.mean_m[2]:.4g} m, the box goes from {low} to {high} m; is the mesh "
                "fine enough there, or is a group of the file meant?",
            )


def _area_and_centre(mesh: Mesh, name: str) -> tuple[float, FloatArray]:
    """Area [m²] and centre of area [m] of the facets, which are curves of a meridian in 2D."""
    if mesh.points.shape[1] == 3:
        from solidwhirl.meshing.imported.measures import area_and_centre

        return area_and_centre(mesh, name)
    facets = mesh.interfaces[name]
    ends, middle = mesh.points[facets[:, :2]], mesh.points[facets[:, 2]]
    # Simpson's rule along curves of second order, whose third node is in the middle
    bend = ends.sum(axis=1) - 2.0 * middle
    along = 0.5 * (ends[:, 1] - ends[:, 0])
    slopes = np.stack([along - bend, along, along + bend], axis=1)
    places = np.stack([ends[:, 0], middle, ends[:, 1]], axis=1)
    ring = np.linalg.norm(slopes, axis=2) * 2.0 * np.pi * places[:, :, 1] * [1 / 3, 4 / 3, 1 / 3]
    return float(ring.sum()), np.array([0.0, 0.0, (ring * places[:, :, 0]).sum() / ring.sum()])


def _asked_text(interface: Interface | MeshInterface) -> str:
    if isinstance(interface, MeshInterface):
        if interface.box_m is None:
            return f"group {interface.group}"
        low, high = ([f"{value:.6g}" for value in corner] for corner in interface.box_m)
        return f"box from ({', '.join(low)}) to ({', '.join(high)}) m"
    at = f"z = {interface.start_m:.6g} m"
    if interface.end_m != interface.start_m:
        at = f"z = {interface.start_m:.6g} to {interface.end_m:.6g} m"
    radius = (
        ""
        if interface.radius_m is None
        else " radius {:.6g} to {:.6g} m".format(*interface.radius_m)
    )
    return f"{interface.kind} {at}{radius}"
