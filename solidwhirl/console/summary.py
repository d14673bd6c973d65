"""The end of a run: a table of the results that matter, or the same as one JSON document."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from solidwhirl.analyses.base import Operating
from solidwhirl.console.terminal import duration_text
from solidwhirl.core.check_report import checks_line, failed, failure_lines
from solidwhirl.pipeline.verdict_text import answers, margin_words, percent_text
from solidwhirl.scene_checks.operating import (
    critical_speeds_that_count,
    margin_of,
    nearest,
    operating_speeds,
)

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import Results

_SCHEMA = "solidwhirl-run-1"
_MOST_ROWS = 12
# Kinds of analyses whose headline the verdict has.
_ANSWERED = ("separation_margins", "stability")
_KEYS = (
    *("speed_rpm", "frequency_hz", "frequency_error_estimate", "whirl", "log_decrement"),
    *("amplification_factor", "critically_damped", "excited_by"),
)
_WIDTH_WITHOUT_TERMINAL = 110
# Characters that no table is as wide as.
_UNLIMITED = 10_000
# Marks and colours of all pictures, see rotordyn/plots/campbell.py.
_WHIRL = {"forward": ("●", "#0072B2"), "backward": ("□", "#D55E00")}
_OTHER_WHIRL = ("◇", "#999999")
# Files of a run that are worth naming, and what they are.
_FILES = (
    ("Campbell plot", "campbell.png"),
    ("page", "report.html"),
    ("report", "report.md"),
    ("results", "results.json"),
)


def print_summary(results: Results, out: Path, seconds: float | None = None) -> None:
    """Print what matters of a run, and where its files are.

    Parameters
    ----------
    seconds
        Wall time [s]; None: the sum over its stages.
    """
    width = None if sys.stdout.isatty() else _WIDTH_WITHOUT_TERMINAL
    console = Console(width=width, highlight=False)
    document = summary_document(results, out, seconds)
    console.print(Text(results.scene.title or results.scene.name, style="bold"))
    for about, text, good in answers(document):
        said = Text(f"{about[0].lower()}{about[1:]}: ")
        console.print(said.append(text, style={True: "green", False: "red", None: ""}[good]))
    operating = operating_speeds(results.scene)
    console.print(fitting_table(document["critical_speeds"], console, operating))
    for name, outcome in results.analyses.items():
        if outcome.headline and outcome.kind not in _ANSWERED:
            console.print(Text(f"{name}: {outcome.headline}"))
    for line in doubt_lines(results):
        console.print(Text(line, style="yellow"))
    console.print(Text(f"checks: {checks_line(results.checks)}"))
    console.print(Text(_cost_line(document)))
    for title, name in _FILES:
        if name in document["files"]:
            console.print(Text(f"{title}: {out / name}"), soft_wrap=True)


def doubt_lines(results: Results) -> tuple[str, ...]:
    """What is doubtful about a run and was not known before it: supports and bearings.

    Returns
    -------
    tuple of str
        One line each.
    """
    from solidwhirl.plausibility.supports import support_doubts
    from solidwhirl.rotordyn.assembly.bearing_notes import note_lines

    messages = [doubt.message for doubt in support_doubts(results.system)]
    messages += note_lines(results.bearing_notes)
    messages = [alarm.message for alarm in results.alarms] + messages
    return tuple(f"warning: {message}" for message in messages)


def warning_lines(results: Results) -> tuple[str, ...]:
    """What the last lines of a run say: checks that failed, and an accuracy that is not met.

    Returns
    -------
    tuple of str
        One line each.
    """
    from solidwhirl.estimates.documents import accuracy_document, followed_by

    found = accuracy_document(results.scene, results.estimates, results.rounds, results.checks)
    missed = found["met"] is False and found["largest_error_estimate"] is not None
    line = (
        f"warning: accuracy not met: estimated error "
        f"{percent_text(found['largest_error_estimate'])}, asked {percent_text(found['asked'])}"
    )
    if found["rounds"] and found["rounds"][-1]["stopped"]:
        last = len(found["rounds"])
        line += f"; refinement {followed_by(found['rounds'], last - 1)} after round {last}"
    return (*failure_lines(results.checks), *((line,) if missed else ()))


def summary_document(results: Results, out: Path, seconds: float | None = None) -> dict[str, Any]:
    """What matters of a run as plain data; units in the keys, absent values are null.

    Parameters
    ----------
    seconds
        Wall time [s]; None: the sum over its stages.
    """
    document = json.loads((out / "results.json").read_text(encoding="utf-8"))
    computing = sum(results.timings_s.values())
    bad = failed(results.checks)
    return {
        "schema": _SCHEMA,
        "scene": document["scene"]["name"],
        "exit_code": 3 if bad else 0,
        "error": None,
        "folder": str(out),
        "files": [name for _, name in _FILES if (out / name).is_file()],
        "levels": {name: body["level"] for name, body in document["bodies"].items()},
        "accuracy": {
            key: document["accuracy"][key] for key in ("asked", "largest_error_estimate", "met")
        },
        "verdict": document["verdict"],
        "critical_speeds": _critical_speeds(document, operating_speeds(results.scene)),
        "analyses": {name: outcome.headline for name, outcome in results.analyses.items()},
        "checks": {
            "passed": sum(check.passed is True for check in results.checks),
            "failed": len(bad),
            "not_decided": sum(check.passed is None for check in results.checks),
            "failures": list(failure_lines(results.checks)),
        },
        "doubts": [doubt["message"] for doubt in document["doubts"]] + document["bearing_notes"],
        "seconds": computing if seconds is None else seconds,
        "computing_seconds": computing,
        "peak_memory_gib": results.peak_memory_gib,
    }


def refusal_document(scene: Path, message: str) -> dict[str, Any]:
    """A run that was refused as plain data."""
    return {"schema": _SCHEMA, "scene_file": str(scene), "exit_code": 2, "error": message}


def _critical_speeds(
    document: Mapping[str, Any], operating: Sequence[Operating]
) -> list[dict[str, Any]]:
    rows = []
    for entry in document["critical_speeds"]:
        margin, shaft = margin_of(entry["speed_rpm"], entry["excited_by"], operating) or (
            None,
            None,
        )
        rows.append({key: entry.get(key) for key in _KEYS} | {"margin": margin, "margin_of": shaft})
    return rows


def fitting_table(
    every: list[dict[str, Any]], console: Console, operating: Sequence[Operating]
) -> Table | Text:
    """The critical speeds that are resonances, with as much as the console has room for."""
    rows = critical_speeds_that_count({"critical_speeds": every})
    if not rows:
        too_much = f"; {len(every)} critically damped" if every else ""
        return Text(f"no critical speed in the speed range{too_much}")
    shown = [dict(row) for row in nearest(rows, operating, _MOST_ROWS)[0]]
    columns = {name: make(shown) for name, make in _COLUMNS.items()}
    if all(row["margin"] is None for row in rows):
        del columns["margin"]
    if all(row["amplification_factor"] is None for row in rows):
        del columns["AF"]
    same = len({tuple(row["excited_by"]) for row in shown}) == 1
    first = ("excited by",) if same else ()
    unlimited = console.options.update(width=_UNLIMITED)
    for name in ("", "shorter margin", *first, "log\ndecr.", "error\n[%]", "excited by", "AF"):
        if name == "shorter margin" and "margin" in columns:
            columns["margin"] = [_short_margin(row) for row in shown]
        columns.pop(name, None)
        table = _table(columns)
        if Measurement.get(console, unlimited, table).maximum <= console.width:
            break
    counts = ((len(rows) - len(shown), "more"), (len(every) - len(rows), "critically damped"))
    said = [f"{count} {what}" for count, what in counts if count]
    if said:
        table.caption = f"and {', '.join(said)}, see the report"
    return table


def _table(columns: Mapping[str, Sequence[str | Text]]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for head in columns:
        left = head in ("whirl", "excited by", "margin")
        table.add_column(Text(head), justify="left" if left else "right", no_wrap=left)
    for cells in zip(*columns.values(), strict=True):
        table.add_row(*cells)
    return table


def _whirl_text(row: Mapping[str, Any]) -> Text:
    mark, colour = _WHIRL.get(row["whirl"], _OTHER_WHIRL)
    return Text(f"{mark} {row['whirl']}", style=colour)


def _decrement_text(row: Mapping[str, Any]) -> str:
    decrement = row["log_decrement"]
    return "-" if decrement is None else f"{decrement:.3g}"


def _factor_text(row: Mapping[str, Any]) -> str:
    factor = row["amplification_factor"]
    return "-" if factor is None else f"{factor:.3g}"


def long_margin(row: Mapping[str, Any]) -> str:
    """Return the margin of a critical speed in words, such as "4 % above lp"."""
    return "-" if row["margin"] is None else margin_words(row["margin"], row["margin_of"])


def _short_margin(row: Mapping[str, Any]) -> str:
    """A margin with a sign instead of a word, such as "+4 % lp"."""
    if not row["margin"]:
        return long_margin(row).replace("the speeds of ", "")
    size, _, shaft = long_margin(row).rpartition(" % ")
    sign = "+" if row["margin"] > 0.0 else "-"
    return f"{sign}{size.replace('< ', '<')} % {shaft.split(' ', 1)[1]}"


# Columns of the table of critical speeds by their heads, as they follow one another.
_COLUMNS: Mapping[str, Callable[[list[dict[str, Any]]], Sequence[str | Text]]] = {
    "speed\n[rpm]": lambda rows: [f"{row['speed_rpm']:.0f}" for row in rows],
    "frequency\n[Hz]": lambda rows: [f"{row['frequency_hz']:.2f}" for row in rows],
    "error\n[%]": lambda rows: [
        percent_text(row["frequency_error_estimate"]).removesuffix(" %") for row in rows
    ],
    "whirl": lambda rows: [_whirl_text(row) for row in rows],
    "log\ndecr.": lambda rows: [_decrement_text(row) for row in rows],
    "AF": lambda rows: [_factor_text(row) for row in rows],
    "excited by": lambda rows: [", ".join(row["excited_by"]) for row in rows],
    "margin": lambda rows: [long_margin(row) for row in rows],
}


def _cost_line(document: Mapping[str, Any]) -> str:
    """Wall time, the part of it that the page and the report divide into stages, memory."""
    computing = duration_text(document["computing_seconds"])
    spent, memory = duration_text(document["seconds"]), f"{document['peak_memory_gib']:.2f} GiB"
    return f"time {spent} (computing {computing}), {memory}"
