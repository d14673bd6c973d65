"""The written files in ROSS, in its own environment: one process for all that is asked."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from plain_run_up import unbalance_forces
from python_exports import HOSTILE, with_names
from springs import on_springs, spring

from solidwhirl.rotordyn import (
    Rotor,
    SuperelementError,
    assemble,
    attach_rigid_disk,
    critical_speeds,
    matrices_at_speed,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.exchange.python.ross import write_ross
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import ramp_and_hold

PYTHON = Path(__file__).parents[3] / ".venv-ross" / "bin" / "python"
# Compiling ROSS's loops takes longer than running them as they are.
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "NUMBA_DISABLE_JIT": "1"}
MODES = {"speeds": [0.0, 900.0], "count": 8}


def run(*arguments, folder):
    assert PYTHON.exists(), "ROSS is missing; run tools/ross_environment.sh"
    done = subprocess.run(
        [PYTHON, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=ENVIRONMENT,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def bearing(at, stiffness, damping=0.0, **more):
    made = spring(("r", str(at)), stiffness, damping)
    matrices = {"stiffness": made.stiffness_n_per_m, "damping": made.damping_n_s_per_m}
    return {"at": at, **{name: matrix.tolist() for name, matrix in matrices.items()}, **more}


DISK = {"at": "a", "mass": 2.0, "polar": 0.01, "diametral": 0.006}
RESPONSE = {"at": "a", "moment": 1e-4, "phase": 0.3, "read": ["a", "b"]}
RESPONSE["speeds"] = np.linspace(50.0, 900.0, 8).tolist()
RUN_UP = {"at": "a", "moment": 1e-4, "phase": 0.3, "top": 900.0, "duration": 0.2, "steps": 80}
SEAL = bearing("b", [[2e6, 1e6], [-1e6, 2e6]], 300.0, kind="SealElement")
CASES = {
    "free": ("lateral_shaft", [], {"modes": MODES, "refused": True}),
    "even": (
        "lateral_shaft",
        [bearing("a", 5e7), bearing("b", 3e7)],
        {
            "modes": MODES,
            "campbell": {"speeds": [0.0, 500.0, 900.0], "count": 6},
            "critical": 4,
            "shapes": True,
        },
    ),
    "damped": (
        "lateral_shaft",
        [bearing("a", (5e6, 2e6), 900.0), bearing("b", (3e6, 4e6), 700.0), SEAL],
        {"modes": MODES, "response": RESPONSE, "run_up": RUN_UP},
    ),
    "six motions": ("disk_shaft", [bearing("front", 5e7), bearing("rear", 3e7)], {"modes": MODES}),
}
CASES["wheel"] = ("wheel", [bearing("hub", 1e6)], {"modes": MODES})
SPRING_OPTIONS = ["--spring", f"{HOSTILE}=5e7", "--spring", "b=5e7,4e7"]
SOLID = {
    "solid free": ("harmonic_rotor", [], {"modes": MODES}),
    "solid": (
        "harmonic_rotor",
        [bearing("front", (5e6, 2e6), 900.0), bearing("rear", 3e6, 700.0)],
        {
            "modes": MODES,
            "response": RESPONSE | {"at": "front", "read": ["front", "rear"]},
            "run_up": RUN_UP | {"at": "front"},
        },
    ),
}


def assembled(element, bearings, more=(), rotors=()):
    """The same system here."""
    listed = [spring(("r", b["at"]), b["stiffness"], b["damping"]) for b in bearings]
    return assemble(
        {"r": Rotor(element=element, speed_ratio=1.0), **dict(rotors)}, (*listed, *more)
    )


def two_cases(lateral_shaft):
    """A disk of ROSS on the shaft; its end on a mass of its own, as of a pedestal."""
    on_disk = [bearing("a", 5e7), bearing("b", 3e7)]
    on_mass = [bearing("a", 5e7), bearing("b", 3e7, link=2), bearing(2, (2e7, 1e7))]
    asked = {"modes": MODES}
    pedestal = rigid_superelement(
        "pedestal", 12.0, np.zeros(3), np.ones(3), {"top": 0.0}, ("ux", "uy")
    )
    joined = [spring(("r", "b"), 3e7, 0.0, ("p", "top")), spring(("p", "top"), (2e7, 1e7))]
    with_disk = attach_rigid_disk(
        lateral_shaft, "a", "disk", DISK["mass"], DISK["polar"], DISK["diametral"]
    )
    ours = {
        "disk": assembled(with_disk, on_disk),
        "pedestal": assembled(
            lateral_shaft,
            on_mass[:1],
            joined,
            {"p": Rotor(element=pedestal, speed_ratio=0.0)}.items(),
        ),
    }
    cases = {
        "disk": {"bearings": on_disk, "disks": [DISK], "asked": asked},
        "pedestal": {"bearings": on_mass, "masses": [[2, 12.0]], "asked": asked},
    }
    return ours, cases


def wheel():
    """A wheel with one seat beside its centre: one node only, no elastic motion."""
    wheel = rigid_superelement("wheel", 4.0, [0, 0, 0.02], (0.02, 0.02, 0.035), {"hub": 0.0})
    return dataclasses.replace(wheel, constraint=None)


@pytest.fixture(scope="session")
def ross(request, tmp_path_factory):
    """ROSS's values and our systems by the name of the case; ROSS alone takes 6 s to load."""
    folder = tmp_path_factory.mktemp("ross")
    ours, cases = {}, {}
    chosen = CASES | (SOLID if find_spec("dolfinx") else {})
    for name, (body, bearings, asked) in chosen.items():
        element = wheel() if body == "wheel" else request.getfixturevalue(body)
        ours[name] = assembled(element, bearings)
        written = write_ross(element, folder / f"{body}.py").files[0]
        cases[name] = {"bearings": bearings, "asked": asked, "file": str(written)}
    shaft = request.getfixturevalue("lateral_shaft")
    more_ours, more = two_cases(shaft)
    ours |= more_ours
    cases |= {name: {**case, "file": cases["even"]["file"]} for name, case in more.items()}
    written = write_ross(with_names(shaft, HOSTILE), folder / "two words").files
    assert [f.name for f in written] == ["two words.py", "two words.npz"]
    cases["printed"] = {"file": str(written[0]), "run": ["--speed", "1000", *SPRING_OPTIONS]}
    (folder / "cases.json").write_text(json.dumps(cases))
    run(Path(__file__).with_name("ross_run.py"), "cases.json", "values.json", folder=folder)
    found = json.loads((folder / "values.json").read_text())
    assert found["version"] in ("2.3.0", "3.1.0")
    assert not list(folder.rglob("harm"))
    return found["values"], ours


