"""Magnetic bearings apart from their rotor, and the state matrix of both.

Unknown are q, its rate, and the states x of all controllers,
M q'' + V q' + K q = −Σ Aᵀ ki (C x + D S q + R S q'), x' = A x + B S q, with A q the motion at the
magnets and S q that at the sensors.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.magnetic_laws import magnetic_bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem, LawJoint, matrices_at_speed
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing
from solidwhirl.rotordyn.core.arrays import FloatArray


class Loop(NamedTuple):
    """A magnetic bearing of a system: motion per coordinate of its magnets and sensors, (2, n)."""

    name: str
    bearing: MagneticBearing
    magnets: FloatArray
    sensors: FloatArray


class Controlled(NamedTuple):
    """A system without its magnetic bearings, and these."""

    system: AssembledSystem
    loops: tuple[Loop, ...]


def controlled(assembled: AssembledSystem) -> Controlled:
    """Take the magnetic bearings out of a system."""
    others = tuple(j for j in assembled.law_joints if magnetic_bearing(j.law) is None)
    found = [_loop(joint) for joint in assembled.law_joints]
    loops = tuple(loop for loop in found if loop is not None)
    return Controlled(replace(assembled, law_joints=others), loops)


class _Matrices(NamedTuple):
    """M q'' + V q' + K q + F x = 0 and x' = A x + B q, all loops closed."""

    mass: FloatArray
    velocity: FloatArray
    stiffness: FloatArray
    force: FloatArray
    states: FloatArray
    seen: FloatArray


def _matrices(parts: Controlled, speed_rad_s: float) -> _Matrices:
    mass, damping, gyroscopic, stiffness = matrices_at_speed(parts.system, speed_rad_s)
    velocity = damping + gyroscopic
    force, states, seen = [], [], []
    for _, bearing, magnets, sensors in parts.loops:
        own, gain = bearing.controller, bearing.current_stiffness_n_per_a
        held = bearing.negative_stiffness_n_per_m * magnets.T @ magnets
        stiffness = stiffness + gain * magnets.T @ own.d @ sensors - held
        velocity = velocity + gain * magnets.T @ own.gain_of_rate @ sensors
        force.append(gain * magnets.T @ own.c)
        states.append(own.a)
        seen.append(own.b @ sensors)
    size = sum(len(own) for own in states)
    joined = la.block_diag(*states) if size else np.zeros((0, 0))
    return _Matrices(mass, velocity, stiffness, np.hstack(force), joined, np.vstack(seen))


def state_matrix(parts: Controlled, speed_rad_s: float) -> FloatArray:
    """Return the state matrix on (q, q', x) at a speed."""
    found = _matrices(parts, speed_rad_s)
    n, states = len(found.mass), found.states
    factor = la.cho_factor(found.mass)
    right = (found.stiffness, found.velocity, found.force)
    pushed = [la.cho_solve(factor, m) for m in right]
    return np.block(
        [
            [np.zeros((n, n)), np.eye(n), np.zeros((n, len(states)))],
            [-pushed[0], -pushed[1], -pushed[2]],
            [found.seen, np.zeros((len(states), n)), states],
        ]
    )


def _loop(joint: LawJoint) -> Loop | None:
    bearing = magnetic_bearing(joint.law)
    if bearing is None:
        return None
    return Loop(joint.bearing, bearing, joint.motion[:2], joint.motion[-2:])
