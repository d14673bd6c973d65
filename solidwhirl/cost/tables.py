"""A forecast as rows of a table, and as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from solidwhirl.cost.forecast import Forecast
from solidwhirl.cost.work import Cost, RunCost

Row = tuple[str, str, str, str]

_HEAD = ("what", "unknowns", "predicted s", "predicted GiB")
_LABELS = {
    "import_solvers": "import of the solvers",
    "meshing": "mesh",
    "around": "around them",
    "campbell": "Campbell diagram",
    "checks": "checks and stability",
}
_SHARED = ("import_solvers", "campbell", "critical_speeds", "checks")


def forecast_rows(found: Forecast) -> tuple[Row, ...]:
    """Rows of all that a run takes, head first, and the total; pictures are no part of it."""
    last, written = found.last or found.first, found.writing
    rows = [_HEAD, ("start and choice of the level", "", seconds_text(found.start_s), "")]
    rows += cost_rows(last)[1:-1]
    if found.last is not None:
        rows += [
            (f"first round: {name}", str(cost.unknowns), seconds_text(cost.total_s), "")
            for name, cost in found.first.bodies.items()
        ]
    rows += [
        (f"analysis {name}", "", seconds_text(cost.seconds), memory_text(cost.memory_gib))
        for name, cost in found.analyses.items()
    ]
    rows.append(("files", "", seconds_text(written.files_s), ""))
    rows.append(("page", "", seconds_text(written.page_s), ""))
    size, memory = _unknowns(last.whole), memory_text(found.peak_memory_gib)
    rows.append(("all", size, seconds_text(found.seconds), memory))
    rows.append(("with --pictures, more", "", seconds_text(written.pictures_s), ""))
    return tuple(rows)


def cost_rows(cost: RunCost) -> tuple[Row, ...]:
    """Rows (what, unknowns, predicted s, predicted GiB) as text, the first one is the head.

    Per body one row and one for each of its stages, then what the bodies share, then all. Numbers
    that were extrapolated have "(extrapolated)" after the unknowns.
    """
    return (_HEAD, *_cost_rows(cost), _row("all", cost.whole, cost.whole.total_s))


def _cost_rows(cost: RunCost) -> Iterator[Row]:
    for name, body in cost.bodies.items():
        yield _row(name, body, body.total_s)
        for stage, spent in body.seconds.items():
            yield f"  {_label(stage)}", "", seconds_text(spent), ""
    for stage in _SHARED:
        if cost.whole.seconds.get(stage):
            size = "" if stage == "import_solvers" else f"{cost.whole.coordinates} coordinates"
            yield _label(stage), size, seconds_text(cost.whole.seconds[stage]), ""
    # what bodies are compared with belongs to all of them
    own = sum(body.seconds.get("error_estimate", 0.0) for body in cost.bodies.values())
    shared = cost.whole.seconds.get("error_estimate", 0.0) - own
    if shared > 0.0:
        yield "other models", "", seconds_text(shared), ""


def forecast_document(found: Forecast) -> dict[str, Any]:
    """The forecast as plain data."""
    return {
        "cpu_s": found.seconds,
        "start_cpu_s": found.start_s,
        "analyses_cpu_s": {name: cost.seconds for name, cost in found.analyses.items()},
        "files_cpu_s": found.writing.files_s,
        "page_cpu_s": found.writing.page_s,
        "pictures_cpu_s": found.writing.pictures_s,
        "peak_memory_gib": found.peak_memory_gib,
        "unknowns": found.unknowns,
        "extrapolated": found.extrapolated,
    }


def _label(stage: str) -> str:
    return _LABELS.get(stage, stage.replace("_", " "))


def _row(what: str, cost: Cost, seconds: float) -> Row:
    return what, _unknowns(cost), seconds_text(seconds), memory_text(cost.peak_memory_gib)


def _unknowns(cost: Cost) -> str:
    text = f"{cost.unknowns:.3g}" if cost.unknowns >= 1e6 else f"{cost.unknowns}"
    return f"{text} (extrapolated)" if cost.extrapolated else text


def seconds_text(value: float) -> str:
    """Two digits, and whole seconds from a hundred on."""
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"


def memory_text(value: float) -> str:
    """Two digits."""
    return f"{value:.2g}"
