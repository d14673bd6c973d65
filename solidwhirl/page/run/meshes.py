"""Section: the meshes of the bodies, meridians in the plane and solids in space."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.bodies.reduction import BodyResult
from solidwhirl.drawing.surfaces import outer_faces
from solidwhirl.meshing import Mesh
from solidwhirl.page.frame import records
from solidwhirl.page.frame.in_space import BodyInSpace, chart_in_space, surface_trace
from solidwhirl.page.frame.plotly_chart import Trace, page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.plots.chart import Axis, Chart, Choice, Curve, Look, Option, series_look

# Edges that are drawn of one body; of finer meshes its outline alone.
_MOST_EDGES = 30_000
_COLORS = 8


def section(run: Run) -> Section | None:
    """Meshes of a run; None where no body has one."""
    results = run.results.bodies
    if not results:
        return None
    plane = {name: r for name, r in results.items() if r.mesh.dimension == 2}
    solid = {name: r for name, r in results.items() if r.mesh.dimension == 3}
    blocks: list[Block] = []
    if plane:
        meshes = {name: r.mesh for name, r in plane.items()}
        blocks.append(page_chart(plane_chart(meshes, _MOST_EDGES)))
    if solid:
        blocks.append(_solid_chart(solid))
    blocks.append(_table(run.document["bodies"], results))
    return Section(
        name="meshes",
        title="Meshes",
        blocks=blocks,
        note="The files are in `meshes/`, as VTU for ParaView and as MSH for gmsh.",
    )


def _table(bodies: Mapping[str, Any], results: Mapping[str, BodyResult]) -> Table:
    rows = []
    for name, result in results.items():
        mesh, size = bodies[name]["mesh"], result.mesh.size
        kind = _kind(result.mesh)
        rows.append(
            (
                name,
                kind,
                mesh["cells"],
                mesh["points"],
                bodies[name]["element_order"],
                f"{1e3 * size.corner_size_m:.3g}",
                f"{1e3 * size.size_m:.3g}",
                f"{mesh['minimum_scaled_jacobian']:.3f}",
                mesh["straightened_elements"],
            )
        )
    return Table(
        head=("body", "mesh", "elements", "points", "order", "size at corners [mm]",
              "largest size [mm]", "least scaled Jacobian", "straightened"),
        rows=rows,
        caption="The scaled Jacobian is 1 for an ideal element and 0 for one that is folded; its "
        "least value is a bound over whole elements, not a sample. Straightened: elements whose "
        "curved edges were made straight, as they were nearly folded.",
    )  # fmt: skip


def _kind(mesh: Mesh) -> str:
    if mesh.dimension == 2:
        return "meridian, triangles"
    if mesh.sector is None:
        return "solid, tetrahedra"
    part = "half of one" if mesh.sector.mirrored else "one"
    return f"solid, tetrahedra: {part} of {mesh.sector.count} equal sectors"


def plane_chart(meshes: Mapping[str, Mesh], most_edges: int) -> Chart:
    """Return meridian meshes, of several bodies one at a time; of finer ones the outline alone."""
    options = [
        Option(label=name, marks=_meridian_curves(name, mesh, most_edges))
        for name, mesh in meshes.items()
    ]
    thinned = [name for name, mesh in meshes.items() if _edge_count(mesh) > most_edges]
    said = ", ".join(f"{name} {len(mesh.cells)}" for name, mesh in meshes.items())
    more = f" Of {', '.join(thinned)} the outline alone is drawn." if thinned else ""
    several = len(options) > 1
    return Chart(
        name="mesh-meridian",
        title="Meridian meshes",
        caption="Half of the section through the axis, to scale; the "
        "circumference is solved by Fourier series. Thick lines are interfaces. Drag over a part "
        f"to magnify it, click twice to go back.{more}",
        alt=f"Triangles of the meridians; elements by body: {said}.",
        x=Axis(label="z", unit="mm", digits=".4g"),
        y=Axis(label="r", unit="mm", digits=".4g"),
        parts=[Choice(label="body", options=options)] if several else options[0].marks,
        is_to_scale=True,
        height_px=460,
    )


def _edge_count(mesh: Mesh) -> int:
    return len(edges_of(mesh.cells[:, :3]))


def _meridian_curves(name: str, mesh: Mesh, most_edges: int) -> list[Curve]:
    """Edges of the elements by material, the outline, and the interfaces of one body."""
    points = 1e3 * mesh.points
    found = []
    for k, material in enumerate(mesh.materials if _edge_count(mesh) <= most_edges else ()):
        own = mesh.cells[mesh.cell_material == k, :3]
        look = replace(series_look(k), mark="", width=0.8)
        words = f"{material.name}, {len(own)} elements"
        found.append(_lines(points, edges_of(own), words, replace(look, color=f"{look.color}/0.8")))
    outline = boundary_of(mesh.cells[:, :3])
    found.append(_lines(points, outline, "outline", Look("@ink", width=1.4)))
    thick = Look("@backward", width=4.0)
    for interface, facets in mesh.interfaces.items():
        curve = _lines(points, facets[:, :2], "interfaces", thick)
        found.append(replace(curve, texts=[f"{name}.{interface}"] * curve.x.size))
    return found


def _lines(points: FloatArray, edges: IntArray, name: str, look: Look) -> Curve:
    """Many separate edges as one curve."""
    return Curve(x=_apart(points[:, 0], edges), y=_apart(points[:, 1], edges), name=name, look=look)


def _apart(values: FloatArray, edges: IntArray) -> FloatArray:
    """Values at the ends of edges with a gap after each edge."""
    return np.hstack([values[edges], np.full((len(edges), 1), np.nan)]).ravel()


def edges_of(triangles: IntArray) -> IntArray:
    """Return every edge of triangles (c, 3) once, shape (e, 2)."""
    return np.unique(_all_edges(triangles), axis=0)


def boundary_of(triangles: IntArray) -> IntArray:
    """Return the edges that one triangle of (c, 3) alone has, shape (e, 2)."""
    edges, counts = np.unique(_all_edges(triangles), axis=0, return_counts=True)
    return np.asarray(edges[counts == 1])


def _all_edges(triangles: IntArray) -> IntArray:
    return np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)


def _solid_chart(results: Mapping[str, BodyResult]) -> records.Chart:
    bodies = [
        BodyInSpace(name, [*_solid_traces(name, result.shown_mesh, f"@c{k % _COLORS}")])
        for k, (name, result) in enumerate(results.items())
    ]
    said = ", ".join(f"{n} {len(r.shown_mesh.cells)}" for n, r in results.items())
    return chart_in_space(
        "mesh-solid",
        "body",
        bodies,
        title="Solid meshes",
        caption="Surface of the tetrahedra, to scale; the axis is z. Drag "
        "to turn, roll to come nearer. Thin lines are edges of elements.",
        alt=f"Surfaces of the solid meshes; elements by body: {said}.",
    )


def _solid_traces(name: str, mesh: Mesh, color: str) -> Iterator[Trace]:
    """Surface and edges of one body."""
    faces = outer_faces(mesh.cells[:, :4])
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    lighting = {"ambient": 0.75, "diffuse": 0.6, "specular": 0.05}
    surface = surface_trace(mesh.points[used], faces, name, {"color": color, "lighting": lighting})
    yield surface
    edges = edges_of(faces)
    if len(edges) > _MOST_EDGES:
        return
    yield {
        "type": "scatter3d",
        "mode": "lines",
        **{along: _apart(surface[along], edges) for along in "xyz"},
        "line": {"color": "@paper", "width": 1.5},
        "hoverinfo": "skip",
        "name": f"{name}: edges",
    }
