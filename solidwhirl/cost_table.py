"""The predicted cost of a run as rows of a printed plan."""

from __future__ import annotations

from solidwhirl.cost import Cost, RunCost

_HEAD = ("what", "unknowns", "predicted s", "predicted GiB")
_LABELS = {
    "import_solvers": "import of the solvers",
    "meshing": "mesh",
    "assembly": "assembly",
    "factorisations": "factorisations",
    "static_solutions": "static solutions",
    "eigensolutions": "eigensolutions",
    "projection": "projection",
    "error_estimate": "error estimate",
    "campbell": "Campbell diagram",
    "critical_speeds": "critical speeds",
}
_SHARED = ("import_solvers", "campbell", "critical_speeds")


def cost_rows(cost: RunCost) -> tuple[tuple[str, str, str, str], ...]:
    """Rows (what, unknowns, predicted s, predicted GiB) as text, the first one is the head.

    Parameters
    ----------
    cost
        From `solidwhirl.cost.predict_cost`.

    Returns
    -------
    tuple
        Per body one row and one for each of its stages, then what the bodies share, then all.
        Numbers that were extrapolated have "(extrapolated)" after the unknowns.
    """
    rows = [_HEAD]
    for name, body in cost.bodies.items():
        rows.append(_row(name, body, body.total_s))
        rows += [
            (f"  {_LABELS[stage]}", "", _seconds(spent), "")
            for stage, spent in body.seconds.items()
        ]
    for stage in _SHARED:
        if cost.whole.seconds.get(stage):
            size = "" if stage == "import_solvers" else f"{cost.whole.coordinates} coordinates"
            rows.append((_LABELS[stage], size, _seconds(cost.whole.seconds[stage]), ""))
    rows.append(_row("all", cost.whole, cost.whole.total_s))
    return tuple(rows)


def cost_table(cost: RunCost) -> tuple[str, ...]:
    """Lines of `cost_rows` in columns: what to the left, numbers to the right.

    Parameters
    ----------
    cost
        From `solidwhirl.cost.predict_cost`.
    """
    rows = cost_rows(cost)
    widths = [max(len(row[k]) for row in rows) for k in range(len(_HEAD))]
    return tuple(
        "  ".join(
            [row[0].ljust(widths[0]), *(row[k].rjust(widths[k]) for k in range(1, len(_HEAD)))]
        )
        for row in rows
    )


def _row(what: str, cost: Cost, seconds: float) -> tuple[str, str, str, str]:
    unknowns = f"{cost.unknowns:.3g}" if cost.unknowns >= 1e6 else f"{cost.unknowns}"
    if cost.extrapolated:
        unknowns += " (extrapolated)"
    return what, unknowns, _seconds(seconds), f"{cost.peak_memory_gib:.2g}"


def _seconds(value: float) -> str:
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"
