"""A body with a floating frame for Exudyn: a Python file that is ready to run, and its data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray, cross_matrix
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.multibody import body_fixed
from solidwhirl.rotordyn.exchange.multibody.body_fixed import BodyFixedForm
from solidwhirl.rotordyn.exchange.python.python_files import write_python
from solidwhirl.rotordyn.superelement.record import Superelement

# Points on a circle around each interface; they carry its rotation as well.
_RING_POINTS = 4


def write_exudyn_frame(
    element: Superelement,
    path: str | Path,
    *,
    modes: int | None = None,
    speed_rad_s: float = 0.0,
) -> Exported:
    """Write a body as a flexible body with a floating frame for Exudyn.

    `element`: a free body that knows its moments and its spin generator; `path`: the Python file,
    named `.py`; the numbers go into an `.npz` file of the same name beside it; `modes`: number of
    elastic modes, the lowest; None for all; `speed_rad_s`: spin about z whose centrifugal stress
    stiffens the body, unless the Python file is told another. Raises SuperelementError if the path
    has another ending, the speed is not finite or beyond that of the body's basis, or the body has
    no body-fixed form (see `body_fixed_form`).

    The `.npz` file is what Exudyn's `ObjectFFRFreducedOrderInterface` saves, for
    `ObjectFFRFreducedOrder`; equations in Zwölfer and Gerstmayr 2020, Acta Mechanica 232. Tested
    with Exudyn 1.13.6.
    """
    if not np.isfinite(speed_rad_s) or abs(speed_rad_s) > element.maximum_speed_rad_s:
        raise SuperelementError(
            f"superelement {element.name!r}: speed_rad_s is {speed_rad_s}; allowed is up to "
            f"{element.maximum_speed_rad_s:g} rad/s"
        )
    form = body_fixed.body_fixed_form(element, modes=modes)
    radius = float(np.sqrt(element.inertia_kg_m2[2, 2] / element.mass_kg))
    arrays = {**frame_arrays(form, speed_rad_s, radius), **_names(form, speed_rad_s)}
    return Exported(
        files=write_python(path, _TEXT, element, arrays),
        carried=(
            f"{form.frequencies_hz.size} elastic modes with mass and stiffness",
            "all inertia terms of a large motion, of any spin and of its change",
            f"stress stiffening at one spin about z, {speed_rad_s:g} rad/s unless add_body is "
            "given another",
            "interfaces as rings of points, which carry displacement and rotation",
        ),
        left_out=(
            "Exudyn's body has no stress stiffening of its own: it is added to the stiffness for "
            "one spin and does not follow the spin.",
            *body_fixed.body_fixed_limits(element, form),
        ),
    )


def frame_arrays(
    form: BodyFixedForm, speed_rad_s: float, radius_m: float
) -> dict[str, npt.NDArray[Any]]:
    """Return what Exudyn's class for floating frames reads.

    `speed_rad_s`: spin about z whose stress stiffens the body. Returns arrays by the names of
    Exudyn 1.13.6; points are the rings of all interfaces, four each, then the recovery points.
    """
    m = form.frequencies_hz.size
    points, motion = _points(form, radius_m)
    skew = cross_matrix(form.I3.T)
    return {
        "fileVersion": np.array(1),
        "type": np.array("ObjectFFRFreducedOrderInterface"),
        "infoList": np.array([m, len(points), 3, 4, 7, 7 + m]),
        "rigidBodyNodeType": np.array("NodeType.RotationEulerParameters"),
        "xRef": points.ravel(),
        "modeBasis": motion.reshape(-1, m),
        "massMatrixReduced": form.mass,
        "stiffnessMatrixReduced": form.stiffness + speed_rad_s**2 * form.stress_stiffening,
        "totalMass": np.array(form.mass_kg),
        "Mtt": form.mass_kg * np.eye(3),
        "chiU": form.center_of_gravity_m,
        "chiUtilde": cross_matrix(form.center_of_gravity_m),
        "inertiaLocal": form.inertia_kg_m2,
        "mPhitTPsi": form.I3,
        "mPhitTPsiTilde": skew.transpose(1, 0, 2).reshape(3, 3 * m),
        "mXRefTildePsi": -form.I4,
        "mXRefTildePsiTilde": form.I8.transpose(0, 2, 1).reshape(3, 3 * m),
        "mPsiTildePsi": -form.I5.transpose(1, 0, 2).reshape(3 * m, m),
        "mPsiTildePsiTilde": -form.I9.transpose(2, 0, 3, 1).reshape(3 * m, 3 * m),
        "trigList": np.zeros((0, 3), dtype=int),
        # the class expects a dictionary here, which numpy can only keep as an object
        "postProcessingModes": np.array({}, dtype=object),
    }


def _names(form: BodyFixedForm, speed_rad_s: float) -> dict[str, npt.NDArray[Any]]:
    """Return what the Python file needs beside Exudyn's arrays."""
    rings = np.arange(len(form.nodes) * _RING_POINTS).reshape(-1, _RING_POINTS)
    return {
        "interface_name": np.array([node.name for node in form.nodes], dtype=np.str_),
        "interface_xyz": np.array([node.position_m for node in form.nodes]),
        "interface_ring": rings,
        "stressStiffening": form.stress_stiffening,
        "stiffened_at_rad_s": np.array(float(speed_rad_s)),
    }


def _points(form: BodyFixedForm, radius_m: float) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 3) and their motion per mode (p, 3, m); rings move as rigid bodies."""
    angles = 2.0 * np.pi * np.arange(_RING_POINTS) / _RING_POINTS
    arms = radius_m * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    places = [node.position_m + arms for node in form.nodes]
    motions = [
        node.translations[None] + np.cross(node.rotations.T[None], arms[:, None]).transpose(0, 2, 1)
        for node in form.nodes
    ]
    return np.vstack([*places, form.points_m]), np.concatenate([*motions, form.point_modes])


_TEXT = '''\
"""A flexible body with a floating frame for Exudyn: large motion, any spin; SI units.

