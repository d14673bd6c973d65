"""Section: faces of joints that are pressed together, their pressure and where they lift."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table
from solidwhirl.rotordyn.plots.chart import Axis, Chart, Curve, series_look

_NOTE = (
    "The body spins freely; friction is left out of the pressure, as in Lamé's thick cylinders. "
    "Motions are computed with the face bonded where it is closed at rest."
)


def section(run: Run) -> Section | None:
    """Pressed joints of all bodies; None without any."""
    found = [
        (f"{name}: {' on '.join(reversed(joint['between']))}", joint)
        for name, body in run.document["bodies"].items()
        for joint in body.get("joints", ())
    ]
    if not found:
        return None
    blocks: list[Block] = [_table(found)]
    blocks += [page_chart(_chart(title, joint)) for title, joint in found]
    return Section(name="joints", title="Joints", blocks=blocks, note=_NOTE)


def _table(found: list[tuple[str, Mapping[str, Any]]]) -> Table:
    return Table(
        head=("joint", "speed [rpm]", "mean pressure [MPa]", "lifted part of the face",
              "torque by friction [N m]", "von Mises stress beside it [MPa]", "first lift [rpm]",
              "loose [rpm]"),
        rows=[row for title, joint in found for row in _rows(title, joint)],
        caption="At rest and at the largest speed that is asked of the body. Torque: friction "
        "times pressure times radius over the face, at slip. Stress: mean over the face, in the "
        "first and the second section. Loose: where the last place of the face lifts.",
    )  # fmt: skip


def _rows(title: str, joint: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    speeds = joint["speed_rpm"]
    for k in (0, len(speeds) - 1)[: len(speeds)]:
        yield (
            title if k == 0 else "",
            f"{speeds[k]:.0f}",
            f"{1e-6 * joint['mean_pressure_pa'][k]:.4g}",
            f"{joint['lifted_part'][k]:.3g}",
            f"{joint['torque_n_m'][k]:.4g}",
            ", ".join(f"{1e-6 * s:.4g}" for s in joint["stress_pa"][k]),
            _rpm(joint["lifts_at_rpm"]),
            _rpm(joint["loose_at_rpm"]),
        )


def _rpm(speed: float | None) -> str:
    return "does not" if speed is None else f"{speed:.0f}"


def _chart(title: str, joint: Mapping[str, Any]) -> Chart:
    order = np.argsort(joint["along_m"])
    along = 1e3 * np.array(joint["along_m"])[order]
    speeds = joint["speed_rpm"]
    shown = dict.fromkeys((0, len(speeds) // 2, len(speeds) - 1))
    curves = [
        Curve(
            x=along,
            y=1e-6 * np.array(joint["pressure_pa"][k])[order],
            name=f"{speeds[k]:.0f} rpm",
            look=series_look(number),
        )
        for number, k in enumerate(shown)
    ]
    plane = joint["interference_m"] is None
    return Chart(
        name=f"joint-{title.replace(': ', '-').replace(' ', '-')}",
        title=f"Contact pressure, {title}",
        caption="Zero where the face has lifted. Where one part ends on the other, the pressure "
        "has a peak that grows with the fineness of the mesh.",
        alt=f"Contact pressure along the face of {title} at rest and at speed.",
        x=Axis(label="r" if plane else "z", unit="mm", digits=".4g"),
        y=Axis(label="contact pressure", unit="MPa", low=0.0, digits=".4g"),
        parts=curves,
    )
