"""A meshed rotor with blades on bearings, in the frame that turns with it, with all its harmonics.

The whole circle of the mesh has forms of its own; its fields are those of the indices 0, 1 and 2.
The superelement, in coordinates at rest with the index 1 and 0 alone, has its Floquet multipliers
and follows its run-up.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from reduced import reduced_to, requested
from whole_circle import Turning, WholeCircle

sys.path += [str(Path(__file__).parents[1] / name) for name in ("meshing", "rotordyn")]
from rotors import connect, one_rotor
from shapes import bladed_disk
from sometimes import often
from turning_frame import floquet_multipliers, unbalance_run_up

from solidwhirl import rotordyn as rd
from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.reduction.body.reduced_order import reduce_order
from solidwhirl.reduction.body.request import order_operators
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

pytestmark = pytest.mark.solver

COARSE = MeshSize(size_m=0.04, corner_size_m=0.02, growth=1.0)
TOP = 3000.0
ASKED = {
    "components": COMPONENTS,
    "modes": 2,
    "maximum_speed_rad_s": TOP,
    "gyroscopic": True,
    "centrifugal": True,
}
EYE, CROSS = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
# Per 1e7 N/m, 5e4 N m/rad; whirl at 2000 rad/s, and damping of some per cent.
SUPPORTS = {
    "same in all directions": (EYE, 0.0 * EYE, EYE, 0.0 * EYE),
    "planes": (np.diag([1.0, 2.5]), 0.0 * EYE, np.diag([1.0, 0.5]), 0.0 * EYE),
    "damped, cross terms": (
        np.diag([1.0, 2.5]) + 0.2 * CROSS,
        1e-5 * (np.diag([1.0, 2.0]) + 0.3 * CROSS),
        EYE,
        1e-5 * EYE,
    ),
}


def hold(support):
    return [a * unit for a, unit in zip(SUPPORTS[support], (1e7, 1e7, 5e4, 5e4), strict=True)]


@pytest.fixture(scope="module")
def rotor():
    """The superelement, and (M, C, K, K2) of the turning whole with the motion of its bore."""
    body = bladed_disk(5)
    mesh = mesh_sector(body, COARSE)
    element, _ = reduced_to(body, "solid", mesh=mesh, orders=(0, 1), **ASKED)
    whole, fields = WholeCircle(mesh), []
    for index in (0, 1, 2):
        asked = requested("solid", orders=(index,), **ASKED)
        operators = order_operators(body, mesh, MPI.COMM_SELF, asked, index)
        basis, _ = reduce_order(operators, asked, np.zeros((0, 3)))
        laid = whole.fields(operators, basis.vectors)
        fields += [laid.real, laid.imag] if np.iscomplexobj(laid) else [laid]
        basis.factor.destroy()
        operators.release()
    fields = np.hstack(fields)
    small = Turning(*(a.tocsr() for a in whole.matrices)).projected(fields)
    turning = (small.mass, small.coriolis.imag, small.stiffness, small.centrifugal.real)
    at = whole.on("bore")
    moved = fields.reshape(len(whole.points), 3, -1)[at].reshape(3 * len(at), -1)
    rigid = _rigid(whole.points[at])
    port = np.linalg.lstsq(rigid, moved, rcond=None)[0]
    assert np.abs(rigid @ port - moved).max() < 1e-12 * np.abs(moved).max()
    return element, turning, port


def _rigid(points):
    """Motions ux uy uz rx ry rz of points, (3m, 6)."""
    shift = np.tile(np.eye(3), (len(points), 1))
    turn = [np.cross(e, points).ravel() for e in np.eye(3)]
    return np.hstack([shift, np.column_stack(turn)])


def on(element, support):
    names = ("stiffness", "damping", "tilt", "drag")
    held = connect("bearing", "rotor.bore", **dict(zip(names, hold(support), strict=True)))
    return one_rotor(element, [held])


@pytest.mark.parametrize("support", often(SUPPORTS, "damped, cross terms"))
def test_floquet_multipliers(rotor, support):
    element, turning, port = rotor
    system = on(element, support)
    modes = rd.modes_at_speed(system, TOP)
    values = np.concatenate((modes.eigenvalues, modes.eigenvalues.conj(), modes.real_eigenvalues))
    assert values.size + modes.zero_count == 2 * system.size
    known = floquet_multipliers(turning, port, TOP, hold(support))
    # the index 2 of the whole is not among those of the superelement
    assert len(known) > values.size
    found = np.exp(2.0 * np.pi / TOP * values)
    apart = np.abs(known - found[:, None]).min(axis=1)
    # of motions of 4e4 Hz for a turn, in steps good to 1e-12
    assert (apart < 1e-8 * np.abs(found)).all()


@pytest.mark.verify
def test_run_up(rotor):
    """Speed that rises pushes the blades against the hub: half of G is in the answer."""
    element, turning, port = rotor
    support, moment, start, rise, end = "damped, cross terms", 1e-3, 500.0, 1e5, 0.005
    profile = SpeedProfile(times_s=[0.0, end], speeds_rad_s=[start, start + rise * end])
    run = run_up(
        on(element, support),
        profile,
        [Unbalance(body="rotor", interface="bore", moment_kg_m=moment)],
        step_s=1e-5,
        outputs=[rd.End(body="rotor", interface="bore")],
    )
    found = run.translation_m[0, 0] + 1j * run.translation_m[0, 1]
    given = (turning, port, hold(support), moment, (start, rise), run.time_s)
    known, without = (unbalance_run_up(*given, euler=euler) for euler in (True, False))
    size = np.abs(known).max()
    # the fourth power of a step that turns the highest mode by 2.6 rad
    assert np.abs(found - known).max() < 1e-6 * size
    assert np.abs(without - known).max() > 1e-3 * size
