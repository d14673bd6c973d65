"""Meshes of the reference rotor for the comparison: `python peers_mesh.py FOLDER`.

A sector is pickled for solidwhirl, and its copies all around, the same model, are written as the
model part of a CalculiX deck.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import sys
from pathlib import Path

import numpy as np
from harmonic_and_solid import reference_rotor

#: Largest edge, edge at the corners [m], growth, elements through the thickness, sectors.
SIZES = {
    "even": (0.0085, 0.0085, 1.0, 1.0, 12),
    "graded": (0.1, 0.004, 0.6, 1.2, 12),
    "graded, finer": (0.1, 0.001, 0.6, 1.2, 12),
    "graded, between": (0.1, 0.002, 0.6, 1.2, 12),
}


def deck_of(mesh) -> str:
    """Nodes, ten-node tetrahedra and material."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{k + 1},{x:.11e},{y:.11e},{z:.11e}" for k, (x, y, z) in enumerate(mesh.points)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=BODY")
    # CalculiX numbers the last two edges the other way round
    for k, cell in enumerate(mesh.cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] + 1):
        lines.append(",".join(str(v) for v in (k + 1, *cell)))
    (steel,) = mesh.materials
    lines += ["*MATERIAL, NAME=M", "*ELASTIC"]
    lines.append(f"{steel.youngs_modulus_pa:.11e},{steel.poissons_ratio:.11e}")
    lines += ["*DENSITY", f"{steel.density_kg_per_m3:.11e}"]
    return "\n".join([*lines, "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]) + "\n"


def pins_of(points) -> list[str]:
    """Six supports, statically determinate: both ends of the axis and one on a rim."""

    def nearest(*place: float) -> int:
        return int(np.argmin(np.linalg.norm(points - np.array(place), axis=1))) + 1

    left, right, rim = nearest(0, 0, 0), nearest(0, 0, 0.4), nearest(0.02, 0, 0)
    return [f"{left},1,3", f"{right},1,2", f"{rim},2,2"]


def main() -> None:
    """Make all meshes."""
    from solidwhirl.meshing import MeshSize, mesh_meridian
    from solidwhirl.meshing.own.revolved import revolved
    from solidwhirl.meshing.own.whole import whole_mesh

    folder = Path(sys.argv[1])
    body = reference_rotor()
    listed = {}
    for name, (edge, corner, growth, through, sectors) in SIZES.items():
        size = MeshSize(size_m=edge, corner_size_m=corner, growth=growth, through_thickness=through)
        sector = revolved(mesh_meridian(body, size), sectors)
        mesh = whole_mesh(sector)[0]
        stem = f"{name.replace(', ', '_')}"
        deck = deck_of(mesh)
        (folder / f"{stem}.pickle").write_bytes(pickle.dumps(sector))
        (folder / f"{stem}.mesh").write_text(deck)
        np.save(folder / f"{stem}.npy", mesh.points)
        listed[name] = {
            "stem": stem,
            "unknowns": 3 * len(mesh.points),
            "elements": len(mesh.cells),
            "pins": pins_of(mesh.points),
            "sha256": hashlib.sha256(deck.encode()).hexdigest(),
        }
    (folder / "meshes.json").write_text(json.dumps(listed, indent=1))


if __name__ == "__main__":
    main()
