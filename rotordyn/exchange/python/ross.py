"""A body as a rotor of ROSS: a Python file that is ready to run, and its data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.python import python_files
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS

_LATERAL = {"ux", "uy"}
# Spare coordinates vibrate this far above the highest frequency of the body.
_SPARE_RATIO = 2.0
_SPARE_RAD_S = 1e4


def write_ross(element: Superelement, path: str | Path) -> Exported:
    """Write a body as a `Rotor` for ROSS.

    `path`: the Python file, named `.py`; the numbers go into an `.npz` file of the same name beside
    it. Raises SuperelementError if the path has another ending, or the body is tied, so that its
    interfaces have no coordinates of their own.

    ROSS (2.3.0 and 3.1.0) has six coordinates x, y, z, α, β, θ at each node, which are ux to rz
    here with the same signs. Interfaces are nodes, in the order of their z; modal coordinates
    follow behind all nodes.
    """
    if element.constraint is not None and element.constraint.shape[1] < element.size:
        raise SuperelementError(
            f"superelement {element.name!r}: its interfaces are tied to each other "
            f"({element.size} coordinates, {element.constraint.shape[1]} of them independent); "
            "ROSS needs coordinates of its own at every node. Allowed are bodies without "
            "'constraint'"
        )
    arrays = {
        **python_files.matrices(element),
        **python_files.coordinate_arrays(element),
        "spare": _spare(element),
        "mass": np.array(element.mass_kg),
        "center": element.center_of_gravity_m,
        "inertia": element.inertia_kg_m2,
    }
    files = python_files.write_python(path, _TEXT, element, arrays)
    return Exported(files=files, carried=_CARRIED, left_out=_left_out(element))


def _spare(element: Superelement) -> FloatArray:
    """Return mass, inertia and rate squared of coordinates that only ROSS has."""
    highest = la.eigvalsh(element.stiffness, element.mass)[-1]
    rate = max(_SPARE_RATIO * np.sqrt(max(highest, 0.0)), _SPARE_RAD_S)
    return np.array([element.mass_kg, np.linalg.eigvalsh(element.inertia_kg_m2)[-1], rate**2])


_CARRIED = (
    *python_files.LINEAR_TERMS,
    "interfaces as nodes; disks, bearings and seals of ROSS can be put on them",
)


def _left_out(element: Superelement) -> tuple[str, ...]:
    """Return what ROSS does not get, or not as it is."""
    said = [
        "ROSS draws straight placeholders and cubic curves between the nodes, not the body.",
        "Static sag, bending moments, cracks, misalignment, the map over support stiffness, "
        "synchronous matrices, pure torsion, motors, other meshes, saving, and rotors joined by "
        "gears or bearings need ROSS's own shaft elements; these functions stop with an error.",
        "Shapes for pictures, error forms and provenance stay in the superelement file.",
    ]
    lacking = [
        f"{node.name!r} ({', '.join(m for m in MOTIONS if m not in has)})"
        for node in element.interfaces
        if len(has := element.components_at(node.name)) < len(MOTIONS)
    ]
    if lacking:
        said.insert(
            0,
            f"The body has no coordinate for {'; '.join(lacking)}: the node of ROSS has one that "
            "is not connected to the body; its motion is left out of the modes.",
        )
    if any(np.hypot(*node.position_m[:2]) > 0.0 for node in element.interfaces):
        said.append("ROSS puts all nodes on the axis; x and y of the interfaces are not kept.")
    if len(element.interfaces) == 1:
        said.append("ROSS needs two nodes; the second one is not connected to the body.")
    return tuple(said)


_TEXT = '''\
"""A rotating body as a rotor of ROSS, SI units; written for ROSS 2.3.0 and 3.1.0.

M q'' + W G q' + (K0 + W^2 K2) q = f, where W is the spin about +z in rad/s.

Frequencies of the free body, and of the body on springs (N/m, on x and y) at a speed (rad/s):

    python FILE.py --speed 1000 --spring INTERFACE=5e7 --spring OTHER=5e7,4e7

In models of your own: import this file, then for example

    at = nodes()
    rotor = BodyRotor(bearing_elements=[ross.BearingElement(n=at["INTERFACE"], kxx=5e7, cxx=1e3)])
    rotor.run_campbell(speeds); rotor.run_unbalance_response(at["OTHER"], 1e-4, 0.0, speeds)

