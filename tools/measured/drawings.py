"""Write the STEP files of the blades in scenes/measured: a blisk, blades with a swept tip, a panel.

`python tools/measured/drawings.py`. One sector each of the blisk and of four equal blades on a hub;
millimetres, the axis of rotation is z.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import gmsh

SCENES = Path(__file__).resolve().parents[2] / "scenes" / "measured"
#: In-plane sweeps of the tip that were measured [degrees]
SWEEPS_DEG = (0, 15, 30, 45)


def blisk() -> None:
    """One of five blades with its part of the hub and half of a conical bore's wall."""
    occ = gmsh.model.occ
    radius, width, half, fillet = 40.0, 60.0, 1.0, 10.0
    # the circle of the root fillet touches the blade's face and the hub
    x, y = math.sqrt((radius + fillet) ** 2 - (half + fillet) ** 2), half + fillet
    foot = (x * radius / (radius + fillet), y * radius / (radius + fillet))
    corners = [(30.0, 0.0), foot, (x, half), (162.0, half)]
    upper = [occ.addPoint(a, b, 0.0) for a, b in corners[1:]]
    lower = [occ.addPoint(a, -b, 0.0) for a, b in corners[1:]]
    centres = [occ.addPoint(x, s * y, 0.0) for s in (1.0, -1.0)]
    outline = [
        occ.addCircleArc(upper[0], centres[0], upper[1]),
        occ.addLine(upper[1], upper[2]),
        occ.addLine(upper[2], lower[2]),
        occ.addLine(lower[2], lower[1]),
        occ.addCircleArc(lower[1], centres[1], lower[0]),
        occ.addLine(lower[0], upper[0]),
    ]
    face = occ.addPlaneSurface([occ.addCurveLoop(outline)])
    blade = [e for e in occ.extrude([(2, face)], 0, 0, width) if e[0] == 3]
    hub = occ.addCylinder(0, 0, 0, 0, 0, width, radius, angle=2.0 * math.pi / 5.0)
    occ.rotate([(3, hub)], 0, 0, 0, 0, 0, 1, -math.pi / 5.0)
    whole, _ = occ.fuse(blade, [(3, hub)])
    bore = 24.0
    cone = occ.addCone(0, 0, 0, 0, 0, width, bore, bore - width * math.tan(math.radians(4.0)))
    occ.cut(whole, [(3, cone)])


def swept_blade(sweep_deg: float) -> None:
    """One of four strips on a hub that stands for the clamp, its tip swept in the plane."""
    occ = gmsh.model.occ
    clamp, straight, tip, chord, thickness = 63.5, 800.1, 152.4, 25.4, 1.6002
    bend, back = clamp + straight, math.radians(sweep_deg)
    low, half = -thickness / 2.0, chord / 2.0
    hub = occ.addCylinder(0, 0, -6.35, 0, 0, 12.7, clamp, angle=math.pi / 2.0)
    occ.rotate([(3, hub)], 0, 0, 0, 0, 0, 1, -math.pi / 4.0)
    # edges of the strip meet on the line that halves the bend
    shift = half * math.tan(back / 2.0)
    end = (bend + tip * math.cos(back), -tip * math.sin(back))
    across = (half * math.sin(back), half * math.cos(back))
    corners = [
        (clamp - 10.0, -half),
        (bend - shift, -half),
        (end[0] - across[0], end[1] - across[1]),
        (end[0] + across[0], end[1] + across[1]),
        (bend + shift, half),
        (clamp - 10.0, half),
    ]
    points = [occ.addPoint(a, b, low) for a, b in corners]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    strip = [e for e in occ.extrude([(2, face)], 0, 0, thickness) if e[0] == 3]
    occ.fuse([(3, hub)], strip)


def panel() -> None:
    """Panel of a cylinder about z, an arc of 0.5 rad; one curved edge lies in the plane z = 0."""
    occ = gmsh.model.occ
    radius, thickness, length, arc = 609.6, 3.048, 304.8, 0.5
    outer = occ.addCylinder(0, 0, 0, 0, 0, length, radius + thickness / 2.0, angle=arc)
    inner = occ.addCylinder(0, 0, 0, 0, 0, length, radius - thickness / 2.0, angle=arc)
    occ.cut([(3, outer)], [(3, inner)])


def write(name: str, draw: Callable[[], None]) -> Path:
    """Draw in an empty model and write scenes/measured/NAME.step."""
    path = SCENES / f"{name}.step"
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        draw()
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def main() -> None:
    """Write all files."""
    drawings: dict[str, Callable[[], None]] = {"blisk": blisk, "panel": panel}
    drawings |= {f"swept_blade_{sweep}": partial(swept_blade, sweep) for sweep in SWEEPS_DEG}
    for name, draw in drawings.items():
        path = write(name, draw)
        sys.stdout.write(f"{path.name} {path.stat().st_size} bytes\n")


if __name__ == "__main__":
    main()
