"""Write the files of scenes/own_mesh.toml: a rotor as STEP, a bearing pedestal as a mesh.

Both stand for what a user brings from a CAD program and a mesher. The pedestal is drawn and meshed
with gmsh and written as an input file of CalculiX, in millimetres, with its own y upwards and z
along the shaft.
"""

from __future__ import annotations

import sys
from pathlib import Path

import gmsh
import meshio
import numpy as np

from solidwhirl.geometry import MATERIALS, Body, Section
from solidwhirl.meshing.own.step_write import write_step

HERE = Path(__file__).resolve().parents[1] / "scenes" / "own_mesh"
# gmsh's tetrahedra in the order of Abaqus, which is VTK's
_TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


def rotor() -> Body:
    """Overhung disk on a stepped shaft."""
    steel = MATERIALS["steel"]

    def part(name: str, start: float, end: float, inner: float, outer: float) -> Section:
        return Section(
            name=name,
            start_m=start,
            end_m=end,
            inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer),
            material=steel,
        )

    return Body(
        name="rotor",
        sections=(
            part("front", 0.0, 0.06, 0.0, 0.025),
            part("shaft", 0.06, 0.34, 0.0, 0.03),
            part("rear", 0.34, 0.4, 0.0, 0.025),
            part("overhang", 0.4, 0.5, 0.0, 0.02),
            part("disk", 0.46, 0.49, 0.02, 0.11),
        ),
    )


def pedestal(path: Path) -> None:
    """Plate with a bore for the bearing on a foot, 40 mm wide; the bore's axis is at y = 150."""
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        foot = occ.addBox(-90, 0, 10, 180, 25, 40)
        web = occ.addBox(-45, 25, 15, 90, 125, 30)
        ring = occ.addCylinder(0, 150, 10, 0, 0, 40, 55)
        bore = occ.addCylinder(0, 150, 0, 0, 0, 60, 35)
        whole, _ = occ.fuse([(3, foot)], [(3, web), (3, ring)])
        occ.cut(whole, [(3, bore)])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 18)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 16)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, x, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(11)
    finally:
        gmsh.finalize()
    row = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    points = np.round(x.reshape(-1, 3), 6)
    radius = np.hypot(points[:, 0], points[:, 1] - 150.0)
    meshio.Mesh(
        points,
        [("tetra10", row[nodes.astype(np.int64)].reshape(-1, 10)[:, _TO_VTK])],
        point_sets={
            "BORE": np.flatnonzero(np.abs(radius - 35.0) < 1e-3),
            "SOLE": np.flatnonzero(points[:, 1] < 1e-6),
        },
    ).write(path, float_fmt=".6f", file_format="abaqus")


def main() -> None:
    """Write both files."""
    HERE.mkdir(parents=True, exist_ok=True)
    write_step([rotor()], HERE / "rotor.step")
    pedestal(HERE / "pedestal.inp")
    sys.stdout.write("".join(f"{p.name} {p.stat().st_size} bytes\n" for p in HERE.iterdir()))


if __name__ == "__main__":
    main()