The numbers are in the .npz file of the same name.
"""

import argparse
import inspect
from pathlib import Path

import numpy as np
import ross
import scipy.linalg as la

# @BODY@
DATA = Path(__file__).with_suffix(".npz")
COMPONENTS = ["ux", "uy", "uz", "rx", "ry", "rz"]  # x, y, z, alpha, beta, theta in ROSS


# ROSS 3 reads bearings at a speed and a frequency of the motion, ROSS 2 at one of the two
HAS_SPEED = "speed" in inspect.signature(ross.Rotor.K).parameters


def asked(frequency, speed):
    """Arguments of ROSS's matrices."""
    return (frequency, speed) if HAS_SPEED else (frequency,)


def load(file=DATA):
    """Arrays of the body."""
    with np.load(file, allow_pickle=False) as data:
        return {key: data[key] for key in data.files}


def nodes(body=None):
    """Number of the node of each interface, in the order of z."""
    body = body or load()
    order = np.argsort(body["interface_xyz"][:, 2], kind="stable")
    return {body["interface_name"][i].item(): node for node, i in enumerate(order)}


class Placeholder(ross.ShaftElement):
    """Stretch between two nodes, without mass or stiffness: the matrices are those of the body."""

    def M(self):
        return np.zeros((12, 12))

    K = C = G = Kst = M


