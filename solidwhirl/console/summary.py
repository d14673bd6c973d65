"""The end of a run: a table of the results that matter, or the same as one JSON document."""

from __future__ import annotations

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
from solidwhirl.console.terminal import RUN_SCHEMA, duration_text
from solidwhirl.core.blocks import motion_text
from solidwhirl.core.check_report import checks_line, failed, failure_lines
from solidwhirl.core.warnings import warnings_of
from solidwhirl.pipeline.verdict_text import answers, margin_words, percent_text
from solidwhirl.scene_checks.operating import (
    critical_speeds_that_count,
    excited_critical_speeds,
    margin_of,
    nearest,
)

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import Results

_MOST_ROWS = 12
# Kinds of analyses whose headline the verdict has.
_ANSWERED = ("separation_margins", "stability")
_KEYS = (
    *("speed_rpm", "frequency_hz", "frequency_error_estimate", "whirl", "kind", "shares"),
    *("log_decrement", "amplification_factor", "critically_damped", "shafts", "exciters"),
    *("excited_by", "excited", "excited_why"),
)
_WIDTH_WITHOUT_TERMINAL = 110
# Characters that no table is as wide as.
_UNLIMITED = 10_000
# Colours of all pictures, see rotordyn/plots/frame.py.
_COLOURS = {"forward": "#0072B2", "backward": "#D55E00"}
_OTHER_COLOUR = "#999999"
# Files of a run that are worth naming, and what they are.
_FILES = (
    ("Campbell plot", "campbell.png"),
    ("page", "report.html"),
    ("report", "report.md"),
    ("results", "results.json"),
)


def print_summary(results: Results, document: Mapping[str, Any]) -> None:
    """Print what matters of a run, and where its files are.

    `document`: from `summary_document`.
    """
    width = None if sys.stdout.isatty() else _WIDTH_WITHOUT_TERMINAL
    console = Console(width=width, highlight=False)
    console.print(Text(results.scene.title or results.scene.name, style="bold"))
    for about, text, good in answers(document):
        said = Text(f"{about[0].lower()}{about[1:]}: ")
        console.print(said.append(text, style={True: "green", False: "red", None: ""}[good]))
    console.print(fitting_table(document["critical_speeds"], console, results.operating))
    for name, outcome in results.analyses.items():
        if outcome.headline and outcome.kind not in _ANSWERED:
            console.print(Text(f"{name}: {outcome.headline}"))
    console.print(Text(f"checks: {checks_line(results.checks)}"))
    computing = duration_text(document["computing_seconds"])
    spent, memory = duration_text(document["seconds"]), f"{document['peak_memory_gib']:.2f} GiB"
    console.print(Text(f"time {spent} (computing {computing}), {memory}"))
    for title, name in _FILES:
        if name in document["files"]:
            console.print(Text(f"{title}: {Path(document['folder'], name)}"), soft_wrap=True)


def warning_texts(document: Mapping[str, Any]) -> list[str]:
    """Return the warnings of a run, and that its accuracy is not met, each once.

    `document`: the contents of `results.json`.
    """
    from solidwhirl.estimates.documents import followed_by  # loads the mesher

    found = document["accuracy"]
    missed = found["met"] is False and found["largest_error_estimate"] is not None
    line = (
        f"accuracy not met: estimated error "
        f"{percent_text(found['largest_error_estimate'])}, asked {percent_text(found['asked'])}"
    )
    if found["rounds"] and found["rounds"][-1]["stopped"]:
        last = len(found["rounds"])
        line += f"; refinement {followed_by(found['rounds'], last - 1)} after round {last}"
    return [*warnings_of(document), *([line] if missed else [])]


