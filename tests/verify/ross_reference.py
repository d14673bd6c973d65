"""Compute reference values with ROSS: `python ross_reference.py cases.json values.json`.

Runs inside the environment of ROSS, which solidwhirl is not part of. Complex numbers are written
as pairs. Axial motion and torsion are taken out unless a case has a gear.
"""

from __future__ import annotations

import contextlib
import copy
import io
import json
import sys
import tempfile
import warnings
from pathlib import Path

with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import numpy as np
    import ross
    from ross.utils import convert_6dof_to_4dof

# run_modal keeps half of the modes it is asked for.
HALF = 2


def elements(shaft, material):
    """Shaft elements, disks and gears of one shaft."""
    lengths = np.diff(shaft["nodes_m"])
    shafts = [
        ross.ShaftElement(L=length, idl=2 * inner, odl=2 * outer, material=material)
        for length, inner, outer in zip(
            lengths, shaft["inner_radius_m"], shaft["outer_radius_m"], strict=True
        )
    ]
    first = shaft.get("first_node", 0)
    disks = []
    for disk in shaft["disks"]:
        inertia = {"m": disk["mass"], "Id": disk["diametral"], "Ip": disk["polar"]}
        where = first + disk["node"]
        if "teeth" in disk:
            wheel = ross.GearElement(
                n=where,
                n_teeth=disk["teeth"],
                base_diameter=2 * disk["base_radius_m"],
                pr_angle=disk["pressure_angle_rad"],
                **inertia,
            )
            disks.append(wheel)
        else:
            disks.append(ross.DiskElement(n=where, **inertia))
    return shafts, disks


def bearing_element(bearing):
    """Bearing between a node and the ground or another node.

    With factors over the speed if any; or a table over it, or the short bearing's film. Tables are
    saved to a file and read from it, as ROSS does with a whole rotor.
    """
    if "table" in bearing:
        table = {**bearing["table"], "frequency": bearing["speeds_rad_s"]}
        return saved_and_read(
            ross.BearingElement(n=bearing["node"], tag=f"at {bearing['node']}", **table)
        )
    if "film" in bearing:
        film = {**bearing["film"], "speed": np.array(bearing["speeds_rad_s"])}
        return ross.CylindricalBearing(n=bearing["node"], **film)
    names = [letter + ends for letter in "kcm" for ends in ("xx", "xy", "yx", "yy")]
    mass = bearing.get("mass", [[0.0, 0.0], [0.0, 0.0]])
    matrices = np.ravel([bearing["stiffness"], bearing["damping"], mass])
    values = dict(zip(names, matrices, strict=True))
    if "speeds_rad_s" in bearing:
        # ROSS takes a table and puts a cubic spline through it, exact for these polynomials
        factors = {
            letter: np.polynomial.polynomial.polyval(bearing["speeds_rad_s"], coefficients)
            for letter, coefficients in ({"m": [1.0]} | bearing["factors"]).items()
        }
        values = {name: value * factors[name[0]] for name, value in values.items()}
        values["frequency"] = bearing["speeds_rad_s"]
    return ross.BearingElement(n=bearing["node"], n_link=bearing.get("other"), **values)


