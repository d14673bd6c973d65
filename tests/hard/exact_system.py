"""Frequencies of one supported body in 50 decimal digits, straight from its equations.

Nothing is scaled, transformed or factorised as the program does it: supports are added to the
diagonal, held coordinates are left out, and Q(ω) x = 0 is solved by inverse iteration.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

DIGITS = 50


def exact_frequencies(element, supports, speed_rad_s, guesses_rad_s):
    """Return ω in rad/s nearest to each guess, for a body whose planes couple by the spin alone.

    `supports` maps (interface, component) to N/m, or to None where the coordinate is held.
    """
    with localcontext() as context:
        context.prec = DIGITS
        problem = _problem(element, supports, speed_rad_s)
        return np.array([float(_nearest(problem, guess)) for guess in guesses_rad_s])


def _problem(element, supports, speed_rad_s):
    """Return K, H, M of K + ωH − ω²M: x real and y imaginary, so that all of it is real."""
    stiffness, mass = _free_stiffness(element), _decimal(element.mass)
    geometric = _decimal(element.stress_stiffening) - _decimal(element.spin_softening)
    speed = Decimal(float(speed_rad_s))
    stiffness = stiffness + speed**2 * geometric
    kept = np.ones(element.size, dtype=bool)
    for (interface, component), value in supports.items():
        at = element.interface_index(interface, component)
        if value is None:
            kept[at] = False
        else:
            stiffness[at, at] += Decimal(float(value))
    in_x = _plane(element)
    turning = _decimal(element.gyroscopic)
    coupling = np.full(turning.shape, Decimal(0))
    across = np.ix_(in_x, ~in_x)
    coupling[across] = -speed * turning[across]
    coupling[np.ix_(~in_x, in_x)] = coupling[across].T
    inside = np.ix_(kept, kept)
    return stiffness[inside], coupling[inside], mass[inside]


def _free_stiffness(element):
    """Return K with the rounding in its rigid motions removed: K R = 0 is exact for the body."""
    stiffness, mass = _decimal(element.stiffness), _decimal(element.mass)
    rigid = _decimal(element.rigid_body_modes[:, element.rigid_body_present])
    momentum = mass.dot(rigid)
    projector = _decimal(np.eye(element.size))
    projector = projector - rigid.dot(_solved(rigid.T.dot(momentum), momentum.T))
    return projector.T.dot(stiffness).dot(projector)


def _plane(element):
    """Return which coordinates move in the plane of x: those coupled to some ux by M or K."""
    linked = (np.abs(element.mass) > 0) | (np.abs(element.stiffness) > 0)
    inside = np.array([c.component == "ux" for c in element.coordinates])
    while (grown := linked[inside].any(axis=0) | inside).sum() > inside.sum():
        inside = grown
    assert 2 * inside.sum() == element.size
    return inside


def _nearest(problem, guess_rad_s):
    stiffness, coupling, mass = problem
    omega = Decimal(float(guess_rad_s))
    n = len(mass)
    vector = _decimal(np.random.default_rng(1).standard_normal((n, 1)))
    for _ in range(2):
        vector = _solved(stiffness + omega * coupling - omega**2 * mass, vector)
        vector = vector / max(abs(v) for v in vector[:, 0])
        k, h, m = (vector[:, 0].dot(a.dot(vector[:, 0])) for a in problem)
        omega = (h + (h**2 + 4 * k * m).sqrt()) / (2 * m)
    return omega


def _decimal(matrix):
    convert = np.vectorize(lambda v: Decimal(float(v)), otypes=[object])
    return convert(np.asarray(matrix, dtype=float))


def _solved(matrix, right):
    """Gaussian elimination with pivoting."""
    a, n = np.hstack((matrix, right)), len(matrix)
    for k in range(n):
        pivot = k + max(range(n - k), key=lambda i: abs(a[k + i, k]))
        a[[k, pivot]] = a[[pivot, k]]
        rows = [i for i in range(k + 1, n) if a[i, k] != 0]
        for i in rows:
            a[i, k:] = a[i, k:] - (a[i, k] / a[k, k]) * a[k, k:]
    for k in range(n - 1, -1, -1):
        a[k, n:] = a[k, n:] / a[k, k]
        a[:k, n:] = a[:k, n:] - a[:k, k, None] * a[None, k, n:]
    return a[:, n:]
