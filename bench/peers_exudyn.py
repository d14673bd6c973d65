"""Hurty-Craig-Bampton reduction in Exudyn: `python peers_exudyn.py matrices|reduce STEM`.

Runs inside the environment of Exudyn, which solidwhirl is not part of. `matrices` turns what
CalculiX stored (`*FREQUENCY, SOLVER=MATRIXSTORAGE`) into sparse matrices, not charged to Exudyn.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
from scipy import linalg, sparse

MODES = 20
ENDS_M = (0.0, 0.4)


def stored(path: Path, places: np.ndarray) -> sparse.csr_matrix:
    """Symmetric matrix from triplets of its upper half, node by node."""
    rows, columns, values = np.loadtxt(path, unpack=True)
    rows, columns = places[rows.astype(int) - 1], places[columns.astype(int) - 1]
    half = sparse.csr_matrix((values, (rows, columns)), shape=(places.size, places.size))
    found = half + half.T - sparse.diags(half.diagonal())
    found = found.tocsr()
    # CalculiX stores both matrices on one pattern; zeros would cost Exudyn time
    found.eliminate_zeros()
    return found


def matrices(stem: Path) -> None:
    """Write M and K as .npz."""
    names = [line.split(".") for line in stem.with_suffix(".dof").read_text().split()]
    places = np.array([3 * (int(node) - 1) + int(motion) - 1 for node, motion in names])
    for suffix, name in ((".mas", "mass"), (".sti", "stiffness")):
        found = stored(stem.with_suffix(suffix), places)
        sparse.save_npz(stem.with_name(f"{stem.name}_{name}.npz"), found, compressed=False)


def reduce(stem: Path) -> dict:
    """Reduced matrices with rigid (RBE2) interfaces at both ends, and CPU time of the reduction."""
    import exudyn
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection

    body = FEMinterface()
    body.nodes = {"Position": np.load(stem.with_suffix(".npy"))}
    body.massMatrix = sparse.load_npz(stem.with_name(f"{stem.name}_mass.npz"))
    body.stiffnessMatrix = sparse.load_npz(stem.with_name(f"{stem.name}_stiffness.npz"))
    ends = [body.GetNodesInPlane([0.0, 0.0, z], [0.0, 0.0, 1.0]) for z in ENDS_M]
    start = time.process_time()
    body.ComputeHurtyCraigBamptonModes(
        boundaryNodesList=ends,
        nEigenModes=MODES,
        useSparseSolver=True,
        computationMode=HCBstaticModeSelection.RBE2,
        # the first interface moves too, as those of a superelement do
        excludeRigidBodyMotion=False,
        timerTreshold=10**9,
    )
    basis = body.modeBasis["matrix"]
    mass = basis.T @ (body.massMatrix @ basis)
    stiffness = basis.T @ (body.stiffnessMatrix @ basis)
    taken = time.process_time() - start
    squares = linalg.eigh(stiffness, mass, eigvals_only=True)
    return {
        "version": exudyn.__version__,
        "reduction_cpu_s": taken,
        "coordinates": basis.shape[1],
        "interface_nodes": [len(e) for e in ends],
        "free_hz": (np.sqrt(np.abs(squares[6:])) / (2.0 * np.pi)).tolist(),
        "rigid_hz": (np.sqrt(np.abs(squares[:6])) / (2.0 * np.pi)).tolist(),
    }


def main() -> None:
    """Do what is asked."""
    stem = Path(sys.argv[2])
    if sys.argv[1] == "matrices":
        matrices(stem)
    else:
        stem.with_name(f"{stem.name}_exudyn.json").write_text(json.dumps(reduce(stem)))


if __name__ == "__main__":
    main()
