"""What Exudyn's floating-frame body does near a steady spin, by differences of its own equations.

Exudyn gives M(q) q'' = f(q, q') in place, Euler parameters and modal amplitudes. Here the state is
seen from axes that turn with Ω: place y, tilt ψ and modal amplitudes. Written in those, the
equations do not depend on time, and their derivatives by central differences give the modes.
"""

from __future__ import annotations

import exudyn as exu
import numpy as np

# f is at most cubic in the state, so a step this wide leaves 1e-9.
STEP = 1e-5
K = np.array([0.0, 0.0, 1.0])


class Equations:
    """Mass matrix and forces of an assembled system whose first body is a floating-frame one."""

    def __init__(self, mbs):
        self.mbs, self.solver = mbs, exu.MainSolverImplicitSecondOrder()
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        self.solver.InitializeSolver(mbs, settings)
        self.size = self.solver.GetODE2size()

    def at(self, coordinates, rates):
        """M and f at Exudyn's coordinates (from their reference) and rates."""
        self.mbs.systemData.SetODE2Coordinates(coordinates, exu.ConfigurationType.Current)
        self.mbs.systemData.SetODE2Coordinates_t(rates, exu.ConfigurationType.Current)
        self.solver.ComputeMassMatrix(self.mbs)
        mass = self.solver.GetSystemMassMatrix()[: self.size, : self.size]
        self.solver.ComputeODE2RHS(self.mbs)
        return mass, self.solver.GetSystemResidual()[: self.size]


def turned(p):
    """Quaternion product of the unit vector of z with p."""
    w, x, y, z = p
    return np.array([-z, -y, x, w])


def turning_form(equations, speed, state, rates):
    """Mass matrix and force in (y, ψ, modal amplitudes) at angle 0 of the turning axes."""
    m = equations.size - 7
    (y, tilt), (v, spin) = (np.split(x[:6], 2) for x in (state, rates))
    first = np.sqrt(1.0 - tilt @ tilt / 4.0)
    to_p = np.vstack([-tilt / (4.0 * first), np.eye(3) / 2.0])
    p, own = np.append(first, tilt / 2.0), to_p @ spin
    p_rate = speed / 2.0 * turned(p) + own
    # what p and the place accelerate while ψ and y do not
    p_more = speed**2 / 4.0 * turned(turned(p)) + speed * turned(own)
    p_more[0] -= spin @ spin / (4.0 * first) + (tilt @ spin) ** 2 / (16.0 * first**3)
    place_more = 2.0 * speed * np.cross(K, v) + speed**2 * np.cross(K, np.cross(K, y))
    coordinates = np.concatenate([y, p - [1.0, 0.0, 0.0, 0.0], state[6:]])
    velocities = np.concatenate([v + speed * np.cross(K, y), p_rate, rates[6:]])
    more = np.concatenate([place_more, p_more, np.zeros(m)])
    tangent = np.zeros((7 + m, 6 + m))
    tangent[:3, :3], tangent[3:7, 3:6], tangent[7:, 6:] = np.eye(3), to_p, np.eye(m)
    mass, force = equations.at(coordinates, velocities)
    return tangent.T @ mass @ tangent, tangent.T @ (force - mass @ more)


def spinning_frequencies(mbs, speed, generator):
    """Frequencies [Hz] in fixed axes of the body at a steady spin, rising.

    generator: L of the modal amplitudes; a mode with L u = i n u at the rate ω in the turning
    axes has ω + n Ω in fixed ones; n is 0 or 1, ω of either sign.
    """
    equations = Equations(mbs)
    n = equations.size - 1
    still = np.zeros(n)
    mass, _ = turning_form(equations, speed, still, still)

    def slope(of_state):
        columns = []
        for step in STEP * np.eye(n):
            up, down = (
                turning_form(equations, speed, *((s, still) if of_state else (still, s)))[1]
                for s in (step, -step)
            )
            columns.append((up - down) / (2 * STEP))
        return np.linalg.solve(mass, np.array(columns).T)

    stiffness, damping = slope(True), slope(False)
    turn = np.zeros((n, n))
    turn[1, 0] = turn[4, 3] = 1.0
    turn[0, 1] = turn[3, 4] = -1.0
    turn[6:, 6:] = generator
    # The equations keep the eigenspaces of L, so each is solved alone: for its eigenvectors the
    # spin about z and the travel of a free body, two zeros each, would be in the way.
    angles, spaces = np.linalg.eig(turn)
    found = []
    for order in (0, 1):
        basis = spaces[:, np.abs(angles - 1j * order) < 1e-6]
        back = np.linalg.pinv(basis)
        k, c = (back @ matrix @ basis for matrix in (stiffness, damping))
        one = np.eye(len(k))
        values = np.linalg.eigvals(np.block([[0.0 * one, one], [k, c]])).imag
        found.append(np.abs(values + speed) if order else values[values > 0.0])
    return np.sort(np.concatenate(found)) / (2 * np.pi)
