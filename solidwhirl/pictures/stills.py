"""Views of the engine in space: modes with their orbits, meshes of solids."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from solidwhirl.drawing.surfaces import outer_faces
from solidwhirl.meshing import Mesh
from solidwhirl.pictures.engine_shape import BodyInSpace, EngineShape, displaced
from solidwhirl.rotordyn.plots import frame

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Image = NDArray[np.uint8]
# Pixels of a still, and from where it is seen: the axis to the right, y up, a little from above.
_PIXELS = (2000, 1100)
_EYE = (-1.0, 0.55, -0.42)
_ZOOM = 1.3
#: Of values, from the least to the largest.
COLORS = "cividis"
# Points nearer than this part of the size of a body are one.
_SAME = 1e-7


@contextmanager
def scene_in_space(
    pixels: tuple[int, int], smoothing: Literal["ssaa", "msaa"] = "ssaa"
) -> Iterator[Any]:
    """Give a plotter without a window, so many pixels wide and high; it is closed at the end."""
    import pyvista

    # VTK says on the standard error that there is no screen; none is needed
    with pyvista.vtk_verbosity("off"):
        plotter = pyvista.Plotter(off_screen=True, window_size=list(pixels), lighting="light kit")
        plotter.set_background("white")
        plotter.enable_anti_aliasing(smoothing)
        try:
            yield plotter
        finally:
            plotter.close()


def look_at(plotter: Any, zoom: float = 1.35) -> None:
    """Look at everything with the axis z to the right and y up; a larger zoom shows less."""
    plotter.view_vector(_EYE, viewup=(0.0, 1.0, 0.0))
    plotter.enable_parallel_projection()
    plotter.camera.zoom(zoom)


def thickness(plotter: Any) -> float:
    """Return the width of lines over that in a still."""
    return float(plotter.window_size[0]) / _PIXELS[0]


def polydata(body: BodyInSpace, phase_rad: float, largest_m: float) -> Any:
    """Return the displaced surface of a body with its displacement, largest 1, at the points."""
    import pyvista

    points, moved = displaced(body, phase_rad)
    faces = [_with_count(cells) for cells in (body.quadrangles, body.triangles) if len(cells)]
    lines = _with_count(body.lines) if len(body.lines) else None
    found = pyvista.PolyData(points, faces=np.concatenate(faces) if faces else None, lines=lines)
    found["displacement"] = moved / largest_m if largest_m > 0.0 else moved
    return found


def _with_count(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cells in VTK's way: each begins with its number of points."""
    count = np.full((len(cells), 1), cells.shape[1], dtype=np.int64)
    return np.asarray(np.hstack((count, cells)).ravel())


def edges_of(surface: Any) -> Any:
    """Return the edges of a surface: where it ends, and where it turns by more than 40°."""
    # faces that touch share points then: their common sides are no edges
    return surface.clean(tolerance=_SAME).extract_feature_edges(
        feature_angle=40.0, manifold_edges=False, non_manifold_edges=False
    )


def add_bodies(plotter: Any, shape: EngineShape, phase_rad: float) -> list[Any]:
    """Add the bodies of a mode at a phase and return them; those of the phase before make way."""
    added = []
    for body in shape.bodies:
        surface = polydata(body, phase_rad, shape.largest_m)
        added.append(
            plotter.add_mesh(surface, scalars="displacement", clim=(0.0, 1.0), cmap=COLORS,
                             show_scalar_bar=False, smooth_shading=False, ambient=0.62,
                             diffuse=0.45, specular=0.08, line_width=4.0, name=body.body,
                             point_size=11.0 * thickness(plotter), render_points_as_spheres=True)
        )  # fmt: skip
        edges = edges_of(surface)
        if edges.n_cells:
            name = f"edges of {body.body}"
            wide = 1.4 * thickness(plotter)
            drawn = plotter.add_mesh(
                edges, color="#202020", line_width=wide, lighting=False, name=name
            )
            # in front of the faces they belong to
            drawn.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            drawn.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -4.0)
            added.append(drawn)
    return added


def add_orbits(plotter: Any, shape: EngineShape, phase_rad: float) -> list[Any]:
    """Add the orbits of a mode and the points that go round on them; see `add_bodies`."""
    import pyvista

    added = []
    at = phase_rad / (2.0 * np.pi)
    for number, orbit in enumerate(shape.orbits):
        style = frame.WHIRL_STYLES[orbit.whirl]
        closed = np.vstack((orbit.points_m, orbit.points_m[:1]))
        path = _path(closed, orbit.whirl)
        wide, name = 5.0 * thickness(plotter), f"orbit {number}"
        added.append(
            plotter.add_mesh(path, color=style.color, line_width=wide, lighting=False, name=name)
        )
        place = orbit.points_m[round(at * len(orbit.points_m)) % len(orbit.points_m)]
        size = 0.11 * shape.largest_m + 1e-12
        if orbit.whirl == "backward":
            mark = pyvista.Cube(center=place, x_length=size, y_length=size, z_length=size)
        else:
            mark = pyvista.Sphere(radius=0.55 * size, center=place)
        added.append(plotter.add_mesh(mark, color=style.color, lighting=False,
                                      name=f"mark {number}"))  # fmt: skip
    return added


