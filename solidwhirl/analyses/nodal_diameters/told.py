"""Charts and tables of an analysis of nodal diameters, from its document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.analyses.base import Engine, reference_ranges_rad_s
from solidwhirl.analyses.nodal_diameters.results import crossing_text, operating_of
from solidwhirl.analyses.nodal_diameters.shapes import DIRECTIONS, turning_modes
from solidwhirl.core.blocks import (
    AnalysisBlock,
    Table,
    Text,
    margin_words,
    numbers,
    warning,
    whirl_text,
)
from solidwhirl.rotordyn import nodal_diameters as nd
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.plots import nodal_diameters as charts
from solidwhirl.rotordyn.plots.chart import Chart

Document = Mapping[str, Any]
# Rows of a table that is shown whole.
_MOST = 12
# Of a line that shows where further engine orders would be.
_ORDERS = 200


def campbell_view(document: Document, engine: Engine) -> charts.BladeCampbell:
    """Return what the diagrams over the speed show."""
    families = []
    for k, (index, standing) in enumerate(
        zip(document["nodal_diameter"], document["standing"], strict=True)
    ):
        for direction in ("backward",) if standing else ("backward", "forward"):
            families.append(
                charts.FamilyCurves(
                    index=index,
                    direction="standing" if standing else direction,
                    frequency_hz=numbers(document["frequency_hz"][direction][k]),
                    error=numbers(document["frequency_error_estimate"][direction][k]),
                )
            )
    orders: dict[int, list[int]] = {}
    for order in document["engine_orders"]:
        orders.setdefault(nd.excited_index(order, document["sectors"])[0], []).append(order)
    return charts.BladeCampbell(
        rpm=numbers(document["speed_rpm"]),
        speed_ratio=_ratio(document),
        families=families,
        crossings=[
            charts.CrossingMark(
                engine_order=c["engine_order"],
                index=c["nodal_diameter"],
                rpm=c["speed_rpm"],
                hertz=c["frequency_hz"],
                text=_crossing_lines(c),
                is_near=c["too_near"],
            )
            for c in document["crossings"]
        ],
        engine_orders=orders,
        operating_rad_s=reference_ranges_rad_s(operating_of(engine, document["body"])),
    )


def _ratio(document: Document) -> float:
    return float(document["body_speed_rpm"][-1] / document["speed_rpm"][-1])


def _crossing_lines(crossing: Document) -> str:
    text = crossing_text(crossing)
    if crossing["margin"] is None:
        return text
    return f"{text}\n{margin_words(crossing['margin'])} the {crossing['operating']}"


def interference_view(document: Document) -> charts.Interference:
    """Return what the interference diagram shows."""
    found, sectors = document["interference"], document["sectors"]
    body_rad_s = _ratio(document) * found["speed_rpm"] * RAD_S_PER_RPM
    orders = document["engine_orders"]
    turn = body_rad_s * nd.HZ_PER_RAD_S
    standing = np.array(document["standing"])
    own = {d: numbers(found["frequency_hz"][d]) for d in DIRECTIONS}
    by_direction: dict[str, FloatArray] = {
        d: np.where(standing[:, None], np.nan, hertz) for d, hertz in own.items()
    }
    by_direction["standing"] = np.where(standing[:, None], own["backward"], np.nan)
    return charts.Interference(
        rpm=found["speed_rpm"],
        index=document["nodal_diameter"],
        frequency_hz=by_direction,
        zigzag=nd.zigzag(sectors, max(*orders, _to_the_top(own, turn)), body_rad_s),
        engine_orders=[(e, nd.excited_index(e, sectors)[0], e * turn) for e in orders],
    )


def _to_the_top(own: Mapping[Any, FloatArray], turn_hz: float) -> int:
    """The engine order at the highest frequency, as far as a line can be told from the next one."""
    highest = max((float(np.nanmax(f, initial=0.0)) for f in own.values()), default=0.0)
    return min(int(1.2 * highest / turn_hz), _ORDERS) if turn_hz > 0.0 else 0


def amplification_view(document: Document) -> Chart:
    """Return the distribution of the amplification of random patterns."""
    found = document["mistuning"]
    own = found["amplification"]
    return charts.amplification_chart(numbers(own["factors"]), own["quantiles"], found["bound"])


def blocks_of(document: Document, engine: Engine, record: Mapping[str, Any]) -> list[AnalysisBlock]:
    """Return what a page tells: crossings, diagrams, shapes, mistuning, and all frequencies.

    `record`: the arrays of the analysis' file.
    """
    view = campbell_view(document, engine)
    near = [c for c in document["crossings"] if c["too_near"]]
    has_probe = document["fixed_frame_hz"] is not None
    blocks: list[AnalysisBlock] = [
        *warning([_crossing_lines(c).replace("\n", ", ") for c in near]),
        charts.blade_campbell_chart(view),
        *_crossing_table(document),
        charts.interference_chart(interference_view(document)),
        *([charts.fixed_frame_chart(view, document["sectors"])] if has_probe else []),
        turning_modes(document, record),
        *_veering_table(document["veerings"]),
        *_mistuning_blocks(document),
        _frequency_table(document),
    ]
    if document["notes"]:
        blocks.append(Text(text="\n".join(f"- {note}" for note in document["notes"]), kind="note"))
    return blocks


def _direction(word: str) -> str:
    return whirl_text(None if word == "standing" else word).replace("none", "standing")


def _crossing_table(document: Document) -> list[Table]:
    found = document["crossings"]
    if not found:
        return []
    is_long = len(found) > _MOST
    title = "Engine orders that meet modes"
    return [
        Table(
            title="" if is_long else title,
            folded=f"{title} ({len(found)})" if is_long else "",
            head=[
                *("engine order", "nodal diameter", "wave", "mode", "reference shaft [rpm]"),
                *("body [rpm]", "frequency [Hz]", "error [%]", "from operating speed"),
            ],
            rows=[
                [
                    str(c["engine_order"]),
                    str(c["nodal_diameter"]),
                    _direction(c["direction"]),
                    str(c["mode"]),
                    f"{c['speed_rpm']:.1f}",
                    f"{c['body_speed_rpm']:.1f}",
                    c["frequency_hz"],
                    _percent(c["frequency_error_estimate"]),
                    None if c["margin"] is None else margin_words(c["margin"]),
                ]
                for c in found
            ],
            caption=f"Nearer than {document['margin_percent']:g} % to an operating speed is too "
            "near. The frequency is that on the body.",
        )
    ]


def _percent(error: float | None) -> str | None:
    return None if error is None else f"{100.0 * error:.2g}"


def _veering_table(found: Sequence[Document]) -> list[Table]:
    if not found:
        return []
    return [
        Table(
            folded=f"Modes of one nodal diameter that come close ({len(found)})",
            head=[
                *("nodal diameter", "wave", "modes", "they", "reference shaft [rpm]"),
                *("frequency [Hz]", "smallest distance [Hz]", "exchange of shapes (MAC)"),
            ],
            rows=[
                [
                    str(v["nodal_diameter"]),
                    _direction(v["direction"]),
                    " and ".join(str(k) for k in v["modes"]),
                    "cross" if v["kind"] == "crossing" else "veer",
                    f"{v['speed_rpm']:.1f}",
                    v["frequency_hz"],
                    v["gap_hz"],
                    f"{v['exchanged']:.3f}",
                ]
                for v in found
            ],
        )
    ]


def _mistuning_blocks(document: Document) -> list[AnalysisBlock]:
    found = document["mistuning"]
    if found is None:
        return []
    where = "where they meet" if found["at_crossing"] else "at the last speed"
    tuned = numbers(found["tuned_hz"])
    text = (
        f"**Mistuned blades**: mode {found['mode']} under engine order {found['engine_order']}, "
        f"{where}, {found['speed_rpm']:.1f} rpm; damping ratio {found['damping_ratio']:g}. The "
        f"tuned family lies from {tuned.min():.5g} to {tuned.max():.5g} Hz"
    )
    neighbour = found["neighbour_hz"]
    text += "." if neighbour is None else f", the nearest other mode at {neighbour:.5g} Hz."
    pattern = found["pattern"]
    blocks: list[AnalysisBlock] = [Text(text=text)]
    if found["amplification"] is not None:
        own = found["amplification"]
        rows = [[f"{name} of the patterns stay below", v] for name, v in own["quantiles"].items()]
        rows += [["worst pattern", own["worst"]], ["bound (1 + √N) / 2", found["bound"]]]
        head = ["amplification factor", f"of {len(own['factors'])} patterns [1]"]
        blocks += [amplification_view(document), Table(head=head, rows=rows)]
    which = "the worst pattern" if found["amplification"] is not None else "the given pattern"
    blades = zip(pattern["deviations"], pattern["blade_amplification"], pattern["peak_hz"],
                 strict=True)  # fmt: skip
    blocks.append(
        Table(
            folded=f"Blades of {which} ({len(tuned)})",
            head=["blade", "deviation of its frequency [%]", "amplification [1]", "at [Hz]"],
            rows=[[str(k + 1), 100.0 * d, a, f] for k, (d, a, f) in enumerate(blades)],
        )
    )
    return blocks


def _frequency_table(document: Document) -> Table:
    """One row for each nodal diameter, direction and mode at the first and the last speed."""
    found, errors = document["frequency_hz"], document["frequency_error_estimate"]
    roots = document["root_stress"]
    rows = []
    for k, index in enumerate(document["nodal_diameter"]):
        for direction in DIRECTIONS[:1] if document["standing"][k] else DIRECTIONS:
            for mode in range(len(found[direction][k][0])):
                for at in (0, -1):
                    row = [
                        str(index),
                        _direction("standing" if document["standing"][k] else direction),
                        str(mode + 1),
                        f"{document['speed_rpm'][at]:.1f}",
                        found[direction][k][at][mode],
                        _percent(errors[direction][k][at][mode]),
                    ]
                    for own in (roots or {}).values():
                        row.append(_mpa_per_mm(own[direction][k][at][mode]))
                    rows.append(row)
    head = [
        *("nodal diameter", "wave", "mode", "reference shaft [rpm]", "frequency [Hz]"),
        *("error [%]", "root stress, nominal [MPa/mm]", "in elements [MPa/mm]")[
            : 3 if roots else 1
        ],
    ]
    caption = "In the frame that turns with the body."
    if roots:
        caption += (
            " Stress amplitudes are those of 1 mm of the largest displacement. Nominal is the "
            "normal stress of axial force and bending moment over the section where the blade "
            "meets its carrier, by equilibrium with the blade's inertia; a notch factor goes on "
            "top of it. That in elements is the largest von Mises stress inside of those at the "
            "root: at a sharp edge it grows with every finer mesh."
        )
    return Table(
        folded=f"Frequencies at the first and the last speed ({len(rows)})",
        head=head,
        rows=rows,
        caption=caption,
    )


def _mpa_per_mm(stress_pa_per_m: float | None) -> float | None:
    return None if stress_pa_per_m is None else 1e-9 * stress_pa_per_m
