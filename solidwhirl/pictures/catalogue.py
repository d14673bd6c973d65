"""All pictures of a run, by name, in the order in which they are read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.core.outcome import Drawing, Write, is_picture
from solidwhirl.drawing.bodies import silhouettes_of
from solidwhirl.drawing.modes import pictured_modes
from solidwhirl.files.picture_index import Picture
from solidwhirl.output.documents import diagrams_of
from solidwhirl.page.run.accuracy import time_chart
from solidwhirl.page.run.checks import checks_chart
from solidwhirl.page.run.meshes import plane_chart
from solidwhirl.pictures.engine import draw_engine
from solidwhirl.pictures.engine_shape import EngineShape, engine_shape
from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn.plots.campbell import draw_annotated_campbell, draw_damped_campbell
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

# Decrements below this are rounding.
_UNDAMPED = 1e-8
# Of a meridian with more edges the outline alone is drawn.
_MOST_EDGES = 200_000
# Every so many frames of a film a line says how far it is.
_TOLD = 4


def pictures_of(
    results: Results, modes: int = 4, progress: Callable[[str], None] = lambda text: None
) -> tuple[Picture, ...]:
    """Return all pictures that a run has something for.

    Their names differ; nothing is drawn yet.
    """
    title = results.scene.title or results.scene.name
    found = [
        Picture(
            name="engine",
            kind="plot",
            caption="The engine to scale: bodies, rigid disks, bearings, gears and node names.",
            draw=lambda path: draw_engine(results.scene, silhouettes_of(results), path, title),
        ),
        *_meshes(results, title),
        *_campbell(results),
        *_modes(results, modes, title, progress),
        *_analyses(results, title),
        *_accounts(results, title),
    ]
    return tuple(found)


def _meshes(results: Results, title: str) -> Iterator[Picture]:
    for name, body in results.bodies.items():
        mesh, own = body.shown_mesh, f"{title}: mesh of {name}"
        flat, degree = mesh.dimension == 2, body.discretisation.degree
        yield Picture(
            name=f"mesh_{name}",
            kind="plot" if flat else "still",
            caption=f"Mesh of {name}: {len(mesh.cells)} elements of order {degree}.",
            draw=partial(_draw_meridian if flat else _draw_solid, name, mesh, own),
        )


def _draw_meridian(name: str, mesh: Any, title: str, path: Path) -> None:
    draw_charts([plane_chart({name: mesh}, _MOST_EDGES)], path, title)


def _draw_solid(_: str, mesh: Any, title: str, path: Path) -> None:
    from solidwhirl.pictures.stills import draw_solid_mesh

    draw_solid_mesh(mesh, path, title)


_DIAGRAMS = {
    "campbell": "Natural frequencies over the speed, with critical speeds.",
    "campbell_annotated": "The same with marks where branches cross, veer or end.",
    "campbell_damped": "The same with the logarithmic decrements below.",
    "campbell_errors": "Natural frequencies with bands of their estimated error, and the error by "
    "part.",
    "critical_speeds": "Critical speeds with their estimated errors, and the error by part.",
}


def _campbell(results: Results) -> Iterator[Picture]:
    """The diagrams that are in the folder of a run, and one with notes and one with damping."""
    drawn = {Path(file).stem: draw for file, draw in diagrams_of(results).items()}
    shown = drawn["campbell"]
    if results.campbell.notes:
        drawn["campbell_annotated"] = partial(
            draw_annotated_campbell, *shown.args, **shown.keywords
        )
    if np.nanmax(np.abs(results.campbell.log_decrement), initial=0.0) > _UNDAMPED:
        drawn["campbell_damped"] = partial(draw_damped_campbell, *shown.args, **shown.keywords)
    for name, caption in _DIAGRAMS.items():
        if name in drawn:
            yield Picture(name=name, kind="plot", caption=caption, draw=drawn[name])


def _modes(
    results: Results, count: int, title: str, progress: Callable[[str], None]
) -> Iterator[Picture]:
    beginning, shown = pictured_modes(results, count)
    for k in range(0 if shown is None else len(shown.rpm)):
        assert shown is not None
        name = f"{beginning}_{k + 1}"
        caption = (
            f"Mode of {shown.modes.frequency_hz[k]:.4g} Hz at {shown.rpm[k]:.0f} rpm, "
            f"{shown.whirl[k]}: deformed bodies, and orbits of the axis: solid with a ball where "
            "they are forward, dashed with a cube where they are backward."
        )
        shape = partial(engine_shape, results, shown, k)
        still = Drawing(shown=shape, draw=partial(_draw_mode, title=title))
        yield Picture(name=name, kind="still", caption=caption, draw=still)
        told = partial(_tell, progress, name)
        draw = partial(_draw_film, shape, title, told)
        yield Picture(name=f"{name}_film", kind="film", caption=caption, draw=draw)


def _tell(progress: Callable[[str], None], name: str, frame: int, frames: int) -> None:
    if frame % _TOLD == 0:
        progress(f"{name}_film: frame {frame} of {frames}")


# The modules of stills and films load VTK.
def _draw_mode(shape: EngineShape, path: Path, title: str) -> None:
    from solidwhirl.pictures.stills import draw_mode_still

    draw_mode_still(shape, path, title)


def _draw_film(
    shape: Callable[[], EngineShape], title: str, told: Callable[[int, int], None], path: Path
) -> None:
    from solidwhirl.pictures.animation import mode_frames, write_film

    write_film(mode_frames(shape(), title, told), path)


def _analyses(results: Results, title: str) -> Iterator[Picture]:
    """Pictures that analyses draw themselves, and those of their fields."""
    for outcome in results.analyses.values():
        for file, write in outcome.files.items():
            if is_picture(file):
                name, caption = str(Path(file).with_suffix("")), outcome.caption
                yield Picture(name=name, kind="plot", caption=caption, draw=write)
            elif file.endswith(".vtu") and not _is_frame(file):
                state = Path(file).stem
                yield Picture(
                    name=state,
                    kind="still",
                    caption=f"Recovered state {state}: half of the body, deformed, with stress.",
                    draw=partial(_draw_stress, write, f"{title}: {state.replace('_', ' ')}"),
                )


def _is_frame(file: str) -> bool:
    """Whether a state is one frame of a period; these belong to a film, not to a page."""
    return Path(file).stem[-4:-3] == "_" and Path(file).stem[-3:].isdigit()


def _draw_stress(record: Write, title: str, path: Path) -> None:
    from solidwhirl.pictures.stress import draw_stress_still

    draw_stress_still(record, path, title)


def _accounts(results: Results, title: str) -> Iterator[Picture]:
    """What the run cost, and whether its checks hold."""
    checks = checks_chart(results.checks)
    if checks is not None:
        yield Picture(
            name="checks",
            kind="plot",
            caption="Errors of the checks of the run over their limits.",
            draw=partial(draw_charts, [checks], title=f"{title}: checks"),
        )
    spent = {name: seconds for name, seconds in results.timings_s.items() if seconds > 0.0}
    if spent:
        yield Picture(
            name="cost",
            kind="plot",
            caption="Wall time of the stages that were computed in this run.",
            draw=partial(draw_charts, [time_chart(spent)], title=f"{title}: wall time"),
        )
