"""Use written files in ROSS: `python ross_run.py cases.json values.json`.

Runs inside the environment of ROSS, which solidwhirl is not part of. One process for all cases,
since ROSS alone takes seconds to load. Complex numbers are written as pairs.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import runpy
import sys
import warnings
from pathlib import Path

with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import numpy as np
    import ross


def module_of(path):
    spec = importlib.util.spec_from_file_location(Path(path).stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def pairs(values):
    values = np.asarray(values, dtype=complex)
    return np.stack((values.real, values.imag), axis=-1).tolist()


def bearings_of(case, at):
    names = ("kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy")
    return [
        getattr(ross, b.get("kind", "BearingElement"))(
            n=at[b["at"]] if isinstance(b["at"], str) else b["at"],
            n_link=b.get("link"),
            **dict(zip(names, np.ravel([b["stiffness"], b["damping"]]), strict=True)),
        )
        for b in case["bearings"]
    ]


def rotor_of(file, case):
    at = file.nodes()
    disks = [
        ross.DiskElement(n=at[d["at"]], m=d["mass"], Id=d["diametral"], Ip=d["polar"])
        for d in case.get("disks", [])
    ]
    masses = [ross.PointMass(n=n, m=m) for n, m in case.get("masses", [])]
    return file.BodyRotor(disks or None, bearings_of(case, at), masses or None)


def modes(rotor, plan):
    """Eigenvalues by both solvers and the whirl, at each speed."""
    found = {}
    for speed in plan["speeds"]:
        dense = rotor.run_modal(speed, num_modes=2 * plan["count"], sparse=False)
        sparse = rotor.run_modal(speed, num_modes=2 * plan["count"])
        found[f"{speed:g}"] = {
            "dense": pairs([v for v in dense.evalues if v.imag > 1.0]),
            "sparse": pairs(sparse.evalues[: plan["count"]]),
            "whirl": [str(w) for w in sparse.whirl_direction()],
        }
    return found


def response(rotor, at, plan):
    """ux, uy at nodes, shape (speeds, nodes, 2)."""
    found = rotor.run_unbalance_response(
        at[plan["at"]], plan["moment"], plan["phase"], plan["speeds"]
    )
    rows = 6 * np.array([at[name] for name in plan["read"]])
    values = np.stack((found.forced_resp[rows], found.forced_resp[rows + 1]), axis=-1)
    figure = found.plot(probe=[ross.Probe(at[plan["at"]], 0.0)])
    assert len(figure.data)
    return pairs(values.transpose(1, 0, 2))


def run_up(rotor, at, plan):
    """ux, uy at a node at all times."""
    times = np.linspace(0.0, plan["duration"], plan["steps"] + 1)
    speeds = plan["top"] * times / plan["duration"]
    node = at[plan["at"]]
    force = rotor.unbalance_force_over_time(
        [node], [plan["moment"]], [plan["phase"]], speeds, times
    )
    with contextlib.redirect_stdout(io.StringIO()):
        found = rotor.run_time_response(speeds, force.T, times, method="newmark").yout
    return found[:, 6 * node : 6 * node + 2].tolist()


def campbell(rotor, plan):
    found = rotor.run_campbell(np.array(plan["speeds"]), frequencies=plan["count"])
    assert len(found.plot().data)
    return np.sort(found.wd, axis=1).tolist()


def shapes(rotor):
    """Motion of the nodes in the lowest mode, and whether ROSS can draw it and the rotor."""
    found = rotor.run_modal(0.0)
    drawn = [found.plot_mode_3d(0), found.plot_mode_2d(0), rotor.plot_rotor()]
    assert all(len(figure.data) for figure in drawn)
    return pairs(found.modes[:, 0])


def refused(rotor):
    """Functions that need ROSS's own shaft elements, and what they say."""
    names = ("run_static", "run_ucs", "run_level1", "run_crack", "run_misalignment", "save")
    names += tuple(n for n in ("refine", "refine_mesh", "run_with_motor") if hasattr(rotor, n))
    calls = {name: lambda name=name: getattr(rotor, name)("x") for name in names}
    calls["synchronous"] = lambda: rotor.run_modal(0.0, synchronous=True)
    calls["torsion"] = lambda: rotor.run_campbell([0.0, 1.0], torsional_analysis=True)
    said = {}
    for name, call in calls.items():
        try:
            call()
        except NotImplementedError as error:
            said[name] = str(error)
    return said


def printed(case):
    """What the file prints when it is run as a program."""
    kept, sys.argv = sys.argv, [case["file"], *case["run"]]
    try:
        with contextlib.redirect_stdout(io.StringIO()) as text:
            runpy.run_path(case["file"], run_name="__main__")
    finally:
        sys.argv = kept
    return text.getvalue()


def values_of(case):
    if "run" in case:
        return printed(case)
    file = module_of(case["file"])
    at, rotor = file.nodes(), rotor_of(file, case)
    found = {"nodes": at, "m": rotor.m, "CG": rotor.CG, "Ip": rotor.Ip, "It": rotor.It}
    found["node z"] = list(map(float, rotor.nodes_pos))
    asked = case["asked"]
    if "modes" in asked:
        found["modes"] = modes(rotor, asked["modes"])
    if "response" in asked:
        found["response"] = response(rotor, at, asked["response"])
    if "run_up" in asked:
        found["run_up"] = run_up(rotor, at, asked["run_up"])
    if "campbell" in asked:
        found["campbell"] = campbell(rotor, asked["campbell"])
    if "critical" in asked:
        found["critical"] = rotor.run_critical_speed(num_modes=2 * asked["critical"], rtol=1e-12)
        found["critical"] = found["critical"].wd().tolist()
    if "shapes" in asked:
        found["shapes"] = shapes(rotor)
    if "refused" in asked:
        found["refused"] = refused(rotor)
    return found


def main() -> None:
    """Read the cases, write the values."""
    cases = json.loads(Path(sys.argv[1]).read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = {name: values_of(case) for name, case in cases.items()}
    Path(sys.argv[2]).write_text(json.dumps({"version": ross.__version__, "values": found}))


if __name__ == "__main__":
    main()
