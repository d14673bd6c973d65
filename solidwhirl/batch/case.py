"""One case of a batch on the ranks of a team: its folder, its row, and what becomes of failures."""

from __future__ import annotations

import contextlib
import gc
import resource
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.batch.rows import failed_row, row_of_document
from solidwhirl.console.exit_handling import is_out_of_memory, memory_text
from solidwhirl.core.errors import USER_ERRORS, OutputError, clean
from solidwhirl.core.stages import Stage
from solidwhirl.files.run_folder import STAGES, claimed, forget_results
from solidwhirl.output.documents import write_into
from solidwhirl.pipeline.cached_stages import StageCache, open_store
from solidwhirl.pipeline.run import run_scene
from solidwhirl.sweep.cases import case_scene
from solidwhirl.sweep.records import BatchCase, BatchRow

#: File in the folder of a case that failed: why, with the traceback of a defect.
ERROR_FILE = "error.txt"
# What a long run said last, for that file.
_LAST_LINES = 20


@dataclass(frozen=True, kw_only=True)
class CaseSettings:
    """What all cases of a batch have in common."""

    out: Path  # folder of the batch; each case has one in it
    store: Path | None = None  # folder of the stages of all cases; None: `.stages` in `out`
    # level, accuracy: instead of those of the scenes; None: nothing is replaced
    level: str | None = None
    accuracy: float | None = None
    pictures: bool = True  # whether to draw those of sweeps at the end

    @property
    def stages(self) -> Path:
        """Folder of the stages."""
        return self.store or self.out / STAGES


def run_alone(case: BatchCase, settings: CaseSettings) -> BatchRow:
    """Run a case in this process and write its folder; whatever fails is in its row."""
    from mpi4py import MPI

    row, problem = lead_case(case, settings, MPI.COMM_SELF)
    if problem is not None:
        problem = None
        gc.collect()  # what the exception held, before the next case wants the memory
    return row


def lead_case(
    case: BatchCase, settings: CaseSettings, team: Any
) -> tuple[BatchRow, Exception | None]:
    """Run a case where its results arrive, on the first rank of a team.

    Returns the row, and what went wrong.
    """
    start = time.monotonic()
    _forget_peak_memory()
    said: list[str] = []
    try:
        with claimed(settings.out / case.name, within=settings.out) as folder:
            try:
                document = _computed(case, settings, team, folder, said)
            except Exception as error:
                message = failure_text(error)
                with contextlib.suppress(OSError):
                    _write_failure(folder, message, error, said)
                raise
            return row_of_document(case, document, time.monotonic() - start, team.size), None
    except Exception as error:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
        seconds = time.monotonic() - start
        row = failed_row(case, failure_text(error), seconds, team.size, peak, said=said)
        return row, error.with_traceback(None)


def _computed(
    case: BatchCase, settings: CaseSettings, team: Any, folder: Path, said: list[str]
) -> dict[str, Any]:
    """Run a case and write its folder; returns what its results hold."""
    scene = case_scene(case, level=settings.level, accuracy=settings.accuracy)
    store = open_store(settings.stages)

    def tell(event: Stage | str) -> None:
        said.append(str(event))

    results = run_scene(scene, comm=team, progress=tell, store=store)
    assert results is not None
    kept = StageCache(store=store, progress=tell)
    document = write_into(results, folder, pictures=False, page=False, stage_cache=kept)
    (folder / ERROR_FILE).unlink(missing_ok=True)
    return document


def follow_case(case: BatchCase, settings: CaseSettings, team: Any) -> Exception | None:
    """Take part in a case; returns what went wrong on this rank."""
    _forget_peak_memory()
    try:
        scene = case_scene(case, level=settings.level, accuracy=settings.accuracy)
        run_scene(scene, comm=team)
    except Exception as error:
        return error.with_traceback(None)
    return None


def failure_text(error: Exception) -> str:
    """Say why a case failed, as the command `run` would."""
    if isinstance(error, (OutputError, *USER_ERRORS)):
        return clean(str(error))
    if is_out_of_memory(error):
        return memory_text(error)
    if isinstance(error, np.linalg.LinAlgError | Warning):
        return (
            f"the numbers of this scene can not be solved ({clean(str(error))}); check masses, "
            "inertias, stiffnesses and units"
        )
    return f"defect of the program: {type(error).__name__}: {clean(str(error))}; see {ERROR_FILE}"


def _write_failure(folder: Path, message: str, error: Exception, said: list[str]) -> None:
    """Leave why a case failed in its folder, and no results of another content."""
    forget_results(folder)
    parts = [message, *(f"before: {line}" for line in said[-_LAST_LINES:])]
    if message.startswith("defect"):
        parts += ["", "".join(traceback.format_exception(error)).rstrip()]
    (folder / ERROR_FILE).write_text("\n".join(parts) + "\n", encoding="utf-8")


def _forget_peak_memory() -> None:
    """Let the largest resident set be that of the next case, where the system can (Linux)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