def with_solver(name):
    return pytest.param(name, marks=pytest.mark.solver)


def complex_of(listed):
    return np.array(listed)[..., 0] + 1j * np.array(listed)[..., 1]


@pytest.mark.parametrize("name", [*CASES, "disk", "pedestal", *map(with_solver, SOLID)])
def test_modes(ross, name):
    """Every oscillating mode here is one there, in frequency and growth; spares lie above.

    Ω² K2 of a solid, for which ROSS has no place, counts: without it frequencies are off by 1.5e-3.
    """
    theirs, ours = ross[0][name], ross[1][name]
    for speed, found in theirs["modes"].items():
        modes = modes_at_speed(ours, float(speed)).eigenvalues
        for kind in ("dense", "sparse"):
            values = complex_of(found[kind])
            count = min(values.size, modes.size)
            assert count >= (modes.size if kind == "dense" else 2)
            if kind == "sparse":
                # ARPACK lists zeros of a free body as well
                values = values[values.imag > 1.0][:count]
                count = values.size
            # ROSS divides by M, so errors are of the size of the highest mode's square: seen 1e-9
            np.testing.assert_allclose(values[:count].imag, modes[:count].imag, rtol=1e-7)
            np.testing.assert_allclose(
                values[:count].real, modes[:count].real, rtol=1e-6, atol=1e-3
            )


@pytest.mark.parametrize("name", ["damped", with_solver("solid")])
def test_response_and_run_up(ross, name):
    """Through resonances, amplitude and phase; a seal with cross-coupling on the shaft.

    The run-up is by the same steps of Newmark's average acceleration, from no acceleration as ROSS
    begins.
    """
    theirs, ours, asked = ross[0][name], ross[1][name], (CASES | SOLID)[name][2]
    plan = asked["response"]
    unbalance = Unbalance(
        body="r", interface=plan["at"], moment_kg_m=plan["moment"], phase_rad=plan["phase"]
    )
    (exciter,) = unbalance_response(ours, [unbalance], plan["speeds"]).exciters
    response = complex_of(theirs["response"])
    for place, node in enumerate(plan["read"]):
        expected = exciter.at_node("r", node)
        size = np.abs(expected).max()
        np.testing.assert_allclose(response[:, place], expected, rtol=0, atol=1e-9 * size)
    plan = asked["run_up"]
    profile, h = ramp_and_hold(plan["top"], plan["duration"]), plan["duration"] / plan["steps"]
    # the reading at the very end is that before the hold
    times = np.linspace(0.0, plan["duration"] * (1.0 - 1e-14), plan["steps"] + 1)
    forces = unbalance_forces(ours, profile, [unbalance], times)
    rows = np.array([interface_row(ours, "r", plan["at"], c) for c in ("ux", "uy")])
    q, v, a = np.zeros((3, ours.size))
    found = [rows @ q]
    for time, force in zip(times[1:], forces[1:], strict=True):
        matrices = matrices_at_speed(ours, float(profile.speed_rad_s(time)))
        c = matrices.damping + matrices.gyroscopic
        k = matrices.stiffness + plan["top"] / plan["duration"] / 2.0 * ours.gyroscopic
        place, rate = q + h * v + h**2 / 4.0 * a, v + h / 2.0 * a
        a = np.linalg.solve(ours.mass + h / 2.0 * c + h**2 / 4.0 * k, force - c @ rate - k @ place)
        q, v = place + h**2 / 4.0 * a, rate + h / 2.0 * a
        found.append(rows @ q)
    found = np.array(found)
    miss = np.abs(np.array(theirs["run_up"]) - found).max() / np.abs(found).max()
    # ROSS stops its iteration at 1e-6 of the largest coordinate.
    assert miss < 1e-6, miss


