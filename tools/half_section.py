"""Draw docs/half_section.png: the words of a scene file on a half-section of two rotors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from solidwhirl.rotordyn.plots.frame import SMALL_PT, TEXT_PT, picture

TARGET = Path(__file__).resolve().parents[1] / "docs" / "half_section.png"
# Sections (name, start, end, inner and outer radius) by body and its colour.
BODIES = {
    "inner": ("#BBD4E8", [("shaft", 0.0, 9.0, 0.0, 0.5), ("disk", 2.0, 2.8, 0.5, 3.0)]),
    "outer": ("#F2D5B8", [("sleeve", 5.0, 8.2, 1.1, 1.5), ("rim", 6.0, 6.7, 1.5, 3.4)]),
}
BLUE, RED = "#0072B2", "#D55E00"
# Interfaces: label, line from and to, where the label stands.
INTERFACES = (
    ('interface\nkind = "section"', (0.4, 0.0), (0.4, 0.5), (-0.6, 1.7)),
    ('kind = "slab"', (3.6, 0.5), (4.2, 0.5), (3.9, 1.7)),
    ('kind = "face"', (9.0, 0.0), (9.0, 0.5), (9.6, 1.3)),
    ('kind = "outer"', (7.3, 1.5), (7.9, 1.5), (9.3, 3.0)),
    ('kind = "inner"', (5.3, 1.1), (5.9, 1.1), (4.8, 3.0)),
)


def main() -> None:
    """Write the picture."""
    title = "A scene on the half-section of two rotors"
    with picture(TARGET, title, 105.0) as (_, axes):
        for name, (color, sections) in BODIES.items():
            for section, start, end, inner, outer in sections:
                axes.fill([start, end, end, start], [inner, inner, outer, outer], color=color,
                          edgecolor="black", linewidth=0.8)  # fmt: skip
                place = 0.5 * (start + end) + (section == "shaft")
                axes.text(place, 0.5 * (inner + outer), section, ha="center", va="center",
                          fontsize=SMALL_PT)  # fmt: skip
            last = sections[-1]
            ratio = {"inner": "1.0", "outer": "-1.2"}[name]
            axes.text(0.5 * (last[1] + last[2]), last[4] + 0.3,
                      f"[bodies.{name}]\nspeed_ratio = {ratio}", ha="center", va="bottom",
                      fontsize=TEXT_PT)  # fmt: skip
        for label, start, end, place in INTERFACES:
            axes.plot(*zip(start, end, strict=True), color=BLUE, linewidth=3.5)
            axes.annotate(label, (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])), place,
                          color=BLUE, fontsize=SMALL_PT, ha="center",
                          arrowprops={"arrowstyle": "-", "color": BLUE})  # fmt: skip
        axes.fill([3.6, 4.2, 4.2, 3.6], [0.0, 0.0, 0.5, 0.5], color=BLUE, alpha=0.4)
        spring(axes, 0.4, -0.05, -1.0, ground=True)
        axes.text(0.65, -0.65, '[[bearings]]  first = "inner.front"\nsecond = "ground"',
                  color=RED, fontsize=SMALL_PT, va="center")  # fmt: skip
        spring(axes, 5.6, 1.05, 0.55, ground=False)
        axes.annotate('[[bearings]]  first = "inner.middle"\nsecond = "outer.bore"', (5.65, 0.8),
                      (4.9, -0.75), color=RED, fontsize=SMALL_PT, ha="left", va="center",
                      arrowprops={"arrowstyle": "-", "color": RED})  # fmt: skip
        axes.annotate("", (10.4, 0.0), (-1.2, 0.0),
                      arrowprops={"arrowstyle": "->", "linestyle": "-."})  # fmt: skip
        axes.text(10.4, 0.12, "z")
        axes.annotate("outer_radius_m", (2.0, 3.0), (-0.6, 3.2), fontsize=SMALL_PT,
                      arrowprops={"arrowstyle": "-"})  # fmt: skip
        axes.annotate("start_m", (2.0, 1.6), (0.7, 2.5), fontsize=SMALL_PT,
                      arrowprops={"arrowstyle": "-"})  # fmt: skip
        axes.annotate("end_m", (2.8, 1.0), (3.0, 2.2), fontsize=SMALL_PT,
                      arrowprops={"arrowstyle": "-"})  # fmt: skip
        axes.set(xlim=(-1.5, 10.7), ylim=(-1.5, 4.6), aspect="equal")
        axes.set_axis_off()


def spring(axes: Any, z: float, top: float, bottom: float, *, ground: bool) -> None:
    """A zigzag from one radius to another, on hatched ground if there is no second body."""
    steps = [0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0]
    sides = [0.0, 0.0, 0.12, -0.12, 0.12, -0.12, 0.0, 0.0]
    axes.plot([z + s for s in sides], [top + t * (bottom - top) for t in steps], color=RED,
              linewidth=1.2)  # fmt: skip
    if ground:
        axes.plot([z - 0.3, z + 0.3], [bottom, bottom], color=RED, linewidth=2.0)


if __name__ == "__main__":
    main()
