"""Accuracy against cost: one scene with many settings, each held against the same truth."""

from __future__ import annotations

import importlib.util
import json
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from solidwhirl.errors import OutputError
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.scene_file import read_scene
from solidwhirl.study_document import Study, study_document, study_notes, summary
from solidwhirl.study_matrix import FULL, QUICK
from solidwhirl.study_measure import Progress
from solidwhirl.study_runner import StudyError, run_cases
from solidwhirl.study_settings import study_cases
from solidwhirl.study_table import study_table

__all__ = ["StudyDone", "StudyError", "study_command"]


@dataclass(frozen=True, kw_only=True)
class StudyDone:
    """Files of a study.

    Attributes
    ----------
    out
        The folder.
    document, page, report
        study.json, study.html and study.md.
    pictures
        The PNG files.
    done, failed, skipped
        Numbers of cases.
    notes
        One sentence per case that is missing, and what else a reader must know.
    """

    out: Path
    document: Path
    page: Path
    report: Path
    pictures: tuple[Path, ...]
    done: int
    failed: int
    skipped: int
    notes: tuple[str, ...]


def study_command(
    scene_path: str | Path,
    out: str | Path,
    progress: Progress = lambda text: None,
    *,
    quick: bool = False,
) -> StudyDone:
    """Measure error against processor time and memory over levels, orders, meshes and modes.

    Parameters
    ----------
    scene_path
        The scene file. It needs a body with a profile; its analyses are left out.
    out
        Folder for study.json, study.md, study.html and the pictures. Results of finished cases are
        kept in its folder cases/: a study that was broken off goes on where it stopped.
    progress
        Called with one line per case, with the time to go.
    quick
        A small matrix, under a minute for a small scene.

    Returns
    -------
    StudyDone

    Raises
    ------
    SceneError
        The scene can't be read.
    StudyError
        There is no body with a profile, the reference fails, or plotly is not installed.
    OutputError
        The folder can't be written.
    """
    scene = read_scene(scene_path)
    if not scene.bodies:
        raise StudyError("a study needs a body with a profile, [bodies.NAME]; the scene has none")
    if importlib.util.find_spec("plotly") is None:
        raise StudyError("study.html needs plotly, which is not installed (pip install plotly)")
    out = Path(out)
    if os.path.lexists(out / "study.json") and not _is_study(out / "study.json"):
        raise OutputError(f"{out / 'study.json'}: is there already and no study wrote it")
    try:
        matrix = QUICK if quick else FULL
        cases = study_cases(scene, matrix)  # a scene that is refused leaves no folder
        out.mkdir(parents=True, exist_ok=True)
        outcomes = run_cases(cases, out / "cases", matrix, progress)
        progress("pictures")
        table = study_table(outcomes)
        notes = study_notes(outcomes, table)
        study = Study(scene=scene, quick=quick, outcomes=outcomes, table=table, notes=notes)
        return _write(study, out)
    except OSError as error:
        raise OutputError(f"{out}: can not be written: {error.strerror or error}") from error


def _is_study(path: Path) -> bool:
    try:
        return path.is_file() and "solidwhirl-study-" in path.read_text(encoding="utf-8")[:1000]
    except (OSError, UnicodeDecodeError):
        return False


def _write(study: Study, out: Path) -> StudyDone:
    """Write all files, study.json last."""
    from solidwhirl.study_html import study_page
    from solidwhirl.study_pictures import draw_study

    document = study_document(study)
    pictures = draw_study(study, document, out)
    files = {
        out / "study.html": study_page(study, document),
        out / "study.md": summary(study, document),
        out / "study.json": json.dumps(document, indent=1, allow_nan=False) + "\n",
    }
    for path, text in files.items():
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    page, report, record = files
    count = Counter(o.status for o in study.outcomes)
    return StudyDone(
        out=out,
        document=record,
        page=page,
        report=report,
        pictures=pictures,
        done=count["done"],
        failed=count["failed"],
        skipped=count["skipped"],
        notes=study.notes,
    )
