"""Forces of squeeze films, gaps and cubic springs, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.nonlinear.forces import Clearance, CubicSpring, SqueezeFilm

FILM = SqueezeFilm(radius_m=0.05, length_m=0.03, clearance_m=1e-4, viscosity_pa_s=0.1)
FORCES = [
    CubicSpring(radial_n_per_m3=3e12, along_n_per_m3=(2e12, -1e12)),
    Clearance(gap_m=2e-5, stiffness_n_per_m=1e7, friction=0.2, center_m=(5e-6, -3e-6)),
    Clearance(gap_m=2e-5, stiffness_n_per_m=1e7, friction=0.2, spin_sense=-1),
    FILM,
    SqueezeFilm(**{**vars(FILM), "centring_n_per_m": 1e6}),
]


@pytest.mark.parametrize("force", FORCES)
def test_derivatives(force):
    """Against differences, away from the edges of the gap."""
    rng = np.random.default_rng(1)
    u, v = rng.uniform(-6e-5, 6e-5, (40, 2)), rng.uniform(-0.1, 0.1, (40, 2))
    found = force.at(u, v)
    for k in range(2):
        for own, at, step in (("stiffness_n_per_m", 0, 1e-10), ("damping_n_s_per_m", 1, 1e-6)):
            moved = step * np.eye(2)[k]
            up, down = (force.at(*((u + s, v), (u, v + s))[at]) for s in (moved, -moved))
            slope = (up.force_n - down.force_n) / (2.0 * step)
            wanted = getattr(found, own)[:, :, k]
            np.testing.assert_allclose(slope, wanted, rtol=1e-5, atol=1e-5 * np.abs(wanted).max())


def test_circular_orbit_in_a_squeeze_film():
    """Short film, half of it with pressure: closed form of Gunter, Barrett and Allaire (1977)."""
    omega, b0 = 1000.0, 135_000.0
    for e in (0.05, 0.3, 0.6, 0.9):
        turn = np.linspace(0.0, 2 * np.pi, 7)
        out = np.stack((np.cos(turn), np.sin(turn)), axis=1)
        across = np.stack((-np.sin(turn), np.cos(turn)), axis=1)
        force = FILM.at(1e-4 * e * out, 1e-4 * e * omega * across).force_n
        stiffness = 2 * e * omega * b0 / (1 - e**2) ** 2
        damping = np.pi * b0 / (2 * (1 - e**2) ** 1.5)
        radial, tangential = (force * out).sum(axis=1), (force * across).sum(axis=1)
        np.testing.assert_allclose(radial, stiffness * 1e-4 * e, rtol=1e-9)
        np.testing.assert_allclose(tangential, damping * omega * 1e-4 * e, rtol=1e-9)
        if e == 0.3:
            assert (damping, stiffness) == pytest.approx((244_282.0, 97.814e6), rel=1e-5)


def test_a_gap_pushes_back_and_rubs_against_the_spin():
    found = FORCES[2].at(np.array([[1e-5, 0.0], [0.0, 3e-5]]), np.zeros((2, 2))).force_n
    # pressed by 1e-5 m along y; the shaft turns backward there, towards +x, and is held from it
    np.testing.assert_allclose(found, [[0.0, 0.0], [20.0, 100.0]], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: CubicSpring(radial_n_per_m3=np.nan), "radial_n_per_m3 is nan"),
        (lambda: Clearance(gap_m=-1.0, stiffness_n_per_m=1.0), "gap_m is -1"),
        (lambda: Clearance(gap_m=1.0, stiffness_n_per_m=0.0), "stiffness_n_per_m is 0"),
        (
            lambda: Clearance(gap_m=1.0, stiffness_n_per_m=1.0, friction=0.1, spin_sense=0),
            "spin_sense is 0",
        ),
        (lambda: SqueezeFilm(**{**vars(FILM), "clearance_m": 0.0}), "clearance_m is 0"),
    ],
)
def test_refusals(make, says):
    with pytest.raises(AnalysisError, match=says):
        make()
