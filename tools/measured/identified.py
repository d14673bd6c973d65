"""What measured frequencies say of parameters that their sources leave open."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from measured.scenes import ROOT, STORE

from solidwhirl.identify.record import document, value_lines
from solidwhirl.identify.run import identify, read_problem
from solidwhirl.output.plan_text import table
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

PROBLEMS = ROOT / "scenes" / "identify"
#: Problem files and what their results mean
CASES = {
    "dtu_shaft": """The second frequency is too high by as much as the third is too low, and no
modulus mends both: either the frequencies are known less well than assumed, or the shaft is not the
one drawn. The fourth agrees all the same; one agreement proves little.""",
    "magnetic_rotor": """A clamping between the two readings explains all four frequencies: the hubs
are neither free to bend with the shaft nor rigid with it over their seats. The lines of the
recording are 0.25 Hz apart; were that the only uncertainty (a standard deviation of 0.07 Hz), no
clamping would fit.""",
    "magnetic_rotor_open": """The same with steel and diameter of the shaft open too, which were
taken as known above. Frequencies go with the root of the modulus and nearly with the square of the
radius, so that one can be had for the other, and both for the clamping: the values above hold as
far as the source's shaft does. The search ends at a bound, which the data did not choose. Weighing
the shaft would settle the radius.""",
}
HEAD = """## Parameters from these frequencies

The predictions above fit nothing. Here [identification](identify.md#measurements) asks what the
frequencies say of what the sources left open: values with intervals of 95 %, whether the model can
fit at all within the uncertainty, what the data can not tell apart, and whether a mode that was
kept aside is predicted."""


def identified_sections(folder: Path) -> tuple[list[str], dict[str, Any]]:
    """Return the part of the page about identified parameters, and its numbers."""
    data = {name: _found(name) for name in CASES}
    draw_charts([_chart(data)], folder / "identified.png", "Identified models against measurements")
    return list(lines_of(data)), data


def lines_of(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the part of the page from its numbers."""
    yield HEAD
    yield "![Model less measurement, in standard deviations](measured/identified.png)"
    for name, meaning in CASES.items():
        yield from _section(name, data[name])
        yield meaning


def _found(name: str) -> dict[str, Any]:
    """Identify, and return of the record what the page shows."""
    print(f"identify: {name}", file=sys.stderr, flush=True)
    found = identify(read_problem(PROBLEMS / f"{name}.toml"), store=STORE)
    record = document(found)
    aside = {one["name"]: one for one in record["statistics"]["kept_aside"]}
    of_target = ("name", "value", "uncertainty", "reached", "use")
    of_parameter = ("name", "value", "plus_minus", "lower", "upper", "at_bound", "why")
    return {
        "title": record["problem"]["title"],
        "notes": record["problem"]["notes"],
        "targets": [
            {key: t[key] for key in of_target} | {"standard_deviations": _deviation(t, aside)}
            for t in record["targets"]
        ],
        "parameters": [{key: p[key] for key in of_parameter} for p in record["parameters"]],
        "statistics": record["statistics"],
        "said": [t for t in value_lines(found) if "apart" in t or "uncertainties" in t],
    }


def _section(name: str, found: Mapping[str, Any]) -> Iterator[str]:
    own = found["statistics"]
    yield f"### {found['title']}"
    yield f"Problem: [{name}](../scenes/identify/{name}.toml). {' '.join(found['notes'])}"
    parameters = (
        (
            p["name"],
            f"{p['value']:.4g}",
            "unknown" if p["plus_minus"] is None else f"{p['plus_minus']:.2g}",
            f"{p['lower']:g} to {p['upper']:g}",
            p["at_bound"] or "",
            p["why"],
        )
        for p in found["parameters"]
    )
    yield table("parameter | value | ± | bounds | at bound | what it is", parameters, str)
    targets = (
        (
            t["name"],
            f"{t['value']:g}",
            f"{t['uncertainty']:g}",
            f"{t['reached']:.4g}",
            f"{100 * (t['reached'] / t['value'] - 1):+.2f}",
            f"{t['standard_deviations']:+.1f}",
            "fitted" if t["use"] == "fit" else "kept aside",
        )
        for t in found["targets"]
    )
    head = (
        "mode | measured [Hz] | standard deviation [Hz] | model [Hz] | difference [%] "
        "| in standard deviations | use"
    )
    yield table(head, targets, str)
    freedom = own["degrees_of_freedom"]
    chance = f", probability {own['probability']:.2g}" if own["probability"] is not None else ""
    yield (
        f"Sum of squared deviations {own['chi_squared']:.2g} with {freedom} degrees of freedom"
        f"{chance}."
    )
    if len(found["parameters"]) > 1:
        yield _correlations(found)
    yield from (f"**{line[0].upper()}{line[1:]}.**" for line in found["said"])


def _correlations(found: Mapping[str, Any]) -> str:
    names = [p["name"] for p in found["parameters"]]
    rows = zip(names, found["statistics"]["correlation"], strict=True)
    cells = ((name, *(f"{value:+.3f}" for value in row)) for name, row in rows)
    return table(" | ".join(["correlation", *names]), cells, str)


def _deviation(target: Mapping[str, Any], aside: Mapping[str, Mapping[str, float]]) -> float:
    """Model less measurement in standard deviations: of both where it was kept aside."""
    if target["name"] in aside:
        return float(aside[target["name"]]["standard_deviations"])
    return float((target["reached"] - target["value"]) / target["uncertainty"])


def _chart(data: Mapping[str, Any]) -> charts.Chart:
    """Draw deviations of each mode; marks of those kept aside are open."""
    parts: list[charts.Mark] = [charts.Rule(at=float(at), along="y") for at in (-2, 0, 2)]
    for number, (name, found) in enumerate(data.items()):
        for use, mark, text in (("fit", "circle", ""), ("check", "circle-open", ", kept aside")):
            shown = [k for k, t in enumerate(found["targets"]) if t["use"] == use]
            if shown:
                y = np.array([found["targets"][k]["standard_deviations"] for k in shown])
                look = charts.Look(f"@c{number}", "", mark, size=9.0)
                x = np.array(shown) + 0.12 * (number - 1.0)
                parts.append(charts.Curve(x=x, y=y, name=name + text, look=look))
    return charts.Chart(
        name="identified",
        title="Model less measurement",
        x=charts.Axis(label="mode", places=[f"f{k}" for k in range(1, 5)]),
        y=charts.Axis(label="in standard deviations"),
        parts=parts,
    )
