"""Our side of the comparison: `python peers_ours.py reference|solid|reduced OUT.json ...`."""

from __future__ import annotations

import dataclasses
import json
import pickle
import sys
from pathlib import Path

import numpy as np
from harmonic_and_solid import reference_rotor

TOP_RPM = 20_000.0
SPEEDS = 21
BRANCHES = 10
#: Degree, corner [m] and modes of the converged figures; without interfaces they are free modes.
CONVERGED = (4, 2e-5, 60)
#: Motions of an interface that all six of Exudyn's stand against.
SIX = ("ux", "uy", "uz", "rx", "ry", "rz")


def request_of(level, degree, modes, top_rpm, components=("ux", "uy"), orders=(1,)):
    """Reduction with every effect of the spin."""
    from solidwhirl.reduction import ReductionRequest

    return ReductionRequest(
        level=level,
        orders=orders,
        components=components,
        degree=degree,
        modes=modes,
        maximum_speed_rad_s=top_rpm * np.pi / 30.0,
        gyroscopic=True,
        centrifugal=True,
    )


def diagram(element, speeds_rpm) -> list[list[float]]:
    """Frequencies by speed [Hz], ascending."""
    from solidwhirl.rotordyn import Rotor, assemble, campbell

    system = assemble({"rotor": Rotor(element=element, speed_ratio=1.0)}, ())
    # at speed a rigid tilt whirls too, which is 0 Hz at rest and left out there
    count = BRANCHES if speeds_rpm[0] == 0.0 else BRANCHES + 2
    found = campbell(system, np.array(speeds_rpm) * np.pi / 30.0, branch_count=count)
    hz = np.asarray(found.frequency_hz)
    # one row per branch
    return np.sort(hz.T, axis=1).tolist()


def reference() -> dict:
    """Converged frequencies of the harmonic level."""
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_meridian
    from solidwhirl.reduction import reduce_body

    degree, corner, modes = CONVERGED
    body = dataclasses.replace(reference_rotor(), interfaces=())
    mesh = mesh_meridian(body, MeshSize(size_m=0.1, corner_size_m=corner, growth=0.6))
    request = request_of("harmonic", degree, modes, TOP_RPM, components=())
    element, _ = reduce_body(body, mesh, MPI.COMM_SELF, request, {})
    speeds = np.linspace(0.0, TOP_RPM, SPEEDS).tolist()
    return {
        "speed_rpm": speeds,
        "frequency_hz": diagram(element, speeds),
        "free_hz": element.free_frequencies_hz[:12].tolist(),
        "unknowns": element.full_dofs,
    }


def loaded(mesh_file: str):
    """Mesh from its file."""
    return pickle.loads(Path(mesh_file).read_bytes())


def solid(mesh_file: str, speeds: str) -> dict:
    """Reduction of a sector and its Campbell diagram, at one speed or all."""
    from mpi4py import MPI

    from solidwhirl.reduction import reduce_body

    listed = [TOP_RPM / 2] if speeds == "1" else np.linspace(0.0, TOP_RPM, SPEEDS).tolist()
    request = request_of("solid", 2, 8, listed[-1])
    element, _ = reduce_body(reference_rotor(), loaded(mesh_file), MPI.COMM_SELF, request, {})
    return {
        "speed_rpm": listed,
        "frequency_hz": diagram(element, listed),
        "free_hz": element.free_frequencies_hz[:12].tolist(),
        "coordinates": len(element.coordinates),
    }


def rigid_ends(body):
    """The rotor with rigid interfaces."""
    rigid = tuple(dataclasses.replace(i, coupling="rigid") for i in body.interfaces)
    return dataclasses.replace(body, interfaces=rigid)


def reduced(mesh_file: str, motions: str) -> dict:
    """Superelement with two rigid interfaces and 20 modes, with prestress and gyroscopic terms.

    "six" motions keep modes of the orders 0 and 1, "lateral" ones of order 1. 20 modes count each
    of a pair, as Exudyn does.
    """
    from mpi4py import MPI

    from solidwhirl.reduction import reduce_body

    lateral = motions == "lateral"
    components = ("ux", "uy", "rx", "ry") if lateral else SIX
    orders = (1,) if lateral else (0, 1)
    request = request_of("solid", 2, 10, TOP_RPM, components, orders)
    body = rigid_ends(reference_rotor())
    element, work = reduce_body(body, loaded(mesh_file), MPI.COMM_SELF, request, {})
    return {
        "coordinates": len(element.coordinates),
        "free_hz": element.free_frequencies_hz[:12].tolist(),
        "solved": {k: list(v) for k, v in work.solved.items()},
        "speed_rpm": [TOP_RPM / 2],
        "frequency_hz": diagram(element, [TOP_RPM / 2]),
    }


def main() -> None:
    """Do what is asked and write it."""
    task = {"reference": reference, "solid": solid, "reduced": reduced}[sys.argv[1]]
    Path(sys.argv[2]).write_text(json.dumps(task(*sys.argv[3:])))


if __name__ == "__main__":
    main()
