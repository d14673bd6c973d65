"""Shafts of steel as ROSS and this program take them, and what ROSS returns."""

from __future__ import annotations

import numpy as np

STEEL = {"E": 211e9, "G": 81.2e9, "rho": 7810.0}


def disk(node, width_m, outer_m, bore_m=0.05):
    mass = STEEL["rho"] * np.pi / 4 * (outer_m**2 - bore_m**2) * width_m
    polar = mass * (outer_m**2 + bore_m**2) / 8
    diametral = polar / 2 + mass * width_m**2 / 12
    return {"node": node, "mass": mass, "polar": polar, "diametral": diametral}


def bearing(node, kx, ky=None, cx=0.0, cy=0.0, kxy=0.0, kyx=0.0, **more):
    stiffness = [[kx, kxy], [kyx, kx if ky is None else ky]]
    return {"node": node, "stiffness": stiffness, "damping": [[cx, 0.0], [0.0, cy]], **more}


def shaft(bearings, disks=None, nodes_m=None, outer=0.025, inner=0.0, first_node=0):
    nodes = np.linspace(0.0, 1.5, 7) if nodes_m is None else np.asarray(nodes_m)
    count = nodes.size - 1
    return {
        "nodes_m": nodes.tolist(),
        "outer_radius_m": np.broadcast_to(outer, count).tolist(),
        "inner_radius_m": np.broadcast_to(inner, count).tolist(),
        "disks": [disk(2, 0.07, 0.28), disk(4, 0.07, 0.35)] if disks is None else disks,
        "bearings": bearings,
        "first_node": first_node,
    }


def complex_of(pairs):
    return np.array(pairs)[..., 0] + 1j * np.array(pairs)[..., 1]
