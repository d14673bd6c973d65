"""Section: the meshes of the bodies, meridians in the plane and solids in space."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.bodies.reduction import BodyResult
from solidwhirl.meshing import Mesh
from solidwhirl.page.frame.records import Block, Chart, Choice, Option, Run, Section, Table

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Trace = dict[str, Any]
# Edges that are drawn of one body; of finer meshes its outline alone.
_MOST_EDGES = 30_000
_COLORS = 8
# Largest length and height of the box of a solid body in the view.
_LONG, _HIGH = 3.0, 1.4


def section(run: Run) -> Section | None:
    """Meshes of a run; None where no body has one.

    Parameters
    ----------
    run
        The run.
    """
    results = run.results.bodies
    if not results:
        return None
    plane = {name: r for name, r in results.items() if r.mesh.dimension == 2}
    solid = {name: r for name, r in results.items() if r.mesh.dimension == 3}
    blocks: list[Block] = []
    if plane:
        blocks.append(_plane_chart(plane))
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
        kind = "meridian, triangles" if result.mesh.dimension == 2 else "solid, tetrahedra"
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


def _plane_chart(results: Mapping[str, BodyResult]) -> Chart:
    traces: list[Trace] = []
    options = []
    thinned = []
    for k, (name, result) in enumerate(results.items()):
        own = list(_meridian_traces(name, result.mesh, f"@c{k % _COLORS}"))
        if len(edges_of(result.mesh.cells[:, :3])) > _MOST_EDGES:
            thinned.append(name)
        options.append(Option(label=name, traces=range(len(traces), len(traces) + len(own))))
        traces += own
    said = ", ".join(f"{n} {len(r.mesh.cells)}" for n, r in results.items())
    more = f" Of {', '.join(thinned)} the outline alone is drawn." if thinned else ""
    return Chart(
        name="mesh-meridian",
        title="Meridian meshes",
        caption="Half of the section through the axis, alike scaled in both directions; the "
        "circumference is solved by Fourier series. Thick lines are interfaces. Drag over a part "
        f"to magnify it, click twice to go back.{more}",
        alt=f"Triangles of the meridians; elements by body: {said}.",
        traces=traces,
        layout={
            "xaxis": {"title": {"text": "z [mm]"}, "showgrid": False, "constrain": "domain"},
            "yaxis": {
                "title": {"text": "r [mm]"},
                "showgrid": False,
                "scaleanchor": "x",
                "scaleratio": 1,
                "constrain": "domain",
            },
            "hovermode": "closest",
        },
        height_px=460,
        controls=(Choice(label="body", options=options),) if len(options) > 1 else (),
    )


def _meridian_traces(name: str, mesh: Mesh, color: str) -> Iterator[Trace]:
    """Edges of the elements, the outline, and the interfaces of one body."""
    points = 1e3 * mesh.points
    edges = edges_of(mesh.cells[:, :3])
    if len(edges) <= _MOST_EDGES:
        yield _lines(points, edges, f"{name}: elements", f"{color}/0.8", 0.8)
    yield _lines(points, boundary_of(mesh.cells[:, :3]), f"{name}: outline", "@ink", 1.4)
    for k, (interface, facets) in enumerate(mesh.interfaces.items()):
        yield {
            **_lines(points, facets[:, :2], "interfaces", "@backward", 4),
            "hovertemplate": f"{name}.{interface}<br>"
            "z %{x:.4g} mm, r %{y:.4g} mm<extra></extra>",
            "hoverinfo": "all",
            "legendgroup": "interfaces",
            "showlegend": k == 0,
        }


def _lines(points: FloatArray, edges: IntArray, name: str, color: str, width: float) -> Trace:
    """Many separate edges as one trace."""
    ends = points[edges]
    gap = np.full((len(edges), 1), np.nan)
    return {
        "type": "scatter",
        "mode": "lines",
        "x": np.hstack([ends[:, :, 0], gap]).ravel(),
        "y": np.hstack([ends[:, :, 1], gap]).ravel(),
        "name": name,
        "line": {"color": color, "width": width},
        "hoverinfo": "skip",
    }


def edges_of(triangles: IntArray) -> IntArray:
    """Return every edge of triangles once, shape (e, 2).

    Parameters
    ----------
    triangles
        Corners, shape (c, 3).
    """
    return np.unique(_all_edges(triangles), axis=0)


def boundary_of(triangles: IntArray) -> IntArray:
    """Return the edges that one triangle alone has, shape (e, 2).

    Parameters
    ----------
    triangles
        Corners, shape (c, 3).
    """
    edges, counts = np.unique(_all_edges(triangles), axis=0, return_counts=True)
    alone: IntArray = edges[counts == 1]
    return alone


def _all_edges(triangles: IntArray) -> IntArray:
    return np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)


def _aspect(traces: Sequence[Trace]) -> dict[str, float]:
    """Sides of the box around what is drawn, as large as the view; the axis lies along x."""
    sides = {key: _extent(np.concatenate([t[key] for t in traces])) for key in "xyz"}
    scale = min(_LONG / sides["x"], _HIGH / max(sides["y"], sides["z"]))
    return {key: scale * side for key, side in sides.items()}


def _extent(values: FloatArray) -> float:
    return float(np.nanmax(values) - np.nanmin(values))


def _solid_chart(results: Mapping[str, BodyResult]) -> Chart:
    traces: list[Trace] = []
    options = []
    for k, (name, result) in enumerate(results.items()):
        own = list(_solid_traces(name, result.mesh, f"@c{k % _COLORS}"))
        shown = range(len(traces), len(traces) + len(own))
        options.append(Option(label=name, traces=shown, layout={"scene.aspectratio": _aspect(own)}))
        traces += own
    axis = {"tickformat": ".4~r"}
    said = ", ".join(f"{n} {len(r.mesh.cells)}" for n, r in results.items())
    return Chart(
        name="mesh-solid",
        title="Solid meshes",
        caption="Surface of the tetrahedra, alike scaled in all directions; the axis is z. Drag "
        "to turn, roll to come nearer. Thin lines are edges of elements.",
        alt=f"Surfaces of the solid meshes; elements by body: {said}.",
        traces=traces,
        layout={
            "scene": {
                # by hand: to scale as "data" is, but a slender body stays in view
                "aspectmode": "manual",
                "aspectratio": options[0].layout["scene.aspectratio"],
                "xaxis": {"title": {"text": "z [mm]"}, **axis},
                "yaxis": {"title": {"text": "x [mm]"}, **axis},
                "zaxis": {"title": {"text": "y [mm]"}, **axis},
                "camera": {
                    "eye": {"x": 0.6, "y": -1.45, "z": 0.6},
                    "projection": {"type": "orthographic"},
                },
            },
            "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
            "showlegend": False,
        },
        height_px=500,
        controls=(Choice(label="body", options=options),) if len(options) > 1 else (),
    )


def _solid_traces(name: str, mesh: Mesh, color: str) -> Iterator[Trace]:
    """Surface and edges of one body."""
    faces = _skin(mesh.cells[:, :4])
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    x, y, z = (1e3 * mesh.points[used]).T
    yield {
        "type": "mesh3d",
        "x": z,
        "y": x,
        "z": y,
        "i": faces[:, 0],
        "j": faces[:, 1],
        "k": faces[:, 2],
        "color": color,
        "flatshading": True,
        "lighting": {"ambient": 0.75, "diffuse": 0.6, "specular": 0.05},
        "name": name,
        "hovertemplate": name + "<br>z %{x:.4g}, x %{y:.4g}, y %{z:.4g} mm<extra></extra>",
    }
    edges = edges_of(faces)
    if len(edges) > _MOST_EDGES:
        return
    ends = np.column_stack([z, x, y])[edges]
    gap = np.full((len(edges), 1), np.nan)
    lines = [np.hstack([ends[:, :, k], gap]).ravel() for k in range(3)]
    yield {
        "type": "scatter3d",
        "mode": "lines",
        "x": lines[0],
        "y": lines[1],
        "z": lines[2],
        "line": {"color": "@paper", "width": 1.5},
        "hoverinfo": "skip",
        "name": f"{name}: edges",
    }


def _skin(tetrahedra: IntArray) -> IntArray:
    """Faces that one tetrahedron alone has, shape (f, 3)."""
    faces = tetrahedra[:, [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]].reshape(-1, 3)
    _, first, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    alone: IntArray = faces[first[counts == 1]]
    return alone
