"""A rigid hub with hinged point-mass blades: every blade in the turning frame, and a superelement.

In the turning frame all points move by u = J q + u2(q, q) / 2, with the rotation of the hub and of
the blades to second order, and M q'' + 2 Ω C q' + (K + Ω² (Kσ − S)) q = f. Of N > 2 equal blades
q = Re[E c] holds the index 1 with the amplitudes c = q1 − i q2, and the index 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg as la
from rotors import lumped_hub
from turning_frame import floquet_multipliers

SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # e_z ×
HUB = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True, kw_only=True)
class BladedHub:
    """Hinges at `hinge` and the height `offset`, masses 1 at the distance 1 from them.

    `cone`: angle of the blades to the plane of the hinges. `springs`: (2, 2) on lag and flap.
    `ring`: masses at the radius 1 that turn with the hub; `ends`: masses at z = ±1 on the axis.
    """

    count: int
    springs: np.ndarray
    hinge: float = 0.2
    offset: float = 0.0
    cone: float = 0.0
    ring: float = 4.0
    ends: float = 3.0

    @property
    def size(self):
        """Number of direct coordinates: the hub, then lag and flap of each blade."""
        return 6 + 2 * self.count

    def places(self):
        """Mass and place of each point, and the blade whose mass it is, or None."""
        for angle in 2.0 * np.pi * np.arange(8) / 8:
            yield self.ring / 8, np.array([np.cos(angle), np.sin(angle), 0.0]), None
        for side in (-1.0, 1.0):
            yield self.ends / 2, np.array([0.0, 0.0, side]), None
        for k in range(self.count):
            r, _, along, _ = self.axes(k)
            yield 1.0, self.hinge * r + [0.0, 0.0, self.offset] + along, k

    def axes(self, k):
        """Directions of a blade: radial, lag, along the blade, flap."""
        angle = 2.0 * np.pi * k / self.count
        r, z = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])
        lag = np.array([-np.sin(angle), np.cos(angle), 0.0])
        cos, sin = np.cos(self.cone), np.sin(self.cone)
        return r, lag, cos * r + sin * z, cos * z - sin * r

    def first(self, place, blade, q):
        """J q."""
        moved = q[:3] + np.cross(q[3:6], place)
        if blade is not None:
            _, lag, _, flap = self.axes(blade)
            moved = moved + q[6 + 2 * blade] * lag + q[7 + 2 * blade] * flap
        return moved

    def second(self, place, blade, q):
        """Half of u2(q, q)."""
        moved = 0.5 * np.cross(q[3:6], np.cross(q[3:6], place))
        if blade is not None:
            _, lag, along, flap = self.axes(blade)
            own = q[6 + 2 * blade : 8 + 2 * blade]
            moved = moved + np.cross(q[3:6], own[0] * lag + own[1] * flap) - 0.5 * own @ own * along
        return moved

    @cached_property
    def direct(self):
        """M, C, K, Kσ and S of all coordinates in the turning frame."""
        n, unit = self.size, np.eye(self.size)
        mass, coriolis, stress, softening = np.zeros((4, n, n))
        for m, place, blade in self.places():
            motion = np.array([self.first(place, blade, e) for e in unit]).T
            turned = SPIN @ motion
            mass += m * motion.T @ motion
            coriolis += m * motion.T @ turned
            softening += m * turned.T @ turned
            pull = -m * place * [1.0, 1.0, 0.0]  # Ω² m r outward, as a stiffness
            own = np.array([pull @ self.second(place, blade, e) for e in unit])
            for i in range(n):
                for j in range(n):
                    both = pull @ self.second(place, blade, unit[i] + unit[j])
                    stress[i, j] += both - own[i] - own[j]
        stiffness = la.block_diag(np.zeros((6, 6)), *[self.springs] * self.count)
        return mass, coriolis, stiffness, stress, softening

    def multipliers(self, speed, hold):
        """Floquet multipliers of a turn on a support `hold` of the hub; uz and rz are free."""
        mass, coriolis, stiffness, stress, softening = self.direct
        turning = (mass, coriolis, stiffness, stress - softening)
        return floquet_multipliers(turning, np.eye(6, self.size), speed, hold)

    def superelement(self):
        """The hub with uz and rz, index 1 and 0 of the blades, as a reduction gives them."""
        phase = np.exp(2j * np.pi * np.arange(self.count) / self.count)
        fields = np.zeros((self.size, 4), dtype=complex)  # of ux, ry, lag, flap
        fields[[0, 1], 0], fields[[4, 3], 1] = (1.0, 1.0j), (1.0, -1.0j)
        fields[6::2, 2], fields[7::2, 3] = phase, phase
        mass, coriolis, stiffness, stress, softening = (
            0.5 * fields.conj().T @ a @ fields for a in self.direct
        )
        bending = {
            "mass": _planes(mass),
            "stiffness": _planes(stiffness),
            "gyroscopic": _gyroscopic(mass - 1j * coriolis),
            "stress_stiffening": _planes(stress),
            "spin_softening": _planes(softening + mass - 2j * coriolis),
        }
        even = np.zeros((self.size, 4))  # of uz, rz, lag, flap
        even[2, 0], even[5, 1], even[6::2, 2], even[7::2, 3] = 1.0, 1.0, 1.0, 1.0
        m, c, k, s, t = (even.T @ a @ even for a in self.direct)
        radial = {
            "mass": m, "stiffness": k, "gyroscopic": 2.0 * c,
            "stress_stiffening": s, "spin_softening": t,
        }  # fmt: skip
        # ux, ry, lag, flap, uy, −rx, lag, flap, uz, rz, lag, flap
        order = [0, 4, 8, 5, 1, 9, 2, 6, 3, 7, 10, 11]
        sign = np.where(np.arange(12) == 5, -1.0, 1.0)

        def joined(name):
            whole = la.block_diag(bending[name], radial[name]) * np.outer(sign, sign)
            return whole[np.ix_(order, order)]

        generator = np.kron([[0.0, -1.0], [1.0, 0.0]], np.eye(4))
        generator = la.block_diag(generator, np.zeros((4, 4))) * np.outer(sign, sign)
        element = lumped_hub(
            "hub", {name: joined(name) for name in bending}, HUB, generator[np.ix_(order, order)]
        )
        rigid = self.direct[0][:6, :6]
        return replace(
            element,
            mass_kg=float(rigid[0, 0]),
            center_of_gravity_m=np.array([0.0, 0.0, rigid[0, 4] / rigid[0, 0]]),
            inertia_kg_m2=rigid[3:, 3:] - rigid[0, 4] ** 2 / rigid[0, 0] * np.diag([1.0, 1.0, 0.0]),
            harmonics=(0, 1),
            cyclic_sectors=self.count,
        )


def _planes(matrix):
    """Real matrix of q1, q2 from a Hermitian one of c = q1 − i q2."""
    return np.block([[matrix.real, matrix.imag], [-matrix.imag, matrix.real]])


def _gyroscopic(matrix):
    return 2.0 * np.block([[-matrix.imag, matrix.real], [-matrix.real, -matrix.imag]])
