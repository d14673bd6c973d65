"""A tube as matrices in mm, t and N, made here, and scenes that take it as a casing."""

from __future__ import annotations

import copy

import numpy as np

from solidwhirl.scene_reading.reader import parse_scene

MILLIMETRES = {"length_unit": "mm", "mass_unit": "t"}
# A tube of steel along the file's x axis, in mm, t and N; E in MPa.
LENGTH, OUTER, INNER, MODULUS, DENSITY = 1200.0, 160.0, 150.0, 2.1e5, 7.85e-9
AREA = np.pi * (OUTER**2 - INNER**2)
BENDING = 0.25 * np.pi * (OUTER**4 - INNER**4) * MODULUS
MOUNT_N_PER_MM = 4.0e4


def tube(elements=16):
    """Arrays of a free Euler-Bernoulli tube with six motions per node: nobody's code but this."""
    step = LENGTH / elements
    n = 6 * (elements + 1)
    stiffness, mass = np.zeros((n, n)), np.zeros((n, n))
    k = BENDING / step**3
    bend = k * np.array(
        [
            [12, 6 * step, -12, 6 * step],
            [6 * step, 4 * step**2, -6 * step, 2 * step**2],
            [-12, -6 * step, 12, -6 * step],
            [6 * step, 2 * step**2, -6 * step, 4 * step**2],
        ]
    )
    m = DENSITY * AREA * step / 420.0
    inertia = m * np.array(
        [
            [156, 22 * step, 54, -13 * step],
            [22 * step, 4 * step**2, 13 * step, -3 * step**2],
            [54, 13 * step, 156, -22 * step],
            [-13 * step, -3 * step**2, -22 * step, 4 * step**2],
        ]
    )
    rod = np.array([[1.0, -1.0], [-1.0, 1.0]]) / step
    bar = np.array([[2.0, 1.0], [1.0, 2.0]]) * step / 6.0
    polar = 2.0 * BENDING / MODULUS  # second moment of area about the axis
    shear = MODULUS / 2.6
    for e in range(elements):
        at = 6 * e
        ends = np.array([at, at + 6])
        for first, slope, sign in ((1, 5, 1.0), (2, 4, -1.0)):  # w' = θz of uy, −θy of uz
            rows = [at + first, at + slope, at + 6 + first, at + 6 + slope]
            turn = np.diag([1.0, sign, 1.0, sign])
            stiffness[np.ix_(rows, rows)] += turn @ bend @ turn
            mass[np.ix_(rows, rows)] += turn @ inertia @ turn
        for motion, elastic, heavy in (
            (0, MODULUS * AREA, DENSITY * AREA),
            (3, shear * polar, DENSITY * polar),
        ):
            rows = ends + motion
            stiffness[np.ix_(rows, rows)] += elastic * rod
            mass[np.ix_(rows, rows)] += heavy * bar
    nodes = np.arange(1, elements + 2)
    return {
        "MASS": mass,
        "STIFF": stiffness,
        "dof_node": np.repeat(nodes, 6),
        "dof_component": np.tile(np.arange(1, 7), elements + 1),
        "node_id": nodes,
        "node_position": np.outer(np.linspace(0.0, LENGTH, elements + 1), [1.0, 0.0, 0.0]),
    }  # fmt: skip


ENTRY = {
    "file": "casing.npz",
    "mass": "MASS",
    "stiffness": "STIFF",
    "axes": "yzx",
    "interfaces": {"front": 1, "rear": 17},
    **MILLIMETRES,
}


def mounts(body="casing", stiffness=1e3 * MOUNT_N_PER_MM):
    return [
        {
            "name": end,
            "first": f"{body}.{end}",
            "stiffness_n_per_m": stiffness,
            "axial_stiffness_n_per_m": 1e6,
            "torsion_stiffness_n_m_per_rad": 1e5,
        }
        for end in ("front", "rear")
    ]


def scene_of(entry, folder, **tables):
    """A scene with one imported body, read as if it lay in a folder."""
    name = tables.pop("body", "rotor")
    data = {"name": "small", "imported": {name: entry}, **tables}
    return parse_scene(copy.deepcopy(data), folder / "small.toml")
