"""Predict measured machines and write docs/measured.md.

`python tools/measured` runs the scenes in scenes/measured with the readings of cases.toml; what
is changed there is what the sources leave open, and nothing is fitted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.core.blocks import numbers
from solidwhirl.drawing.modes import shown_modes
from solidwhirl.output.documents import results_document
from solidwhirl.output.plan_text import table
from solidwhirl.pictures.catalogue import pictures_of
from solidwhirl.pictures.engine_shape import engine_shape
from solidwhirl.pictures.stills import draw_mode_still
from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.scene_reading.paths import find_target, with_values

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from measured.identified import identified_sections  # noqa: E402
from measured.scenes import CASES, run_of, scene_name, scene_of  # noqa: E402
from measured.spinning import spinning_sections  # noqa: E402

PAGE, PICTURES = ROOT / "docs" / "measured.md", ROOT / "docs" / "measured"
DATA = ROOT / "docs" / "data" / "measured.json"
#: Modes of each machine that are drawn
_DRAWN = 3
#: Change of a parameter whose effect is told
_STEP = 0.02

HEAD = """# Measured machines

Predictions of machines that others built and measured, with parameters of their sources alone.
`make measured` runs the scenes in `scenes/measured` and writes this page; what
was measured, and the readings of what a source leaves open, stand in
[cases.toml](../tools/measured/cases.toml), all numbers of this page in
[data/measured.json](data/measured.json). No prediction was fitted to a measured frequency. No
source states the uncertainty of its measurements.