Frequencies at rest, free and on springs to the ground (N/m, on x and y), then, if a speed is
given, the drift of a body that spins freely for a while (rad/s, s):

    python FILE.py --spring INTERFACE=5e7 --spring OTHER=5e7,4e7 --speed 300 --time 0.05

In models of your own: import this file, then add_body, add_bearing, interface_marker.
The numbers are in the .npz file of the same name. Needs numpy, scipy and exudyn.
"""

import argparse
from pathlib import Path

import exudyn as exu
import exudyn.itemInterface as eii
import numpy as np
from exudyn.FEM import ObjectFFRFreducedOrderInterface

# @BODY@
DATA = Path(__file__).with_suffix(".npz")


def load(file=DATA):
    """Names, places and rings of the interfaces, stiffening; what Exudyn does not ask for."""
    keys = ("interface_name", "interface_xyz", "interface_ring")
    with np.load(file, allow_pickle=False) as data:
        names, places, rings = (data[key].tolist() for key in keys)
        return dict(zip(names, zip(places, rings))), data["stressStiffening"], data[
            "stiffened_at_rad_s"
        ].item()


def add_body(mbs, spin=0.0, stiffened_at=None, **more):
    """Add the body; returns the dictionary of its item numbers, with its interfaces.

    spin: about its z at the start, rad/s. stiffened_at: spin whose centrifugal stress stiffens
    it, rad/s; without it the spin that the file was written for. It does not follow the spin.
    more: for AddObjectFFRFreducedOrder, such as positionRef or stiffnessProportionalDamping.
    """
    interfaces, stiffening, written_at = load()
    body = ObjectFFRFreducedOrderInterface()
    body.LoadFromFile(str(DATA), mode="NPZ")
    if stiffened_at is not None:
        change = stiffened_at**2 - written_at**2
        body.stiffnessMatrixReduced = body.stiffnessMatrixReduced + change * stiffening
    start = {"initialAngularVelocity": [0.0, 0.0, spin], "positionRef": [0.0, 0.0, 0.0]}
    return body.AddObjectFFRFreducedOrder(mbs, **start | more) | {"interfaces": interfaces}


def interface_marker(mbs, body, interface, rigid=True):
    """Marker of an interface: of displacement and rotation, or of displacement alone."""
    _, ring = body["interfaces"][interface]
    kind = eii.MarkerSuperElementRigid if rigid else eii.MarkerSuperElementPosition
    weights = [1.0 / len(ring)] * len(ring)
    number = body["oFFRFreducedOrder"]
    return mbs.AddMarker(kind(bodyNumber=number, meshNodeNumbers=ring, weightingFactors=weights))


def add_bearing(mbs, body, interface, stiffness, damping=0.0):
    """Hold an interface by springs to the ground on x and y (a number, or two), at its place."""
    place, _ = body["interfaces"][interface]
    ground = mbs.AddObject(eii.ObjectGround(referencePosition=place))
    ends = [
        mbs.AddMarker(eii.MarkerBodyPosition(bodyNumber=ground)),
        interface_marker(mbs, body, interface, rigid=False),
    ]
    k, c = ([*np.broadcast_to(x, 2).tolist(), 0.0] for x in (stiffness, damping))
    spring = eii.ObjectConnectorCartesianSpringDamper(markerNumbers=ends, stiffness=k, damping=c)
    return mbs.AddObject(spring)


def frequencies(mbs):
    """Frequencies at rest in Hz, rising; rigid motions are zeros among them."""
    mbs.Assemble()
    squares, _ = mbs.ComputeODE2Eigenvalues(useAbsoluteValues=False)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


def spin_freely(speed, duration, steps=2000):
    """Relative change of the spin of the free body over a time, from its frame."""
    mbs = exu.SystemContainer().AddSystem()
    body = add_body(mbs, speed, speed)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, duration
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.solution.file.write = False
    mbs.SolveDynamic(settings)
    kind = exu.OutputVariableType.AngularVelocityLocal
    return mbs.GetNodeOutput(body["nRigidBody"], kind)[2] / speed - 1


def named(text):
    """NAME=k or NAME=kx,ky as (name, numbers)."""
    name, _, numbers = text.rpartition("=")
    return name, [float(x) for x in numbers.split(",")]


def main():
    options = argparse.ArgumentParser(description="A flexible body in Exudyn.")
    options.add_argument("--spring", type=named, action="append", default=[], help="NAME=N/m")
    options.add_argument("--count", type=int, default=12, help="number of frequencies")
    options.add_argument("--speed", type=float, help="rad/s")
    options.add_argument("--time", type=float, default=0.02, help="s")
    given = options.parse_args()
    for title, springs in (("free", []), ("on springs", given.spring)):
        print(f"{title}, at rest, without stiffening by spin: frequency in Hz")
        mbs = exu.SystemContainer().AddSystem()
        body = add_body(mbs, stiffened_at=0.0)
        for interface, stiffness in springs:
            add_bearing(mbs, body, interface, stiffness)
        found = frequencies(mbs)
        for value in found[found > 1e-5 * found.max()][: given.count]:
            print(f"{value:.10g}")
    if given.speed:
        drift = spin_freely(given.speed, given.time)
        print(f"free, {given.speed:g} rad/s, {given.time:g} s: change of the spin {drift:.3g}")


if __name__ == "__main__":
    main()
'''
