"""Bodies of a few points of mass, whose integrals are plain sums."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.exchange.multibody.body_fixed import BodyFixedForm, BodyFixedNode


class Points(NamedTuple):
    """Masses (p,), places (p, 3), displacement per mode (p, 3, m), rotation per mode (p, 3, m)."""

    mass: np.ndarray
    place: np.ndarray
    shape: np.ndarray
    turn: np.ndarray


def some_points(modes, count=7, seed=0):
    """Return points with shapes that are orthonormal in the mass."""
    rng = np.random.default_rng(seed)
    assert 3 * count >= modes
    mass = rng.uniform(0.5, 2.0, count)
    shape, _ = np.linalg.qr(rng.normal(size=(3 * count, modes)))
    shape = shape.reshape(count, 3, modes) / np.sqrt(mass)[:, None, None]
    return Points(mass, rng.normal(size=(count, 3)), shape, rng.normal(size=(count, 3, modes)))


def point_form(points, name="points", stiffening=0.0, shown=2):
    """Return the form of a body of points: the first are interfaces, the next recovery points."""
    mass, x, phi, turn = points
    m = phi.shape[2]
    pieces = [integrals_of(*one) for one in zip(mass, x, phi, strict=True)]
    sums = {key: sum(piece[key] for piece in pieces) for key in pieces[0]}
    frequencies = 10.0 + 7.0 * np.arange(m)
    rng = np.random.default_rng(1)
    square = rng.normal(size=(m, m))
    return BodyFixedForm(
        name=name,
        frequencies_hz=frequencies,
        shapes=np.zeros((m, m)),
        mass_kg=float(mass.sum()),
        center_of_gravity_m=mass @ x / mass.sum(),
        mass=np.eye(m),
        stiffness=np.diag((2 * np.pi * frequencies) ** 2),
        stress_stiffening=stiffening * (square + square.T),
        nodes=tuple(
            BodyFixedNode(name=f"node {k}", position_m=x[k], translations=phi[k], rotations=turn[k])
            for k in range(shown)
        ),
        points_m=x[shown : 2 * shown],
        point_modes=phi[shown : 2 * shown],
        **sums,
    )


def integrals_of(mass, x, phi):
    """Integrals of one point, from crosses alone."""
    cross = [skew(v) for v in phi.T]
    place = skew(x)
    return {
        "inertia_kg_m2": -mass * place @ place,
        "I3": mass * phi,
        "I4": mass * np.cross(x, phi.T).T,
        "I5": mass * np.array([[np.cross(a, b) for b in phi.T] for a in phi.T]).transpose(2, 0, 1),
        "I8": -mass * np.stack([place @ c for c in cross], axis=2),
        "I9": mass * np.array([[a @ b for b in cross] for a in cross]).transpose(2, 3, 0, 1),
    }


def skew(vectors):
    """Matrices of v × of vectors (..., 3): their rows are e × v, as b·(e × v) = e·(v × b)."""
    return np.cross(np.eye(3), np.asarray(vectors)[..., None, :])
