"""How the results of a run show themselves, as text and in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.check_report import checks_line, failed
from solidwhirl.displays import counted, heading, indented, percent, table, titled

if TYPE_CHECKING:
    from solidwhirl.pipeline import Results

_RPM = 30.0 / np.pi
Critical = tuple[str, str, str, str]


def results_text(results: Results) -> str:
    """What a run found: accuracy, checks, critical speeds, analyses."""
    head = f"Results of {results.scene.name!r}{titled(results.scene.title)}"
    rows = _critical_rows(results)
    lines = _summary(results)
    lines.append("critical speeds: " + ("none" if not rows else str(len(rows))))
    lines += indented(counted([f"{s} rpm, {f} Hz, {w}, error {e}" for s, f, w, e in rows]))
    lines += [f"{name}: {o.headline or o.kind}" for name, o in results.analyses.items()]
    return "\n".join([head, *indented(lines)])


def results_html(results: Results) -> str:
    """The same for a notebook."""
    names = ("critical speed rpm", "Hz", "whirl", "error")
    about = [tuple(line.split(": ", 1)) for line in _summary(results)]
    about += [(name, o.headline or o.kind) for name, o in results.analyses.items()]
    head = f"Results of {results.scene.name!r}{titled(results.scene.title)}"
    return heading(head) + table((), about) + table(names, _critical_rows(results))


def _summary(results: Results) -> list[str]:
    lines = [
        "bodies: "
        + ", ".join(counted([f"{n} ({e.level})" for n, e in results.elements.items()]))
        + f"; {results.system.size} coordinates"
    ]
    if results.estimates is not None:
        asked = percent(results.scene.model.accuracy)
        lines.append(f"largest error estimate: {percent(results.estimates.largest)}, asked {asked}")
    bad = [check.name for check in failed(results.checks)]
    names = f": {', '.join(counted(bad))}" if bad else ""
    lines.append(f"checks: {checks_line(results.checks)}{names}")
    rpm = results.campbell.speeds_rad_s * _RPM
    branches = len(results.campbell.frequency_hz)
    lines.append(f"Campbell diagram: {branches} branches, {rpm[0]:.6g} to {rpm[-1]:.6g} rpm")
    return lines


def _critical_rows(results: Results) -> list[Critical]:
    rows: list[Critical] = []
    for k, found in enumerate(results.critical_speeds):
        critical = found.critical
        known = results.estimates is not None
        error = float(results.estimates.critical_speeds.total[k]) if results.estimates else np.nan
        rows.append(
            (
                f"{critical.speed_rad_s * _RPM:.1f}",
                f"{critical.frequency_hz:.2f}",
                critical.whirl,
                percent(error) if known else "not estimated",
            )
        )
    return rows
