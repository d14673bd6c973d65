"""Modes of systems whose bearings depend on the frequency: controllers and laws over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem, at_rate, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.spectrum import spectrum
from solidwhirl.rotordyn.paths.frequency_roots import (
    FrequencyRoot,
    constant_law_roots,
    frequency_roots,
)

# Roots with less turning than this part of them are real.
_TURNING = 1e-9
# A mode in which the rotor moves less than this part of its controllers' states is theirs alone.
_ROTOR = 1e-12
# Newton's steps on a law that knows its force at any rate, relative accuracy, and relative step of
# its derivative; how far (relative) a root may lie from that of the law at |Im s|.
_STEPS, _AT_REST, _STEP, _FARTHEST = 20, 1e-13, 1e-6, 0.5


class ModesWithLaws(NamedTuple):
    """All roots of a system whose bearings depend on the frequency.

    `values`: s with Im s > 0, rising, (m,); `shapes`: of the coordinates of the bodies, (n, m);
    `signs`: 1, or −1 for roots that a law makes by rising too steeply, (m,); `real_values`: others,
    rising; `zero_count`, `negative_count`: as of `Modes`.
    """

    values: ComplexArray
    shapes: ComplexArray
    signs: IntArray
    real_values: FloatArray
    zero_count: int
    negative_count: int


def modes_with_laws(assembled: AssembledSystem, speed_rad_s: float) -> ModesWithLaws:
    """Return all modes of a system with bearings that depend on the frequency.

    `speed_rad_s`: Ω. Laws over the frequency are read at |Im s| of each mode, added mass and all;
    controllers are states. None is missing and none is made up: see `frequency_roots`. Laws that
    know their force at any rate s, decay and all, are followed to it. Real roots are those of the
    bearings for slow motions.
    """
    operator = operator_of(assembled)
    if operator.frequency_knots:
        still = spectrum(operator, speed_rad_s, 0.0)
        roots = frequency_roots(operator, speed_rad_s)
        roots = [root for root in roots if root.value.imag > _TURNING * abs(root.value)]
        if any(not law.is_table for law in assembled.frequency_laws):
            roots = _at_own_rate(assembled, operator, speed_rad_s, roots)
    else:
        still = spectrum(operator, speed_rad_s)
        roots = constant_law_roots(still)
        roots.sort(key=lambda root: (root.value.imag, root.value.real))
    n = assembled.size
    roots = [root for root in roots if _moves_rotor(root.right, n)]
    values = np.array([root.value for root in roots], dtype=complex)
    shapes = np.array([root.right[:n] for root in roots], dtype=complex).reshape(-1, n).T
    real = still.values[np.abs(still.values.imag) <= _TURNING * np.abs(still.values)].real
    slow = matrices_at_speed(at_rate(assembled, 0j), speed_rad_s)
    even = 0.5 * (slow.stiffness + slow.stiffness.T)
    return ModesWithLaws(
        values,
        shapes,
        np.array([root.sign for root in roots], dtype=int),
        np.sort(real[real != 0]),
        int(np.count_nonzero(still.values == 0)),
        scale_by_stiffness(even, slow.mass, assembled.body_rate).negative_count,
    )


def _moves_rotor(vector: ComplexArray, n: int) -> bool:
    return bool(np.abs(vector[:n]).max() > _ROTOR * np.abs(vector).max())


def _at_own_rate(
    assembled: AssembledSystem, operator: SecondOrder, speed: float, roots: list[FrequencyRoot]
) -> list[FrequencyRoot]:
    """Follow roots from the law at |Im s| to the law at s, by Newton's method on the whole."""

    def dynamic(rate: complex) -> ComplexArray:
        whole = operator.at(speed, abs(rate.imag)).value(rate)
        for joint in assembled.law_joints:
            law = joint.frequency_law
            if law is None or law.is_table or joint.motion.shape[0] != law.size:
                continue
            spin = abs(joint.speed_ratio * speed)
            stiffness, damping, mass = law.at_frequency(spin, abs(rate.imag))
            own = law.dynamic_stiffness(spin, rate)
            change = own - (stiffness + rate * damping + rate**2 * mass)
            n = joint.motion.shape[1]
            whole[:n, :n] += joint.motion.T @ change @ joint.motion
        return whole

    found = []
    for root in roots:
        value, vectors = root.value, np.stack((root.right, root.left), axis=1)
        for _ in range(_STEPS):
            step = _STEP * abs(value)
            slope = (dynamic(value + step) - dynamic(value - step)) / (2.0 * step)
            here = dynamic(value * (1.0 + 1e-12))
            right = la.solve(here, slope @ vectors[:, 0])
            left = la.solve(here.conj().T, slope.conj().T @ vectors[:, 1])
            vectors = np.stack((right / la.norm(right), left / la.norm(left)), axis=1)
            miss = left.conj() @ dynamic(value) @ right / (left.conj() @ slope @ right)
            value = complex(value - miss)
            if abs(miss) <= _AT_REST * abs(value):
                break
        if abs(value - root.value) <= _FARTHEST * abs(root.value) and value.imag > 0:
            found.append(root._replace(value=value, right=vectors[:, 0]))
    return found
