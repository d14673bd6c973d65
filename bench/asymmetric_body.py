"""Time of the reduction of a whole solid in its own axes, against a floor of the same run.

A shaft of 40 by 30 mm with a disk, as a mesh of tetrahedra: no symmetry is used. The floor is one
factorisation of its stiffness and the solutions of one block. CPU time on one core.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import tempfile
import time
from pathlib import Path

from harmonic_and_solid import floor_cpu_s

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
ENDS = ("left", "right")
LENGTH, WIDTH, HEIGHT = 0.6, 0.04, 0.03


def write_mesh(path: Path, size_m: float) -> None:
    """Second-order tetrahedra of the shaft and its disk, with its ends as groups."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    bar = (3, occ.addBox(-0.5 * WIDTH, -0.5 * HEIGHT, 0.0, WIDTH, HEIGHT, LENGTH))
    disk = (3, occ.addCylinder(0.0, 0.0, 0.5 * LENGTH - 0.01, 0.0, 0.0, 0.02, 0.1))
    occ.fragment([bar], [disk])
    occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [t for _, t in gmsh.model.getEntities(3)], name="body")
    for name, z in zip(ENDS, (0.0, LENGTH), strict=True):
        faces = [
            t for _, t in gmsh.model.getEntities(2) if abs(occ.getCenterOfMass(2, t)[2] - z) < 1e-9
        ]
        gmsh.model.addPhysicalGroup(2, faces, name=name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size_m)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(str(path))
    gmsh.finalize()


def measure(size_m: float, modes: int, estimates: tuple[str, ...]) -> dict[str, float]:
    """Reduce the shaft, and find its floor."""
    from mpi4py import MPI

    from solidwhirl.geometry import Material
    from solidwhirl.meshing.imported.body import body_of_mesh, mesh_from_file
    from solidwhirl.meshing.imported.records import MeshInterface, MeshRequest
    from solidwhirl.reduction import ReductionRequest, reduce_body
    from solidwhirl.reduction.body.request import order_operators

    steel = Material(
        name="steel", density_kg_per_m3=7800.0, youngs_modulus_pa=2e11, poissons_ratio=0.3
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shaft.msh"
        write_mesh(path, size_m)
        request = MeshRequest(
            path=str(path),
            digest="",
            unit_m=1.0,
            origin=(0.0, 0.0, 0.0),
            direction=(0.0, 0.0, 1.0),
            material=steel,
            interfaces=tuple(MeshInterface(name=n, coupling="rigid", group=n) for n in ENDS),
            shape="asymmetric",
        )
        mesh = mesh_from_file(request, "shaft")
    body = body_of_mesh("shaft", request, mesh)
    asked = ReductionRequest(
        level="solid",
        orders=(),
        components=COMPONENTS,
        degree=2,
        modes=modes,
        maximum_speed_rad_s=1500.0,
        gyroscopic=True,
        centrifugal=True,
        estimates=estimates,
    )
    start = time.process_time()
    element, work = reduce_body(body, mesh, MPI.COMM_SELF, asked, {})
    reduced = time.process_time() - start
    operators = order_operators(body, mesh, MPI.COMM_SELF, asked, None)
    factored, solved = floor_cpu_s(operators.stiffness, operators.coupling.held)
    return {
        "unknowns": element.full_dofs,
        "coordinates": element.size,
        "reduction_cpu_s": reduced,
        **{f"{name}_s": seconds for name, seconds in work.seconds.items()},
        "factorisation_cpu_s": factored,
        "solutions_cpu_s": solved,
        "reduction_over_floor": reduced / (factored + solved),
    }


def main() -> None:
    """Print what is measured as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size-m", type=float, default=0.006)
    parser.add_argument("--modes", type=int, default=6)
    parser.add_argument("--estimates", action="store_true")
    given = parser.parse_args()
    estimates = ("mode_truncation", "mesh") if given.estimates else ()
    print(json.dumps(measure(given.size_m, given.modes, estimates), indent=1))


if __name__ == "__main__":
    main()