def view(plotter: Any, shape: EngineShape, phase_rad: float, zoom: float | None) -> Image:
    """Return an image of a mode at a phase, its orbits in front of the bodies they lie in."""
    bodies = add_bodies(plotter, shape, phase_rad)
    lines = add_orbits(plotter, shape, phase_rad)
    if zoom is not None:
        look_at(plotter, zoom)
    images = []
    for shown, hidden in ((bodies, lines), (lines, bodies)):
        for actor, visible in [(a, True) for a in shown] + [(a, False) for a in hidden]:
            actor.SetVisibility(visible)
        plotter.render()
        images.append(np.array(plotter.screenshot(return_img=True), dtype=np.uint8))
    # drawn alone on white, the lines darken what is behind them as a transparent film does
    below, above = images
    ink = (255 - above.astype(int)).max(axis=2, keepdims=True) / 255.0
    strength = np.minimum(1.0, 1.6 * ink)
    return np.asarray((1.0 - strength) * below + strength * above, dtype=np.uint8)


def _path(closed: Any, whirl: str) -> Any:
    """An orbit as lines: whole if forward, in dashes if backward, in dots if flat."""
    import pyvista

    steps = np.arange(len(closed) - 1)
    kept = {"forward": steps >= 0, "backward": steps % 6 < 4}.get(whirl, steps % 2 == 0)
    pairs = np.column_stack((steps[kept], steps[kept] + 1))
    return pyvista.PolyData(closed, lines=_with_count(pairs))


def shape_image(shape: EngineShape, phase_rad: float = 0.0) -> Image:
    """Return a view of a mode, shape (h, w, 3)."""
    with scene_in_space(_PIXELS) as plotter:
        return view(plotter, shape, phase_rad, _ZOOM)


@frame.styled
def draw_mode_still(shape: EngineShape, path: Path, title: str) -> None:
    """Draw a mode in space: deformed bodies coloured by displacement, orbits by whirl."""
    image = cropped(shape_image(shape))
    figure = frame_of(image, path, title, shape)
    frame.write_figure(figure, path)


def frame_of(image: Image, path: Path, title: str, shape: EngineShape) -> Figure:
    """Return a figure with a view in it, a bar of its colours and the meaning of the orbits."""
    from matplotlib.lines import Line2D

    figure = image_figure(image, path, f"{fill(title, 80)}\n{shape.text}", (156.0, 20.0))
    add_color_bar(figure, 1.0, "displacement, largest 1", 0.8)
    texts = {"forward": "forward orbit", "backward": "backward orbit", "straight": "along a line"}
    rows = [
        Line2D([], [], color=style.color, linestyle=style.dashes, marker=style.marker,
               markerfacecolor=style.face, markersize=4.5, label=text)
        for kind, text in texts.items()
        for style in [frame.WHIRL_STYLES[kind]]
        if any(orbit.whirl == kind for orbit in shape.orbits)
    ]  # fmt: skip
    if rows:
        figure.legend(handles=rows, loc="outside lower center", ncols=3, frameon=False,
                      fontsize=frame.SMALL_PT, handlelength=3.2)  # fmt: skip
    return figure


def image_figure(image: Image, path: Path, title: str, size_mm: tuple[float, float]) -> Figure:
    """Return a figure with an image in it; `size_mm`: width of the image, and height beside it."""
    height, width = image.shape[:2]
    figure = frame.new_figure(path, frame.TWO_COLUMNS_MM, size_mm[0] * height / width + size_mm[1])
    axes = figure.add_subplot()
    axes.imshow(image, interpolation="antialiased")
    axes.set_axis_off()
    figure.suptitle(title, fontsize=frame.TITLE_PT)
    return figure


def add_color_bar(figure: Figure, largest: float, label: str, shrink: float) -> None:
    """Add the bar of the colours of an image, from zero."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    colors = ScalarMappable(Normalize(0.0, largest), COLORS)
    bar = figure.colorbar(colors, ax=figure.axes[0], shrink=shrink, pad=0.01, aspect=28)
    bar.set_label(label)


def cropped(image: Image) -> Image:
    """Return the part of an image that is not white, with a margin."""
    return image[inked_part(image)]


def inked_part(image: Image) -> tuple[slice, ...]:
    """Return rows and columns of an image that are not white, with a margin."""
    inked = (image < 250).any(axis=2)
    places = [np.flatnonzero(inked.any(axis=axis)) for axis in (1, 0)]
    return tuple(slice(max(p[0] - 12, 0), p[-1] + 13) for p in places if p.size)


@frame.styled
def draw_solid_mesh(mesh: Mesh, path: Path, title: str) -> None:
    """Draw the mesh of a solid: its surface with the edges of the elements."""
    import pyvista

    faces = outer_faces(np.asarray(mesh.cells[:, :4], dtype=np.int64))
    surface = pyvista.PolyData(np.asarray(mesh.points), faces=_with_count(faces))
    with scene_in_space(_PIXELS) as plotter:
        plotter.add_mesh(surface, color="#A9CCE3", show_edges=True, edge_color="#1B4F72",
                         line_width=0.6, ambient=0.5, diffuse=0.5)  # fmt: skip
        look_at(plotter)
        image = np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    text = f"{fill(title, 80)}\n{len(mesh.cells)} elements"
    frame.write_figure(image_figure(cropped(image), path, text, (176.0, 13.0)), path)
