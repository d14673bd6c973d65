"""A body as linear equations for Exudyn: a Python file that is ready to run, and its data."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.python import python_files
from solidwhirl.rotordyn.superelement.record import Superelement


def write_exudyn(element: Superelement, path: str | Path) -> Exported:
    """Write a body as a linear object for Exudyn, in the inertial frame.

    `path`: the Python file, named `.py`; the numbers go into an `.npz` file of the same name beside
    it. Raises SuperelementError if the path has another ending.

    The object is Exudyn's `ObjectGenericODE2` with M, K + Ω² (Kgeo − S) and Ω G, or user
    functions of the same terms and ½ Ω' G where the speed varies. A tied body is written in its
    independent coordinates r. Tested with Exudyn 1.13.6.
    """
    arrays = {
        **python_files.matrices(element),
        **python_files.coordinate_arrays(element),
        "B": np.eye(element.size) if element.constraint is None else element.constraint,
    }
    return Exported(
        files=python_files.write_python(path, _TEXT, element, arrays),
        carried=(*python_files.LINEAR_TERMS, "interfaces with their coordinates"),
        left_out=(
            "The motion is small, in fixed axes: the body can't travel, and its spin is given, "
            "not computed from torques.",
            "Shapes for pictures, error forms and provenance stay in the superelement file.",
        ),
    )


_TEXT = '''\
"""A rotating body as linear equations for Exudyn, in fixed (inertial) axes, SI units.

M q'' + W G q' + (K0 + W^2 K2 + W'/2 G) q = f, where W is the spin about +z in rad/s.

Frequencies of the free body, and of the body on springs (N/m, on x and y) at a speed (rad/s):

    python FILE.py --speed 1000 --spring INTERFACE=5e7 --spring OTHER=5e7,4e7

