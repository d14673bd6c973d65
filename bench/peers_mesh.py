"""Meshes of the reference rotor for the comparison: `python peers_mesh.py FOLDER`.

Each is pickled for solidwhirl and written as the model part of a CalculiX deck.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import sys
from pathlib import Path

import numpy as np
from harmonic_and_solid import reference_rotor

#: Largest edge, edge at the corners [m], growth, elements through the thickness, around.
SIZES = {
    "even": (0.00815, 0.00815, 1.0, 1.0, 12),
    "graded": (0.1, 0.0033, 1.0, 1.0, 8),
    "graded, finer": (0.1, 0.0015, 0.6, 1.2, 12),
    "graded, between": (0.1, 0.0026, 0.6, 1.2, 12),
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
    from solidwhirl.meshing import MeshSize, mesh_solid

    folder = Path(sys.argv[1])
    body = reference_rotor()
    listed = {}
    for name, (size, corner, growth, through, around) in SIZES.items():
        mesh = mesh_solid(
            body,
            MeshSize(
                size_m=size,
                corner_size_m=corner,
                growth=growth,
                through_thickness=through,
                around=around,
            ),
        )
        stem = f"{name.replace(', ', '_')}"
        deck = deck_of(mesh)
        (folder / f"{stem}.pickle").write_bytes(pickle.dumps(mesh))
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
