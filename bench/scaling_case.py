"""One case of bench/scaling.py in a process of its own: what every call of the reduction took.

`python bench/scaling_case.py '{"level": "harmonic", ...}'` prints one line of JSON. Functions of
the reduction are wrapped while it runs, so that the program itself is measured and not a copy.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import functools
import json
import resource
import sys
import time
from collections.abc import Callable

import numpy as np

TOP_RAD_S = 20_000 * np.pi / 30.0
SPEEDS = 21
#: Stage of the functions that are wrapped, by module and name; inner ones are taken off outer ones.
STAGES = {
    ("operators.matrices", "build_operators"): "assembly",
    ("solvers.constrained", "factorise"): "factorisation",
    ("solvers.constrained", "eigenpairs"): "eigensolutions",
    ("solvers.slepc_modes", "slepc_pairs"): "eigensolutions",
    ("basis.spinning_modes", "modes_at_speed"): "eigensolutions",
    ("basis.overspeed", "softest_direction"): "eigensolutions",
    ("basis.craig_bampton", "reduction_basis"): "projection",
    ("basis.craig_bampton", "orthogonality_error"): "projection",
    ("body.superelements", "reduce_block"): "projection",
    ("body.superelements", "build_superelement"): "projection",
    ("residuals.residual_energy", "mesh_energy"): "estimate",
    ("residuals.residual_energy", "truncation_energy"): "estimate",
}
#: Stages that keep what they call: how an eigenvalue solver works is its own affair.
WHOLE = ("eigensolutions",)


class Log:
    """Calls of one process: stage, unknowns, columns and exclusive processor time."""

    def __init__(self) -> None:
        self.calls: list[dict] = []
        self.inner = [0.0]
        self.closed = False

    def timed(self, stage: str, function: Callable, measure: Callable) -> Callable:
        """The function, with its calls logged; `measure` gives unknowns and columns."""

        @functools.wraps(function)
        def run(*args, **kwargs):
            if self.closed:
                return function(*args, **kwargs)
            self.inner.append(0.0)
            self.closed = stage in WHOLE
            start = time.process_time()
            out = function(*args, **kwargs)
            spent = time.process_time() - start
            self.closed = False
            own = spent - self.inner.pop()
            self.inner[-1] += spent
            size, columns = measure(args, kwargs, out)
            self.calls.append(
                {"stage": stage, "unknowns": size, "columns": columns, "seconds": own}
            )
            return out

        return run


def rotor(planes: int, disks: int = 1):
    """Shaft with disks, and section interfaces at equal distances along it."""
    from solidwhirl.geometry import MATERIALS, Body, Interface, Section

    pieces = [("shaft", 0.0, 0.4, 0.0, 0.02)]
    for k in range(disks):
        middle = 0.16 if disks == 1 else 0.4 * (k + 0.5) / disks
        half = 0.015 if disks == 1 else 0.1 / disks
        pieces.append((f"disk{k}", middle - half, middle + half, 0.02, 0.15))
    sections = tuple(
        Section(
            name=name,
            start_m=start,
            end_m=end,
            inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer),
            material=MATERIALS["steel"],
        )
        for name, start, end, inner, outer in pieces
    )
    interfaces = tuple(
        Interface(
            name=f"p{k}",
            kind="section",
            coupling="distributing",
            start_m=float(z),
            end_m=float(z),
            radius_m=(0.0, 0.02),
        )
        for k, z in enumerate(np.linspace(0.0, 0.4, planes))
    )
    return Body(name="rotor", sections=sections, interfaces=interfaces)


def mesh_maker(level: str):
    """Function: mesh of a body for a level; "revolved" is half a sector, "solid" the whole."""
    from solidwhirl.meshing import mesh_meridian, mesh_revolved, mesh_solid

    return {"harmonic": mesh_meridian, "revolved": mesh_revolved, "solid": mesh_solid}[level]


def whole_body(body, mesh):
    """The body as one that comes from a file with the mesh of all of it."""
    from solidwhirl.meshing.imported.body import body_of_mesh
    from solidwhirl.meshing.imported.records import MeshInterface, MeshRequest

    request = MeshRequest(
        path="",
        digest="",
        unit_m=1.0,
        origin=(0.0, 0.0, 0.0),
        direction=(0.0, 0.0, 1.0),
        material=mesh.materials[0],
        interfaces=tuple(
            MeshInterface(name=i.name, coupling=i.coupling, group=i.name) for i in body.interfaces
        ),
        shape="round",
    )
    return body_of_mesh(body.name, request, mesh)


def mesh_size(body, level: str, degree: int, unknowns: int):
    """Uniform element size whose predicted mesh has about so many unknowns."""
    from solidwhirl.meshing import MeshSize
    from solidwhirl.meshing.own.prediction import predict_mesh

    def of(edge: float):
        return MeshSize(size_m=edge, corner_size_m=edge, growth=0.6, around=4)

    low, high = 1e-4, 0.05
    for _ in range(40):
        middle = float(np.sqrt(low * high))
        made = predict_mesh(body, of(middle), level).unknowns(degree)
        low, high = (middle, high) if made > unknowns else (low, middle)
    return of(high)


def wrap(log: Log) -> None:
    """Wrap the functions of STAGES wherever the reduction has imported them."""
    import importlib

    def size_of(matrix) -> int:
        return int(matrix.getSize()[0])

    def nothing(_args, _kwargs, _out) -> tuple[int, int]:
        return 0, 0

    measures = {
        "build_operators": lambda a, k, out: (out.full_dofs // out.families, 1),
        "factorise": lambda a, k, out: (size_of(a[0]), 1),
        "eigenpairs": lambda a, k, out: (size_of(a[0].matrix), k["count"]),
        "slepc_pairs": lambda a, k, out: (size_of(a[0].matrix), k["count"]),
    }
    modules = [m for n, m in sys.modules.items() if n.startswith("solidwhirl.reduction")]
    for (module, name), stage in STAGES.items():
        original = getattr(importlib.import_module(f"solidwhirl.reduction.{module}"), name)
        wrapped = log.timed(stage, original, measures.get(name, nothing))
        for place in modules:
            if getattr(place, name, None) is original:
                setattr(place, name, wrapped)
    from solidwhirl.reduction.solvers.constrained import ConstrainedFactor

    solve = log.timed(
        "static_solutions", ConstrainedFactor.solve, lambda a, k, out: (len(out), out.shape[1])
    )
    ConstrainedFactor.solve = solve


def measure(case: dict) -> dict:
    """Mesh and reduction of one body."""
    log = Log()
    start = time.process_time()
    from mpi4py import MPI

    from solidwhirl.reduction import ReductionRequest, reduce_body

    imported = time.process_time() - start
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    wrap(log)
    comm = MPI.COMM_WORLD
    level, degree = case["level"], case["degree"]
    body = rotor(case["planes"])
    size = mesh_size(body, level, degree, case["unknowns"])
    start = time.process_time()
    mesh = mesh_maker(level)(body, size) if comm.rank == 0 else None
    meshing = time.process_time() - start
    if level == "solid":
        body = comm.bcast(whole_body(body, mesh) if mesh is not None else None)
    request = ReductionRequest(
        level="harmonic" if level == "harmonic" else "solid",
        orders=(1,),
        components=("ux", "uy"),
        degree=degree,
        modes=case["modes"],
        maximum_speed_rad_s=TOP_RAD_S,
        gyroscopic=True,
        centrifugal=True,
        estimates=tuple(case["estimates"]),
    )
    wall, start = time.perf_counter(), time.process_time()
    element, work = reduce_body(body, mesh, comm, request, {})
    spent, wall = time.process_time() - start, time.perf_counter() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    peak = comm.allreduce(peak)
    families = 1 if level == "solid" else 2
    return {
        **case,
        "made_unknowns": element.full_dofs // families,
        "cells": len(mesh.cells) if mesh is not None else 0,
        "columns": len(element.coordinates) // families,
        "interface_columns": case["planes"] * 2 // families,
        "import_s": imported,
        "meshing_s": meshing,
        "reduction_s": spent,
        "reduction_wall_s": wall,
        "base_gib": base,
        "peak_gib": peak,
        "solved": next(iter(work.solved.values())),
        "calls": log.calls,
    }


def measure_mesh(case: dict) -> dict:
    """A mesh alone, graded to the corners of some disks."""
    from solidwhirl.meshing import MeshSize
    from solidwhirl.meshing.own.prediction import predict_mesh

    body = rotor(2, case["disks"])
    size = MeshSize(
        size_m=0.1,
        corner_size_m=case["corner_m"],
        growth=0.6,
        through_thickness=1.2,
        around=12,
    )
    make = mesh_maker(case["kind"])
    start = time.process_time()
    mesh = make(body, size)
    spent = time.process_time() - start
    predicted = predict_mesh(body, size, case["kind"])
    return {
        **case,
        "cells": len(mesh.cells),
        "predicted_cells": predicted.cells,
        "graded_places": predicted.graded_places,
        "meshing_s": spent,
    }


def engine(stations: int, evenness: float, damping_s: float):
    """Two counter-rotating spools of beams on four bearings, one between them."""
    from solidwhirl.rotordyn import Bearing, Disk, End, Rotor, assemble, beam_superelement

    def spool(label, start, stop, radii, seats, at):
        disk = Disk(name="disk", position_m=at, mass_kg=40.0, polar_kg_m2=1.6, diametral_kg_m2=0.85)
        z = np.linspace(start, stop, stations + 1)
        return beam_superelement(label, z, *radii, (2e11, 0.3, 7800.0), seats, [disk])

    def bearing(body, seat, second=None):
        k = 4e7 * np.diag([1.0, evenness])
        return Bearing(
            name=f"{body} {seat}",
            first=End(body=body, interface=seat),
            second=second,
            stiffness_n_per_m=k,
            damping_n_s_per_m=damping_s * k,
        )

    low = spool("low", 0.0, 2.0, (0.045, 0.035), {"a": 0.0, "b": 1.5, "c": 2.0}, 1.9)
    high = spool("high", 0.6, 1.5, (0.09, 0.08), {"d": 0.6, "e": 1.5}, 0.75)
    joints = (
        bearing("low", "a"),
        bearing("low", "c"),
        bearing("high", "d"),
        bearing("high", "e", End(body="low", interface="b")),
    )
    rotors = {
        "low": Rotor(element=low, speed_ratio=1.0),
        "high": Rotor(element=high, speed_ratio=-1.6),
    }
    return assemble(rotors, joints, "low")


def measure_engine(case: dict) -> dict:
    """Campbell diagram and critical speeds of an engine of beams."""
    from solidwhirl.rotordyn import campbell, critical_speeds

    evenness, damping = {"even": (1.0, 0.0), "uneven": (0.7, 0.0), "damped": (0.7, 2e-5)}[
        case["kind"]
    ]
    system = engine(case["stations"], evenness, damping)
    speeds = np.linspace(0.0, 1000.0, SPEEDS)
    start = time.process_time()
    campbell(system, speeds, branch_count=10)
    drawn = time.process_time()
    critical_speeds(system, excitation_ratio=1.0, speed_max_rad_s=1000.0)
    found = time.process_time()
    return {
        **case,
        "coordinates": len(system.stiffness),
        "campbell_s_per_speed": (drawn - start) / SPEEDS,
        "critical_speeds_s": found - drawn,
    }


def main() -> None:
    """Run the case of the first argument; rank 0 prints."""
    case = json.loads(sys.argv[1])
    row = {"engine": measure_engine, "mesh": measure_mesh}.get(case["level"], measure)(case)
    if case.get("ranks", 1) > 1:
        from mpi4py import MPI

        if MPI.COMM_WORLD.rank != 0:
            return
    print(json.dumps(row))


if __name__ == "__main__":
    main()