In models of your own: import this file, then add_body, with a speed or for a run-up a ramp,
add_bearing, marker for other connectors, add_force, unbalance.
The numbers are in the .npz file of the same name. Needs numpy, scipy and exudyn.
"""

import argparse
from pathlib import Path

import exudyn as exu
import exudyn.itemInterface as eii
import numpy as np

# @BODY@
DATA = Path(__file__).with_suffix(".npz")


class Body:
    """Matrices, places of the interfaces and, once added to a system, the number of the node."""

    def __init__(self, file=DATA):
        with np.load(file, allow_pickle=False) as data:
            # q = B r: r are the coordinates here, the same as q unless the body is tied
            self.M, self.K0, self.K2, self.G, self.B = (data[k] for k in "M K0 K2 G B".split())
            rows = zip(data["interface"].tolist(), data["component"].tolist())
            # (interface, "ux" ... "rz") -> row of B
            self.row = {key: i for i, key in enumerate(rows) if key[1] != "q"}
            self.position = dict(zip(data["interface_name"].tolist(), data["interface_xyz"]))
        self.node = self.object = None

    def motion(self, interface, components=("ux", "uy")):
        """Rows that turn the coordinates into motions of an interface."""
        try:
            return self.B[[self.row[interface, c] for c in components]]
        except KeyError as key:
            raise ValueError(f"no {key}; there are {sorted(self.row)}") from None


def ramp(start, stop, duration):
    """Spin that rises evenly: function from time to (angle, speed, acceleration)."""
    rate = (stop - start) / duration
    return lambda t: (start * t + rate * t * t / 2, start + rate * t, rate)


def add_body(mbs, speed=0.0, body=None):
    """Add the body at a constant speed (a number, rad/s) or with a spin such as ramp()."""
    body = body or Body()
    zero = [0.0] * len(body.M)
    body.node = mbs.AddNode(eii.NodeGenericODE2("", zero, zero, zero, len(zero)))
    terms = {"massMatrix": body.M, "stiffnessMatrix": body.K0}
    if callable(speed):

        def force(mbs, t, item, q, q_t):
            _, w, rate = speed(t)
            q, q_t = np.asarray(q), np.asarray(q_t)
            return -(w * w * (body.K2 @ q) + body.G @ (w * q_t + rate / 2 * q))

        def jacobian(mbs, t, item, q, q_t, factor, factor_t):
            _, w, rate = speed(t)
            return factor * (w * w * body.K2 + rate / 2 * body.G) + factor_t * w * body.G

        terms |= {"forceUserFunction": force, "jacobianUserFunction": jacobian}
        terms["dampingMatrix"] = 0.0 * body.G
    else:
        terms["stiffnessMatrix"] = body.K0 + speed**2 * body.K2
        terms["dampingMatrix"] = speed * body.G
    body.object = mbs.AddObject(eii.ObjectGenericODE2(nodeNumbers=[body.node], **terms))
    return body


def add_bearing(mbs, body, interface, stiffness, damping=0.0, other=None):
    """Hold x and y of an interface; stiffness and damping: a number, two, or a 2 x 2 matrix.

    other: (body, interface) at the far end; the ground if it is None.
    """
    ends, rows = [body.node], body.motion(interface)
    if other is not None:
        ends.append(other[0].node)
        rows = np.hstack([rows, -other[0].motion(other[1])])
    k, c = (
        x if np.ndim(x) == 2 else np.diag(np.broadcast_to(x, 2)) for x in (stiffness, damping)
    )
    matrices = {"stiffnessMatrix": rows.T @ k @ rows, "dampingMatrix": rows.T @ c @ rows}
    nothing = np.zeros((rows.shape[1],) * 2)
    return mbs.AddObject(eii.ObjectGenericODE2(nodeNumbers=ends, massMatrix=nothing, **matrices))


def add_force(mbs, body, interface, force):
    """Put a force(t) = (fx, fy) on an interface."""
    rows = body.motion(interface)
    nothing = np.zeros((rows.shape[1],) * 2)
    return mbs.AddObject(
        eii.ObjectGenericODE2(
            nodeNumbers=[body.node],
            massMatrix=nothing,
            stiffnessMatrix=nothing,
            dampingMatrix=nothing,
            forceUserFunction=lambda mbs, t, item, q, q_t: rows.T @ np.asarray(force(t)),
            jacobianUserFunction=lambda mbs, t, item, q, q_t, factor, factor_t: nothing,
        )
    )


def unbalance(moment, spin, phase=0.0):
    """Force of an unbalance (kg m) that turns with the body, for add_force."""

    def force(t):
        angle, w, rate = spin(t)
        c, s = np.cos(angle + phase), np.sin(angle + phase)
        return moment * np.array([w * w * c + rate * s, w * w * s - rate * c])

    return force


def marker(mbs, body, interface, component):
    """Marker of one coordinate, for Exudyn's CoordinateSpringDamper, LoadCoordinate and so on."""
    (row,) = body.motion(interface, [component])
    if np.count_nonzero(row) != 1 or row.max() != 1.0:
        raise ValueError(f"{interface} {component} is no coordinate of its own; use add_bearing")
    return mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=body.node, coordinate=row.argmax()))


def eigenvalues(mbs):
    """Eigenvalues in 1/s with positive imaginary part, rising; rigid motions left out."""
    mbs.Assemble()
    found, _ = mbs.ComputeODE2Eigenvalues(computeComplexEigenvalues=True, useAbsoluteValues=False)
    found = np.asarray(found)[np.imag(found) > 1e-6 * np.abs(found).max()]
    return found[np.argsort(found.imag)]


def named(text):
    """NAME=k or NAME=kx,ky as (name, numbers)."""
    name, _, numbers = text.rpartition("=")
    return name, [float(x) for x in numbers.split(",")]


def main():
    options = argparse.ArgumentParser(description="A rotating body in Exudyn.")
    options.add_argument("--speed", type=float, default=0.0, help="rad/s")
    options.add_argument("--spring", type=named, action="append", default=[], help="NAME=N/m")
    options.add_argument("--count", type=int, default=12, help="number of frequencies")
    given = options.parse_args()
    for title, springs in (("free", []), ("on springs", given.spring)):
        print(f"{title}, {given.speed:g} rad/s: frequency in Hz, growth in 1/s")
        mbs = exu.SystemContainer().AddSystem()
        body = add_body(mbs, given.speed)
        for interface, stiffness in springs:
            add_bearing(mbs, body, interface, stiffness)
        for value in eigenvalues(mbs)[: given.count]:
            print(f"{value.imag / (2 * np.pi):.10g} {value.real:.3g}")


if __name__ == "__main__":
    main()
'''