*Predicted* is what the scene says; *error* is estimated by the run ([accuracy](accuracy.md)) and
says nothing of inputs. *Span* is from the lowest to the highest prediction of all readings, widened
by their errors: measured values inside it need no other explanation than what the source left open.
How wide it is beside the measured value stands there too: inside a wide span says little.
"""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """What one reading of a machine gives."""

    reading: str
    results: Results
    frequency_hz: FloatArray  #: (m,) of the measured modes, at rest
    error: FloatArray  #: (m,) relative, estimated


def predicted(case: Mapping[str, Any], reading: str, data: dict[str, Any]) -> Prediction:
    """Run a scene of a case."""
    print(f"{case['name']}: {reading}", file=sys.stderr, flush=True)
    results = run_of(data)
    found = results_document(results)["modes_at_rest"]
    hz, error = (numbers(found[k]) for k in ("frequency_hz", "frequency_error_estimate"))
    modes = case["modes"]
    return Prediction(reading=reading, results=results, frequency_hz=hz[modes], error=error[modes])


def sensitivities(case: Mapping[str, Any], base: Prediction) -> Iterator[tuple[str, FloatArray]]:
    """Yield the change of every frequency with a parameter, relative over relative."""
    data = scene_of(case, case)
    for effect in case["effects"]:
        target = find_target(data, effect["place"])
        more = with_values(data, {target: target.nominal * (1.0 + _STEP)})
        changed = predicted(case, f"{effect['name']} + {_STEP:.0%}", more)
        yield effect["name"], np.log(changed.frequency_hz / base.frequency_hz) / np.log1p(_STEP)


def chart_of(case: Mapping[str, Any], runs: Sequence[Prediction]) -> charts.Chart:
    """Draw the differences of all readings from what was measured, with their errors."""
    measured = numbers(case["measured_hz"])
    places = np.arange(len(measured), dtype=float)
    parts: list[charts.Mark] = [charts.Rule(at=0.0, along="y", name="measured")]
    for number, run in enumerate(runs):
        off = 100.0 * (run.frequency_hz / measured - 1.0)
        look = replace(charts.series_look(number), dash="", size=8.0)
        shift = 0.12 * (number - (len(runs) - 1) / 2.0)
        bars = 100.0 * run.error * run.frequency_hz / measured
        parts.append(charts.Curve(x=places + shift, y=off, name=run.reading, look=look,
                                  errors=bars, errors_along="y"))  # fmt: skip
    names = [f"{hz:g} Hz" for hz in measured]
    return charts.Chart(
        name="differences",
        title="Predicted against measured",
        x=charts.Axis(label="measured mode", places=names),
        y=charts.Axis(label="predicted over measured, less 1", unit="%"),
        parts=parts,
    )


def case_section(case: Mapping[str, Any]) -> tuple[list[str], dict[str, Any]]:
    """Return the part of the page about a case, and its numbers."""
    base = predicted(case, case["first"], scene_of(case, case))
    runs = [base, *(predicted(case, v["name"], scene_of(case, v)) for v in case["variants"])]
    folder = PICTURES / case["name"]
    folder.mkdir(parents=True, exist_ok=True)
    draw_charts([chart_of(case, runs)], folder / "differences.png", case["title"])
    drawn = list(pictures_in(case, base.results, folder))
    effects = dict(sensitivities(case, base))
    names = [r.reading for r in runs]
    scene = scene_name(case)
    lines = [
        f"## {case['title']}",
        f"Source: {case['source']}. Scene: [{scene}](../scenes/measured/{scene}.toml).",
        case["open"],
        *drawn[:1],
        _span_table(case, runs),
        f"Predicted: {case['first']}. Readings of the span: {'; '.join(names)}.",
        f"![Differences of all readings](measured/{case['name']}/differences.png)",
        *drawn[1:],
        *([_effect_table(effects, len(base.frequency_hz))] if effects else []),
        case["why"],
    ]
    record = {
        "measured_hz": numbers(case["measured_hz"]).tolist(),
        "readings": {
            r.reading: {
                "frequency_hz": r.frequency_hz.tolist(),
                "frequency_error_estimate": r.error.tolist(),
            }
            for r in runs
        },
        "sensitivity": {name: v.tolist() for name, v in effects.items()},
    }
    return lines, record


def _span_table(case: Mapping[str, Any], runs: Sequence[Prediction]) -> str:
    """Each mode as measured, as the first reading has it, and the span of all readings."""
    head = (
        "mode | measured [Hz] | predicted [Hz] | error [%] | difference [%] | span [Hz] "
        "| measured inside, span [%]"
    )
    low = np.min([r.frequency_hz * (1.0 - r.error) for r in runs], axis=0)
    high = np.max([r.frequency_hz * (1.0 + r.error) for r in runs], axis=0)
    rows = []
    for k, measured in enumerate(case["measured_hz"]):
        ours, error = runs[0].frequency_hz[k], runs[0].error[k]
        rows.append(
            (
                f"{k + 1}{' (doubtful)' if k + 1 in case.get('doubtful', ()) else ''}",
                f"{measured:g}",
                f"{ours:.4g}",
                f"{100 * error:.2g}",
                f"{100 * (ours / measured - 1):+.1f}",
                f"{low[k]:.4g} to {high[k]:.4g}",
                ("yes, " if low[k] <= measured <= high[k] else "no, ")
                + f"{100 * (low[k] / measured - 1):+.1f} to {100 * (high[k] / measured - 1):+.1f}",
            )
        )
    return table(head, rows, str)


def _effect_table(effects: Mapping[str, FloatArray], modes: int) -> str:
    head = ["change of a frequency in %, by 1 % of", *(f"mode {k + 1}" for k in range(modes))]
    rows = ([name, *(f"{x:+.2f}" for x in values)] for name, values in effects.items())
    return table(" | ".join(head), rows, str)


def pictures_in(case: Mapping[str, Any], results: Results, folder: Path) -> Iterator[str]:
    """Draw a machine and its lowest measured modes; yield the Markdown that shows them."""
    named = [f"mesh_{body}" for body in results.scene.mesh_bodies] or ["engine"]
    for drawing in (p for p in pictures_of(results) if p.name in named):
        drawing.draw(folder / "drawing.png")
        yield f"![{drawing.caption}](measured/{folder.name}/drawing.png)"
    at_rest = shown_modes(results)[0]
    for number, mode in enumerate(case["modes"][:_DRAWN], start=1):
        path = folder / f"mode_{number}.png"
        shape = engine_shape(results, at_rest, mode)
        draw_mode_still(shape, path, f"{case['title']}, mode {number}")
        yield f"![Mode {number}](measured/{folder.name}/{path.name})"


def main() -> None:
    """Run all cases and write the page."""
    lines, data = [HEAD], dict[str, Any]()
    for case in CASES:
        section, data[case["name"]] = case_section(case)
        lines += section
    for name, part in (("spinning", spinning_sections), ("identified", identified_sections)):
        section, data[name] = part(PICTURES)
        lines += section
    replace_text(DATA, json.dumps(data, indent=1) + "\n")
    replace_text(PAGE, "\n\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
