"""Draw the figures of docs/theory.md: what a formula means, in one style, from formulas alone."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "theory"
# Colours and strokes mean the same as in all pictures of the program.
FORWARD, BACKWARD, GREY, LIGHT = "#0072B2", "#D55E00", "#666666", "#DDE3E8"
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "savefig.facecolor": "white",
    "svg.hashsalt": "solidwhirl",
}
MERIDIAN = np.array(
    [(0, 0), (0, 0.6), (1.6, 0.6), (1.6, 2.2), (2.2, 2.2), (2.2, 0.6), (4, 0.6), (4, 0)]
)


def fourier_order(figure: Any) -> None:
    """Meridian of a rotor, and what order 1 makes of a displacement of it."""
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1])
    left.fill(*MERIDIAN.T, facecolor=LIGHT, edgecolor="black")
    left.fill(MERIDIAN[:, 0], -MERIDIAN[:, 1], facecolor="none", edgecolor=GREY, ls=":")
    left.plot([-0.4, 4.6], [0, 0], "k-.", lw=0.8)
    left.annotate("z", (4.65, 0), va="center")
    left.annotate("", (-0.3, 1.4), (-0.3, 0), arrowprops={"arrowstyle": "->"})
    left.annotate("r", (-0.3, 1.5), ha="center")
    left.text(2.6, 1.3, "meridian:\nthe only part\nthat is meshed", ha="left")
    left.set(aspect="equal", title="mesh in z and r")
    left.axis("off")
    angle = np.linspace(0, 2 * np.pi, 200)
    right.plot(np.cos(angle), np.sin(angle), color=GREY, ls=":")
    right.plot(np.cos(angle) + 0.25, np.sin(angle), color="black")
    for k in np.arange(0, 2 * np.pi, np.pi / 6):
        start = np.array([np.cos(k), np.sin(k)])
        end = start + np.array([0.25, 0.0])
        right.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": FORWARD})
    right.text(0.12, 0, "$u_r=a\\,\\cos\\theta$\n$u_\\theta=-a\\,\\sin\\theta$", ha="center")
    right.set(aspect="equal", title="order 1: the section moves sideways")
    right.axis("off")


def frames(figure: Any) -> None:
    """The two frames, and a forward mode in each."""
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.3])
    turn = np.deg2rad(35)
    for angle, colour, names in ((0, "black", ("x", "y")), (turn, FORWARD, ("x'", "y'"))):
        for k, name in enumerate(names):
            way = np.array([np.cos(angle + k * np.pi / 2), np.sin(angle + k * np.pi / 2)])
            arrow = {"arrowstyle": "->", "color": colour}
            left.annotate("", way, (0, 0), arrowprops=arrow)
            left.annotate(name, 1.1 * way, color=colour, ha="center", va="center")
    arc = np.linspace(0, turn, 30)
    left.plot(0.55 * np.cos(arc), 0.55 * np.sin(arc), color=FORWARD)
    left.annotate(r"$\Omega t$", (0.6, 0.17), color=FORWARD)
    left.text(-0.75, -0.2, "black: at rest\nblue: turns with the body", va="top")
    left.set(aspect="equal", xlim=(-1.1, 1.3), ylim=(-0.6, 1.3), title="frames")
    left.axis("off")
    speed = np.linspace(0, 1, 100)
    forward = 0.3 * speed + np.sqrt(1 + 0.09 * speed**2)
    backward = -0.3 * speed + np.sqrt(1 + 0.09 * speed**2)
    thin = {"lw": 0.9, "markevery": 16, "ms": 4}
    right.plot(speed, forward, color=FORWARD, label=r"forward: $\omega$, at rest")
    right.plot(speed, forward - speed, color=FORWARD, marker="o", **thin)
    right.plot(speed, backward, color=BACKWARD, ls="--", label=r"backward: $\omega$, at rest")
    right.plot(speed, backward + speed, color=BACKWARD, ls="--", marker="s", mfc="w", **thin)
    right.annotate(r"$\omega-\Omega$", (0.75, 0.3), color=FORWARD, ha="right")
    right.annotate(r"$\omega+\Omega$", (0.75, 1.72), color=BACKWARD, ha="right")
    right.set(xlabel=r"speed $\Omega$", ylabel=r"frequency $\omega$", xlim=(0, 1), ylim=(0, 2.4))
    right.set_title("marked: as the body sees it")
    right.legend(frameon=False, loc="upper left")


def craig_bampton(figure: Any) -> None:
    """Parts of the basis: constraint modes and fixed-interface modes, and the reduced matrix."""
    axes = figure.subplots(2, 2, width_ratios=[2.2, 1]).T
    place = np.linspace(0, 1, 200)
    ends = axes[0][0]
    for value, colour, ls in ((1 - place, FORWARD, "-"), (place, BACKWARD, "--")):
        ends.plot(place, value, color=colour, ls=ls)
    ends.set(title="constraint modes: one interface moves by 1")
    held = axes[0][1]
    for k, ls in ((1, "-"), (2, "--"), (3, ":")):
        held.plot(place, np.sin(k * np.pi * place), color="black", ls=ls, label=f"{k}")
    held.set(title="fixed-interface modes: the interfaces are held")
    for axis in (ends, held):
        axis.plot([0, 1], [0, 0], "o", color="black", ms=4)
        axis.set(xticks=[], yticks=[])
        axis.spines[["left", "bottom"]].set_visible(False)
    for axis, name, full in ((axes[1][0], "K", False), (axes[1][1], "M", True)):
        _matrix(axis, name, full)


def _matrix(axis: Any, name: str, full: bool) -> None:
    """Shape of a reduced matrix: a full block of the interfaces, a diagonal of the modes."""
    axis.add_patch(_box(0, 3, 2, 2, FORWARD))
    if full:
        axis.add_patch(_box(2, 3, 3, 2, GREY))
        axis.add_patch(_box(0, 0, 2, 3, GREY))
    axis.plot([2, 5], [3, 0], color="black", lw=3)
    axis.add_patch(_box(0, 0, 5, 5, "none"))
    axis.set(aspect="equal", xlim=(-0.2, 5.2), ylim=(-0.2, 5.2), title=f"{name}, reduced")
    axis.axis("off")


def _box(x: float, y: float, width: float, height: float, colour: str) -> Any:
    from matplotlib.patches import Rectangle

    face = "none" if colour == "none" else colour
    return Rectangle((x, y), width, height, facecolor=face, edgecolor="black", alpha=0.6)


def campbell_split(figure: Any) -> None:
    """A rigid disk that tilts: how the gyroscopic moment parts two equal frequencies."""
    axis = figure.subplots()
    speed = np.linspace(0, 2, 200)
    ratio = 1.4  # polar over diametral inertia of the disk
    half = ratio * speed / 2
    forward, backward = half + np.sqrt(half**2 + 1), -half + np.sqrt(half**2 + 1)
    axis.plot(speed, forward, color=FORWARD, label="forward whirl")
    axis.plot(speed, backward, color=BACKWARD, ls="--", label="backward whirl")
    axis.plot(speed, speed, color="black", lw=0.8, label=r"$\omega=\Omega$: unbalance")
    critical = 1 / np.sqrt(1 + ratio)
    axis.plot(critical, critical, "s", mfc="white", mec=BACKWARD)
    axis.annotate(
        "critical speed", (critical, critical), (0.85, 0.25), arrowprops={"arrowstyle": "->"}
    )
    axis.annotate(r"$\to\ \Theta_p/\Theta_d\;\Omega$", (1.45, 2.9), color=FORWARD, ha="right")
    axis.set(xlim=(0, 2), ylim=(0, 3.2))
    axis.set(xlabel=r"speed $\Omega/\omega_0$", ylabel=r"frequency $\omega/\omega_0$")
    axis.legend(frameon=False, loc="upper left")


FIGURES: Mapping[str, tuple[Callable[[Any], None], tuple[float, float]]] = {
    "fourier_order": (fourier_order, (6.3, 2.6)),
    "frames": (frames, (6.3, 2.7)),
    "craig_bampton": (craig_bampton, (6.3, 3.2)),
    "campbell_split": (campbell_split, (4.2, 3.0)),
}


def main() -> None:
    """Draw all figures."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--format", default="svg", help="svg, pdf or png")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder of the figures")
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    with rc_context(STYLE):
        for name, (draw, size) in FIGURES.items():
            figure = Figure(figsize=size, layout="constrained")
            draw(figure)
            path = chosen.out / f"{name}.{chosen.format}"
            figure.savefig(path, dpi=150, metadata={"Date": None} if path.suffix == ".svg" else {})


if __name__ == "__main__":
    main()