class BodyRotor(ross.Rotor):
    """The body as a rotor; the coordinates of its modes follow behind those of all nodes."""

    def __init__(self, disk_elements=None, bearing_elements=None, point_mass_elements=None, **more):
        body = load()
        at, z = nodes(body), np.sort(body["interface_xyz"][:, 2])
        z = np.append(z, z[-1] + 0.1) if z.size == 1 else z  # ROSS needs two nodes
        length = z[-1] - z[0]
        steel = ross.Material(name="placeholder", rho=7850.0, E=2.1e11, G_s=8e10)
        # two interfaces in one plane: a length for the pictures only
        lengths = np.maximum(np.diff(z), 1e-6 * max(length, 1e-3))
        shaft = [Placeholder(x, 0.0, 0.1 * lengths.sum(), material=steel) for x in lengths]
        super().__init__(shaft, disk_elements, bearing_elements, point_mass_elements, **more)
        self._put_matrices(body, at)
        self._put_mass_properties(body, z[0])

    def _put_matrices(self, body, at):
        """Add the body's matrices to those of disks and point masses."""
        place, end = [], self.ndof
        for name, component in zip(body["interface"].tolist(), body["component"].tolist()):
            modal = component == "q"
            place.append(end if modal else 6 * at[name] + COMPONENTS.index(component))
            end += modal
        there = np.ix_(place, place)
        # coordinates that the body lacks: masses of their own, far above its frequencies
        self.spare = spare = np.setdiff1d(np.arange(6 * len(self.nodes)), place)
        mass, inertia, square = body["spare"]
        weight = np.where(spare % 6 < 3, mass, inertia)
        for name, own in {"M0": "M", "K0": "K0", "G0": "G", "C0": None, "Ksdt0": "G"}.items():
            full = np.pad(getattr(self, name), (0, end - self.ndof))
            if own:
                full[there] += body[own] * (0.5 if name == "Ksdt0" else 1.0)
            setattr(self, name, full)
        self.M0[spare, spare] += weight
        self.K0[spare, spare] += weight * square
        self.K2 = np.zeros((end, end))  # times the speed squared
        self.K2[there] = body["K2"]
        self.ndof = end

    def _put_mass_properties(self, body, start):
        """Mass, centre of gravity (from the first node) and inertias with the disks."""
        own, tensor = float(body["mass"]), body["inertia"]
        parts = [(own, body["center"][2] - start, tensor[0, 0], tensor[2, 2])]
        parts += [(d.m, self.nodes_pos[d.n], d.Id, d.Ip) for d in self.disk_elements]
        m, z, diametral, polar = np.array(parts).T
        self.m_shaft, self.m, self.CG, self.Ip = own, m.sum(), m @ z / m.sum(), polar.sum()
        self.It = diametral.sum() + m @ (z - self.CG) ** 2

    def M(self, frequency=None, speed=None, synchronous=False):
        if synchronous:
            raise NotImplementedError("synchronous matrices need ROSS's own shaft elements")
        return super().M(*asked(frequency, speed))

    def K(self, frequency, speed=None):
        """Stiffness at a speed; where ROSS names one value alone it is that of both."""
        turning = frequency if speed is None else speed
        return super().K(*asked(frequency, speed)) + (turning or 0.0) ** 2 * self.K2

    def A(self, speed=0, frequency=None, synchronous=False):
        at = asked(speed if frequency is None else frequency, speed)
        M = self.M(at[0], speed, synchronous)
        K = super().K(*at) + speed**2 * self.K2
        rates = -la.solve(M, np.hstack([K, self.C(*at) + speed * self.G()]))
        return np.vstack([np.eye(self.ndof, 2 * self.ndof, self.ndof), rates])

    def _eigen(self, *given, **more):
        values, vectors = super()._eigen(*given, **more)
        motion = np.abs(vectors[: self.ndof])
        size = motion.max(axis=0)
        own = np.delete(motion, self.spare, axis=0).max(axis=0) > 1e-9 * size
        # ROSS divides a shape by the largest lateral motion of a node, which may be none
        lateral = [6 * n + i for n in self.nodes for i in (0, 1)]
        still = motion[lateral].max(axis=0) < 1e-9 * size
        vectors[0, still] = 1e-9 * size[still]
        return values[own], vectors[:, own]

    def run_modal(self, speed, *given, **more):
        modal = super().run_modal(speed, *given, **more)
        modal.ndof = 6 * len(self.nodes)  # shapes are made of the nodes
        modal.update_mode_shapes()
        return modal

    def _rotor_system_for_integrate(self, rotor, speed, t, reduction, forces, **more):
        if np.ndim(speed) == 0:
            return super()._rotor_system_for_integrate(rotor, speed, t, reduction, forces, **more)
        several = isinstance(reduction, (list, tuple))  # of ROSS 3, which wants the forces back
        reduce_matrix = reduction[0] if several else reduction
        M, G, Ksdt = (reduce_matrix(more.get(k, getattr(self, k)())) for k in ("M", "G", "Ksdt"))
        rate = np.gradient(speed, t)

        def system(step, **state):
            return (
                M,
                reduce_matrix(rotor.C(speed[step])) + G * speed[step],
                reduce_matrix(rotor.K(speed[step])) + Ksdt * rate[step],
                forces(step, **state),
            )

        return (system, forces) if several else system

    def _impossible(self, *_, **__):
        raise NotImplementedError("this function of ROSS needs its own shaft elements")

    run_static = run_ucs = run_level1 = run_crack = run_misalignment = _impossible
    add_nodes = add_elements = refine = refine_mesh = run_mesh_convergence = _impossible
    convergence = run_with_motor = summary = save = load = _impossible

    def run_campbell(self, *given, torsional_analysis=False, **more):
        return self._impossible() if torsional_analysis else super().run_campbell(*given, **more)


def named(text):
    """NAME=k or NAME=kx,ky as (name, kx, ky)."""
    name, _, numbers = text.rpartition("=")
    k = [float(x) for x in numbers.split(",")]
    return name, k[0], k[-1]


def main():
    options = argparse.ArgumentParser(description="A rotating body in ROSS.")
    options.add_argument("--speed", type=float, default=0.0, help="rad/s")
    options.add_argument("--spring", type=named, action="append", default=[], help="NAME=N/m")
    options.add_argument("--count", type=int, default=12, help="number of frequencies")
    given, at = options.parse_args(), nodes()
    springs = [ross.BearingElement(n=at[n], kxx=x, kyy=y, cxx=0.0) for n, x, y in given.spring]
    for title, held in (("free", []), ("on springs", springs)):
        print(f"{title}, {given.speed:g} rad/s: frequency in Hz, whirl")
        rotor = BodyRotor(bearing_elements=held)
        modal = rotor.run_modal(given.speed, num_modes=2 * given.count + 12, sparse=False)
        rows = [(w, d) for w, d in zip(modal.wd, modal.whirl_direction()) if w > 0.1]
        for rate, direction in rows[: given.count]:
            print(f"{rate / (2 * np.pi):.10g} {direction}")


if __name__ == "__main__":
    main()
'''
