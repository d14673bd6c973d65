"""Parameter identification from measurements."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

from solidwhirl.cache.files import StageStore
from solidwhirl.core.errors import OutputError, SceneError, writing
from solidwhirl.files.run_folder import refuse_foreign
from solidwhirl.identify.model import InfeasibleError, Model, Progress
from solidwhirl.identify.problem import Problem, read_problem
from solidwhirl.identify.record import Identification, document, text
from solidwhirl.identify.scene import Steps, scene_text, with_references
from solidwhirl.identify.search import measured_slopes, search
from solidwhirl.rotordyn.core.atomic import replace_text

#: Ends of the names of the record, as JSON and as Markdown.
RECORD, REPORT = ".identification.json", ".identification.md"
# What a scene says in its head that a search has written.
_WRITTEN = "Written by `solidwhirl identify"

__all__ = ["identified_scene", "identify", "identify_command", "read_problem"]


def identify_command(
    path: str | Path, out: str | Path, progress: Progress = lambda text: None
) -> Identification:
    """Identify the free numbers of a scene and write the scene with them, and the record.

    `out`: the scene file to write. Beside it go `<stem>.identification.json` and `.md`, and while
    the search runs its evaluations, `<stem>.stages`: started again with the same problem, the
    search continues where it was broken off. They are removed at the end. `progress`: called with
    one line per step.
    Raises SceneError: the problem or its scene can't be run; OutputError: a file can't be written.
    """
    problem = read_problem(path)
    out = Path(out)
    _refuse_target(problem, out)
    store = StageStore(out.with_suffix(".stages"))
    found = identify(problem, store=store, progress=progress)
    contents = {
        out: identified_scene(found),
        out.with_suffix(REPORT): text(found),
        out.with_suffix(RECORD): json.dumps(document(found), indent=1, allow_nan=False) + "\n",
    }
    for file, content in contents.items():
        with writing(file):
            replace_text(file, content)
    store.remove()
    return found


def _refuse_target(problem: Problem, out: Path) -> None:
    """Find out before the long work, not after, that the file can not be written."""
    read = (problem.path, problem.path.parent / problem.spec.scene)
    if out.resolve() in [p.resolve() for p in read]:
        raise OutputError(f"{out}: is read by this problem; choose another file to write")
    if out.is_dir():
        raise OutputError(f"{out}: is a folder; the name of a file is needed")
    refuse_foreign(
        out, _WRITTEN, "`identify` did not write it; move it away or choose another file"
    )
    with writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
    if not os.access(out.parent, os.W_OK | os.X_OK):
        raise OutputError(f"{out}: can not be written: no permission in {out.parent}")


def identify(
    problem: Problem, *, store: StageStore | None = None, progress: Progress = lambda text: None
) -> Identification:
    """Find the values of the parameters that bring the targets nearest to their values.

    `store`: keeps evaluations. `progress`: called with one line per step.
    Returns the best that was found, with all targets met or not.
    Raises SceneError: no start of the search has a model, or the slopes at the result can't be
    measured.

    Minimised is Σ ((q/q₀ - 1)/tolerance)² + Σ (prior (p - start)/(upper - lower))² over the
    box of the bounds, by the trust region reflective method of Branch, Coleman and Li (1999).
    """
    begun = time.perf_counter()
    model = Model(problem, store, progress)
    settings = problem.spec.settings
    try:
        last, starts = search(model, progress)
        progress("sensitivities at the result")
        model.limit = None
        slopes = measured_slopes(model, last.point)
        reached = model.complete(last.point, settings.accuracy)
    except InfeasibleError as error:
        raise SceneError(problem.path, [str(error)]) from error
    return Identification(
        problem=problem,
        values=model.values(last.point),
        point=last.point,
        reached=reached,
        slopes=slopes,
        starts=starts,
        ended=last.ended,
        evaluations=model.evaluations,
        infeasible=tuple(model.infeasible),
        seconds=time.perf_counter() - begun,
    )


def identified_scene(found: Identification) -> str:
    """Return the scene with the identified values as TOML, with the origin of each number."""
    problem = found.problem
    comments: dict[Steps, str] = {}
    for place, said in problem.spec.comments.items():
        comments[problem.places[place].steps] = said
    for parameter in problem.spec.parameters:
        for place in parameter.places:
            comments[problem.places[place].steps] = f"identified ({parameter.name})"
    for derived in problem.spec.derived:
        said = f"follows from {', '.join(derived.terms)}"
        for place in derived.places:
            comments[problem.places[place].steps] = said
    header = (
        problem.spec.title or problem.spec.name,
        f"{_WRITTEN} {problem.path.name}`; see its record.",
    )
    data = with_references(problem.scene_at(found.values), problem.spec)
    return scene_text(data, comments, header)
