"""Write the mesh of scenes/crank_mesh.toml: a crankshaft with one throw and two counterweights.

Drawn and meshed with gmsh, in millimetres, z along the axis, as a user's mesher writes it (.msh 4.1
with named groups).
"""

from __future__ import annotations

import sys
from pathlib import Path

import gmsh

HERE = Path(__file__).resolve().parents[1] / "scenes" / "crank_mesh"
# mm: radii of journals, pin and end, throw, half width and thickness of the webs, reach of the
# counterweights, and the ends of everything along the axis
JOURNAL, PIN, END, THROW, HALF_WIDTH, REACH = 24.0, 21.0, 20.0, 30.0, 33.0, 68.0
LEFT, WEB_1, WEB_2, WEB_3, WEB_4, RIGHT, NOSE = 0.0, 50.0, 70.0, 110.0, 130.0, 180.0, 300.0
SIZE = 26.0


def main() -> None:
    """Draw, mesh and write."""
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        parts = [
            occ.addCylinder(0, 0, LEFT, 0, 0, WEB_1 - LEFT, JOURNAL),
            occ.addCylinder(THROW, 0, WEB_2, 0, 0, WEB_3 - WEB_2, PIN),
            occ.addCylinder(0, 0, WEB_4, 0, 0, RIGHT - WEB_4, JOURNAL),
            occ.addCylinder(0, 0, RIGHT, 0, 0, NOSE - RIGHT, END),
        ]
        for z in (WEB_1, WEB_3):
            disk = occ.addCylinder(0, 0, z, 0, 0, WEB_2 - WEB_1, REACH)
            plate = occ.addBox(
                -REACH, -HALF_WIDTH, z, REACH + THROW + PIN, 2 * HALF_WIDTH, WEB_2 - WEB_1
            )
            half, _ = occ.intersect([(3, disk)], [(3, plate)])
            end = occ.addCylinder(THROW, 0, z, 0, 0, WEB_2 - WEB_1, HALF_WIDTH)
            parts += [tag for _, tag in half] + [end]
        occ.fuse([(3, parts[0])], [(3, tag) for tag in parts[1:]])
        occ.synchronize()
        (volume,) = gmsh.model.getEntities(3)
        gmsh.model.addPhysicalGroup(3, [volume[1]], name="crank")
        seats = {"left": (LEFT, WEB_1), "right": (WEB_4, RIGHT), "wheel": (RIGHT, NOSE)}
        for name, ends in seats.items():
            gmsh.model.addPhysicalGroup(2, _cylinders(*ends), name=name)
        gmsh.model.addPhysicalGroup(2, _cylinders(WEB_2, WEB_3), name="pin")
        gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
        gmsh.option.setNumber("Mesh.Binary", 0)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        HERE.mkdir(parents=True, exist_ok=True)
        gmsh.write(str(HERE / "crank.msh"))
    finally:
        gmsh.finalize()
    sys.stdout.write(f"crank.msh {(HERE / 'crank.msh').stat().st_size} bytes\n")


def _cylinders(low: float, high: float) -> list[int]:
    """Curved faces that lie between two places on the axis and reach both."""
    found = []
    for _, tag in gmsh.model.getEntities(2):
        box = gmsh.model.getBoundingBox(2, tag)
        spans = abs(box[2] - low) < 1e-3 and abs(box[5] - high) < 1e-3
        if spans and gmsh.model.getType(2, tag) == "Cylinder":
            found.append(tag)
    return found


if __name__ == "__main__":
    main()