def test_campbell_and_critical_speeds(ross):
    theirs, ours = ross[0]["even"], ross[1]["even"]
    asked = CASES["even"][2]
    # the lowest pair of a symmetric rotor at speed
    assert theirs["modes"]["900"]["whirl"][:2] == ["Backward", "Forward"]
    for speed, found in zip(asked["campbell"]["speeds"], theirs["campbell"], strict=True):
        expected = 2 * np.pi * modes_at_speed(ours, speed).frequency_hz[: len(found)]
        np.testing.assert_allclose(found, expected, rtol=1e-7)
    found = [c.speed_rad_s for c in critical_speeds(ours, speed_max_rad_s=3000.0)]
    listed = np.array(theirs["critical"])
    # ROSS counts a backward mode that meets its own speed as well, as we do
    np.testing.assert_allclose(listed[listed < 3000.0], found[: listed.size], rtol=1e-7)


def test_shapes(ross, lateral_shaft):
    """Nodes move as interfaces do: ROSS's displacements and rotations, signs included."""
    theirs = complex_of(ross[0]["even"]["shapes"]).reshape(2, 6)
    ours = modes_at_speed(ross[1]["even"], 0.0, 2).shapes
    where = {"ux": 0, "uy": 1, "rx": 3, "ry": 4}
    columns = np.zeros((12, ours.shape[1]), dtype=complex)
    for node, name in enumerate(("a", "b")):
        for component, row in where.items():
            columns[6 * node + row] = interface_row(ross[1]["even"], "r", name, component) @ ours
    # the plane of an equal pair is free: theirs lies in the span of ours
    shape = theirs.ravel()
    weights, *_ = np.linalg.lstsq(columns, shape, rcond=None)
    assert np.linalg.norm(columns @ weights - shape) < 1e-5 * np.linalg.norm(shape)


def test_mass_properties(ross, lateral_shaft):
    """ROSS's own numbers, the disk included; places from the first node at z = 0.1 m."""
    theirs, plain = ross[0]["disk"], ross[0]["even"]
    start, m, z = 0.1, lateral_shaft.mass_kg, lateral_shaft.center_of_gravity_m[2]
    assert plain["nodes"] == {"a": 0, "b": 1}
    np.testing.assert_allclose(plain["node z"], [0.0, 0.3], rtol=1e-12)
    assert plain["m"] == pytest.approx(m) and plain["CG"] == pytest.approx(z - start)
    assert plain["It"] == pytest.approx(lateral_shaft.inertia_kg_m2[0, 0])
    total = m + DISK["mass"]
    assert theirs["m"] == pytest.approx(total)
    assert theirs["CG"] == pytest.approx((m * (z - start)) / total)
    assert theirs["Ip"] == pytest.approx(lateral_shaft.inertia_kg_m2[2, 2] + DISK["polar"])


def test_functions_that_need_shaft_elements_stop(ross):
    said = ross[0]["free"]["refused"]
    assert len(said) >= 8 and all("own shaft elements" in text for text in said.values())


def test_file_runs(ross, lateral_shaft):
    """As told in its head, under a hostile name."""
    element, text = with_names(lateral_shaft, HOSTILE), ross[0]["printed"]
    lines = text[text.index("free, 1000 rad/s") :].splitlines()
    cut = next(i for i, line in enumerate(lines) if line.startswith("on springs"))
    for block, given in ((lines[1:cut], {}), (lines[cut + 1 :], {HOSTILE: 5e7, "b": (5e7, 4e7)})):
        ours = modes_at_speed(on_springs(element, given), 1000.0).frequency_hz[:12]
        np.testing.assert_allclose([float(line.split()[0]) for line in block], ours, rtol=1e-7)


def test_what_is_left_out_is_said(lateral_shaft, disk_shaft, tmp_path):
    lateral, six = (write_ross(e, tmp_path / "x.py").left_out for e in (lateral_shaft, disk_shaft))
    assert "no coordinate for 'a' (uz, rz)" in lateral[0]
    assert not any("no coordinate" in sentence for sentence in six)


def test_refusals(tmp_path):
    seats = {"front": 0.0, "rear": 0.4}
    tied = rigid_superelement("casing", 30.0, np.zeros(3), np.ones(3), seats)
    with pytest.raises(SuperelementError, match="12 coordinates, 6 of them independent"):
        write_ross(tied, tmp_path / "tied.py")
    assert not list(tmp_path.iterdir())
