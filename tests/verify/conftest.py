"""Beam rotors from plain data, and what ROSS says about the same data."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "rotordyn"))
sys.path.append(str(Path(__file__).parent))
from rotors import connect, polynomial_law, steel_shaft, turning

from solidwhirl import rotordyn as rd

ROOT = Path(__file__).parents[2]


@pytest.fixture
def four_points(monkeypatch):
    """Integrate all of an element at four points, as CalculiX does."""

    import ufl

    from solidwhirl.reduction.operators import forms

    def measure(domain, kin, degree):
        return ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 2})

    monkeypatch.setattr(forms, "measure", measure)


@pytest.fixture(scope="session")
def run_ross(tmp_path_factory):
    """Function from cases to ROSS's values, one process in its environment per call."""
    python = ROOT / ".venv-ross" / "bin" / "python"

    def run(cases):
        assert python.exists(), "ROSS is missing; `make verify` installs it in .venv-ross"
        folder = tmp_path_factory.mktemp("ross")
        (folder / "cases.json").write_text(json.dumps(cases))
        script = Path(__file__).with_name("ross_reference.py")
        done = subprocess.run(
            [python, script, "cases.json", "values.json"],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
        )
        assert done.returncode == 0, done.stderr[-2000:]
        found = json.loads((folder / "values.json").read_text())
        assert found["version"] == "2.3.0"
        return found["values"]

    return run


def beam_of(case, number):
    """Beam with an interface at every node; a geared one twists."""
    data, steel = case["shafts"][number], case["material"]
    nodes = data["nodes_m"]
    disks = [(nodes[d["node"]], d["mass"], d["polar"], d["diametral"]) for d in data["disks"]]
    seats = {f"{i}": z for i, z in enumerate(nodes)}
    material = (steel["E"], steel["E"] / (2 * steel["G"]) - 1, steel["rho"])
    parts = ("ux", "uy", "rx", "ry", *(["rz"] if "gear" in case else []))
    own = (nodes, data["outer_radius_m"], seats, disks, data["inner_radius_m"], material)
    return steel_shaft(f"shaft {number}", *own, components=parts)


def law_of(bearing):
    """Speed law of a bearing whose coefficients have factors over Ω in rad/s."""
    if "factors" not in bearing:
        return None
    k, c = (tuple(bearing["factors"][kind]) for kind in "kc")
    return polynomial_law(k, k, c, c, top=bearing["speeds_rad_s"][-1])


def joints(case):
    """Bearings of all shafts and pedestals; nodes beyond the shafts are the pedestals' masses."""
    places = {}
    for number, data in enumerate(case["shafts"]):
        for i in range(len(data["nodes_m"])):
            # geared shafts count their own nodes, coaxial ones go on counting
            key = (number, i) if "gear" in case else data["first_node"] + i
            places[key] = rd.End(body=f"{number}", interface=f"{i}")
    for node, _ in case.get("point_masses", []):
        places[node] = rd.End(body=f"mass {node}", interface="at")
    listed = [(number, b) for number, s in enumerate(case["shafts"]) for b in s["bearings"]]
    listed += [(0, b) for b in case.get("pedestals", [])]
    bearings = []
    for at, (number, b) in enumerate(listed):
        first = places[(number, b["node"]) if "gear" in case else b["node"]]
        ends = (first, places[b["other"]] if "other" in b else None)
        own = (b["stiffness"], b["damping"])
        bearings.append(connect(f"bearing {at}", *ends, *own, speed_law=law_of(b)))
    return tuple(bearings)


def gear(case):
    """ROSS turns the line of action by the pressure angle from the tangent of the wheels."""
    orientation = case["gear"]["orientation_rad"]
    wheel = next(d for d in case["shafts"][0]["disks"] if "teeth" in d)
    ends = [rd.End(body=f"{i}", interface=f"{n}") for i, n in enumerate(case["gear"]["nodes"])]
    return rd.Gear(
        name="gear", first=ends[0], second=ends[1], ratio=case["ratios"][1],
        mesh_stiffness_n_per_m=case["gear"]["stiffness"],
        base_radius_first_m=wheel["base_radius_m"],
        line_of_action_rad=np.pi / 2 - wheel["pressure_angle_rad"] + orientation,
    )  # fmt: skip


def pedestal(mass_kg):
    """Mass that moves along x and y; its inertia about itself does not matter."""
    seats = {"at": 0.0, "foot": 0.0}
    return rd.rigid_superelement("pedestal", mass_kg, np.zeros(3), np.ones(3), seats, ("ux", "uy"))


def _system(case):
    """Assembled system of a case."""
    rotors = {}
    for number, _ in enumerate(case["shafts"]):
        ratio = case.get("ratios", [1.0])[number]
        rotors[f"{number}"] = turning(beam_of(case, number), ratio)
    for node, mass in case.get("point_masses", []):
        rotors[f"mass {node}"] = turning(pedestal(mass), 0.0)
    gears = (gear(case),) if "gear" in case else ()
    return rd.assemble(rotors, joints(case), "0", gears)


@pytest.fixture(scope="session")
def system_of():
    return _system
