"""CalculiX on a mesh of ours: lines of a deck, and the table of eigenvalues that it prints."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np


def calculix_body(mesh):
    """Nodes, ten-node tetrahedra and the material of a mesh; no field is longer than 20 signs."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{k + 1},{x:.13e},{y:.13e},{z:.13e}" for k, (x, y, z) in enumerate(mesh.points)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=BODY")
    for k, cell in enumerate(mesh.cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] + 1):
        lines.append(",".join(str(v) for v in (k + 1, *cell)))
    (material,) = mesh.materials
    lines += ["*MATERIAL, NAME=M", "*ELASTIC"]
    lines.append(f"{material.youngs_modulus_pa:.11e},{material.poissons_ratio:.11e}")
    lines += ["*DENSITY", f"{material.density_kg_per_m3:.11e}"]
    return [*lines, "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]


def calculix_rows(lines, folder, *, columns):
    """Rows of the eigenvalues of a deck, as numbers."""
    program = shutil.which("ccx")
    assert program, "CalculiX is missing; `make verify` installs Debian's calculix-ccx"
    (folder / "deck.inp").write_text("\n".join(lines) + "\n")
    done = subprocess.run(
        [program, "deck"], cwd=folder, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0 and "*ERROR" not in done.stdout, done.stdout[-2000:]
    tables = (folder / "deck.dat").read_text().split("E I G E N V A L U E   O U T P U T")[1:]
    text = "".join(table.split("P A R T I C I P A T I O N")[0] for table in tables)
    number = r"[ \t]+(\S+)" * (columns - 1)
    rows = re.findall(rf"^[ \t]*(\d+){number}[ \t]*$", text, re.MULTILINE)
    return np.array(rows, dtype=float)
