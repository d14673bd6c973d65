"""The command `run` on the rank that has the results."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import typer
from mpi4py import MPI

from solidwhirl.bodies import build_bodies
from solidwhirl.check_report import failed, failure_lines
from solidwhirl.pipeline import Results, run_scene
from solidwhirl.plausibility import implausible
from solidwhirl.progress_line import telling
from solidwhirl.results import write_into
from solidwhirl.run_folder import claimed
from solidwhirl.scene import Scene
from solidwhirl.scene_sweep import nominal_text
from solidwhirl.store_stages import Keeper, open_fresh_store, open_store


@dataclass(frozen=True, kw_only=True)
class RunPlaces:
    """Where a run reads and writes, and where stages are kept.

    Attributes
    ----------
    path
        The scene file.
    out
        Folder of the results.
    store
        Folder of the stages; None: in `out`.
    fresh
        Whether all stages are computed again.
    """

    path: Path
    out: Path
    store: Path | None
    fresh: bool


def run_command(scene: Scene, places: RunPlaces, *, pictures: bool, quiet: bool) -> int:
    """Run and write a scene; rank 0 calls this, the others `run_scene`.

    Parameters
    ----------
    scene
        The scene.
    places
        Its file and folders.
    pictures
        Whether to draw.
    quiet
        Say nothing but errors.

    Returns
    -------
    Exit code: 0, or 3 if an invariant is violated.
    """
    for line in () if quiet else _before(scene, places.path):
        typer.echo(line, err=True)
    results = _computed(scene, places, pictures, quiet)
    drawn = (("Campbell plot", "campbell.png"),) if pictures else ()
    for title, name in (*drawn, ("report", "report.md"), ("results", "results.json")):
        if not quiet:
            typer.echo(f"{title}: {places.out / name}")
    for line in failure_lines(results.checks):
        typer.echo(line, err=True)
    return 3 if failed(results.checks) else 0


def _before(scene: Scene, path: Path) -> Iterator[str]:
    """What a user should know before the long work."""
    if scene.sweep is not None:
        yield nominal_text(str(path), scene.sweep)
    for doubt in implausible(scene, build_bodies(scene)):
        yield f"doubt: {doubt.message}"


def _computed(scene: Scene, places: RunPlaces, pictures: bool, quiet: bool) -> Results:
    with telling(quiet) as progress, claimed(places.out) as folder:
        opened = open_fresh_store if places.fresh else open_store
        kept = opened(places.store or folder.stages)
        kept.clear_leftovers()
        results = run_scene(scene, comm=MPI.COMM_WORLD, progress=progress, store=kept)
        assert results is not None
        progress("write the results")
        keeper = Keeper(store=kept, progress=progress)
        write_into(results, folder, pictures=pictures, keeper=keeper)
        if places.store is None:
            kept.prune()
    return results
