"""All motions of a rotor in magnetic bearings, with the states of the controllers among them.

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
from solidwhirl.rotordyn.core.dense import (
    Spectrum,
    apart_from_zeros,
    iterated,
    reciprocal,
    scale_by_stiffness,
)
from solidwhirl.rotordyn.core.ledger import solved

# A system of this condition has motions that nothing holds; others are found beside this part of
# the softest.
_SINGULAR, _SLOW = 1e13, 1e-3
# Roots with less turning than this part of them are real.
_TURNING = 1e-7


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


def has_controllers_alone(assembled: AssembledSystem) -> bool:
    """Tell whether all bearings that depend on the frequency are magnetic, one or more."""
    laws = assembled.frequency_laws
    return bool(laws) and all(magnetic_bearing(law) is not None for law in laws)


def controlled_motions(parts: Controlled, speed_rad_s: float) -> Spectrum:
    """Return all motions of rotor and controllers with all loops closed.

    `speed_rad_s`: Ω. Other bearings that depend on the frequency are taken at that of the spin.
    Roots that oscillate have shapes of the coordinates of the rotor, (n, m); zeros of motions that
    nothing holds are left out.
    """
    found = _matrices(parts, speed_rad_s)
    even, mass = 0.5 * (found.stiffness + found.stiffness.T), found.mass
    scale = scale_by_stiffness(even, mass, parts.system.body_rate).scale
    n, states = len(mass), len(found.states)
    shift = 0.0
    if np.linalg.cond(_balanced(_slow(found, scale, 0.0))[0]) > _SINGULAR:
        shift = _SLOW / float(np.sqrt((scale**2 * np.diag(mass)).max()))
    # from the inverse, so that slow motions keep their digits
    velocity = found.velocity + shift * mass
    right = np.zeros((n + states, 2 * n + states))
    right[:n, :n] = -scale[:, None] * velocity * scale
    right[:n, n : 2 * n] = -scale[:, None] * mass * scale
    right[n:, 2 * n :] = np.eye(states)
    held, rows, columns = _balanced(_slow(found, scale, shift))
    moved = la.solve(held, right / rows) / columns
    rates = shift * moved[:n]
    rates[:, :n] += np.eye(n)
    inverse = np.vstack((moved[:n], rates, moved[n:]))
    solved("eigenproblems")
    reciprocals, vectors = la.eig(inverse, check_finite=False)
    values = shift + reciprocal(reciprocals)
    # the inverse errs by the rounding of the slowest motion, the problem at a root by its own
    outer = np.append(scale, np.ones(states))
    problem = tuple(outer[:, None] * m * outer / rows / columns.T for m in _quadratic(found))
    shapes = columns * np.delete(vectors, slice(n, 2 * n), axis=0)
    for at in np.flatnonzero(values.imag > _TURNING * np.abs(values)):
        values[at], shapes[:, at] = iterated(complex(values[at]), shapes[:, at], problem)
    vectors[:n] = shapes[:n] / columns[:n]
    return apart_from_zeros(values, scale[:, None] * vectors[:n], 1e-3 * shift)


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


def _quadratic(found: _Matrices) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return M, V and K of (q, x), of which the states have no mass."""
    none = np.zeros_like(found.states)
    return (
        la.block_diag(found.mass, none),
        la.block_diag(found.velocity, np.eye(len(none))),
        np.block([[found.stiffness, found.force], [-found.seen, -found.states]]),
    )


def _slow(found: _Matrices, scale: FloatArray, rate: float) -> FloatArray:
    """Return what a slow motion e^{st} is held by, on coordinates over a scale and on states."""
    held = found.stiffness + rate * found.velocity + rate**2 * found.mass
    return np.block(
        [
            [scale[:, None] * held * scale, scale[:, None] * found.force],
            [found.seen * scale, found.states - rate * np.eye(len(found.states))],
        ]
    )


def _balanced(matrix: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a matrix whose rows and columns have units of their own without these, and them.

    The units, (n, 1) each: matrix = rows · balanced · columnsᵀ.
    """
    units = [np.ones((len(matrix), 1)), np.ones((1, len(matrix)))]
    for axis in (0, 1, 0, 1):
        size = np.abs(matrix).max(axis=axis, keepdims=True)
        size[size == 0.0] = 1.0
        matrix = matrix / size
        units[1 - axis] = units[1 - axis] * size
    return matrix, units[0], units[1].T


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