def summary_document(
    results: Results, document: Mapping[str, Any], out: Path, *, seconds: float
) -> dict[str, Any]:
    """What matters of a run as plain data; units in the keys, absent values are null.

    `document`: the contents of `results.json`. `seconds`: wall time [s].
    """
    bad = failed(results.checks)
    return {
        "schema": RUN_SCHEMA,
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
        "critical_speeds": [
            {key: entry.get(key) for key in _KEYS} | _margin(entry, results.operating)
            for entry in document["critical_speeds"]
        ],
        "analyses": {name: outcome.headline for name, outcome in results.analyses.items()},
        "checks": {
            "passed": sum(check.passed is True for check in results.checks),
            "failed": len(bad),
            "not_decided": sum(check.passed is None for check in results.checks),
            "failures": list(failure_lines(results.checks)),
        },
        "doubts": warnings_of(document),
        "seconds": seconds,
        "computing_seconds": sum(results.timings_s.values()),
        "peak_memory_gib": results.peak_memory_gib,
    }


def _margin(entry: Mapping[str, Any], operating: Sequence[Operating]) -> dict[str, Any]:
    found = margin_of(entry["speed_rpm"], entry["shafts"], operating)
    return dict(zip(("margin", "margin_of"), found or (None, None), strict=True))


def fitting_table(
    every: list[dict[str, Any]], console: Console, operating: Sequence[Operating]
) -> Table | Text:
    """The critical speeds that unbalance excites, with as much as the console has room for."""
    found = critical_speeds_that_count({"critical_speeds": every})
    rows = excited_critical_speeds({"critical_speeds": every})
    others = (
        (len(found) - len(rows), "not excited by unbalance"),
        (len(every) - len(found), "critically damped"),
    )
    left_out = [f"{count} {what}" for count, what in others if count]
    if not rows:
        return Text("; ".join(["no critical speed in the speed range", *left_out]))
    shown = nearest(rows, operating, _MOST_ROWS)[0]
    columns = dict(_COLUMNS)
    for name, key in (("margin", "margin"), ("AF", "amplification_factor")):
        if all(row[key] is None for row in rows):
            del columns[name]
    same = len({tuple(row["excited_by"]) for row in shown}) == 1
    unlimited = console.options.update(width=_UNLIMITED)
    first = ("excited by",) if same else ()
    for name in ("", "shorter margin", *first, "log\ndecr.", "error\n[%]", "excited by", "AF"):
        if name == "shorter margin" and "margin" in columns:
            columns["margin"] = _short_margin
        columns.pop(name, None)
        table = _table(columns, shown)
        if Measurement.get(console, unlimited, table).maximum <= console.width:
            break
    more = len(rows) - len(shown)
    said = [*([f"{more} more"] if more else []), *left_out]
    if said:
        table.caption = f"and {', '.join(said)}, see the report"
    return table


def _table(
    columns: Mapping[str, Callable[[Mapping[str, Any]], str | Text]],
    rows: Sequence[Mapping[str, Any]],
) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for head in columns:
        left = head in ("whirl", "excited by", "margin")
        table.add_column(Text(head), justify="left" if left else "right", no_wrap=left)
    for row in rows:
        table.add_row(*(cell(row) for cell in columns.values()))
    return table


def _whirl_text(row: Mapping[str, Any]) -> Text:
    return Text(motion_text(row), style=_COLOURS.get(row["whirl"], _OTHER_COLOUR))


def _number_text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


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
_COLUMNS: Mapping[str, Callable[[Mapping[str, Any]], str | Text]] = {
    "speed\n[rpm]": lambda row: f"{row['speed_rpm']:.0f}",
    "frequency\n[Hz]": lambda row: f"{row['frequency_hz']:.2f}",
    "error\n[%]": lambda row: percent_text(row["frequency_error_estimate"]).removesuffix(" %"),
    "whirl": _whirl_text,
    "log\ndecr.": lambda row: _number_text(row["log_decrement"]),
    "AF": lambda row: _number_text(row["amplification_factor"]),
    "excited by": lambda row: ", ".join(row["excited_by"]),
    "margin": long_margin,
}
