"""A chain of point masses in a ring, two motions each, as a whole and by cyclic index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn import nodal_diameters as nd

TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class Chain:
    """Masses with radial and tangential motion (u, v), springs to the disk and to neighbours."""

    sectors: int = 7
    mass: float = 2.0
    radial: float = 5.0e4
    tangential: float = 8.0e4
    coupling: float = 1.0e4  #: v_j to v_{j+1}
    skew: float = 0.7e4  #: v_j to u_{j+1}: no mirror plane
    stiffening: float = 3.0  #: Of v by the spin, over mass Ω²

    def blocks(self):
        """Stiffness of a sector and its coupling to the next one, (2, 2) each."""
        own = np.diag([self.radial + self.skew, self.tangential + 2 * self.coupling + self.skew])
        following = np.array([[0.0, 0.0], [-self.skew, -self.coupling]])  # u_j, v_j by u, v of j+1
        return own, following

    def whole(self):
        """M, C, K and Kσ - S_c of all masses."""
        n = self.sectors
        own, following = self.blocks()
        ahead = np.roll(np.eye(n), 1, axis=1)
        stiffness = np.kron(np.eye(n), own) + np.kron(ahead, following)
        stiffness += np.kron(ahead.T, following.T)
        mass = self.mass * np.eye(2 * n)
        centrifugal = np.kron(np.eye(n), self.mass * np.diag([-1.0, self.stiffening - 1.0]))
        return mass, np.kron(np.eye(n), self.mass * TURN), stiffness, centrifugal

    def index(self, h):
        own, following = self.blocks()
        phase = np.exp(2j * np.pi * h / self.sectors)
        stiffness = own + phase * following + (phase * following).conj().T
        return nd.CyclicMatrices(
            index=h,
            mass=self.mass * np.eye(2),
            stiffness=stiffness,
            coriolis=1j * self.mass * TURN,
            centrifugal=self.mass * np.diag([-1.0, self.stiffening - 1.0]),
        )

    def body(self):
        indices = tuple(self.index(h) for h in range(self.sectors // 2 + 1))
        return nd.CyclicBody(name="chain", sectors=self.sectors, indices=indices)

    def rates(self, speed):
        """All positive angular frequencies of the whole, rising."""
        mass, c, stiffness, centrifugal = self.whole()
        n = len(mass)
        dynamic = stiffness + speed**2 * centrifugal
        state = np.block(
            [[np.zeros((n, n)), np.eye(n)], [-dynamic / self.mass, -2 * speed * c / self.mass]]
        )
        found = la.eigvals(state)
        return np.sort(found.imag[found.imag > 0.0])

    def response(self, speeds, order):
        """Largest motion at every speed under forces of an engine order, (s,)."""
        mass, c, stiffness, centrifugal = self.whole()
        speed = np.reshape(speeds, (-1, 1, 1))
        rate = order * speed
        dynamic = stiffness + speed**2 * centrifugal + 2j * rate * speed * c - rate**2 * mass
        waves = np.exp(2j * np.pi * order * np.arange(self.sectors) / self.sectors)
        force = np.tile(np.kron(waves, [0.3, 1.0])[:, None], (len(speed), 1, 1))
        return np.abs(np.linalg.solve(dynamic, force)).max(axis=(1, 2))
