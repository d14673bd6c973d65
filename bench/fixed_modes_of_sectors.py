"""Time of the fixed-interface modes of sectors: SLEPc's Krylov-Schur against block Krylov.

Both get the same factor and mass, of a bladed disk on a shaft held at two seats: half a sector of
real unknowns, and a whole one of complex unknowns, which PETSc holds as pairs of real ones. Every
eigenvalue of the pairs is double (v and iv); SLEPc works on the pairs as they are, and copies are
taken out of what it finds by complex Gram-Schmidt in M.

    python bench/fixed_modes_of_sectors.py [thousands of real unknowns ...]

Prints a Markdown table: CPU seconds without the factor, and the largest relative difference of
eigenvalues. Default: 30 and 100.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from mpi4py import MPI

from solidwhirl.geometry import MATERIALS, Blade, Body, Interface, Section
from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.reduction.operators.matrices import BodyOperators, OperatorEffects, build_operators
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, eigenpairs, factorise
from solidwhirl.reduction.solvers.slepc_modes import slepc_pairs
from solidwhirl.reduction.solvers.vectors import apply, inner, unpaired

MODES = 16
STEEL = MATERIALS["steel"]
# The size of elements that the search for a number of unknowns begins with.
_FIRST_SIZE_M = 0.012


def bladed_disk(stagger_deg: float) -> Body:
    """Twelve blades on a disk on a hollow shaft, held at two seats."""
    shaft = Section(
        name="shaft", start_m=0.0, end_m=0.4, inner_radius_m=(0.01, 0.01),
        outer_radius_m=(0.02, 0.02), material=STEEL,
    )  # fmt: skip
    disk = Section(
        name="disk", start_m=0.19, end_m=0.21, inner_radius_m=(0.02, 0.02),
        outer_radius_m=(0.1, 0.1), material=STEEL,
    )  # fmt: skip
    seats = tuple(
        Interface(name=name, kind="outer", coupling="distributing", start_m=z, end_m=z + 0.02)
        for name, z in (("a", 0.02), ("b", 0.36))
    )
    blades = Blade(
        name="blades", on="disk", count=12, length_m=0.06, chord_m=(0.02, 0.02),
        thickness_m=(0.006, 0.003), stagger_deg=(stagger_deg, stagger_deg), material=STEEL,
    )  # fmt: skip
    return Body(name="rotor", sections=(shaft, disk), interfaces=seats, features=(blades,))


def operators_of(stagger_deg: float, unknowns: int) -> BodyOperators:
    """Operators of index 1 on a mesh of about a number of real unknowns."""
    body, size = bladed_disk(stagger_deg), _FIRST_SIZE_M
    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: ("ux", "uy") for i in body.interfaces},
    )
    for _ in range(6):
        mesh = mesh_sector(body, MeshSize(size_m=size, corner_size_m=size))
        pairs = 1 if mesh.sector is not None and mesh.sector.mirrored else 2
        found = 3 * pairs * len(mesh.points)
        if abs(found / unknowns - 1.0) < 0.1:
            break
        size *= (found / unknowns) ** (1 / 3)
    return build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=2, effects=effects)


def by_slepc(factor: ConstrainedFactor, mass: Any) -> tuple[np.ndarray, np.ndarray]:
    """Eigenpairs by SLEPc; of complex unknowns without the copies iv of what is there already.

    Both copies of each are asked for: fewer end in the middle of the list, and starting anew, with
    or without what is found deflated, took two to eight times longer.
    """
    values, vectors = slepc_pairs(factor, mass, shift=0.0, count=factor.parts * MODES)
    return (values, vectors) if factor.parts == 1 else distinct(values, unpaired(vectors), mass)


def distinct(values: np.ndarray, vectors: np.ndarray, mass: Any) -> tuple[np.ndarray, np.ndarray]:
    """Pairs that are no complex multiples of those before them."""
    comm = mass.comm.tompi4py()
    gram = inner(vectors, apply(mass, vectors), comm)
    kept: list[int] = []
    for k in range(len(values)):
        alike = np.abs(gram[kept, k]) / np.sqrt(np.abs(gram[kept, kept] * gram[k, k]))
        if not (alike > 0.5).any():
            kept.append(k)
    return values[kept], vectors[:, kept]


def timed(solve: Any, *given: Any) -> tuple[float, np.ndarray]:
    """CPU seconds, least of three, and eigenvalues."""
    seconds = []
    for _ in range(3):
        start = time.process_time()
        values, _ = solve(*given)
        seconds.append(time.process_time() - start)
    return min(seconds), values


def main() -> None:
    """Print the table."""
    sizes = [1000 * int(word) for word in sys.argv[1:]] or [30_000, 100_000]
    print("| sector | real unknowns | factor s | block Krylov s | SLEPc s | ratio | difference |")
    print("|---|---|---|---|---|---|---|")
    for kind, stagger in (("half, real", 0.0), ("whole, complex", 30.0)):
        for size in sizes:
            operators = operators_of(stagger, size)
            start = time.process_time()
            factor = factorise(operators.stiffness, operators.coupling.rows)
            factored = time.process_time() - start
            block, first = timed(
                lambda f, m: eigenpairs(f, m, shift=0.0, count=MODES), factor, operators.mass
            )
            single, second = timed(by_slepc, factor, operators.mass)
            off = float(np.abs(second[:MODES] / first[:MODES] - 1.0).max())
            print(
                f"| {kind} | {operators.mass.getSize()[0]} | {factored:.2f} | {block:.2f} | "
                f"{single:.2f} | {single / block:.2f} | {off:.1e} |",
                flush=True,
            )
            factor.destroy()
            operators.release()


if __name__ == "__main__":
    main()