def saved_and_read(element):
    """Element as the file of it says."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "element.toml")
        element.save(path)
        return ross.BearingElement.load(path)


def build(case):
    """Rotor of a case, coaxial rotor, or pair of geared rotors."""
    steel = case["material"]
    material = ross.Material(name="case", rho=steel["rho"], E=steel["E"], G_s=steel["G"])
    parts = [elements(shaft, material) for shaft in case["shafts"]]
    bearings = [[bearing_element(b) for b in shaft["bearings"]] for shaft in case["shafts"]]
    if "gear" in case:
        pair = [ross.Rotor(*part, held) for part, held in zip(parts, bearings, strict=True)]
        gear = case["gear"]
        return without_axial_motion(
            ross.MultiRotor(
                *pair,
                coupled_nodes=tuple(gear["nodes"]),
                gear_mesh_stiffness=gear["stiffness"],
                orientation_angle=gear["orientation_rad"],
            )
        )
    if len(parts) == 1:
        return convert_6dof_to_4dof(ross.Rotor(*parts[0], bearings[0]))
    return coaxial(case, parts, [b for held in bearings for b in held])


def without_axial_motion(rotor):
    """Rotor with five motions per node; a spur gear does not move it along its axis."""
    axial = np.arange(2, rotor.ndof, 6)
    full = {name: getattr(rotor, name) for name in "MKCG"}

    def kept(name):
        def matrix(*arguments, **options):
            found = full[name](*arguments, **options)
            return np.delete(np.delete(found, axial, axis=0), axial, axis=1)

        return matrix

    rest = copy.copy(rotor)
    for name in full:
        setattr(rest, name, kept(name))
    rest.ndof, rest.number_dof = rotor.ndof - axial.size, 5
    return rest


def coaxial(case, parts, bearings):
    """Coaxial rotor without axial motion and torsion, each shaft at its own speed ratio.

    ROSS turns both shafts at one speed; the gyroscopic matrices of its elements are scaled here.
    """
    shafts, disks = [p[0] for p in parts], [d for p in parts for d in p[1]]
    masses = [ross.PointMass(n=node, m=mass) for node, mass in case["point_masses"]]
    bearings = bearings + [bearing_element(b) for b in case["pedestals"]]
    rotor = convert_6dof_to_4dof(ross.CoAxialRotor(shafts, disks, bearings, masses))
    gyroscopic, ratio = rotor.G(), np.zeros(rotor.ndof)
    for shaft, factor in zip(case["shafts"], case["ratios"], strict=True):
        first = rotor.number_dof * shaft["first_node"]
        ratio[first : first + rotor.number_dof * len(shaft["nodes_m"])] = factor
    rotor.G = lambda: ratio[:, None] * gyroscopic
    return rotor


def pairs(values):
    """Complex array as nested lists of (real, imaginary)."""
    values = np.asarray(values, dtype=complex)
    return np.stack((values.real, values.imag), axis=-1).tolist()


def modes(rotor, speeds, count):
    """Lowest oscillatory eigenvalues at each speed, from the dense solver."""
    found = []
    for speed in speeds:
        values = rotor.run_modal(speed, num_modes=HALF * 500, sparse=False).evalues
        found.append(pairs(values[values.imag > 1.0][:count]))
    return found


def critical(rotor, count):
    """Critical speeds from damped frequencies by Newton's method, to rounding."""
    return rotor.run_critical_speed(num_modes=HALF * count, rtol=1e-12).wd().tolist()


def response(rotor, plan):
    """Amplitudes at nodes, shape (speeds, nodes, 2)."""
    found = rotor.run_unbalance_response(
        plan["node"], plan["unbalance_kg_m"], plan["phase_rad"], frequency=plan["speeds_rad_s"]
    ).forced_resp
    rows = rotor.number_dof * np.array(plan["read_nodes"])
    return pairs(np.stack((found[rows], found[rows + 1]), axis=-1).transpose(1, 0, 2))


def critical_map(case, plan):
    """Forward critical speeds over the stiffness of all bearings, shape (points, modes)."""
    low, high = np.log10(plan["stiffness_n_per_m"][0]), np.log10(plan["stiffness_n_per_m"][-1])
    points = len(plan["stiffness_n_per_m"])
    steel = case["material"]
    material = ross.Material(name="case", rho=steel["rho"], E=steel["E"], G_s=steel["G"])
    shafts, disks = elements(case["shafts"][0], material)
    held = [bearing_element(b) for b in case["shafts"][0]["bearings"]]
    rotor = ross.Rotor(shafts, disks, held)
    found = rotor.run_ucs(
        stiffness_range=(low, high), num=points, num_modes=4 * plan["count"], synchronous=True
    )
    return found.wn.T.tolist()


def run_up(rotor, plan):
    """Displacements at a node while the speed rises evenly, for both numbers of steps.

    Keys: number of steps, "ross" with ROSS's own term of the angular acceleration, "half" with
    half of the gyroscopic matrix in its place; shape (records, 2).
    """
    found = {}
    for steps in plan["steps"]:
        times = np.linspace(0.0, plan["duration_s"], steps + 1)
        speeds = plan["start_rad_s"] + plan["acceleration_rad_s2"] * times
        force = rotor.unbalance_force_over_time(
            [plan["node"]], [plan["unbalance_kg_m"]], [plan["phase_rad"]], speeds, times
        )
        at = rotor.number_dof * plan["read_node"]
        for name, term in (("ross", rotor.Ksdt()), ("half", 0.5 * rotor.G())):
            with contextlib.redirect_stdout(io.StringIO()):
                motion = rotor.run_time_response(
                    speeds, force.T, times, method="newmark", Ksdt=term
                ).yout
            found[f"{name} {steps}"] = motion[:: steps // plan["records"], at : at + 2].tolist()
    return found


def values_of(case):
    """All values a case asks for."""
    rotor, asked, found = build(case), case["asked"], {}
    if "modes" in asked:
        found["modes"] = modes(rotor, **asked["modes"])
    if "critical" in asked:
        found["critical"] = critical(rotor, asked["critical"])
    if "response" in asked:
        found["response"] = response(rotor, asked["response"])
    if "map" in asked:
        found["map"] = critical_map(case, asked["map"])
    if "run_up" in asked:
        found["run_up"] = run_up(rotor, asked["run_up"])
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
